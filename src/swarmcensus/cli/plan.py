"""The command `plan`: how many robots, and how many minutes, a mission takes. Imports wait until needed."""

import argparse
import time

from swarmcensus.cli.mission_options import tables_of
from swarmcensus.cli.output import answer, reporting, say


def plan(options: argparse.Namespace) -> int:
    """Plan a mission, or print the schema of mission files."""
    if options.schema:
        return _schema(options)
    from pathlib import Path

    from swarmcensus.basics.errors import InputError
    from swarmcensus.basics.files import check_writable
    from swarmcensus.cli.plan_table import show
    from swarmcensus.planning.mission import load_mission, mission_of
    from swarmcensus.planning.planning import plan as plan_of
    from swarmcensus.planning.plans import check_lines, check_out

    inputs = [options.mission] if options.mission else []
    where = f"mission file {options.mission}" if options.mission else "mission"
    base = options.mission.parent if options.mission else Path()
    tables = tables_of(options, load_mission(options.mission) if options.mission else {})
    if options.out:
        check_out(options.out, *inputs)
    if options.plot:
        if options.plot.suffix not in (".png", ".svg", ".pdf"):
            raise InputError(f"--plot {options.plot}: a figure is written as .png, .svg or .pdf")
        check_writable(options.plot, *inputs)
        check_lines(mission_of(tables, where, base))
    begun = time.monotonic()
    with reporting(str(tables.get("name", "mission"))) as progress:
        found = plan_of(tables, options.jobs, progress, where=where, base=base)
    if options.json:
        answer("plan", found.data)
    else:
        show(found)
    if options.plot:
        from swarmcensus.figures.files import save
        from swarmcensus.figures.plan_lines import draw_plan

        save(draw_plan(found), options.plot)
    if options.out:
        found.save(options.out)
    written = ", ".join(str(path) for path in (options.out, options.plot) if path)
    say(f"{written}{': ' * bool(written)}{time.monotonic() - begun:.1f} s")
    return 0


def _schema(options: argparse.Namespace) -> int:
    import json

    from swarmcensus.basics.errors import InputError
    from swarmcensus.planning.schema import schema

    if options.mission or options.out or options.plot or tables_of(options, {}):
        raise InputError("--schema goes alone: swarmcensus plan --schema > mission.schema.json")
    print(json.dumps(schema(), indent=2, ensure_ascii=False))
    return 0
