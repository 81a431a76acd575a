"""Which results a command reads: the file, `--where`, `--bins` and `--delta`, and the settings that they select."""

import argparse
import shlex
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import xarray as xr

from swarmcensus.cli.options import from_zero

MOST_ROWS = 40  # of a table, unless one asks for more


class Source(NamedTuple):
    """A results file as it was read: all settings of it, and those that `--where` selects."""

    stored: "xr.Dataset"
    selected: "xr.Dataset"


def add_source_options(sub: argparse.ArgumentParser) -> None:
    """The options of all commands that read the settings of a results file."""
    sub.add_argument("results", type=Path, metavar="RESULTS.nc")
    sub.add_argument("--where", metavar="EXPR", help="only these settings, as 'topology == \"ring\" and robots == 100'")
    sub.add_argument("--bins", type=int, help="of decisions, instead of the study's own; needs kept estimates")
    sub.add_argument("--delta", type=float, help="of convergence, instead of the study's own; needs kept estimates")


def add_limit_option(sub: argparse.ArgumentParser, more: str = "") -> None:
    """The option of all commands that print a row a setting, or a world."""
    help_ = f"rows at the most, 0: all (default: {MOST_ROWS}{more})"
    sub.add_argument("--limit", type=from_zero, metavar="N", help=help_)


def read(options: argparse.Namespace) -> Source:
    """Read the results file. Raises InputError."""
    from swarmcensus.results.partial import opened
    from swarmcensus.results.remeasuring import remeasure
    from swarmcensus.results.selecting import where

    stored = remeasure(opened(options.results), delta=options.delta, bins=options.bins)
    return Source(stored, where(stored, options.where))


def again(options: argparse.Namespace, command: str, more: Iterable[str] = ()) -> str:
    """The same command as a line for a shell, with the options that select, and the values of `more` options."""
    words = ["swarmcensus", command, str(options.results)]
    for name in ("where", "bins", "delta", *more):
        given = getattr(options, name)
        if given is True:
            words.append(f"--{name}")
        for value in given if isinstance(given, list) else [given]:
            if value is not None and not isinstance(value, bool):
                words += [f"--{name}", str(value)]
    return shlex.join(words)
