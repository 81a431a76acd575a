"""The results that a command reads: labelled and selected as its options ask."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

from swarmcensus.cli.parameters import once
from swarmcensus.support.errors import InputError


def read(
    path: Path, where: str | None, labels: Sequence[tuple[str, str]] = (), logs: bool = False
) -> "tuple[xr.Dataset, xr.Dataset]":
    """Read a results file, or with `logs` the log of a search: all its settings, and those that `where` selects.

    Raises InputError.
    """
    from swarmcensus.results import check_there

    check_there(path)  # before time is spent on imports
    from swarmcensus import search
    from swarmcensus.results import open_partial
    from swarmcensus.studies import UNNAMED
    from swarmcensus.summaries import where as selected, with_labels

    is_log = path.suffix.lower() == ".csv" and search.is_log(path)
    if is_log and not logs:
        raise InputError(f"{path} is the log of a search: swarmcensus show and plot draw it", file=path)
    stored = search.candidates_in(path) if is_log else open_partial(path)
    if stored.attrs["title"] == UNNAMED:
        stored = stored.assign_attrs(title=path.stem)
    if labels:
        stored = with_labels(stored, once("label", labels))
    return stored, selected(stored, where)
