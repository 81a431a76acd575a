"""Consensus rivals and filters at the level of distributions, against theory; each test states its error rate."""

import networkx as nx
import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus import brains
from tests.support.small import SEED, study_of

PLACES = brains.load("linear-consensus").functions
P = 1e-3


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
    used = brains.load("consensus-innovations")
    found, _ = finals(used, trials=400, rounds=60, looks=20)
    off = found - 0.4
    law = stats.chi2(off.size)

    def p_value(c):
        distance = np.einsum("ti,ij,tj->", off, np.linalg.inv(c), off)
        return 2 * min(law.cdf(distance), law.sf(distance))

    right = covariance(0.25, 60, 20, 10, 0.4)
    assert p_value(right) > P
    assert p_value(covariance(0.0, 60, 20, 10, 0.4)) < 1e-9
    assert p_value(covariance(0.1, 60, 20, 10, 0.4)) < 1e-9
    pooled = 0.44 * 0.56 / (10 * 60 * 20 * 0.6**2)  # the variance of one that made all readings
    assert covariance(0.25, 2000, 20, 10, 0.4)[0, 0] == pytest.approx(pooled * 60 / 2000, rel=0.02)  # it gets there


def kept_of(names, order, draws):
    """Which 20 of these names are kept, and which comes first, by `order(name, salt)` in many draws (draw, name)."""
    random = np.random.default_rng(SEED)
    salts = np.floor(random.random(draws) * PLACES.PRIME)
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
    assert min(lots_are_fair(*kept_of(list(names), PLACES.place, 4000))) > P
    assert min(lots_are_fair(*kept_of(list(names), lambda name, salt: (name + salt) % 1000, 400))) < 1e-9
