"""The command `plan`."""

import time
from pathlib import Path
from typing import Annotated

from swarmcensus.cli.messages import reporting
from swarmcensus.cli.parameters import FILE, USUAL, Hardware, Seed, Set, Trials, path, takes, values_of
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError, StudyError
from swarmcensus.support.formatting import elapsed
from swarmcensus.support.options import command as shell_line, wrong_option


def plan(
    study: Annotated[Path | None, takes(path, "STUDY.toml")] = None, /, *, set: Set = (), trials: Trials = None,
    seed: Seed = None, hardware: Hardware = USUAL, out: Annotated[Path | None, FILE] = None,
    plot: Annotated[Path | None, takes(path, "FILE.png|svg|pdf", "draw a figure")] = None,
) -> Answer:  # fmt: skip
    """Find how many robots, or minutes, a mission needs.

    Args:
        study: a study with a table [wanted], such as error = 0.02; without one, --set says all
        out: study of the best plan, to be run
    """
    from swarmcensus.search import missions_of, plan as plan_of, tables_of
    from swarmcensus.studies import with_assignments, with_values
    from swarmcensus.support.files import check_output

    inputs = [study] if study else []
    more = {key: value for key, value in (("trials", trials), ("seed", seed)) if value is not None}
    values = values_of(set, **more) | more
    where, base = (with_assignments(f"study file {study}", values), study.parent) if study else ("mission", Path())
    try:
        tables = with_values(tables_of(study) if study else {}, values)
    except StudyError as error:
        raise error if error.file else StudyError.within(where, error) from None
    check_output("out", out, (".toml",), *inputs)
    if plot:
        check_output("plot", plot, (".png", ".svg", ".pdf"), *inputs)
    missions_of(tables, where, base)  # refused before time is spent
    if out and out.parent != base:
        try:
            missions_of(tables, "the study there", out.parent)
        except InputError as error:
            why = f"paths in it are relative to its folder, and {error}: write it into that of {study}"
            raise wrong_option("out", out, why) from None
    begun = time.monotonic()
    with reporting(str(tables.get("name", "mission"))) as progress:
        found = plan_of(tables, progress=progress, where=where, base=base, **vars(hardware))
    if plot:
        from swarmcensus.figures import draw_plan, save

        save(draw_plan(found), plot)
    if out:
        found.write(out)
        found.next = shell_line("swarmcensus", "run", out)
    found.files = dict.fromkeys((file for file in (out, plot) if file), elapsed(time.monotonic() - begun))
    return found
