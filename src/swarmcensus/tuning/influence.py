"""Which of the values found change nothing: they are no finding, and stay as they were."""

from collections.abc import Callable

import numpy as np

from swarmcensus.basics.seeds import seed_for
from swarmcensus.runs.collect import Progress
from swarmcensus.tuning.plans import Plan
from swarmcensus.tuning.trying import Floats, Training

Values = tuple[float, ...]


def without_idle(
    plan: Plan, values: Values, training: Training, show: Callable[[Progress], None]
) -> tuple[Values, list[str]]:
    """The values found, but those that change no number of any trial as they were before, and which these are.

    Each is tried by itself, then all of them together; where one can stand for another, they are put back one by one,
    as long as that changes nothing.
    """
    changed = [k for k, (value, was) in enumerate(zip(values, plan.start, strict=True)) if value != was]
    if not changed or len(values) == 1:  # where a search finds anything, its only parameter matters
        return values, []

    def as_before(*places: int) -> Values:
        return tuple(plan.start[k] if k in places else value for k, value in enumerate(values))

    def same(places: list[int]) -> bool:
        [other] = _tried(plan, [as_before(*places)], training, show)
        return np.array_equal(found, other, equal_nan=True)

    found, *others = _tried(plan, [values, *map(as_before, changed)], training, show)
    idle = [k for k, other in zip(changed, others, strict=True) if np.array_equal(found, other, equal_nan=True)]
    if len(idle) > 1 and not same(idle):
        alone, idle = idle, []
        for k in alone:
            if same([*idle, k]):
                idle.append(k)
    return as_before(*idle), [plan.ranges[k].place for k in idle]


def _tried(plan: Plan, candidates: list[Values], training: Training, show: Callable[[Progress], None]) -> list[Floats]:
    """The numbers of candidates on the same training trials, (measure, world, trial) each."""
    kept: dict[int, Floats] = {}
    brains = [plan.brain_of(values) for values in candidates]
    training.run(brains, seed_for(plan.study.seed, "influence"), kept.__setitem__, show)
    return [kept[place] for place in range(len(candidates))]
