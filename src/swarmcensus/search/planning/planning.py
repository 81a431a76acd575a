"""Plans missions: `sc.plan`."""

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarmcensus.runs import Device, Hardware, Report, showing
from swarmcensus.search.planning.areas import Unreachable
from swarmcensus.search.planning.mission import Mission, missions_of, tables_of
from swarmcensus.search.planning.plans import Need, Plan, Question
from swarmcensus.search.planning.predictions import with_worst_accuracy
from swarmcensus.search.planning.search import Search
from swarmcensus.search.planning.shortest_time import shortest
from swarmcensus.search.planning.smallest_swarm import smallest
from swarmcensus.studies import Study, with_values
from swarmcensus.support.errors import StudyError
from swarmcensus.support.formatting import counted
from swarmcensus.support.toml_text import plain, read_toml

LOG = logging.getLogger(__name__)


def plan(
    study: Study | Mapping[str, Any] | str | Path, jobs: int | None = None, progress: Report | bool = True, *,
    set: Mapping[str, Any] = {}, where: str = "mission", base: Path | None = None, device: Device = "cpu",
) -> Plan:  # fmt: skip
    """Find how long a mission takes, how many robots it needs, or the trade-off between both (docs/planning.md).

    `study` is a study with a table `wanted`, a study file, or its tables, in which `robots` and `wanted.minutes` may be
    {"choose": [low, high]}, and the accuracy, the fill ratio and adversaries {"worst": [...]}. `set` are values in
    place of those of its keys. The folder `base` has the files that tables name. The question follows from what is
    given: a number of robots asks for the shortest time, a number of minutes for the smallest swarm, a range of robots
    for the trade-off, and a number of both for whether they are enough. Theory predicts the answer, and simulation
    confirms it in the study's number of `trials`, with the same seeds for all brains. `jobs` is the number of threads,
    by default one per core; the numbers do not depend on it. `progress` and `device` are as for `run`. Raises
    InputError, also if the goal cannot be reached.
    """
    if isinstance(study, str | Path):
        where, base, tables = f"study file {study}", Path(study).parent, tables_of(study)
    else:
        tables = dict(study) if isinstance(study, Mapping) else read_toml(study.text, where)
    missions = missions_of(with_values(tables, plain(set)), where, base)
    question, rows = question_of(missions[0]), list[Need]()
    hardware = Hardware(jobs, device)
    if device != "cpu" and any(one.moves for one in missions):
        LOG.info("%s: all settings run on the CPU: robots move", missions[0].study.name)
        hardware = Hardware(jobs)
    with showing(progress, "mission") as show:
        missions = with_worst_accuracy(missions)
        searches = [Search(one, hardware, show) for one in missions]
        try:
            for search in searches:
                rows += _rows(search, question_of(search.mission))
        except Unreachable as error:
            raise StudyError.within(where, error) from None
    if question != "enough" and all(row.answer == "not reached" for row in rows):
        raise StudyError.within(where, f"the goal cannot be reached, because {_how_close(missions[0], rows)}")
    return Plan(question, missions, rows)


def question_of(mission: Mission) -> Question:
    """The question that a mission asks, from what it gives."""
    robots, minutes = mission.robots, mission.minutes
    timed = minutes is not None and minutes[0] == minutes[1]
    if robots is not None and robots[0] == robots[1]:
        return "enough" if timed else "how long"
    if robots is None and minutes is None:
        given = "a number, or {choose = [low, high]}"
        raise StudyError(f"swarm.robots or wanted.minutes should be given: {given}", key="swarm.robots")
    return "how many" if timed else "trade-off"


def _rows(search: Search, question: Question) -> list[Need]:
    mission = search.mission
    if question in ("how long", "trade-off"):
        return [row for size in search.tried_sizes for row in shortest(search, size)]
    assert mission.minutes is not None
    return [smallest(search, brain, mission.minutes[0]) for brain in mission.study.swarm.brain]


def _how_close(mission: Mission, rows: list[Need]) -> str:
    """How close the best row comes to the goal, in words."""
    best = max(rows, key=lambda row: row.share.value)
    value, low, high = (100 * part for part in best.share)
    among = f" among liars ({best.lie})" if best.lie else ""
    longer = "" if mission.minutes or best.lie else ": set wanted.minutes for more"
    return (
        f"in {best.minutes:.3g} min only {value:.1f} % [{low:.1f}, {high:.1f}] of {counted(best.robots, 'robot')} with "
        f"{best.brain} are {mission.goal} at f = {best.fill_ratio:g}{among}, not "
        f"{100 * mission.wanted.probability:g} %{longer}"
    )
