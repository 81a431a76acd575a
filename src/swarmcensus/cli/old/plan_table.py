"""The table of `plan`: the mission, one row per brain, world and size, and what the columns mean."""

import math
from dataclasses import replace

from swarmcensus.search import Mission, Plan, Row
from swarmcensus.support import terminal
from swarmcensus.support.formatting import counted
from swarmcensus.support.printed_tables import NUMBER, Table

HEADS = {
    "how long": "the shortest time",
    "how many": "the smallest swarm",
    "trade-off": "robots against minutes",
    "enough": "whether these are enough",
}
OF_THEORY = [("theory: all", True), ("mixed", True), ("alone", True)]


def show(plan: Plan) -> None:
    """Print a plan; on a narrow terminal the columns of theory are left out."""
    mission = plan.mission
    wanted = f"{100 * mission.wanted.confidence:g} % of robots {mission.goal}"
    title = f"{mission.name}: {HEADS[plan.question]}; {_world(plan)}\nwanted: {wanted}\n"
    table = Table.of_rows(dict([*_heads(mission), *OF_THEORY]), [_cells(plan, row) for row in plan.rows])
    theory = dict(OF_THEORY)
    columns = [replace(one, spare=NUMBER) if one.head in theory else one for one in table.columns]
    terminal.show(Table(columns, title=title, notes=lambda left_out: _meaning(plan, "mixed" not in left_out)))


def _world(plan: Plan) -> str:
    """The world of the mission, in one line."""
    mission, known = plan.mission, plan.mission.known
    low, high = known.fill_ratio
    parts = [", ".join(_places(mission)), f"accuracy {plan.rows[0].accuracy}"]
    if len(known.accuracy) > 1:
        parts[-1] += f", the worst of {', '.join(map(str, known.accuracy))}"
    parts.append(f"f = {low:g}" if low == high else f"f from {low:g} to {high:g}")
    if known.link_success < 1.0:
        parts.append(f"link success {known.link_success:g}")
    if known.precision == "single":
        parts.append("single precision")
    if known.message != "double":
        parts.append(f"messages in {known.message}")
    if known.failing:
        parts.append(f"{100 * known.failing:g} % of robots fail")
    if known.lying:
        parts.append(f"{100 * known.lying:g} % lie ({', '.join(lie.label for lie in mission.lies)})")
    moving = [world for world in mission.worlds if world.moves]
    if not moving:
        return ", ".join(parts)
    truth = "the floor's own share of black" if moving[0].on_floor else "the nominal f"
    where = " where robots move" if len(moving) < len(mission.worlds) and moving[0].on_floor else ""
    return f"{', '.join(parts)}; the truth is {truth}{where}"


def _places(mission: Mission) -> list[str]:
    """The networks, and the size of the area."""
    if [topology.moves for topology in mission.free.topology] == [True]:
        names = [""]
    else:
        names = [str(topology) for topology in mission.free.topology]
    size = f"{mission.side:.4g} m x {mission.side:.4g} m" if mission.side is not None else ""
    if mission.free.density:
        size = f"density {', '.join(f'{density:g}' for density in mission.free.density)}"
    moves = (topology.moves for topology in mission.free.topology)
    return [f"{name} {size}".strip() if moving else name for name, moving in zip(names, moves, strict=True)]


def _several(mission: Mission) -> tuple[bool, bool, bool, bool]:
    """Whether there are several networks, several densities, any density, and several lies."""
    densities = mission.free.density or []
    return len(mission.free.topology) > 1, len(densities) > 1, bool(densities), len(mission.lies) > 1


def _heads(mission: Mission) -> list[tuple[str, bool]]:
    networks, densities, sides, lies = _several(mission)
    heads = [("brain", False)]
    heads += [("topology", False)] * networks + [("density", True)] * densities
    heads += [("robots", True)] + [("side, m", True)] * sides
    heads += [("minutes", True), ("right %", True), ("f", True)] + [("lie", False)] * lies
    return [*heads, ("", False)]


def _cells(plan: Plan, row: Row) -> list[str]:
    networks, densities, sides, lies = _several(plan.mission)
    share = ""
    if row.share:
        value, low, high = (100.0 * number for number in row.share)
        share = f"{value:.1f} [{low:.1f}, {high:.1f}]"
    robots, minutes = f"{row.robots:,}", _digits(row.minutes)
    if row.robots_low is not None:
        robots += f" [{row.robots_low:,}, {'more' if row.robots_high is None else f'{row.robots_high:,}'}]"
    if row.minutes_low is not None:
        high_end = "more" if row.minutes_high is None else _digits(row.minutes_high)
        minutes += f" [{_digits(row.minutes_low)}, {high_end}]"
    if row.answer == "not reached" and plan.question != "enough":
        minutes = f"> {minutes}"
    worst = "" if row.fill_ratio is None else f"{row.fill_ratio:g}"
    return [
        row.brain,
        *[row.topology] * networks,
        *["" if row.density is None else f"{row.density:g}"] * densities,
        robots,
        *["" if row.side is None else _digits(row.side)] * sides,
        minutes,
        share,
        worst,
        *[row.lie or ""] * lies,
        _answer(plan, row),
        *map(_digits, reversed(row.theory)),
    ]


def _answer(plan: Plan, row: Row) -> str:
    if plan.question != "enough" or not row.share:
        return {"reached": "", "not reached": "not reached", "not simulated": "theory alone"}[row.answer]
    answer = "enough" if row.answer == "reached" else "not enough"
    if row.share.low < plan.mission.wanted.confidence <= row.share.high:
        answer += ", but not certain"
    return answer


def _digits(value: float) -> str:
    """A number in three digits, or more if there are more before the point."""
    if value >= 100.0 or not math.isfinite(value):
        return f"{value:,.0f}"
    return f"{value:.{max(0, 2 - math.floor(math.log10(value)))}f}" if value > 0.0 else "0"


def _meaning(plan: Plan, theory: bool) -> list[str]:
    """What the columns and answers mean."""
    mission, trials = plan.mission, max(row.trials for row in plan.rows)
    fewer = min((row.trials for row in plan.rows if row.trials), default=trials)
    who = "share of honest, working robots that are right" if mission.known.lying else "share of robots that are right"
    lines = [
        f"right: {who} at that time, for the worst f of the range; "
        f"[ ]: 95 % intervals over {counted(trials, 'trial')}, seed {mission.seed}"
    ]
    if fewer < trials:
        lines.append(f"not reached: where this was clear after {counted(fewer, 'trial')}, no more were run")
    if theory:
        known = mission.known
        left_out = ["nobody lied"] * (known.lying > 0) + ["no message were lost"] * (known.link_success < 1)
        unreal = f", as if {' and '.join(left_out)}" if left_out else ""
        lines.append(
            f"theory, in minutes{unreal}: all = every robot knows all readings at once; "
            "mixed = robots mix sums with their neighbours; alone = robots hear nobody"
        )
    if mission.free.density:
        lines.append("side: of the square that results from the density and the number of robots")
    if any(not row.trials for row in plan.rows):
        lines.append("theory alone: a simulation would take hours")
    return lines
