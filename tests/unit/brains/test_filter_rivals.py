"""The decentralised filters: against their equations in NumPy, the pooled likelihood by brute force, and themselves."""

import networkx as nx
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from swarmcensus import brains
from swarmcensus.simulation import sampling
from tests.support.second import fixed
from tests.support.small import SEED
from tests.support.trials import record_trial

pytestmark = pytest.mark.interpreted

INFORMATION, KALMAN, INNOVATIONS, INTERSECTION = (
    brains.load(name)
    for name in ("information-filter", "kalman-consensus", "consensus-innovations", "covariance-intersection")
)
APART = {"black": 0.9, "white": 0.65}  # b and w that are not each other's: none may stand in the other's place
MIXED = {"black": "U(0.7, 0.95)", "white": "U(0.55, 0.85)"}


def lived(used, trial=0, **world):
    """A trial: fields, estimates and black readings (round, robot), and b and w of each robot."""
    (setting,) = fixed(used, **world)
    b, w, *_ = sampling.accuracies(setting, SEED, trial, 1)
    return *record_trial(setting, SEED, trial), *(np.broadcast_to(side[0], setting.robots) for side in (b, w))


def variances(b, w, f, least):
    """Of a reading, were the fill ratio f."""
    q = b * f + (1 - w) * (1 - f)
    return np.maximum(q * (1 - q), least)


def told(b, w, blacks, looks, spread):
    """What readings of this variance tell: a fill ratio times how sure it is, and how sure."""
    slope = b + w - 1
    return slope * (blacks - (1 - w) * looks) / spread, slope**2 * looks / spread


def most_likely(counts, looks, b, w):
    """The fill ratio that makes these readings (robot) likeliest, by brute force."""

    def cost(f):
        q = b * f + (1 - w) * (1 - f)
        return -(counts * np.log(q) + (looks - counts) * np.log(1 - q)).sum()

    return minimize_scalar(cost, bounds=(0, 1), method="bounded", options={"xatol": 1e-12}).x


def adjacency(topology, robots):
    graph = {"full": nx.complete_graph, "ring": nx.cycle_graph, "line": nx.path_graph}[topology](robots)
    return nx.to_numpy_array(graph)


@pytest.mark.parametrize("topology", ["full", "ring"])
@pytest.mark.parametrize("least", [0.05, 0.2])
def test_sums_of_the_information_filter_are_those_of_the_equations(topology, least):
    """Each reading weighed by its variance at the sender's estimate before the round."""
    used = INFORMATION.with_parameters({"least_variance": least})
    fields, curves, blacks, b, w = lived(used, robots=7, accuracy=MIXED, rounds=30, looks=3, topology=topology)
    hears = adjacency(topology, 7) + np.eye(7)
    y, sure, x = np.zeros(7), np.zeros(7), np.full(7, 0.5)
    for k in range(1, 31):
        spread = variances(b, w, x, least)
        i, more = told(b, w, blacks[k], 3, spread)
        y, sure = y + hears @ i, sure + hears @ more
        x = np.clip(y / sure, 0, 1)
        assert fields["y"][k] == pytest.approx(y, rel=1e-12)
        assert fields["Y"][k] == pytest.approx(sure, rel=1e-12)
        assert curves[k] == pytest.approx(x, rel=1e-12)


@pytest.mark.parametrize("rounds", [1, 40])
@pytest.mark.parametrize("trial", range(3))
def test_of_equal_readings_it_is_the_pooled_maximum_likelihood(rounds, trial):
    """Sensors alike, readings of one variance, a full network: y / Y is the maximum, cut to [0, 1]."""
    used = INFORMATION.with_parameters({"least_variance": 0.25})
    _, curves, blacks, b, w = lived(used, trial, robots=9, accuracy=APART, rounds=rounds, looks=5, topology="full")
    found = most_likely(blacks[1:].sum(axis=0), 5 * rounds, b, w)
    assert curves[-1] == pytest.approx(found, abs=1e-6)


