"""Rivals as distributions, against theory: opinions, consensus, detectors; each test states its error rate."""

from fractions import Fraction
from itertools import combinations

import networkx as nx
import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus import brains
from tests.support.small import SEED, study_of

P = 1e-3
TIMES = {"explore": 2.0, "disseminate": 4.0}
UNWEIGHTED = TIMES | {"listen": 2.0, "weighted": 0.0}


def run(brain, trials, robots=10, rounds=400, looks=1, fill_ratio=0.55, topology="full", **parameters):
    """One setting of robots with perfect sensors."""
    study = study_of(
        [{"file": brain, **parameters}], robots=robots, accuracy=1.0, rounds=rounds, looks=looks, trials=trials,
        seed=23, measure={"checkpoints": [rounds]}, topology=topology, fill_ratio=fill_ratio,
    )  # fmt: skip
    return sc.run(study, jobs=2).isel(setting=0)


@pytest.mark.long(but_every=3)
@pytest.mark.parametrize("names", [range(9), (0, 1, 2, 10, 20, 30, 100, 10_000, 1_000_000)])
@pytest.mark.parametrize("brain", ["voter", "majority", "direct-comparison"])
def test_lots_are_fair(brain, names):
    """Each of nine senders has the lowest of nine lots as often, and each four the lowest four: chi-square, 0.2 %."""
    used = brains.load(brain)
    me = used.robot(0.9, 0.8)
    lowest, four = np.zeros(9), dict.fromkeys(combinations(range(9), 4), 0)
    for salt in np.random.default_rng(11).random(5000):
        me.salt = float(salt)
        order = np.argsort([used.functions.drawn(me, float(name), float(name % 2)) for name in names])
        lowest[order[0]] += 1
        four[tuple(sorted(order[:4].tolist()))] += 1
    assert stats.chisquare(lowest).pvalue > P
    assert stats.chisquare(list(four.values())).pvalue > P


def test_qualities_decide_among_voters():
    """Perfect sensors and 7 of 10 tiles black: black is told for longer, and wins more often than the half that begins
    with it. That a rule without weights would pass has a chance of 10^-9.
    """
    trials = 300
    given = UNWEIGHTED | {"weighted": 1.0, "disseminate": 20.0, "first": 0.0}
    last = run("voter", trials, fill_ratio=0.7, looks=20, **given)["decision"].values
    black = int((last.mean(axis=1) > 0.5).sum())
    assert stats.binomtest(black, trials, 0.5, alternative="greater").pvalue < 1e-9


def test_the_weighted_voter_copies_dancers_by_their_number():
    """Three dance for bin 2, one for bin 7, six do not dance: the chance of bin 2 is 3/4, two-sided, 0.1 %."""
    used = brains.load("weighted-voter").with_parameters({"every": 1.0})
    said = [(1.0, 2.0)] * 3 + [(1.0, 7.0)] + [(0.0, 5.0)] * 6
    lucks = np.random.default_rng(12).random((2000, len(said)))
    copied = 0
    for lots in lucks:
        me = used.robot(1.0, 1.0)
        me.luck = 0.5
        used.functions.fuse(me)
        me.steps = 0.0
        for message, draws in zip(said, lots, strict=True):
            me.luck = float(draws)
            used.functions.receive(me, message)
        used.functions.fuse(me)
        assert me.site in {2.0, 7.0}
        copied += me.site == 2.0
    assert stats.binomtest(copied, 2000, 0.75).pvalue > P


@pytest.mark.long
@pytest.mark.parametrize("share", [0.2, 0.5, 0.7])
def test_the_voters_exit_probability_is_the_first_share(share):
    """Without qualities, all in reach: each robot's first opinion is as likely to be everybody's last. 0.1 %."""
    trials = 1500
    last = run("voter", trials, black_first=share, **UNWEIGHTED)["decision"].values
    assert (last.min(axis=1) == last.max(axis=1)).mean() > 0.99
    assert stats.binomtest(int((last.mean(axis=1) > 0.5).sum()), trials, share).pvalue > P


def mean_of(time):
    """Of ceil(Exp(time)), which is geometric."""
    return -1.0 / np.expm1(-1.0 / time)


def fixed_point(wrong, quiet):
    """Cross-inhibition at f = 0.5 in the mean field: the majority's share of opinions, and the share that has none.

    With r robots of the majority for one of the minority, and p = ((1 - wrong) r + wrong) / (1 + r) of what is heard
    saying the majority's, opinions are lost and won at equal rates where r = (p / (1 - p))^2, so that s^2 = r with
    wrong s^2 - (1 - 2 wrong) s + wrong = 0. `quiet` is how long robots have none for, in times of having one.
    """
    s = (1.0 - 2.0 * wrong + np.sqrt(1.0 - 4.0 * wrong)) / (2.0 * wrong)
    p = s / (1.0 + s)
    majority = s * s / (1.0 + s * s)
    lost = (majority * (1.0 - p) + (1.0 - majority) * p) * quiet
    return majority, lost / (1.0 + lost)


