"""The options of commands that read results, RESULTS.nc, `--where`, `--bins` and `--delta`, and what they select."""

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import xarray as xr

from swarmcensus.cli.options import add_shared, from_zero, once
from swarmcensus.cli.output import say
from swarmcensus.support.options import command

RESULTS_HELP = "a results file, as 'run' writes it"
MOST_ROWS = 40  # of a table, unless --limit asks for more


class Source(NamedTuple):
    """The dataset of a results file: all its settings, and those that `--where` selects."""

    stored: "xr.Dataset"
    selected: "xr.Dataset"


def add_source_options(
    sub: argparse.ArgumentParser, metavar: str = "RESULTS.nc", results_help: str = RESULTS_HELP
) -> None:
    """Add the options of all commands that read the settings of a results file."""
    add_results(sub, metavar, results_help)
    add_shared(sub, "where", "bins", "delta")


def add_results(
    sub: argparse.ArgumentParser, metavar: str = "RESULTS.nc", text: str = RESULTS_HELP, **more: Any
) -> None:
    """Add the results files that a command reads; `execute` checks that they exist."""
    sub.add_argument("results", type=Path, metavar=metavar, help=text, **more)
    sub.set_defaults(reads_results=True)


def add_limit_option(sub: argparse.ArgumentParser, more: str = "") -> None:
    """Add the option of all commands that print one row per setting, or per world."""
    text = f"maximum number of rows, 0 for all (default: {MOST_ROWS}{more})"
    sub.add_argument("--limit", type=from_zero, metavar="N", help=text)


def read(options: argparse.Namespace) -> Source:
    """Read the results file. Raises InputError."""
    from swarmcensus.results import asked_anew, opened, remeasure, where, with_labels
    from swarmcensus.studies import UNNAMED

    stored = remeasure(opened(options.results), delta=options.delta, bins=options.bins)
    if stored.attrs["title"] == UNNAMED:
        stored = stored.assign_attrs(title=options.results.stem)
    if changed := asked_anew(stored):
        values = " and ".join(f"{key} = {stored.attrs[key]:g}" for key in changed)
        say(f"{options.results}: measured again from its estimates, with {values}")
    if given := getattr(options, "label", []):
        stored = with_labels(stored, once("label", given))
    return Source(stored, where(stored, options.where))


def again(options: argparse.Namespace, name: str, more: Iterable[str] = ()) -> str:
    """The shell line of this command on these results: with the source options and those named in `more`."""
    words = ["swarmcensus", name, options.results]
    for name in ("where", "bins", "delta", *more):
        values = getattr(options, name)
        if values is True:
            words.append(f"--{name}")
        for value in values if isinstance(values, list) else [values]:
            value = "=".join(value) if isinstance(value, tuple) else value
            if value is not None and not isinstance(value, bool):
                words += [f"--{name}", str(value)]
    return command(*words)