@pytest.mark.parametrize("topology", ["full", "ring", "line"])
@pytest.mark.parametrize(("pull", "noise"), [(1.0, 0.0), (3.0, 0.01), (0.0, 0.0), (50.0, 0.01)])
def test_every_round_of_kalman_consensus_is_as_the_equations_say(topology, pull, noise):
    used = KALMAN.with_parameters({"pull": pull, "noise": noise})
    fields, _, blacks, b, w = lived(used, robots=6, accuracy=MIXED, rounds=25, looks=2, topology=topology)
    hears = adjacency(topology, 6)
    x, p = np.full(6, 0.5), np.full(6, 1 / 12)
    for k in range(1, 26):
        spread = variances(b, w, np.clip(x, 0, 1), 0.05)
        u, sure = told(b, w, blacks[k], 2, spread)
        u, sure = u + hears @ u, sure + hears @ sure
        m = 1 / (1 / p + sure)
        g = np.minimum(pull * p / (1 + p), (m / p) / (1 + hears.sum(axis=1)))
        x = x + m * (u - x * sure) + g * (hears @ x - hears.sum(axis=1) * x)
        p = m + noise
        assert fields["x"][k] == pytest.approx(x, abs=1e-12)
        assert fields["P"][k] == pytest.approx(p, rel=1e-12)


@pytest.mark.parametrize("topology", ["full", "ring", "line"])
@pytest.mark.parametrize("pull", [0.25, 0.9])
def test_every_round_of_consensus_and_innovations_is_as_the_equation_says(topology, pull):
    fields, _, blacks, b, w = lived(
        INNOVATIONS.with_parameters({"pull": pull}), robots=6, accuracy=MIXED, rounds=30, looks=3, topology=topology
    )
    hears = adjacency(topology, 6)
    many = hears.sum(axis=1)
    x = np.full(6, 0.5)
    for t in range(30):
        z = (blacks[t + 1] / 3 + w - 1) / (b + w - 1)
        x = x + np.minimum(pull, 1 / (1 + many)) * (hears @ x - many * x) + (z - x) / (t + 1)
        assert fields["x"][t + 1] == pytest.approx(x, abs=1e-12)


@pytest.mark.parametrize("topology", ["full", "ring"])
def test_every_round_of_covariance_intersection_is_as_the_equations_say(topology):
    """Own readings as a Kalman filter folds them in; then the surest of own and neighbours', as it is."""
    used = INTERSECTION.with_parameters({"least_variance": 0.05})
    fields, _, blacks, b, w = lived(used, robots=8, accuracy=MIXED, rounds=30, looks=2, topology=topology)
    hears = adjacency(topology, 8) + np.eye(8)
    x, sure = np.full(8, 0.5), np.zeros(8)
    for k in range(1, 31):
        spread = variances(b, w, np.clip(x, 0, 1), 0.05)
        i, more = told(b, w, blacks[k], 2, spread)
        x, sure = (x * sure + i) / (sure + more), sure + more
        surest = [max(np.flatnonzero(row), key=lambda j: sure[j]) for row in hears]
        x, sure = x[surest], sure[surest]
        assert fields["x"][k] == pytest.approx(x, rel=1e-9)
        assert fields["Y"][k] == pytest.approx(sure, rel=1e-9)


def test_the_surest_are_copied_and_equals_averaged():
    """Of covariances at their intersection; the own estimate stays where nobody is surer."""
    me = INTERSECTION.robot(0.8, 0.8)
    me.x, me.Y = 0.4, 5.0
    INTERSECTION.functions.receive(me, (0.9, 5.0))
    INTERSECTION.functions.fuse(me)
    assert (me.x, me.Y) == (0.4, 5.0)
    for x, sure in ((0.1, 2.0), (0.6, 7.0), (0.5, 3.0), (0.7, 7.0)):
        INTERSECTION.functions.receive(me, (x, sure))
    INTERSECTION.functions.fuse(me)
    assert (me.x, me.Y) == (pytest.approx(0.65), 7.0)
