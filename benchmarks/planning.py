"""Plans run again: `python benchmarks/planning.py [--seed N] [--trials N] [--jobs N]`.

Makes 40 plans of small missions and runs each answer again in 2,000 trials of another seed, of which no planner knew.
Prints what was promised, what the plan said, and the share of robots that are right in the new trials; then by kind of
mission the mean difference from the promise with its standard error, and how many intervals hold what was measured.
Some minutes on one core. The numbers depend on the seed alone.
"""

import argparse
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

import swarmcensus as sc
from swarmcensus.planning.mission import mission_of
from swarmcensus.planning.simulating import Case, curves, study_of

AGAIN = 2000  # trials
OTHER = 1_000_003  # from a mission's seed to that of the trials which run it again
SKEWED = {"black": 0.9, "white": 0.6}
SMALL_WORLD = {"networkx": "watts_strogatz_graph", "k": 4, "p": 0.2}


def on(topology, brain="commons", robots=10, confidence=0.95, *, accuracy=0.7, f=0.55, near=0.05, minutes=None, **more):
    """The tables of a mission: robots that make a reading a round on a network, or that move."""
    known = {"accuracy": accuracy, "fill_ratio": f} | {k: more.pop(k) for k in ("lying", "lie", "failing") if k in more}
    wanted = {"confidence": confidence, "right": more.pop("right", None), "margin": more.pop("margin", None)}
    wanted["half_width"] = None if wanted["right"] else near
    free = {"topology": topology, "brain": brain, "robots": robots, "minutes": minutes, **more}
    if topology != "moving":
        free["observations_per_round"] = 1
    area = {"side": free.pop("side", None)}
    tables = {"area": area, "known": known, "wanted": wanted, "free": free}
    return {name: {k: v for k, v in table.items() if v is not None} for name, table in tables.items()}


MISSIONS = {
    "networks": [
        on("ring"),
        on("ring", "minimalistic", confidence=0.9),
        on("ring", robots=30, confidence=0.8, f=[0.2, 0.8]),
        on("ring", accuracy=SKEWED, f=[0.1, 0.9]),
        on("ring", "minimalistic", accuracy=SKEWED, f=[0.1, 0.9]),
        on("full", robots=20),
        on("full", robots=20, confidence=0.9, accuracy=SKEWED),
        on("full", "minimalistic", robots=12, confidence=0.975),
        on("full", robots=8, confidence=0.99, near=0.1),
        on("full", robots=15, right="majority", margin=0.1, f=[0, 1]),
        on("line", robots=8, confidence=0.9),
        on("line", accuracy=SKEWED, f=0.3),
        on("scale-free", robots=20, confidence=0.9),
        on("scale-free", accuracy="U(0.6,0.9)", confidence=0.975),
        on(SMALL_WORLD, robots=16),
        on(SMALL_WORLD, "minimalistic", robots=16, accuracy=0.8, right=10, margin=0.03, f=[0.2, 0.6]),
    ],
    "moving": [
        on("moving", side=1.5, robots=4),
        on("moving", side=1.5, robots=6, confidence=0.9, accuracy=SKEWED),
        on("moving", "minimalistic", side=2, robots=8, near=0.08),
        on("moving", side=2, robots=8, accuracy=0.8, f=[0.3, 0.7]),
        on("moving", density=5, robots=6, confidence=0.8),
        on("moving", density=10, robots=10, near=0.08, confidence=0.975),
        on("moving", side=2, robots=6, accuracy=SKEWED, near=0.08),
        on("moving", side=2, robots=5, failing=0.2, near=0.1, confidence=0.9),
    ],
    "smallest swarm": [
        on("full", robots=None, minutes=0.2),
        on("full", robots=None, minutes=0.1, confidence=0.9),
        on("full", robots=None, minutes=0.2, accuracy=SKEWED, f=[0.1, 0.9]),
        on("full", robots=None, minutes=0.1, accuracy=0.8, confidence=0.975),
        on("ring", robots=None, minutes=0.3, confidence=0.9),
        on("ring", robots=None, minutes=0.2, confidence=0.8),
        on("moving", robots=[2, 80], minutes=0.2, side=2, accuracy=0.8, near=0.08),
        on("moving", robots=[2, 80], minutes=0.3, side=2, accuracy=SKEWED, confidence=0.9),
    ],
    "liars": [
        on("full", "steadfast", lying=0.1, lie="opposite"),
        on("full", "steadfast", lying=0.1, lie="shouter", robots=20, confidence=0.9),
        on("full", "steadfast", lying=0.2, lie="opposite", accuracy=SKEWED, near=0.08),
        on("full", "steadfast", lying=0.2, lie="jammer", accuracy=0.8, confidence=0.9),
        on("ring", "steadfast", lying=0.1, lie="opposite", accuracy=0.8, near=0.08),
        on("scale-free", "steadfast", lying=0.1, lie="shouter", robots=16, near=0.08),
        on("moving", "steadfast", lying=0.1, lie="opposite", robots=8, side=2, near=0.1),
        on("full", "steadfast", lying=0.1, lie="opposite", robots=[4, 90], minutes=0.2, near=0.08, confidence=0.9),
    ],
}  # fmt: skip


