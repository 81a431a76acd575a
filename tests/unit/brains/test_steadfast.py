"""Steadfast: against its equations in NumPy, its bound by hand and by brute force, and among liars over trials.

Tests of draws state their error rate: the chance that what is right fails them, were the seed not fixed.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from tests.support.lives import lived
from tests.support.second import fixed
from tests.support.small import study_of

STEADFAST = brains.load("steadfast").functions
GEOMETRIC = {"networkx": "random_geometric_graph", "radius": 0.4}


def state(b=0.9, w=0.8, **given):
    """A robot, with what is given in place of the defaults."""
    return SimpleNamespace(**{**STEADFAST.MEMORY, **STEADFAST.PARAMETERS} | given, b=b, w=w)


def told(me, *messages, rounds=1):
    """Rounds without readings, in each of which these messages are heard."""
    for _ in range(rounds):
        for message in messages:
            STEADFAST.receive(me, message)
        STEADFAST.fuse(me)
    return me


def test_a_swarm_follows_the_equations():
    """Six robots, sensors apart, one of them shouting, all at once in NumPy with matrices of who counts whom."""
    rng = np.random.default_rng(3)
    b, w = np.array([0.9, 0.6, 0.75, 0.8, 0.7, 0.95]), np.array([0.8, 0.7, 0.7, 0.9, 0.6, 0.85])
    hears = ~np.eye(6, dtype=bool) & (rng.random((6, 6)) < 0.8)
    robots = [state(*pair) for pair in zip(b, w, strict=True)]
    s, v, n, t, typical = np.zeros(6), np.zeros(6), np.zeros(6), 0.0, np.full(6, 0.25)
    k, counted = b + w - 1.0, []
    for _ in range(60):
        black = rng.binomial(5, 0.4 * k + 1.0 - w).astype(float)
        n, t = n + black, t + 5.0
        s, v = s + k * (black - 5.0 * (1.0 - w)), v + 5.0 * k**2
        says, weighs = s.copy(), v.copy()
        says[5] = weighs[5] = 9.0 * v[5]
        x, q = says / weighs, (n + 2.0) / (t + 4.0)
        apart = np.abs(x[None, :] - (s / v)[:, None])
        off = np.abs(k[:, None] * x[None, :] + 1.0 - w[:, None] - q[:, None])
        good = hears & (apart <= 4.0 * typical[:, None]) & (off <= 2.0 * np.sqrt(q * (1.0 - q) / (t + 4.0))[:, None])
        share = good * np.minimum(1.0, 2.0 * v[:, None] / weighs[None, :])
        near = (hears * np.minimum(apart, 2.0 * typical[:, None])).sum(1)
        typical = (8.0 * typical + near) / (8.5 + hears.sum(1))
        s, v = ((old + share @ new) / (1.0 + good.sum(1)) for old, new in ((s, says), (v, weighs)))
        lean = min(1.0, 3.0 * 5.0 / t)
        s, v = s + lean * (k * (n - t * (1.0 - w)) - s), v + lean * (k**2 * t - v)
        counted.append(good.sum())
        for me, blacks in zip(robots, black, strict=True):
            STEADFAST.observe(me, blacks, 5.0)
        messages = [STEADFAST.broadcast(me) for me in robots]
        messages[5] = (9.0 * messages[5][1], 9.0 * messages[5][1])
        for i, me in enumerate(robots):
            for j in np.flatnonzero(hears[i]):
                STEADFAST.receive(me, messages[j])
            STEADFAST.fuse(me)
        np.testing.assert_allclose(
            [[me.s, me.v, me.typical] for me in robots], np.transpose([s, v, typical]), rtol=1e-9
        )
    assert 0 < min(counted) < max(counted) <= hears.sum()


def test_the_bound_by_hand():
    """100 readings, 46 black, by a sensor of 0.9 and 0.8: q = 48/104, e = 0.0489, and the estimate within 2 e / 0.7."""
    me = state()
    STEADFAST.observe(me, 46.0, 100.0)
    me.s = me.v = 1e12  # as if a lie had come through
    own, half = (48.0 / 104.0 - 0.2) / 0.7, 2.0 * math.sqrt(48.0 / 104.0 * 56.0 / 104.0 / 104.0) / 0.7
    assert STEADFAST.estimate(me) == pytest.approx(own + half) == pytest.approx(0.5133, abs=1e-4)
    me.s = -1e12
    assert STEADFAST.estimate(me) == pytest.approx(own - half)


@pytest.mark.parametrize("open_to_all", [False, True], ids=["gates", "no gate but the bound"])
def test_own_readings_bound_the_estimate(open_to_all):
    """Messages of any size and sign, by up to thirty voices a round, to sensors of all kinds."""
    rng = np.random.default_rng(8)
    moved = 0.0
    for _ in range(150):
        b, w = rng.random(2)
        gates = {"near": math.inf, "cap": math.inf} if open_to_all else {}
        me, f = state(b, w, **gates), rng.random()
        for _ in range(rng.integers(1, 30)):
            looks = float(rng.integers(0, 20))
            STEADFAST.observe(me, float(rng.binomial(int(looks), f * (b + w - 1.0) + 1.0 - w)), looks)
            v = 10.0 ** rng.uniform(-6.0, 6.0, rng.integers(0, 30))
            told(me, *zip(v * rng.choice([0.0, 1.0, rng.normal(0.0, 3.0)], len(v)), v, strict=True))
        q, slope = (me.n + 2.0) / (me.t + 4.0), b + w - 1.0
        own, half = (q + w - 1.0) / slope, 2.0 * math.sqrt(q * (1.0 - q) / (me.t + 4.0)) / abs(slope)
        x = STEADFAST.estimate(me)
        if me.t > 0.0:
            assert min(max(own - half, 0.0), 1.0) - 1e-9 <= x <= min(max(own + half, 0.0), 1.0) + 1e-9
            moved = max(moved, abs(x - min(max(own, 0.0), 1.0)))
    assert moved > 0.1  # the bound is there to be met


@pytest.mark.interpreted
@pytest.mark.parametrize("name", ["opposite", "shouter", "noisy-mirror", "jammer"])
def test_swarms_with_liars_live_as_by_brute_force(name):
    members = [{"robots": 2, "brain": {"file": name}, "honest": False}]
    (setting,) = fixed("steadfast", robots=7, rounds=10, looks=2, members=members, topology="full")
    lived(setting)


def errors(brain, kinds=(), share=0.2, trials=20, f=0.55, topology=GEOMETRIC):
    """Errors after 300 rounds of ten readings, by sensors of 0.75: each trial's median, a row a kind of liar."""
    members = [{"robots": share, "brain": list(kinds), "honest": False}] if kinds else []
    found = sc.run(
        study_of(
            brain, robots=20, accuracy=0.75, rounds=300, trials=trials, seed=31, members=members, topology=topology,
            fill_ratio=f,
        )
    )  # fmt: skip
    return abs(found["final_estimate"] - f).median("robot").values


