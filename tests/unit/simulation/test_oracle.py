"""The upper bound: the oracle's estimate is the maximum of the pooled likelihood, whatever hinders other brains."""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.engine.constants import SENSING
from swarmcensus.simulation import sampling
from swarmcensus.summaries.replaying import recording
from swarmcensus.support.errors import InputError
from swarmcensus.worlds.changes import along
from tests.support.small import study_of

ORACLE = brains.load("oracle")
MIXED = {"black": "U(0.55, 1.0)", "white": "U(0.1, 0.9)"}


def most_likely(b, w, t, n):
    """Where the score of all readings changes its sign, or the end of [0, 1] beyond which it would."""
    k = b + w - 1

    def score(x):
        p = np.clip(x * b + (1 - x) * (1 - w), 1e-9, 1 - 1e-9)
        return (k * (n - t * p) / (p * (1 - p))).sum()

    if score(0.0) <= 0 or score(1.0) >= 0:
        return 0.0 if score(0.0) <= 0 else 1.0
    return brentq(score, 0.0, 1.0, xtol=1e-14)


def study(topology, **other):
    swarm = {"brain": "oracle", "robots": 12, "accuracy": MIXED} | other.pop("swarm", {})
    world = {"topology": topology, "fill_ratio": 0.3} | other.pop("world", {})
    rounds = {"ticks": 400} if topology == "moving" else {"rounds": 60, "observations_per_round": 3}
    if topology == "moving":
        world |= {"density": 1.0}
    faults = other.pop("faults", [{"at": 300 if topology == "moving" else 40, "robots": 1.0, "stop": "sensing"}])
    return sc.Study(**{"seed": 4, "trials": 3, "faults": faults} | other, swarm=swarm, world=world, schedule=rounds)


def pooled(made, results, setting, trial, honest=None):
    """The maximum of the pooled likelihood of what a trial's robots saw."""
    found = made.settings()[setting]
    trace = sc.replay(results, setting, trial)
    b, w = (np.broadcast_to(side[0], found.robots) for side in sampling.accuracies(found, made.seed, trial, 1)[:2])
    t, n = trace["t"].values[-1], trace["n"].values[-1]
    keep = slice(None) if honest is None else honest
    return most_likely(b[keep], w[keep], t[keep], n[keep]), trace


@pytest.mark.parametrize("topology", ["ring", "scale-free", "full", "moving"])
def test_it_finds_the_maximum_of_the_pooled_likelihood(topology):
    hindered = {"link_success": 0.3} | ({"body": {"message_delay": 5}} if topology == "moving" else {})
    made = study(topology, swarm={"assumed_accuracy": 0.95}, world=hindered)
    results = sc.run(made)
    for trial in range(3):
        best, trace = pooled(made, results, 0, trial)
        assert 0.0 < best < 1.0
        assert results["final_estimate"].values[0, trial] == pytest.approx(best, abs=1e-12)
        x = trace["x"].values[: 300 if topology == "moving" else 40]
        assert np.ptp(x, axis=1).max() < 1e-14  # one round as the next: they do not drift apart
    assert (results["messages_heard"].values == 11 * (400 if topology == "moving" else 60)).all()


def test_oracle_ignores_networks_and_beliefs():
    made = study_of(
        "oracle", robots=8, accuracy=MIXED, assumed_accuracy=[0.7, {"error": "N(0, 0.2)"}], rounds=30, looks=2,
        trials=2, seed=9, topology=["full", "ring", "line"], fill_ratio=0.6, link_success=[1.0, 0.2],
        message_delay=[0, 5], missing_links=[0.0, 0.9],
    )  # fmt: skip
    results = sc.run(made)
    final = results["final_estimate"].values
    assert len(final) == 48
    assert (final == final[0]).all()
    assert len(set(results["topology"].values.tolist())) == 3  # and is called by what was asked for
    assert len(set(results["link_success"].values.tolist())) == 2


