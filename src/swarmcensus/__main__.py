"""python -m swarmcensus: the command line."""

from swarmcensus.cli.commands import main

raise SystemExit(main())