@pytest.mark.long
def test_cross_inhibition_with_wrong_messages():
    """15 of 100 messages are of the other opinion: within 4 standard errors and what a finite swarm loses, 0.02 %.

    Direct switching stays near one half.
    """
    given = TIMES | {"miscommunication": 0.15, "weighted": 0.0, "disseminate": 4.0, "explore": 4.0}
    opinions = run("cross-inhibition", 40, 200, 300, 1, 0.5, uncommitted=2.0, **given)["decision"].values
    majority, none = fixed_point(0.15, mean_of(2.0) / mean_of(4.0))
    assert majority == pytest.approx(0.9518, abs=1e-4)
    has = (opinions >= 0).sum(axis=1)
    black = (opinions == 1).sum(axis=1)
    for found, expected in ((np.maximum(black, has - black) / has, majority), (1.0 - has / 200, none)):
        assert abs(found.mean() - expected) < 4.0 * found.std(ddof=1) / np.sqrt(len(found)) + 1.0 / 200
    switched = run("direct-switching", 40, 200, 600, 1, 0.5, **given)["decision"].values.mean(axis=1)
    assert abs(switched.mean() - 0.5) < 4.0 * switched.std(ddof=1) / np.sqrt(40)
    assert np.maximum(switched, 1.0 - switched).max() < 0.75


@pytest.mark.long
def test_cross_inhibition_breaks_the_deadlock():
    """At f = 0.5 all agree in a time that grows as log N; direct switching's grows as N: 4 standard errors, 0.02 %.

    From 10 robots to 40 the mean logarithm of the time grows by less than log 2.2, and by more than that.
    """
    given = TIMES | {"explore": 4.0, "weighted": 0.0, "fill_ratio": 0.5}
    for brain, rounds, side, more in (
        ("cross-inhibition", 600, -1.0, {"uncommitted": 2.0}),
        ("direct-switching", 3000, 1.0, {}),
    ):
        few, many = (run(brain, 100, n, rounds, **given, **more)["consensus_round"].values for n in (10, 40))
        assert np.isfinite([few, many]).all()
        grown = np.log(many).mean() - np.log(few).mean()
        error = np.sqrt((np.log(many).var(ddof=1) + np.log(few).var(ddof=1)) / 100)
        assert side * (grown - np.log(2.2)) > 4.0 * error


# ---- consensus rivals and filters at the level of distributions, against theory; each test states its error rate
PLACES = brains.load("linear-consensus").functions
LEVEL = 1e-3


def finals(used, trials, rounds, looks, robots=10, accuracy=0.8, topology="ring", f=0.4, **more):
    """Final estimates (trial, robot), not a number where a robot lies."""
    study = study_of(used, robots, accuracy, rounds, looks, trials, topology=topology, fill_ratio=f, **more)
    return sc.run(study)["final_estimate"].values[0], study.settings()[0]


def covariance(pull, rounds, looks, robots, f):
    """Of all robots of a ring after so many rounds: C <- A C A + V / (t + 1)^2, A = 1 - pull L - 1 / (t + 1)."""
    q = 0.8 * f + 0.2 * (1 - f)
    noise = q * (1 - q) / (looks * 0.6**2) * np.eye(robots)
    mix = np.eye(robots) - pull * nx.laplacian_matrix(nx.cycle_graph(robots)).toarray()
    c = np.zeros((robots, robots))
    for t in range(rounds):
        a = mix - np.eye(robots) / (t + 1)
        c = a @ c @ a.T + noise / (t + 1) ** 2
    return c


@pytest.mark.long
def test_consensus_and_innovations_scatter_as_computed():
    """The squared distance to the truth in units of its covariance: chi-square of 10 x 400, two-sided, 0.1 %.

    With a covariance of no talk, or of all readings pooled in every robot, it is far off.
    """
    found, _ = finals(brains.load("consensus-innovations"), trials=400, rounds=60, looks=20)
    off = found - 0.4
    law = stats.chi2(off.size)

    def p_value(c):
        distance = np.einsum("ti,ij,tj->", off, np.linalg.inv(c), off)
        return 2 * min(law.cdf(distance), law.sf(distance))

    right = covariance(0.25, 60, 20, 10, 0.4)
    assert p_value(right) > LEVEL
    assert p_value(covariance(0.0, 60, 20, 10, 0.4)) < 1e-9
    assert p_value(covariance(0.1, 60, 20, 10, 0.4)) < 1e-9
    pooled = 0.44 * 0.56 / (10 * 60 * 20 * 0.6**2)  # the variance of one that made all readings
    assert covariance(0.25, 2000, 20, 10, 0.4)[0, 0] == pytest.approx(pooled * 60 / 2000, rel=0.02)  # it gets there


