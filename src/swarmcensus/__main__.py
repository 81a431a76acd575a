"""python -m swarmcensus: the command line."""

from swarmcensus.cli.program import program

program()
