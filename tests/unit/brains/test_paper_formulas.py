"""The shipped brains against the paper's formulas by hand and against the exact likelihood by brute force."""

import decimal
import math
from decimal import Decimal
from itertools import product
from types import SimpleNamespace

import networkx as nx
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import swarmcensus as sc
from swarmcensus import brains
from tests.support.small import study_of

MINIMALISTIC = brains.load("minimalistic")
LEGACY = brains.load("legacy")
COUNTS = [(t, n) for t in (1, 2, 7, 40) for n in sorted({0, 1, t // 3, t // 2, t - 1, t}) if n <= t]
SENSORS = [(b, w) for b, w in product((0.05, 0.3, 0.525, 0.675, 0.9, 1.0), repeat=2) if abs(b + w - 1) > 1e-9]


def looked(t, n, b, w, brain=MINIMALISTIC):
    me = brain.robot(b, w)
    brain.functions.observe(me, float(n), float(t))
    return me


def likelihood(f, t, n, b, w):
    """ln p(n blacks of t | f) without the binomial coefficient, exact to 60 digits."""
    p = b * f + (1 - w) * (1 - f)
    parts = [c * q.ln() if q > 0 else Decimal("-Infinity") for c, q in ((n, p), (t - n, 1 - p)) if c]
    return sum(parts, Decimal(0))


@pytest.mark.parametrize(("t", "n", "b", "w", "expected"), [
    (10, 4, 1.0, 1.0, 0.4),  # perfect sensors: n / t
    (10, 5, 0.8, 0.6, (0.5 + 0.6 - 1) / (0.8 + 0.6 - 1)),  # Eq. 4, second case
    (10, 3, 0.8, 0.6, 0.0),  # n <= (1 - w) t
    (10, 9, 0.8, 0.6, 1.0),  # n >= b t
    (10, 4, 0.8, 0.6, 0.0),  # at the lower end itself
    (10, 8, 0.8, 0.6, 1.0),  # at the upper end itself
    (10, 3, 0.2, 0.4, (0.3 + 0.4 - 1) / (0.2 + 0.4 - 1)),  # a liar, ends exchanged
    (10, 1, 0.2, 0.4, 1.0),
    (10, 7, 0.2, 0.4, 0.0),
])  # fmt: skip
def test_paper_by_hand(t, n, b, w, expected):
    assert looked(t, n, b, w).x_hat == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize(("b", "w"), SENSORS)
def test_maximises_the_exact_likelihood(b, w):
    for t, n in COUNTS:

        def cost(f, t=t, n=n):
            """-ln p(n blacks of t | f) without the binomial coefficient."""
            p = b * f + (1 - w) * (1 - f)
            return -sum(c * math.log(q) if q > 0 else -math.inf for c, q in ((n, p), (t - n, 1 - p)) if c)

        x_hat = looked(t, n, b, w).x_hat
        brute = minimize_scalar(cost, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-12})
        assert cost(x_hat) <= min(brute.fun, cost(0.0), cost(1.0)) + 1e-9 * t
        if min(cost(0.0), cost(1.0)) > brute.fun + 1e-6:
            assert x_hat == pytest.approx(brute.x, abs=1e-4)


@pytest.mark.parametrize(("b", "w"), SENSORS)
def test_second_derivative_of_the_exact_likelihood(b, w):
    for t, n in COUNTS:
        me = looked(t, n, b, w)
        with decimal.localcontext(prec=80):
            h = Decimal("1e-25")
            db, dw = Decimal(b), Decimal(w)
            p = Decimal(n) / t if 0.0 < me.x_hat < 1.0 else None
            f = (p + dw - 1) / (db + dw - 1) if p is not None else Decimal(me.x_hat)
            low, mid, high = (likelihood(x, t, n, db, dw) for x in (f - h, f, f + h))
            assert Decimal("-Infinity") not in (low, mid, high), "the likelihood vanishes beside its own maximum"
            curvature = -(low - 2 * mid + high) / h**2
        assert me.alpha == pytest.approx(float(curvature), rel=1e-6)


@pytest.mark.parametrize("n", [0, 4, 10])
@pytest.mark.parametrize(("b", "w"), [(1.0, 1.0), (1.0, 0.7), (0.7, 1.0)])
def test_limits_of_perfect_accuracies(n, b, w):
    """At b = 1 or w = 1 the values are those that accuracies just below approach."""
    near = looked(10, n, min(b, 1 - 1e-9), min(w, 1 - 1e-9))
    at = looked(10, n, b, w)
    assert at.x_hat == pytest.approx(near.x_hat, abs=1e-7)
    assert at.alpha == pytest.approx(near.alpha, rel=1e-6)


@pytest.mark.parametrize(("b", "w"), [(0.5, 0.5), (0.7, 0.3), (0.9, 0.1), (1.0, 0.0), (0.0, 1.0)])
def test_no_information(b, w):
    me = looked(10, 6, b, w)
    assert (me.x_hat, me.alpha) == (0.5, 0.0)


@pytest.mark.parametrize("brain", [MINIMALISTIC, LEGACY], ids=lambda b: b.name)
def test_eqs_6_to_8_and_legacy_by_hand(brain):
    x_bar, beta = ((0.2 * 3 + 0.6 * 1) / 4, 4.0) if brain is MINIMALISTIC else (0.4, 2 / (1 / 3 + 1 / 1))
    me = looked(10, 5, 0.9, 0.8, brain)
    alpha, x_hat = me.alpha, me.x_hat
    for message in ((0.2, 3.0), (0.6, 1.0)):
        brain.functions.receive(me, message)
    brain.functions.fuse(me)
    assert (me.x_bar, me.beta) == pytest.approx((x_bar, beta))
    assert me.x == pytest.approx((alpha * x_hat + beta * x_bar) / (alpha + beta))
    assert brain.functions.estimate(me) == me.x


@pytest.mark.parametrize("brain", [MINIMALISTIC, LEGACY], ids=lambda b: b.name)
def test_without_neighbours_the_last_social_value_stays(brain):
    me = looked(10, 5, 0.9, 0.8, brain)
    brain.functions.receive(me, (0.2, 3.0))
    brain.functions.fuse(me)
    social = me.x_bar, me.beta
    brain.functions.observe(me, 9.0, 10.0)
    brain.functions.fuse(me)
    assert (me.x_bar, me.beta) == social
    assert me.x == pytest.approx((me.alpha * me.x_hat + 0.2 * 3) / (me.alpha + 3))


# ---- commons and swift: against matrices in NumPy, consistent whatever is lost, old, moved or broken
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
@pytest.mark.parametrize("given", [
    {"link_success": 0.1},
    {"topology": "scale-free", "link_success": 0.5, "accuracy": "U(0.55, 0.95)"},
    {"faults": FAILING},
    {"ticks": 1000, "density": 3, "body": {"message_delay": 4, "tile": 0.01}, "link_success": 0.5},
], ids=["losses", "unequal", "failing", "moving and late"])  # fmt: skip
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


@pytest.mark.long(only=["full"])
@pytest.mark.parametrize("topology", ["full", "line", "ring", "wheel"])
def test_momentum_is_given_up_in_full_networks(topology):
    """Where everyone hears everyone, to the last digit: it is commons there."""
    wheel = nx.wheel_graph(7)
    wheel.name = "wheel"
    world = {"topology": wheel if topology == "wheel" else topology}
    found = sc.run(study_of(["commons", "swift"], robots=7, rounds=500, trials=5, seed=5, **world))
    assert np.array_equal(*found["final_estimate"].values) == (topology == "full")


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
