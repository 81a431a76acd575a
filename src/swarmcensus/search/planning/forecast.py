"""How long a plan will take, from the time that theory predicts and the measured speed of its brains."""

from collections.abc import Sequence

from swarmcensus.runs import Progress, compile_for, placing_of_study, seconds_for
from swarmcensus.search.planning.mission import FEWEST_TRIALS
from swarmcensus.search.planning.plans import Question
from swarmcensus.search.planning.search import MOST_SECONDS, Search, cases_to_confirm
from swarmcensus.search.planning.shortest_time import CONFIRM_FACTOR, FIRST_LOOK_FACTOR, LEAST
from swarmcensus.search.planning.simulating import Case, affordable, study_of
from swarmcensus.search.planning.smallest_swarm import AROUND, theory_size

SLOWEST = 2.6  # how many times theory's time the slowest brain usually takes
SIZES_TRIED = 6  # of a search for the smallest swarm, usually


def seconds_of(search: Search, question: Question) -> float:
    """The seconds of a mission's simulations in one world. Raises Unreachable as the search does."""
    search.check_reach(search.mission.sizes[1])
    mission, minutes = search.mission, search.mission.minutes
    confirmed = cases_to_confirm(search.cases)
    if question in ("how long", "trade-off"):
        whole = 0.0
        for size in search.tried_sizes:
            slowest = SLOWEST * search.predict(size).mixed
            if minutes is not None:
                slowest = min(slowest, mission.rounds(minutes[1]) / CONFIRM_FACTOR)
            looks = _seconds(search, size, search.cases, FIRST_LOOK_FACTOR * slowest, FEWEST_TRIALS)
            whole += looks + _seconds(search, size, confirmed, CONFIRM_FACTOR * slowest, mission.study.trials)
        return whole
    assert minutes is not None
    rounds, size = mission.rounds(minutes[0]), theory_size(search, minutes[0])
    looks, confirmations = (SIZES_TRIED, 1 + 2 * AROUND) if question == "how many" else (bool(search.inner), 1)
    # theory knows the worst case unless robots lie, so "enough" looks at few trials only if there are inner fill ratios
    few = looks * _seconds(search, size, search.cases, rounds, FEWEST_TRIALS) if looks else 0.0
    return few + confirmations * _seconds(search, size, confirmed, rounds, mission.study.trials)


def _seconds(search: Search, robots: int, cases: Sequence[Case], rounds: float, trials: int) -> float:
    mission = search.mission
    study = study_of(mission, robots, mission.brains, cases, [max(LEAST, int(rounds))], trials, mission.study.seed)
    settings, placing = study.settings(), placing_of_study(study, search.device)
    compile_for(
        [(study, placing.on_cpu(settings))],
        lambda note, steps: search.show(Progress(0, 0, 0.0, 0.0, note, steps=steps)),
    )
    trials = min(trials, max(affordable(study, MOST_SECONDS), 1))
    return seconds_for(study, settings, trials, search.jobs, placing=placing)
