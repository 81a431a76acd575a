"""The command `plan`: how many robots, and how many minutes, a mission takes. Imports wait until needed."""

import argparse
import math
import sys
import time
from typing import TYPE_CHECKING

from swarmcensus.cli.mission_options import tables_of

if TYPE_CHECKING:
    from swarmcensus.planning.plans import Plan, Row

HEADS = {
    "how long": "the shortest time",
    "how many": "the smallest swarm",
    "trade-off": "robots against minutes",
    "enough": "are they enough?",
}


def plan(options: argparse.Namespace) -> int:
    """Plan a mission."""
    from pathlib import Path

    from swarmcensus.basics.errors import InputError
    from swarmcensus.basics.files import check_writable
    from swarmcensus.planning.mission import load_mission
    from swarmcensus.planning.planning import plan as plan_of
    from swarmcensus.planning.plans import check_out
    from swarmcensus.runs.progress import reporting

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
    begun = time.monotonic()
    with reporting(str(tables.get("name", "mission"))) as progress:
        found = plan_of(tables, options.jobs, progress, where=where, base=base)
    show(found)
    if options.out:
        found.save(options.out)
    if options.plot:
        from swarmcensus.figures.files import save
        from swarmcensus.figures.plan_lines import draw_plan

        save(draw_plan(found), options.plot)
    written = ", ".join(str(path) for path in (options.out, options.plot) if path)
    print(f"{written}{': ' * bool(written)}{time.monotonic() - begun:.1f} s", file=sys.stderr)
    return 0


def show(found: "Plan") -> None:
    """Print it: what was asked, a row a brain and size, and what the columns mean."""
    from swarmcensus.basics.terminal import UNFOLDED, console, table

    out, mission = console(), found.mission
    out.print(f"{mission.name}: {HEADS[found.question]}; {_world(found)}")
    out.print(f"wanted: {100 * mission.wanted.confidence:g} % of robots {mission.goal}")
    out.print()
    cells = [_cells(found, row) for row in found.rows]
    heads = [("brain", False), ("robots", True), ("minutes", True), ("right %", True), ("f", True), ("", False)]
    heads += [("theory: all", True), ("mixed", True), ("alone", True)]
    rows = table(heads, cells)
    narrow = rows.__rich_measure__(out, out.options.update(max_width=UNFOLDED)).maximum > out.width
    if narrow:  # theory's columns are left to --out
        rows = table(heads[:-3], [row[:-3] for row in cells])
    out.print(rows)
    out.print(_meaning(found, theory=not narrow), style="dim")


def _world(found: "Plan") -> str:
    mission = found.mission
    low, high = mission.known.fill_ratio
    f = f"f = {low:g}" if low == high else f"f from {low:g} to {high:g}"
    fails = f", {100 * mission.known.failing:g} % of robots fail" if mission.known.failing else ""
    lossy = f", link success {mission.known.link_success:g}" if mission.known.link_success < 1.0 else ""
    if not mission.moves:
        return f"{mission.free.topology[0]}, accuracy {mission.known.accuracy}, {f}{lossy}{fails}"
    truth = "the floor's own share of black" if mission.on_floor else "the nominal f"
    side = f"{mission.side:.4g} m x {mission.side:.4g} m"
    return f"{side}, accuracy {mission.known.accuracy}, {f}{lossy}{fails}; the truth is {truth}"


def _cells(found: "Plan", row: "Row") -> list[str]:
    share = ""
    if row.share:
        value, low, high = (100.0 * one for one in row.share)
        share = f"{value:.1f} [{low:.1f}, {high:.1f}]"
    robots, minutes = f"{row.robots:,}", _minutes(row.minutes)
    if row.robots_low is not None:
        robots += f" [{row.robots_low:,}, {'more' if row.robots_high is None else f'{row.robots_high:,}'}]"
    if row.minutes_low is not None:
        high_end = "more" if row.minutes_high is None else _minutes(row.minutes_high)
        minutes += f" [{_minutes(row.minutes_low)}, {high_end}]"
    worst = "" if row.fill_ratio is None else f"{row.fill_ratio:g}"
    answer = {"reached": "", "not reached": "not reached", "not simulated": "theory alone"}[row.answer]
    if found.question == "enough" and row.share:
        answer = "enough" if row.answer == "reached" else "not enough"
        if row.share.low < found.mission.wanted.confidence <= row.share.high:
            answer += ", as far as trials tell"
    return [row.brain, robots, minutes, share, worst, answer, *map(_minutes, reversed(row.theory))]


def _minutes(value: float) -> str:
    """In three digits, or all before the point."""
    if value >= 100.0 or not math.isfinite(value):
        return f"{value:,.0f}"
    return f"{value:.{max(0, 2 - math.floor(math.log10(value)))}f}" if value > 0.0 else "0"


def _meaning(found: "Plan", theory: bool) -> str:
    trials = max(row.trials for row in found.rows)
    lines = [
        "right: share of robots at that time, at the worst f of the range; "
        f"[ ]: 95 % intervals over {trials:,} trials, seed {found.mission.seed}"
    ]
    if theory:
        lines.append(
            "theory, in minutes: were all readings everywhere at once; sums mixed by who meets or hears whom; "
            "a robot alone"
        )
    if any(not row.trials for row in found.rows):
        lines.append("theory alone: to simulate it would take hours")
    return "\n".join(lines)
