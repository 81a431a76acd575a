"""Self-taught, tracking and the trained net: each by hand, by brute force, and in swarms."""

import tomllib

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from tests.support.places import ROOT
from tests.support.small import study_of

TAUGHT = brains.load("self-taught")
RUN = TAUGHT.functions
ALL_FIT = {"z": 1e6, "apart": 1e12}


def robot(b=0.8, w=0.8, **given):
    return TAUGHT.with_parameters(given).robot(b, w)


def talk(states, rounds, hears):
    """So many rounds without new readings; `hears(k)` are those that robot k hears."""
    for _ in range(rounds):
        said = [RUN.broadcast(me) for me in states]
        for k, me in enumerate(states):
            for j in hears(k):
                RUN.receive(me, said[j])
        for me in states:
            RUN.fuse(me)


def everyone(robots):
    return lambda k: [j for j in range(robots) if j != k]


def test_a_first_round_by_hand():
    """Told 0.8: 50 of 98 black give x = (50/98 - 0.2)/0.6 and e = 1/(4 0.36 98); d is 0 yet."""
    me = robot()
    RUN.observe(me, 50.0, 98.0)
    RUN.fuse(me)
    x, e = (50 / 98 - 0.2) / 0.6, 0.25 / (0.36 * 98)
    assert (me.v, me.s, me.m) == pytest.approx((1 / e, x / e, (x * x - e) / e))
    assert (me.given_v, me.given_s, me.given_m) == (me.v, me.s, me.m)
    assert RUN.estimate(me) == pytest.approx((x / e + e / 2) / (1 / e + e))
    RUN.receive(me, (5.0, 10.0, 3.0))
    RUN.fuse(me)
    s, v, m = (0.999 / 2 * (own / e + expected) for own, expected in ((x, 5.0), (1.0, 10.0), (x * x - e, 3.0)))
    d = 0.02 * max(m / v - (s / v) ** 2, 0.0)
    assert me.spread == pytest.approx(d)
    assert me.v == pytest.approx(v + 1 / (e + d) - 0.999 / e)
    assert me.s == pytest.approx(s + x / (e + d) - 0.999 * x / e)


@pytest.mark.parametrize("graph", ["ring", "full"])
def test_self_taught_reaches_the_random_effects_mean(graph):
    """Brute force: f, d and the weights as they determine one another, of sensors of all kinds and any readings."""
    chance, robots = np.random.default_rng(4), 8
    b = chance.uniform(0.6, 0.95, robots)
    t = chance.integers(200, 900, robots).astype(float)
    n = np.floor(t * chance.uniform(0.4, 0.6, robots))
    states = [robot(a, a, memory=1e5, **ALL_FIT) for a in b]
    for me, black, looks in zip(states, n, t, strict=True):
        RUN.observe(me, black, looks)
    hears = everyone(robots) if graph == "full" else lambda k: ((k - 1) % robots, (k + 1) % robots)
    talk(states, 1500, hears)
    x, d = (n / t - 1 + b) / (2 * b - 1), 0.0
    e = 0.25 / ((2 * b - 1) ** 2 * t)
    for _ in range(2000):
        g = 1 / (e + d)
        f = (g * x).sum() / g.sum()
        d += 0.1 * (max((g * (x * x - e)).sum() / g.sum() - f * f, 0.0) - d)
    assert d > 0.005
    for me in states:
        assert me.s / me.v == pytest.approx(f, abs=2e-4)
        assert me.spread == pytest.approx(d, rel=0.02)


@pytest.mark.long(but=["0", "5", "8"])
@pytest.mark.parametrize("wrong", range(12))
def test_majority_keeps_its_evidence(wrong):
    """Eleven robots without noise, of which some read 0.7 where the others read 0.3; 5 against 6 is the limit."""
    states = [robot(1.0, 1.0) for _ in range(11)]
    for k, me in enumerate(states):
        RUN.observe(me, 7e3 if k < wrong else 3e3, 1e4)
    talk(states, 1500, everyone(11))
    out = np.array([me.out for me in states])
    f = {me.s / me.v for me in states}
    if min(wrong, 11 - wrong) in (1, 2, 3, 4):
        assert (out == [(k < wrong) == (wrong < 6) for k in range(11)]).all()
        assert max(abs(x - (0.3 if wrong < 6 else 0.7)) for x in f) < 1e-3
        assert all(me.given_v < 1e-3 * me.v for me in states if me.out)
    elif wrong in (0, 11):
        assert not out.any()


