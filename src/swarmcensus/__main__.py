"""python -m swarmcensus: the command line."""

from swarmcensus.cli import main

raise SystemExit(main())
