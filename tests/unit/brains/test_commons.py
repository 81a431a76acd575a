"""Commons and swift: against matrices in NumPy, consistent whatever is lost, old, moved or broken, sooner where still.

Tests of draws state their error rate: the chance that what is right fails them, were the seed not fixed.
"""

from types import SimpleNamespace

import networkx as nx
import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from tests.support.small import study_of

COMMONS, SWIFT = (brains.load(name).functions for name in ("commons", "swift"))
FAILING = [{"at": 40, "robots": 0.3, "stop": ["sensing", "talking"]}, {"at": 90, "robots": 3, "stop": "talking"}]
PATH = np.eye(4) + np.diag([1.0] * 3, 1) + np.diag([1.0] * 3, -1)  # who is heard, the robot itself among them


def states(functions, accuracies):
    """A robot for each pair of accuracies."""
    given = {**functions.MEMORY, **getattr(functions, "PARAMETERS", {})}
    return [SimpleNamespace(**given, b=b, w=w, name=float(i)) for i, (b, w) in enumerate(accuracies)]


def one_round(functions, robots, blacks, looks, heard):
    """Readings, a message from each, and what follows, robot by robot as on a table."""
    for me, black in zip(robots, blacks, strict=True):
        functions.observe(me, black, looks)
    said = [functions.broadcast(me) for me in robots]
    for i, me in enumerate(robots):
        for j, message in enumerate(said):
            if i != j and heard[i, j]:
                functions.receive(me, message)
        functions.fuse(me)
    return [functions.estimate(me) for me in robots]


def test_commons_is_a_matrix_of_means_that_mixes_both_sums():
    """Four robots on a path, sensors apart: s and v by powers of one matrix, f their ratio with the prior."""
    rng = np.random.default_rng(1)
    b, w = np.array([0.9, 0.6, 0.75, 0.3]), np.array([0.8, 0.7, 0.5, 0.4])
    robots = states(COMMONS, zip(b, w, strict=True))
    mixing, slope = PATH / PATH.sum(1, keepdims=True), b + w - 1.0
    s, v = np.zeros((2, 4))
    for _ in range(30):
        blacks = rng.integers(0, 6, 4)
        found = one_round(COMMONS, robots, blacks, 5.0, PATH)
        s, v = mixing @ (s + slope * (blacks - 5.0 * (1.0 - w))), mixing @ (v + slope**2 * 5.0)
        prior = np.minimum(0.25, 0.0625 / v)
        np.testing.assert_allclose(found, np.clip((s + prior / 2) / (v + prior), 0.0, 1.0), rtol=1e-12)


@pytest.mark.long(only=["losses"])
@pytest.mark.parametrize(
    "given",
    [
        {"link_success": 0.1},
        {"topology": "scale-free", "link_success": 0.5, "accuracy": "U(0.55, 0.95)"},
        {"faults": FAILING},
        {"ticks": 1000, "density": 3, "body": {"message_delay": 4, "tile": 0.01}, "link_success": 0.5},
    ],
    ids=["losses", "unequal", "failing", "moving and late"],
)
def test_the_ratio_has_no_bias_whatever_becomes_of_messages(given):
    """The mean over trials is f within its standard error, 4 of them: fails by 6 in 100,000."""
    found = sc.run(study_of("commons", **{"robots": 12, "rounds": 200, "looks": 5, "trials": 60, "seed": 5} | given))
    mean = found["final_estimate"].mean("robot").values[0]
    off = mean - found["true_fill_ratio"].values[0] if "density" in given else mean - 0.55
    assert abs(off.mean()) < 4.0 * off.std(ddof=1) / off.size**0.5 + 0.0005  # and what the prior may leave


def test_swift_is_a_second_order_recursion_of_the_same_matrix():
    """Four robots on a path, no losses: from round 3 on what is said goes beyond the mean by g times the way since."""
    rng = np.random.default_rng(2)
    robots = states(SWIFT, [(0.9, 0.8)] * 4)
    mixing = PATH / PATH.sum(1, keepdims=True)
    said, before = np.zeros((2, 3, 4))  # of s, v, and of 1 a round
    for rounds in range(1, 31):
        blacks = rng.integers(0, 6, 4)
        found = one_round(SWIFT, robots, blacks, 5.0, PATH)
        said += np.stack([0.7 * (blacks - 5.0 * 0.2), np.full(4, 0.7**2 * 5.0), np.ones(4)])
        mean = said @ mixing.T
        gain = mean[2] / rounds
        said, before = mean + (0.9 if rounds > 2 else 0.0) * (mean - before), said
        prior = gain * np.minimum(0.25, 0.0625 * gain / mean[1])
        np.testing.assert_allclose(found, np.clip((mean[0] + prior / 2) / (mean[1] + prior), 0.0, 1.0), rtol=1e-10)
    assert [me.company for me in robots] == [5.0, 14.0, 29.0, 25.0]  # squares of their names, counted from 1


@pytest.mark.long(only=["full-False"])
@pytest.mark.parametrize(
    ("topology", "keeps"), [("full", False), ("line", True), ("ring", True), (nx.wheel_graph(7), True)], ids=str
)
def test_momentum_is_given_up_in_full_networks(topology, keeps):
    """Where everyone hears everyone, to the last digit: it is commons there."""
    if not isinstance(topology, str):
        topology.name = "wheel"
    found = sc.run(study_of(["commons", "swift"], robots=7, rounds=500, trials=5, seed=5, topology=topology))
    assert np.array_equal(*found["final_estimate"].values) != keeps


def test_lost_messages_stop_momentum_nearby():
    robots = states(SWIFT, [(0.9, 0.8)] * 4)
    one_round(SWIFT, robots, [3.0] * 4, 5.0, PATH)
    lost = PATH.copy()
    lost[0, 1] = 0.0
    one_round(SWIFT, robots, [3.0] * 4, 5.0, lost)
    assert [me.company for me in robots] == [-1.0, 14.0, 29.0, 25.0]
    assert [SWIFT.broadcast(me)[2] for me in robots] == [-1.0, 14.0, 29.0, 25.0]
    for far in (1, 2, 3):
        one_round(SWIFT, robots, [3.0] * 4, 5.0, PATH)
        assert [me.company < 0.0 for me in robots] == [True] * (far + 1) + [False] * (3 - far)
