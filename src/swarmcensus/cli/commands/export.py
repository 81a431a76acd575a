"""The command `export`: results as a table, and logs of robots as MCAP. Imports wait until it needs them."""

from pathlib import Path
from typing import Annotated, Literal

from swarmcensus.cli.messages import say
from swarmcensus.cli.parameters import FILE, Bins, Delta, Where, path, takes
from swarmcensus.cli.source import read
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option_conflict, wrong_option

TABLES = ("csv", "parquet")


def export(
    source: Annotated[Path, takes(path, "RESULTS.nc|FOLDER")], /, *, where: Where = None, bins: Bins = None,
    delta: Delta = None, format: Literal["csv", "parquet", "mcap"] | None = None,
    out: Annotated[Path | None, FILE] = None,
) -> Answer:  # fmt: skip
    """Write results as a table, or robots' logs as MCAP.

    Args:
        source: a results file, as 'run' writes it; or a folder of robots' logs
        format: format (default: by the ending of --out, or csv; of robots' logs mcap)
        out: file to write (default: the input's name and .FORMAT, next to it)
    """
    from swarmcensus.results import check_there, folder_of, say_partial, store
    from swarmcensus.robots import logs_in, without_logs, write_mcap
    from swarmcensus.support.files import check_writable

    logs = logs_in(source)
    if not logs:
        if source.is_dir() and not folder_of(source).is_dir() and format in (None, "mcap"):
            raise without_logs(source)
        check_there(source)
    formats = ("mcap",) if logs else TABLES
    ending = out.suffix.lower().removeprefix(".") if out else ""
    kind = format or (ending if out else formats[0])
    if kind not in formats:
        key, value = ("format", kind) if format else ("out", out)
        what = "robots' logs are written as mcap" if logs else "results are written as csv or parquet"
        raise InputError.of(source, f"{what}, not by --{key} {value}", key, value)
    whole = source if source.name not in ("", "..") else source.resolve()
    out = out or whole.parent / f"{whole.name if logs else source.stem}.{kind}"  # each folder keeps its own
    if (ending in (*TABLES, "mcap") and ending != kind) or (logs and ending not in ("", "mcap")):
        raise wrong_option("out", out, f"--format {kind} is written as .{kind}")
    check_writable(out, source, *logs)
    if not logs:
        stored, data = read(source, where, bins, delta)
        say_partial(stored, source)
        return Answer(files={out: counted(store.export(data, out, kind), "row")})
    for name, given in (("where", where), ("bins", bins), ("delta", delta)):
        if given is not None:
            raise option_conflict(name, None, f"is for results files: {source} holds robots' logs")
    written = write_mcap(source, out)
    for why in [f"{counted(written.lost, 'byte')} of logs are cut or damaged"] * bool(written.lost) + [*written.absent]:
        say(f"{source}: left out: {why}")
    robots, ticks = counted(written.robots, "robot"), counted(written.ticks, "tick")
    return Answer(files={out: f"{robots}, {ticks}, {counted(written.messages, 'message')}"})
