"""How good a candidate is: one number of all its trials in all worlds, each trial's held against the start's.

Worlds have errors of very different size, trials that never end and trials that fail. So each trial's number is made
one in [0, 1], where 1/2 is what the brain as it was usually has in this world, and of these the mean is taken: no world
and no trial can outweigh the others, and what never came, or failed, is the worst that there is.

Some measures are steps: of trials that end without a consensus all are as bad. These have a companion, a measure of how
near a trial came. It is asked only between candidates that the measure itself does not tell apart.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swarmcensus.results.measures import Measure
from swarmcensus.studies.settings import Setting

Floats = NDArray[np.float64]
WORST = 1.0
COMPANIONS = {  # of measures that are the same in whole regions of values: which one breaks their ties
    "consensus_right": "decided_right", "consensus_round": "decided_right", "decided_right": "final_error",
    "decision_round": "decided", "done_round": "done", "correct": "final_error", "right_side": "final_error",
    "first_right": "final_error", "swarm_right": "final_error", "time_right": "final_error",
}  # fmt: skip
FARTHEST = 500.0  # widths from the middle, beyond which a logistic is 0 or 1


def scales_of(numbers: Floats, worlds: Sequence[Setting], measure: Measure, least: float) -> Floats:
    """What is usual in each world, (world, 2), of the start's trials (world, trial): a middle and a width.

    `least` is the smallest number that the measure can be. Of one that is never negative the middle is the median of
    what is above 0 and finite, and the width 0, for ratios to it count; where there is nothing of the kind it is 1, or
    of times the world's own length.
    """
    scales = np.zeros((len(worlds), 2))
    for k, (row, world) in enumerate(zip(numbers, worlds, strict=True)):
        finite = row[np.isfinite(row)]
        if least >= 0:
            above = finite[finite > 0]
            alone = float(world.rounds) if measure.unit == "rounds" else 1.0
            scales[k] = (np.median(above) if above.size else alone), 0.0
        else:
            middle = float(np.median(finite)) if finite.size else 0.0
            width = float(np.abs(finite - middle).mean()) if finite.size else 0.0
            scales[k] = middle, width or 1.0
    return scales


def loss(numbers: Floats, measure: Measure, scales: Floats) -> float:
    """How bad a candidate's trials (world, trial) are, in [0, 1], lower being better; a NaN has failed.

    A share counts as it is. Of other measures the number v of a trial counts as v / (v + s), with the usual s of its
    world: 0 is none, 1/2 what is usual, 1 never. One that may be negative counts as the logistic of its distance from
    what is usual, in usual distances.
    """
    middle, width = scales[:, :1], scales[:, 1:]
    if measure.share:
        bad = numbers if measure.low else 1.0 - numbers
    else:
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = np.where(np.isposinf(numbers), 1.0, numbers / (numbers + middle))
            off = np.clip((numbers - middle) / np.where(width > 0, width, 1.0), -FARTHEST, FARTHEST)
        above = np.where(width > 0, 1.0 / (1.0 + np.exp(-off)), ratio)
        bad = above if measure.low else 1.0 - above
    return float(np.where(np.isnan(numbers), WORST, bad).mean())
