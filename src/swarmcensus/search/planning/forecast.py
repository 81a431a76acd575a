"""How long a plan will take, from the time that theory predicts and the measured speed of its brains."""

from collections.abc import Sequence

from swarmcensus.brains import Brain
from swarmcensus.runs import Progress, compile_for, placing_of_study, seconds_for
from swarmcensus.search.planning.mission import FEWEST_TRIALS
from swarmcensus.search.planning.plans import Question
from swarmcensus.search.planning.search import MOST_SECONDS, Search, cases_to_confirm
from swarmcensus.search.planning.shortest_time import CONFIRM_FACTOR, FIRST_LOOK_FACTOR, LEAST
from swarmcensus.search.planning.simulating import Case, affordable, study_of
from swarmcensus.search.planning.smallest_swarm import AROUND, theory_size

SLOWEST = 2.6  # how many times theory's time the slowest brain usually takes
SIZES_TRIED = 6  # of a search for the smallest swarm, usually


def seconds_of(search: Search, question: Question, sizes: Sequence[int]) -> float:
    """The seconds of a mission's simulations in one world; `sizes` are those of a trade-off.

    Raises Unreachable or NoNetwork as the search does.
    """
    search.check_reach(search.sizes[1])
    mission, brains = search.mission, search.mission.brains
    robots, minutes = mission.free.robots, mission.free.minutes
    confirmed = cases_to_confirm(search.cases)
    whole = 0.0
    if question in ("how long", "trade-off"):
        for size in sizes if question == "trade-off" else [search.sizes[0]]:
            slowest = SLOWEST * search.predict(size).mixed
            if minutes is not None:
                slowest = min(slowest, mission.rounds(minutes[1]) / CONFIRM_FACTOR)
            looks = _seconds(search, size, brains, search.cases, FIRST_LOOK_FACTOR * slowest, FEWEST_TRIALS)
            whole += looks + _seconds(search, size, brains, confirmed, CONFIRM_FACTOR * slowest, mission.trials)
        return whole
    assert minutes is not None
    rounds = mission.rounds(minutes[0])
    if question == "enough":
        assert robots is not None
        looks = _seconds(search, robots[0], brains, search.cases, rounds, FEWEST_TRIALS) if search.inner else 0.0
        return looks + _seconds(search, robots[0], brains, confirmed, rounds, mission.trials)
    size = theory_size(search, minutes[0])
    looks = SIZES_TRIED * _seconds(search, size, brains, search.cases, rounds, FEWEST_TRIALS)
    return looks + (1 + 2 * AROUND) * _seconds(search, size, brains, confirmed, rounds, mission.trials)


def _seconds(
    search: Search, robots: int, brains: Sequence[Brain], cases: Sequence[Case], rounds: float, trials: int
) -> float:
    study = study_of(search.mission, robots, brains, cases, [max(LEAST, int(rounds))], trials, search.mission.seed)
    settings = study.settings()
    placing = placing_of_study(study, search.device)
    compile_for(
        [(study, placing.on_cpu(settings))],
        lambda note, steps: search.show(Progress(0, 0, 0.0, 0.0, note, steps=steps)),
    )
    trials = min(trials, max(affordable(study, MOST_SECONDS), 1))
    return seconds_for(study, settings, trials, search.jobs, placing=placing)
