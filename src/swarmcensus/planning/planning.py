"""Missions planned: `sc.plan`."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.planning.areas import NoNetwork
from swarmcensus.planning.mission import Mission, load_mission, mission_of, text_of
from swarmcensus.planning.plans import Plan, Question, Row
from swarmcensus.planning.predictions import hardest
from swarmcensus.planning.search import BEGUN, Beyond, Search
from swarmcensus.planning.shortest_time import shortest
from swarmcensus.planning.smallest_swarm import enough, smallest
from swarmcensus.runs.collect import Progress
from swarmcensus.runs.pools import thread_count

SIZES = 5  # of a range of robots that a trade-off looks at


def plan(
    mission: Mapping[str, Any] | str | Path,
    jobs: int | None = None,
    progress: Callable[[Progress], None] | None = None,
    *,
    where: str = "mission",
    base: Path | None = None,
) -> Plan:
    """Find how long a mission takes, how many robots it needs, or what one costs in the other.

    `mission` is a mission file or its tables, in which files are looked for in `base`. What is asked follows from what
    is given: with a number of robots the shortest time is sought, with a number of minutes the smallest swarm, with a
    range of robots the trade-off, and with a number of both whether they are enough. Each is found from theory, and
    confirmed by simulation in so many `trials` of the mission, on the same seeds for all brains. `jobs` threads, by
    default one a core; the numbers do not depend on it. Raises InputError, also where the goal cannot be reached.
    """
    if isinstance(mission, str | Path):
        where, base, tables = f"mission file {mission}", Path(mission).parent, load_mission(mission)
    else:
        tables = dict(mission)
    checked = mission_of(tables, where, base)
    asked, rows, so_far = question_of(checked), [], BEGUN
    for world in hardest(checked).worlds:
        search = Search(world, thread_count(jobs), progress or (lambda _: None), so_far)
        try:
            rows += _rows(search, asked)
        except Beyond as beyond:
            raise InputError(f"{where}: the goal cannot be reached, because {beyond}") from None
        except NoNetwork as error:
            raise InputError(f"{where}: {error}") from None
        so_far = search.so_far
    if asked != "enough" and all(row.answer == "not reached" for row in rows):
        raise InputError(f"{where}: the goal cannot be reached, because {_short_of(checked, rows)}")
    return Plan(asked, checked, rows, text_of(tables))


def question_of(mission: Mission) -> Question:
    """What a mission asks."""
    robots, minutes = mission.free.robots, mission.free.minutes
    timed = minutes is not None and minutes[0] == minutes[1]
    if robots is not None and robots[0] == robots[1]:
        return "enough" if timed else "how long"
    return "how many" if timed else "trade-off"


def _rows(search: Search, asked: Question) -> list[Row]:
    robots, minutes = search.mission.free.robots, search.mission.free.minutes
    if asked == "how long":
        assert robots is not None
        return shortest(search, robots[0])
    if asked == "enough":
        assert robots is not None
        assert minutes is not None
        return [enough(search, brain, robots[0], minutes[0]) for brain in search.mission.brains]
    if asked == "how many":
        assert minutes is not None
        return [smallest(search, brain, minutes[0]) for brain in search.mission.brains]
    sizes = np.unique(np.geomspace(*search.sizes, SIZES).round().astype(int)).tolist()
    return [row for size in sizes for row in shortest(search, size)]


def _short_of(mission: Mission, rows: list[Row]) -> str:
    """How near the best of them comes."""
    best = max(rows, key=lambda row: row.share.value if row.share else 0.0)
    assert best.share is not None
    value, low, high = (100 * one for one in best.share)
    among = f" among {100 * mission.known.lying:g} % of liars ({best.lie})" if best.lie else ""
    longer = "" if mission.free.minutes or best.lie else ": free.minutes allows more"
    return (
        f"in {best.minutes:.3g} min only {value:.1f} % [{low:.1f}, {high:.1f}] of {counted(best.robots, 'robot')} with "
        f"{best.brain} are {mission.goal} at f = {best.fill_ratio:g}{among}, not "
        f"{100 * mission.wanted.confidence:g} %{longer}"
    )
