"""Plans missions: `sc.plan`."""

import contextlib
import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarmcensus.runs import Device, Report, announce, check_device, showing, thread_count
from swarmcensus.search.planning.areas import Unreachable
from swarmcensus.search.planning.forecast import seconds_of
from swarmcensus.search.planning.mission import Mission, load_mission, mission_of
from swarmcensus.search.planning.plans import Need, Plan, Question
from swarmcensus.search.planning.predictions import with_worst_accuracy
from swarmcensus.search.planning.search import Search
from swarmcensus.search.planning.shortest_time import shortest
from swarmcensus.search.planning.smallest_swarm import smallest
from swarmcensus.support.errors import InputError, StudyError
from swarmcensus.support.formatting import counted
from swarmcensus.support.toml_text import plain, to_toml

LOG = logging.getLogger(__name__)


def plan(
    mission: Mapping[str, Any] | str | Path, jobs: int | None = None, progress: Report | bool = True, *,
    where: str = "mission", base: Path | None = None, device: Device = "cpu",
) -> Plan:  # fmt: skip
    """Find how long a mission takes, how many robots it needs, or the trade-off between both.

    `mission` is a mission file, or its tables. The folder `base` has the files that tables name. The question follows
    from what is given: a number of robots asks for the shortest time, a number of minutes for the smallest swarm, a
    range of robots for the trade-off, and a number of both for whether they are enough. Theory predicts the answer, and
    simulation confirms it in the mission's number of `trials`, with the same seeds for all brains. `jobs` is the number
    of threads, by default one per core; the numbers do not depend on it. `progress` and `device` are as for `run`.
    Raises InputError, also if the goal cannot be reached.
    """
    if isinstance(mission, str | Path):
        where, base, tables = f"mission file {mission}", Path(mission).parent, load_mission(mission)
    else:
        tables = dict(mission)
    checked = mission_of(tables, where, base)
    question, rows = question_of(checked), []
    jobs = thread_count(jobs)
    check_device(device)
    if device != "cpu" and checked.moves:
        LOG.info("%s: all settings run on the CPU: robots move", checked.name)
        device = "cpu"
    with showing(progress, "mission") as show:
        searches = [Search(world, jobs, show, device) for world in with_worst_accuracy(checked).worlds]
        with contextlib.suppress(Unreachable, InputError):  # the search itself says so
            whole = sum(seconds_of(search, question) for search in searches)
            announce(checked.name, whole, jobs)
            for search in searches:
                search.announced = whole
        try:
            for search in searches:
                rows += _rows(search, question)
        except Unreachable as error:
            raise StudyError.within(where, error) from None
    if question != "enough" and all(row.answer == "not reached" for row in rows):
        raise StudyError.within(where, f"the goal cannot be reached, because {_how_close(checked, rows)}")
    return Plan(question, checked, rows, to_toml(plain(tables)))


def question_of(mission: Mission) -> Question:
    """The question that a mission asks, from what it gives."""
    robots, minutes = mission.free.robots, mission.free.minutes
    timed = minutes is not None and minutes[0] == minutes[1]
    if robots is not None and robots[0] == robots[1]:
        return "enough" if timed else "how long"
    return "how many" if timed else "trade-off"


def _rows(search: Search, question: Question) -> list[Need]:
    mission = search.mission
    if question in ("how long", "trade-off"):
        return [row for size in search.tried_sizes for row in shortest(search, size)]
    assert mission.free.minutes is not None
    return [smallest(search, brain, mission.free.minutes[0]) for brain in mission.brains]


def _how_close(mission: Mission, rows: list[Need]) -> str:
    """How close the best row comes to the goal, in words."""
    best = max(rows, key=lambda row: row.share.value if row.share else 0.0)
    assert best.share is not None
    value, low, high = (100 * part for part in best.share)
    among = f" among {100 * mission.known.lying:g} % of liars ({best.lie})" if best.lie else ""
    longer = "" if mission.free.minutes or best.lie else ": free.minutes allows more"
    return (
        f"in {best.minutes:.3g} min only {value:.1f} % [{low:.1f}, {high:.1f}] of {counted(best.robots, 'robot')} with "
        f"{best.brain} are {mission.goal} at f = {best.fill_ratio:g}{among}, not "
        f"{100 * mission.wanted.confidence:g} %{longer}"
    )
