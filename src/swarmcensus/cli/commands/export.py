"""The command `export`: results as a table, and logs of robots as MCAP. Imports wait until it needs them."""

from pathlib import Path
from typing import Annotated

from swarmcensus.cli.messages import say
from swarmcensus.cli.parameters import Where, path, takes
from swarmcensus.cli.source import read
from swarmcensus.support.answers import Answer
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option_conflict


def export(
    source: Annotated[Path, takes(path, "RESULTS.nc|FOLDER")], /, *, where: Where = None,
    out: Annotated[Path | None, takes(path, "FILE.csv|parquet|mcap")] = None,
) -> Answer:  # fmt: skip
    """Write results as a table, or robots' logs as MCAP.

    Args:
        source: a results file, as 'run' writes it; or a folder of robots' logs
        out: file to write (default: the input's name with .csv, or of robots' logs .mcap, next to it)
    """
    from swarmcensus.results import check_there, folder_of, say_partial, store
    from swarmcensus.robots import logs_in, without_logs, write_mcap
    from swarmcensus.support.files import check_output

    logs = logs_in(source)
    if not logs:
        if source.is_dir() and not folder_of(source).is_dir():
            raise without_logs(source)
        check_there(source)
    whole = source if source.name not in ("", "..") else source.resolve()
    out = out or whole.parent / (f"{whole.name}.mcap" if logs else f"{source.stem}.csv")  # each folder keeps its own
    check_output("out", out, (".mcap",) if logs else (".csv", ".parquet"), source, *logs)
    if not logs:
        stored, data = read(source, where)
        say_partial(stored, source)
        return Answer(files={out: counted(store.export(data, out, out.suffix.lower()[1:]), "row")})
    if where is not None:
        raise option_conflict("where", None, f"is for results files: {source} holds robots' logs")
    written, gaps = write_mcap(source, out)
    for gap in gaps:
        say(f"{source}: {gap}")
    return Answer(files={out: written})