LIES = ("always-black", "always-white", "opposite", "random", "noisy-mirror", "shouter", "slow-liar", "forger")


@pytest.mark.long
def test_steadfast_among_a_fifth_of_liars():
    """Each kind's median is below that of a robot alone, commons' is above: 99 % of bootstraps of the trials agree."""
    alone = errors("alone")
    kinds = [kind for kind in LIES if kind not in ("noisy-mirror", "random", "shouter")]  # who shouts breaks commons
    draw = np.random.default_rng(2).integers(0, 20, (1000, 20))
    told, lost = errors("steadfast", LIES), errors("commons", kinds)
    limit = np.median(alone[0][draw], axis=1)
    for row in told:
        assert np.mean(np.median(row[draw], axis=1) < limit) > 0.99
    for row in lost:
        assert np.mean(np.median(row[draw], axis=1) > limit) > 0.99


@pytest.mark.long
def test_robot_between_two_liars_keeps_its_bound():
    """On a ring with a third of liars nobody is farther off than the bound, own readings' law of 4 standard errors."""
    found = sc.run(
        study_of(
            "steadfast", robots=20, accuracy=0.75, rounds=300, trials=20, seed=7,
            members=[{"robots": 0.3, "brain": list(LIES), "honest": False}],
        )
    )  # fmt: skip
    most = abs(found["final_estimate"] - 0.55).max().item()
    assert most < (4.0 + 2.0) * math.sqrt(0.25 / 3000.0) / 0.5


def test_what_cannot_be_true_is_not_counted():
    """Evidence below 0, of none, of black alone or of white alone, and numbers beyond all reason."""
    me = state()
    STEADFAST.observe(me, 460.0, 1000.0)
    STEADFAST.fuse(me)
    before = me.s, me.v
    told(me, (-me.s, -me.v), (me.s, 0.0), (me.v, me.v), (0.0, me.v), (1e300, 1e-300))
    assert (me.s, me.v) == before