def test_recordings_tell_that_it_hears_all():
    made = study("ring", faults=[])
    readings, edges = recording(sc.run(made), 0, 1)
    assert len(edges) == 12 * 11 / 2
    b, w = (side[0] for side in sampling.accuracies(made.settings()[0], 4, 1, 1)[:2])
    again = sc.infer(readings, edges, {"black": b, "white": w}, 3, brain="oracle")
    assert again["estimate"].values[-1] == pytest.approx(sc.run(made)["final_estimate"].values[0, 1], abs=1e-12)
    with pytest.raises(InputError, match="an oracle hears all"):
        recording(sc.run(study("moving", faults=[])), 0, 0)


def test_who_fails_for_an_oracle_is_who_sees_nothing():
    made = study("ring", faults=[{"at": 5, "robots": 3, "stop": ["talking", "sensing"]}])
    stops = sampling.stops(made.settings()[0], 4, 0)
    assert (stops[SENSING] == 5).sum() == (stops == 5).sum() == 3


@pytest.mark.parametrize(("black", "looks"), [((6.0, 0.0), (6.0, 1.0)), ((0.0, 1.0), (8.0, 2.0))])
def test_steps_end_at_the_maximum_where_whole_ones_go_to_and_fro(black, looks):
    """Of two robots, of which one sees perfectly, few readings."""
    sides, own = (0.7, 1.0), ORACLE.functions
    states = [ORACLE.robot(side, side) for side in sides]
    for me, blacks, seen in zip(states, black, looks, strict=True):
        own.observe(me, blacks, seen)
    for _ in range(300):
        for me, message in zip(states, reversed([own.broadcast(me) for me in states]), strict=True):
            own.receive(me, message)
            own.fuse(me)
    best = most_likely(*map(np.array, (sides, sides, looks, black)))
    assert [own.estimate(me) for me in states] == pytest.approx([best] * 2, abs=1e-9)


# ---- the upper bound where the floor changes or sensors drift: near a maximum likelihood that knows when
DRIFT = {"start": "U(0.6, 0.95)", "drift": -0.002, "least": 0.55}
SIDES = {"black": "U(0.6, 0.95)", "white": "U(0.5, 0.9)"}
SWITCH = {"from": 0.8, "to": 0.3, "at": 40}
RAMP = {"from": 0.85, "to": 0.3, "at": 30, "until": 70}
LATE = {"from": 0.2, "to": 0.9, "at": 70, "until": 200}
LOOKS, ROUNDS = 3, 100


def scheduled(accuracy, fill_ratio, **other):
    swarm = {"brain": "oracle", "robots": 12, "accuracy": accuracy} | other.pop("swarm", {})
    world = {"topology": "ring", "fill_ratio": fill_ratio} | other.pop("world", {})
    schedule = other.pop("schedule", {"rounds": ROUNDS, "observations_per_round": LOOKS})
    return sc.Study(**{"seed": 6, "trials": 20} | other, swarm=swarm, world=world, schedule=schedule)


def likeliest(setting, b, w, blacks, looks, rounds):
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
        (SIDES, SWITCH, 0.1), (DRIFT, 0.3, 0.15), (DRIFT, SWITCH, 0.15), (SIDES, RAMP, 0.15), (DRIFT, RAMP, 0.15),
        (SIDES, LATE, 0.15), (DRIFT, LATE, 0.15),
    ],
    ids=["switch", "drift", "switch and drift", "ramp", "ramp and drift", "during a ramp", "during a ramp, and drift"],
)  # fmt: skip
def test_oracle_is_near_the_informed_maximum(accuracy, fill_ratio, near):
    """Root mean square of the distance, in standard errors of the maximum."""
    made = scheduled(accuracy, fill_ratio)
    results, [setting] = sc.run(made), made.settings()
    truth = setting.fill_ratios([ROUNDS])[0]
    off, errors = [], []
    for trial in range(made.trials):
        readings, _ = recording(results, 0, trial)
        b, w = (side[0] for side in sampling.accuracies(setting, made.seed, trial, 1)[:2])
        best, error = likeliest(setting, b, w, readings, 1, 1 + np.arange(ROUNDS * LOOKS) // LOOKS)
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
