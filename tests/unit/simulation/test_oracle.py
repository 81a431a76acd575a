"""The upper bound: the oracle's estimate is the maximum of the pooled likelihood, whatever hinders other brains."""

import numpy as np
import pytest
from scipy.optimize import brentq

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.engine.constants import SENSING
from swarmcensus.simulation import sampling
from swarmcensus.summaries.replaying import recording
from swarmcensus.support.errors import InputError
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
    assert (stops[SENSING] == 5).sum() == 3
    assert (stops == 5).sum() == 3


@pytest.mark.parametrize(("black", "looks"), [((6.0, 0.0), (6.0, 1.0)), ((0.0, 1.0), (8.0, 2.0))])
def test_steps_end_at_the_maximum_where_whole_ones_go_to_and_fro(black, looks):
    """Of two robots, of which one sees perfectly, few readings."""
    sides, own = (0.7, 1.0), ORACLE.functions
    states = [ORACLE.robot(side, side) for side in sides]
    for me, blacks, seen in zip(states, black, looks, strict=True):
        own.observe(me, blacks, seen)
    for _ in range(300):
        said = [own.broadcast(me) for me in states]
        for me, message in zip(states, reversed(said), strict=True):
            own.receive(me, message)
            own.fuse(me)
    best = most_likely(*map(np.array, (sides, sides, looks, black)))
    assert [own.estimate(me) for me in states] == pytest.approx([best] * 2, abs=1e-9)
