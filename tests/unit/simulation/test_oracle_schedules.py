"""The upper bound where the floor changes or sensors drift: near a maximum likelihood that knows when."""

import numpy as np
import pytest
from scipy.optimize import minimize

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.simulation import sampling
from swarmcensus.summaries.replaying import recording
from swarmcensus.worlds.changes import along

DRIFT = {"start": "U(0.6, 0.95)", "drift": -0.002, "least": 0.55}
MIXED = {"black": "U(0.6, 0.95)", "white": "U(0.5, 0.9)"}
SWITCH = {"from": 0.8, "to": 0.3, "at": 40}
RAMP = {"from": 0.85, "to": 0.3, "at": 30, "until": 70}
LATE = {"from": 0.2, "to": 0.9, "at": 70, "until": 200}
LOOKS, ROUNDS = 3, 100


def study(accuracy, fill_ratio, **other):
    swarm = {"brain": "oracle", "robots": 12, "accuracy": accuracy} | other.pop("swarm", {})
    world = {"topology": "ring", "fill_ratio": fill_ratio} | other.pop("world", {})
    schedule = other.pop("schedule", {"rounds": ROUNDS, "observations_per_round": LOOKS})
    return sc.Study(**{"seed": 6, "trials": 20} | other, swarm=swarm, world=world, schedule=schedule)


def most_likely(setting, b, w, blacks, looks, rounds):
    """The last fill ratio of the likelihood's maximum over the first and the last one, given when f changes.

    `blacks` (step, robot) counts black ones of `looks` readings in the steps of `rounds`. Also its standard error.
    """
    k = rounds[:, np.newaxis]
    drift = setting.accuracy.drift
    if drift is not None:
        slope, least, most = drift.numbers
        b, w = (np.clip(side + slope * (k - 1), np.minimum(least, side), np.maximum(most, side)) for side in (b, w))
    g = along(np.array([0.0, 1.0, *setting.course[2:]]), k) if setting.change else np.zeros(k.shape)
    if setting.change and setting.change.until is None:
        since = rounds >= setting.change.at  # earlier readings are of another fill ratio
        b, w = (np.broadcast_to(side, blacks.shape)[since] for side in (b, w))
        blacks, g = blacks[since], np.ones((since.sum(), 1))

    def of(ends):
        x = (1 - g) * ends[0] + g * ends[1]
        p = np.clip(b * x + (1 - w) * (1 - x), 1e-12, 1 - 1e-12)
        score = (b + w - 1) * (blacks / p - (looks - blacks) / (1 - p))
        worth = (b + w - 1) ** 2 * looks / (p * (1 - p))
        return -(blacks * np.log(p) + (looks - blacks) * np.log(1 - p)).sum(), score, worth

    def loss(ends):
        value, score, _ = of(ends)
        return value, -np.array([((1 - g) * score).sum(), (g * score).sum()])

    best = minimize(loss, [0.5, 0.5], jac=True, bounds=[(0, 1)] * 2, method="L-BFGS-B", options={"ftol": 1e-15}).x
    last, worth = g[-1, 0], of(best)[2]
    parts = np.array([[(u * v * worth).sum() for u in (1 - g, g)] for v in (1 - g, g)])
    way = np.array([1 - last, last])
    return way @ best, np.sqrt(way @ np.linalg.pinv(parts) @ way)


@pytest.mark.long(but=["switch"])
@pytest.mark.parametrize(
    ("accuracy", "fill_ratio", "near"),
    [
        (MIXED, SWITCH, 0.1), (DRIFT, 0.3, 0.15), (DRIFT, SWITCH, 0.15), (MIXED, RAMP, 0.15), (DRIFT, RAMP, 0.15),
        (MIXED, LATE, 0.15), (DRIFT, LATE, 0.15),
    ],
    ids=["switch", "drift", "switch and drift", "ramp", "ramp and drift", "during a ramp", "during a ramp, and drift"],
)  # fmt: skip
def test_oracle_is_near_the_informed_maximum(accuracy, fill_ratio, near):
    """Root mean square of the distance, in standard errors of the maximum."""
    made = study(accuracy, fill_ratio)
    results, [setting] = sc.run(made), made.settings()
    truth = setting.fill_ratios([ROUNDS])[0]
    off, errors = [], []
    for trial in range(made.trials):
        readings, _ = recording(results, 0, trial)
        b, w = (side[0] for side in sampling.accuracies(setting, made.seed, trial, 1)[:2])
        best, error = most_likely(setting, b, w, readings, 1, 1 + np.arange(ROUNDS * LOOKS) // LOOKS)
        final = results["final_estimate"].values[0, trial]
        assert np.ptp(final) < 1e-12
        off.append((final[0] - best) / error)
        errors.append((final[0] - truth) / error)
    assert np.sqrt(np.mean(np.square(off))) < near
    assert np.sqrt(np.mean(np.square(errors))) < 1.5  # 1 is the bound


def test_a_robot_alone_counts_rounds_by_its_readings():
    """It ends a round after each reading, of which a round of the schedule has three: white from round 5 on."""
    oracle = brains.load("oracle")
    me, functions = oracle.robot(0.9, 0.8), oracle.functions
    me.change, me.until, me.fuses = 5.0, 5.0, float(LOOKS)
    for reading in range(8 * LOOKS):
        functions.observe(me, float(reading < 4 * LOOKS), 1.0)
        functions.fuse(me)
    assert (me.t, me.n) == (4 * LOOKS, 0)
    assert functions.estimate(me) == 0.0
