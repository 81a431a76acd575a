"""The command `export`: results as a table, and logs of robots as MCAP. Imports wait until it needs them."""

import argparse
from pathlib import Path

from swarmcensus.cli.options import Command, Group

from swarmcensus.cli.output import say, wrote
from swarmcensus.cli.source import RESULTS_HELP, add_source_options, read
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import misplaced, wrong_option

TABLES = ("csv", "parquet")
FORMATS = (*TABLES, "mcap")
OF_RESULTS = ("where", "bins", "delta")  # options that select and measure results


def add_export_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `export`."""
    add_source_options(sub, "RESULTS.nc|FOLDER", f"{RESULTS_HELP}; or a folder of robots' logs")
    sub.set_defaults(reads_results=False)  # the source may be logs
    sub.add_argument(
        "--format",
        choices=FORMATS,
        help="format (default: by the ending of --out, or csv; of robots' logs mcap)",
    )
    sub.add_argument(
        "--out", type=Path, metavar="FILE", help="file to write (default: the input's name and .FORMAT, next to it)"
    )


def export(options: argparse.Namespace) -> int:
    """Write results as a table, or logs of robots as MCAP."""
    from swarmcensus.results import check_there, folder_of
    from swarmcensus.robots import logs_in, without_logs
    from swarmcensus.support.files import check_writable

    source = options.results
    logs = logs_in(source)
    if not logs:
        if source.is_dir() and not folder_of(source).is_dir() and options.format in (None, "mcap"):
            raise without_logs(source)
        check_there(source)
    formats = ("mcap",) if logs else TABLES
    ending = options.out.suffix.lower().removeprefix(".") if options.out else ""
    kind = options.format or (ending if options.out else formats[0])
    if kind not in formats:
        key, value = ("format", kind) if options.format else ("out", options.out)
        what = "robots' logs are written as mcap" if logs else "results are written as csv or parquet"
        raise InputError.of(source, f"{what}, not by --{key} {value}", key, value)
    whole = source if source.name not in ("", "..") else source.resolve()
    out = options.out or whole.parent / f"{whole.name if logs else source.stem}.{kind}"  # each folder keeps its own
    if (ending in FORMATS and ending != kind) or (logs and ending not in ("", "mcap")):
        raise wrong_option("out", out, f"--format {kind} is written as .{kind}")
    check_writable(out, source, *logs)
    return _export_logs(options, out) if logs else _export_results(options, out, kind)


def _export_logs(options: argparse.Namespace, out: Path) -> int:
    from swarmcensus.robots import write_mcap

    for name in OF_RESULTS:
        if getattr(options, name) is not None:
            raise misplaced(name, None, f"is for results files: {options.results} holds robots' logs")
    written = write_mcap(options.results, out)
    if written.lost:
        say(f"{options.results}: logs are cut or damaged: {counted(written.lost, 'byte')} could not be read")
    robots, ticks = counted(written.robots, "robot"), counted(written.ticks, "tick")
    wrote(f"{out}: {robots}, {ticks}, {counted(written.messages, 'message')}")
    return 0


def _export_results(options: argparse.Namespace, out: Path, kind: str) -> int:
    from swarmcensus.results import say_partial, store

    source = read(options)
    say_partial(source.stored, options.results)
    rows = store.export(source.selected, out, kind)
    wrote(f"{out}: {counted(rows, 'row')}")
    return 0


COMMANDS = (
    Command(
        "export", "Write results as a table, or robots' logs as MCAP.",
        Group.STUDIES, 8, export, add_export_options, json=False,
    ),
)  # fmt: skip