def swarm_of(wrong, expected, truth, fill, brain="self-taught", trials=10, topology="full", rounds=600):
    members = [{"robots": wrong, "assumed_accuracy": expected}]
    return sc.run(study_of(brain, 20, truth, assumed_accuracy=truth, rounds=rounds, trials=trials, seed=8,
                           members=members, topology=topology, fill_ratio=fill))  # fmt: skip


@pytest.mark.parametrize(("expected", "truth", "fill"), [(0.95, 0.75, 0.75), (0.95, 0.75, 0.95), (0.75, 0.95, 0.75)])
def test_six_of_twenty_that_are_wrong_do_no_harm(expected, truth, fill):
    """All robots of ten swarms are right within 0.05, and their median error is a third of commons' at the most."""
    error = abs(swarm_of(6, expected, truth, fill)["final_estimate"].values - fill)
    plain = abs(swarm_of(6, expected, truth, fill, "commons")["final_estimate"].values - fill)
    assert error.max() < 0.05
    assert np.median(error) < 0.01
    assert np.median(plain) > 3.0 * np.median(error)


# ---- tracking: by hand, by brute force, against commons on floors that stay, and in swarms whose floor changes
TRACKING = brains.load("tracking")
TRACK = TRACKING.functions


def tracking_robot(**given):
    return TRACKING.with_parameters(given).robot(1.0, 1.0)


def test_a_round_by_hand():
    """Sixteen black of twenty, a neighbour with sums of its own; a quarter of V = 84 is 21, and v = 30 is cut to it."""
    me = tracking_robot()
    TRACK.observe(me, 16.0, 20.0)
    assert (me.s, me.v, me.long_s, me.long_v) == (16.0, 20.0, 16.0, 20.0)
    TRACK.receive(me, (32.0, 40.0, 120.0, 148.0))
    TRACK.fuse(me)
    assert (me.long_s, me.long_v) == (68.0, 84.0)
    assert me.s / me.v == pytest.approx(24.0 / 30.0)
    assert me.v == pytest.approx(21.0)
    assert TRACK.estimate(me) == pytest.approx((68.0 + 0.03125 / 84.0) / (84.0 + 0.0625 / 84.0))


@pytest.mark.parametrize(("off", "anew"), [(0.9999, False), (1.0001, True)])
def test_it_restarts_where_the_sums_differ(off, anew):
    """z^2 (1/v - 1/V) / (4 n) with v = 25, V = 100, n = 2 and z = 2.5."""
    me = tracking_robot()
    gap = off * 2.5 * ((1.0 / 25.0 - 1.0 / 100.0) / 8.0) ** 0.5
    sums = (25.0 * (0.5 + gap), 25.0, 50.0, 100.0)
    me.s, me.v, me.long_s, me.long_v = sums
    TRACK.receive(me, sums)
    TRACK.fuse(me)
    assert (me.long_s, me.long_v) == ((pytest.approx(0.5 + gap), 1.0) if anew else (50.0, 100.0))
    assert not anew or (me.s, me.v) == (me.long_s, me.long_v)


def test_the_short_sums_hold_what_is_fresh():
    """Brute force: short sums are weights times readings, and no weight is above 1, which the bound needs."""
    chance = np.random.default_rng(2)
    me, weights, readings = tracking_robot(z=1e9, memory=30.0), np.zeros(0), np.zeros(0)
    for _ in range(120):
        fresh = (chance.random(3) < 0.6).astype(float)
        TRACK.observe(me, fresh.sum(), 3.0)
        TRACK.fuse(me)
        weights, readings = np.append(weights, np.ones(3)), np.append(readings, fresh)
        most = min(30.0, max(10.0, 0.25 * len(readings)))
        weights *= min(1.0, most / weights.sum())
        assert me.v == pytest.approx(weights.sum())
        assert me.s == pytest.approx((weights * readings).sum())
        assert (weights**2).sum() <= me.v
    assert (me.long_s, me.long_v) == (readings.sum(), 360.0)
    assert me.v == pytest.approx(30.0)


