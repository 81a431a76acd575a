"""The tables that commands print of results and traces."""

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.cli.output import present
from swarmcensus.cli.source import MOST_ROWS
from swarmcensus.results import done, failed_trials, honest_in, labels_in, records, summary_table
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command
from swarmcensus.support.printed_tables import Table
from swarmcensus.support.terminal import show


def head(data: xr.Dataset, path: Path) -> str:
    """The title line of a results file: its study, its settings and how many trials are done."""
    made = f"seed {data.attrs['seed']}, swarmcensus {data.attrs['swarmcensus_version']}"
    trials = f"{int(done(data).sum()):,} of {counted(data.attrs['trials_total'], 'trial')} done"
    failed = len(failed_trials(data))
    return (
        f"{path}: {data.attrs['title']} ({made}): {counted(data.sizes['setting'], 'setting')}, {trials}"
        + f", {failed:,} failed" * (failed > 0)
    )


def settings(
    data: xr.Dataset,
    path: Path,
    limit: int = MOST_ROWS,
    checkpoint: int | None = None,
    title: str = "",
    again: str = "",
) -> None:
    """Print one row per setting, at most `limit` (0: all): medians over robots and trials, intervals over trials.

    `again` is the shell line of the command. On a narrow terminal intervals are left out, and then other columns.
    """
    more = f"show all: {again or command('swarmcensus', 'show', path)} --limit 0"
    show(summary_table(data, limit, checkpoint, title, more))


def as_rows(data: xr.Dataset, checkpoint: int | None = None) -> list[dict[str, Any]]:
    """The same settings for programs: the columns of `summary`, with brains' labels."""
    labels = labels_in(data)
    return [row | {"brain": labels.get(row["brain"], row["brain"])} for row in records(data, checkpoint)]


def failures(data: xr.Dataset) -> int:
    """Print failed trials on stderr, a line per setting. Returns the exit code: 2 if any failed."""
    by_setting: dict[int, list[dict[str, Any]]] = {}
    for failure in failed_trials(data):
        by_setting.setdefault(failure["setting"], []).append(failure)
    for number, failed in list(by_setting.items())[:MOST_ROWS]:
        trials = ", ".join(str(failure["trial"]) for failure in failed[:8]) + (", ..." if len(failed) > 8 else "")
        print(f"setting {number}, trial {trials}: {failed[0]['why']}", file=sys.stderr)
    if len(by_setting) > MOST_ROWS:
        print(f"and trials of {counted(len(by_setting) - MOST_ROWS, 'more setting')}", file=sys.stderr)
    return 2 if by_setting else 0
