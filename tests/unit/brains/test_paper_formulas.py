"""The shipped brains against the paper's formulas by hand and against the exact likelihood by brute force."""

import decimal
import functools
import math
from decimal import Decimal
from itertools import product

import pytest
from scipy.optimize import minimize_scalar

from swarmcensus import brains

MINIMALISTIC = brains.load("minimalistic")
LEGACY = brains.load("legacy")
COUNTS = [(t, n) for t in (1, 2, 7, 40) for n in sorted({0, 1, t // 3, t // 2, t - 1, t}) if n <= t]
SENSORS = [(b, w) for b, w in product((0.05, 0.3, 0.525, 0.675, 0.9, 1.0), repeat=2) if abs(b + w - 1) > 1e-9]


def looked(t, n, b, w, brain=MINIMALISTIC):
    me = brain.robot(b, w)
    brain.functions.observe(me, float(n), float(t))
    return me


def unlikelihood(f, t, n, b, w):
    """-ln p(n blacks of t | f) without the binomial coefficient."""
    p = b * f + (1 - w) * (1 - f)
    terms = [c * math.log(q) if q > 0 else -math.inf for c, q in ((n, p), (t - n, 1 - p)) if c]
    return -sum(terms)


def likelihood(f, t, n, b, w):
    """ln p(n blacks of t | f) without the binomial coefficient, exact to 60 digits."""
    p = b * f + (1 - w) * (1 - f)
    parts = []
    for count, chance in ((n, p), (t - n, 1 - p)):
        if count:
            parts.append(count * chance.ln() if chance > 0 else Decimal("-Infinity"))
    return sum(parts, Decimal(0))


@pytest.mark.parametrize(
    ("t", "n", "b", "w", "expected"),
    [
        (10, 4, 1.0, 1.0, 0.4),  # perfect sensors: n / t
        (10, 5, 0.8, 0.6, (0.5 + 0.6 - 1) / (0.8 + 0.6 - 1)),  # Eq. 4, second case
        (10, 3, 0.8, 0.6, 0.0),  # n <= (1 - w) t
        (10, 9, 0.8, 0.6, 1.0),  # n >= b t
        (10, 4, 0.8, 0.6, 0.0),  # at the lower end itself
        (10, 8, 0.8, 0.6, 1.0),  # at the upper end itself
        (10, 3, 0.2, 0.4, (0.3 + 0.4 - 1) / (0.2 + 0.4 - 1)),  # a liar, ends exchanged
        (10, 1, 0.2, 0.4, 1.0),
        (10, 7, 0.2, 0.4, 0.0),
    ],
)
def test_paper_by_hand(t, n, b, w, expected):
    assert looked(t, n, b, w).x_hat == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize(("b", "w"), SENSORS)
def test_maximises_the_exact_likelihood(b, w):
    for t, n in COUNTS:
        cost = functools.partial(unlikelihood, t=t, n=n, b=b, w=w)
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
            points = (f - h, f, f + h)
            if any(likelihood(x, t, n, db, dw) == Decimal("-Infinity") for x in points):
                pytest.fail("the likelihood vanishes beside its own maximum")
            low, mid, high = (likelihood(x, t, n, db, dw) for x in points)
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


def test_eqs_6_to_8_by_hand():
    me = looked(10, 5, 0.9, 0.8)
    alpha, x_hat = me.alpha, me.x_hat
    for message in ((0.2, 3.0), (0.6, 1.0)):
        MINIMALISTIC.functions.receive(me, message)
    MINIMALISTIC.functions.fuse(me)
    assert me.beta == 4.0
    assert me.x_bar == pytest.approx((0.2 * 3 + 0.6 * 1) / 4)
    assert me.x == pytest.approx((alpha * x_hat + 4 * me.x_bar) / (alpha + 4))
    assert MINIMALISTIC.functions.estimate(me) == me.x


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


def test_legacy_by_hand():
    me = looked(10, 5, 0.9, 0.8, LEGACY)
    for message in ((0.2, 3.0), (0.6, 1.0)):
        LEGACY.functions.receive(me, message)
    LEGACY.functions.fuse(me)
    assert me.x_bar == pytest.approx(0.4)
    assert me.beta == pytest.approx(2 / (1 / 3 + 1 / 1))
    assert me.x == pytest.approx((me.alpha * me.x_hat + me.beta * 0.4) / (me.alpha + me.beta))