class Again(NamedTuple):
    """An answer run again: shares of right robots, (value, low, high), and at the ends of the plan's interval."""

    at: tuple[float, float, float]
    below: float  # at the lower end, where the promise should not be kept yet
    above: float | None  # at the upper end, where there is one
    fewer: float | None  # with a robot less than the smallest swarm


def again(mission, row, trials, jobs):
    """Run it again."""
    brain = next(one for one in mission.brains if one.label == row.brain)
    lie = next((one for one in mission.lies if one.label == row.lie), None)
    case = Case(row.fill_ratio, lie)

    def shares(robots, minutes):
        times = [max(1, round(one / mission.round_minutes)) for one in minutes]
        study = study_of(mission, robots, [brain], [case], sorted(set(times)), trials, mission.seed + OTHER)
        [curve] = curves(mission, study, jobs, lambda _: None)
        return [curve.at(curve.rounds.index(one)) for one in times]

    if row.robots_low is None:
        ends = [row.minutes_low, row.minutes] + ([row.minutes_high] if row.minutes_high else [])
        below, at, *above = shares(row.robots, ends)
        return Again(tuple(at), below.value, above[0].value if above else None, None)
    [at] = shares(row.robots, [row.minutes])
    below, above, fewer = (
        shares(robots, [row.minutes])[0].value if robots else None
        for robots in (row.robots_low - 1, row.robots_high, row.robots - 1)
    )
    if mission.free.robots and row.robots_low == mission.free.robots[0]:
        below = 0.0  # no smaller one was allowed
    return Again(tuple(at), below or 0.0, above, fewer)


def told(tables):
    """A mission in a few words."""
    free, known, wanted = tables["free"], tables["known"], tables["wanted"]
    topology = free["topology"] if isinstance(free["topology"], str) else "small world"
    asked = f"{free['robots']} robots" if isinstance(free.get("robots"), int) else f"{free['minutes']} min"
    accuracy = "skewed" if known["accuracy"] == SKEWED else known["accuracy"]
    lie = f", {100 * known['lying']:g} % {known['lie']}" if "lying" in known else ""
    goal = wanted.get("half_width") or wanted["right"]
    return f"{topology}, {free['brain']}, {asked}, {accuracy}, {goal}{lie}"


def percent(shares):
    """A share with its interval."""
    value, low, high = (100 * one for one in shares)
    return f"{value:.1f} [{low:.1f}, {high:.1f}]"


def main():
    """The table, and what it comes to."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    console = Console(width=170)
    table, sums = (Table(box=None, header_style="", pad_edge=False) for _ in range(2))
    right = ("plan: right %", "new: right %")
    for name in ("mission", "promised", "answer", *right, "share inside", "answer inside", "one robot fewer"):
        table.add_column(name, justify="left" if name == "mission" else "right", no_wrap=True)
    for name in ("", "plans", "new - promised", "standard error", "new - plan", "share inside", "answer inside"):
        sums.add_column(name, justify="right" if name else "left")
    found = {}
    for kind, missions in MISSIONS.items():
        for number, tables in enumerate(missions):
            tables = {"trials": options.trials, "seed": 100 * options.seed + number} | tables
            mission = mission_of(tables)
            [row] = sc.plan(tables, options.jobs, lambda _: None).rows
            new, promised = again(mission, row, AGAIN, options.jobs), mission.wanted.confidence
            holds = row.share.low <= new.at[0] <= row.share.high
            within = new.below <= promised and (new.above is None or new.above >= promised)
            fewer = np.nan if new.fewer is None else new.fewer
            figures = (new.at[0] - promised, new.at[0] - row.share.value, fewer - promised, holds, within)
            found.setdefault(kind, []).append(figures)
            answer = f"{row.minutes:.3g} min" if row.robots_low is None else f"{row.robots} robots"
            table.add_row(
                told(tables), f"{100 * promised:g}", answer, percent(row.share), percent(new.at),
                "yes" if holds else "NO", "yes" if within else "NO",
                "" if new.fewer is None else f"{100 * new.fewer:.1f}",
            )  # fmt: skip
    console.print(table)
    console.print()
    found["all"] = [one for kind in found.values() for one in kind]
    for kind, each in found.items():
        short, told_short, fewer, holds, within = np.array(each, float).T
        error = short.std(ddof=1) / np.sqrt(len(each))
        sums.add_row(
            kind, f"{len(each)}", f"{100 * short.mean():+.2f}", f"{100 * error:.2f}", f"{100 * told_short.mean():+.2f}",
            f"{holds.sum():.0f}", f"{within.sum():.0f}",
        )  # fmt: skip
    console.print(sums)
    console.print(
        f"smallest swarms with one robot fewer: new - promised {100 * np.nanmean(fewer):+.2f}\n"
        "new: share of robots that are right in new trials; "
        "one robot fewer: the same with one robot fewer than planned\n"
        "share inside: the plan's interval of right % holds the new share\n"
        "answer inside: the plan's interval of the time or size holds the one at which new trials keep the promise"
    )


if __name__ == "__main__":
    main()