def test_after_a_change_it_is_right_within_few_rounds():
    """Nine of ten robots within 40 rounds, where commons needs more than the 200 that are left."""
    changes, measure = {"from": 0.85, "to": 0.25, "at": 201}, {"metrics": ["recovery-time"]}
    both = ["commons", "tracking"]
    results = sc.run(study_of(both, 20, 0.8, rounds=400, trials=20, seed=4, fill_ratio=changes, measure=measure))
    recovery = results["recovery_time"].values.reshape(2, -1)
    assert np.isinf(recovery[0]).all()
    assert np.quantile(recovery[1], 0.9) < 40
    assert np.median(abs(results["final_estimate"].values[1] - 0.25)) < 0.01


# ---- the trained net: its equations by hand, its weights as its training left them, and what they are worth
NET = brains.load("recurrent")
STUDIES = ROOT / "studies" / "rivals"


def sigma(z):
    return 1.0 / (1.0 + np.exp(-z))


@pytest.mark.parametrize("debiased", [0.0, 1.0])
def test_rounds_by_hand(debiased):
    """With matrices, from the equation."""
    chance, sizes = np.random.default_rng(1), {"bias": 5, "inputs": 15, "weights": 25, "output": 5}
    given = {"tau": tuple(chance.uniform(1.0, 20.0, 5)), "offset": 0.3, "debiased": debiased}
    given |= {name: tuple(chance.normal(size=size)) for name, size in sizes.items()}
    me = NET.with_parameters(given).robot(0.9, 0.8)
    tau, bias, output = (np.array(given[name]) for name in ("tau", "bias", "output"))
    weights, inputs = np.reshape(given["weights"], (5, 5)), np.reshape(given["inputs"], (5, 3))
    y, fires = np.zeros(5), np.zeros(5)
    for blacks, looks, heard in [(1, 1, []), (3, 4, [0.2, 0.9]), (0, 0, [0.6]), (2, 5, [])]:
        if looks:
            NET.functions.observe(me, float(blacks), float(looks))
        for x in heard:
            NET.functions.receive(me, (x,))
        NET.functions.fuse(me)
        share = blacks / looks if looks else 0.5
        reading = 2 * share - 1 if not debiased or not looks else 2 * (share + 0.8 - 1) / 0.7 - 1
        opinion = 2 * np.mean(heard) - 1 if heard else 0.0
        y = y + (weights @ fires + inputs @ [reading, opinion, float(bool(heard))] - y) / tau
        fires = sigma(y + bias)
        assert list(me.y) == pytest.approx(y, abs=1e-12)
        assert NET.functions.estimate(me) == pytest.approx(sigma(output @ fires + 0.3), abs=1e-12)
        assert NET.functions.broadcast(me) == (me.x,)


def found(name):
    """What a search left: the line for a study."""
    text = (ROOT / "tests" / "data" / f"{name}-tuned.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)["swarm"]["brain"][0], text


def test_the_weights_are_those_that_the_search_found():
    line, text = found("recurrent")
    for key, value in line.items():
        if key != "file":
            assert NET.parameters[key] == (tuple(value) if isinstance(value, list) else value)
    said = " ".join(text.replace("#", "").split())
    assert "15265 evaluations in 477 generations" in said
    assert "over all 16 worlds: better in 89%" in said
    line, _ = found("recurrent-debiased")
    unseen = tomllib.loads((STUDIES / "recurrent-unseen.toml").read_text(encoding="utf-8"))
    assert (unseen["swarm"]["brain"][1], NET.parameters["debiased"]) == (line, 0.0)