def kept_of(names, order, draws):
    """Which 20 of these names are kept, and which comes first, by `order(name, salt)` in many draws (draw, name)."""
    salts = np.floor(np.random.default_rng(SEED).random(draws) * PLACES.PRIME)
    places = np.array([[order(float(name), float(salt)) for name in names] for salt in salts])
    return places.argsort(axis=1).argsort(axis=1) < 20, places.argmin(axis=1)


def lots_are_fair(kept, first):
    """The p-values: of how often each is kept, of who is first, of how often neighbours in the list are kept together.

    Of draws without replacement, counts of n names have variances and covariances of a hypergeometric law.
    """
    draws, n = kept.shape
    share = 20 / n
    spread = draws * share * (1 - share) * n / (n - 1)
    each = stats.chi2(n - 1).sf(((kept.sum(axis=0) - draws * share) ** 2 / spread).sum())
    together = (kept[:, :-1:2] & kept[:, 1::2]).sum(axis=0)
    both = share * 19 / (n - 1)
    pairs = stats.chi2(len(together)).sf(((together - draws * both) ** 2 / (draws * both * (1 - both))).sum())
    return each, stats.chisquare(np.bincount(first, minlength=n)).pvalue, pairs


@pytest.mark.long(but_every=3)
@pytest.mark.parametrize(
    "names", [range(40), range(0, 4000, 100), [k * k for k in range(60)]], ids=["near", "far", "odd"]
)
def test_who_counts_of_many_is_a_fair_lot(names):
    """Each of 40 or 60 names as often among the 20, as often first, and with its neighbour: 0.3 % in all for each.

    Pairs of names share draws, so that the last of the three p-values is on the safe side. The order of names as they
    are, shifted round, is found out.
    """
    assert min(lots_are_fair(*kept_of(list(names), PLACES.place, 4000))) > LEVEL
    assert min(lots_are_fair(*kept_of(list(names), lambda name, salt: (name + salt) % 1000, 400))) < 1e-9


# ---- the Bayesian rivals' chances: false alarms and delays of the detector, soft feedback's lots, what feedback gains
CHANGING = brains.load("changing-floor")
ALARM = 4.05  # between two values that the sums can take: rounding then decides nothing
RUNS = 400


def run_length(mean, f, slack):
    """How many observations of a floor f a CUSUM of both sides takes to its alarm: the chain of its states, solved."""
    up = {1: 1 - mean - slack, 0: -mean - slack}
    down = {1: mean - 1 - slack, 0: mean - slack}
    places, todo, rows = {(Fraction(0), Fraction(0)): 0}, [(Fraction(0), Fraction(0))], []
    while todo:
        state = todo.pop()
        for colour, chance in ((1, f), (0, 1 - f)):
            to = tuple(max(Fraction(0), x + step[colour]) for x, step in zip(state, (up, down), strict=True))
            if max(to) > ALARM:
                continue
            if to not in places:
                places[to] = len(places)
                todo.append(to)
            rows.append((places[state], places[to], float(chance)))
    chain = np.eye(len(places))
    for here, there, chance in rows:
        chain[here, there] -= chance
    return np.linalg.solve(chain, np.ones(len(places)))[0]


def simulated(mean, f, seed=SEED):
    """Run lengths of the brain's detector, whose earlier observations were so many that their mean is known."""
    used = CHANGING.with_parameters({"detect": 1.0, "every": 1.0, "alarm": ALARM})
    random = np.random.default_rng(seed)
    found = []
    for _ in range(RUNS):
        me = used.robot(0.9, 0.9)
        me.size, me.t, me.n = 1.0, 1e15, 1e15 * mean
        length = 1
        me.seen = float(random.random() < f)
        while not used.functions.detects(me):
            me.seen = float(random.random() < f)
            length += 1
        found.append(length)
    return np.array(found)


@pytest.mark.long(but_every=4)
@pytest.mark.long(only=["0.5-0.5"])
@pytest.mark.parametrize(
    ("mean", "f"), [("0.5", "0.5"), ("0.6", "0.6"), ("0.7", "0.3"), ("0.9", "0.1"), ("0.6", "0.4")]
)
def test_false_alarms_and_delays_of_the_detector(mean, f):
    """Mean run lengths within four standard errors of theory: 0.006 % each."""
    exact = run_length(Fraction(mean), Fraction(f), Fraction("0.1"))
    found = simulated(float(mean), float(f))
    error = found.std(ddof=1) / np.sqrt(RUNS)
    assert abs(found.mean() - exact) < 4.0 * error
    if mean == f:  # a detector with another slack is told apart
        assert abs(found.mean() - run_length(Fraction(mean), Fraction(f), Fraction("0.12"))) > 4.0 * error
