"""The decentralised filters: against their equations in NumPy, the pooled likelihood by brute force, and themselves."""

import networkx as nx
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from swarmcensus import brains
from swarmcensus.simulation import sampling
from swarmcensus.simulation.trials import record_trial
from tests.support.second import SEED, fixed

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


class TestInformationFilter:
    @pytest.mark.parametrize("topology", ["full", "ring"])
    @pytest.mark.parametrize("least", [0.05, 0.2])
    def test_sums_are_those_of_the_equations(self, topology, least):
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
    def test_of_equal_readings_it_is_the_pooled_maximum_likelihood(self, rounds, trial):
        """Sensors alike, readings of one variance, a full network: y / Y is the maximum, cut to [0, 1]."""
        used = INFORMATION.with_parameters({"least_variance": 0.25})
        _, curves, blacks, b, w = lived(used, trial, robots=9, accuracy=APART, rounds=rounds, looks=5, topology="full")
        found = most_likely(blacks[1:].sum(axis=0), 5 * rounds, b, w)
        assert curves[-1] == pytest.approx(found, abs=1e-6)

    def test_first_round_ignores_variances_of_equal_sensors(self):
        _, curves, blacks, b, w = lived(INFORMATION, robots=9, accuracy=APART, rounds=1, looks=50, topology="full")
        assert curves[-1] == pytest.approx(most_likely(blacks[1], 50, b, w), abs=1e-6)

    @pytest.mark.long
    def test_otherwise_it_nears_the_maximum_faster_than_the_truth(self):
        """Sensors of all kinds: it solves sum k (n - r q(f)) / R = 0 with R at earlier estimates, the maximum at f.

        Both agree to first order. From 2 rounds to 200, in the mean of squares over 20 trials: what lies between them
        falls by more than what lies between the maximum and the truth, and is then less than a tenth of that.
        """
        apart, off = np.zeros((2, 20)), np.zeros((2, 20))
        for trial in range(20):
            _, curves, blacks, b, w = lived(
                INFORMATION, trial, robots=10, accuracy=MIXED, rounds=200, looks=5, topology="full", fill_ratio=0.3
            )
            for k, rounds in enumerate((2, 200)):
                best = most_likely(blacks[1 : rounds + 1].sum(axis=0), 5 * rounds, b, w)
                apart[k, trial], off[k, trial] = curves[rounds, 0] - best, best - 0.3
        apart, off = (np.sqrt((one**2).mean(axis=1)) for one in (apart, off))
        assert apart[0] / apart[1] > off[0] / off[1] > 5
        assert apart[1] < off[1] / 10

    def test_each_message_counts_once_on_a_ring_too(self):
        """Y of a robot is that of its own and both neighbours' readings, however long they talk."""
        used = INFORMATION.with_parameters({"least_variance": 0.25})
        fields, *_ = lived(used, robots=6, accuracy=APART, rounds=50, looks=2, topology="ring")
        assert fields["Y"][-1] == pytest.approx(3 * 100 * 0.55**2 / 0.25, rel=1e-12)

    def test_who_saw_nothing_says_nothing(self):
        me = INFORMATION.robot(0.9, 0.7)
        assert INFORMATION.functions.broadcast(me) is None
        INFORMATION.functions.observe(me, 1.0, 2.0)
        assert INFORMATION.functions.broadcast(me) == pytest.approx((0.6 * (1 - 0.6) / 0.24, 0.36 * 2 / 0.24))


class TestKalmanConsensus:
    @pytest.mark.parametrize("topology", ["full", "ring", "line"])
    @pytest.mark.parametrize(("pull", "noise"), [(1.0, 0.0), (3.0, 0.01), (0.0, 0.0), (50.0, 0.01)])
    def test_every_round_is_as_the_equations_say(self, topology, pull, noise):
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

    def test_alone_it_is_the_posterior_of_a_normal(self):
        """No neighbours, readings of one variance: the mean and variance of prior and likelihood multiplied."""
        used = KALMAN.with_parameters({"least_variance": 0.25})
        world = {"robots": 3, "accuracy": APART, "rounds": 20, "looks": 4}
        fields, _, blacks, *_ = lived(used, topology={"name": "nobody", "edges": []}, **world)
        z = (blacks[1:].sum(axis=0) / 80 - 0.35) / 0.55
        sure = 80 * 0.55**2 / 0.25
        assert fields["P"][-1] == pytest.approx(1 / (12 + sure), rel=1e-12)
        assert fields["x"][-1] == pytest.approx((12 * 0.5 + sure * z) / (12 + sure), rel=1e-12)

    def test_a_crowd_does_not_make_it_swing(self):
        """Blind sensors, so that P stays, and a strong pull: what is said lies between what was said before."""
        used = KALMAN.with_parameters({"pull": 100.0})
        me = used.robot(0.5, 0.5)
        for _ in range(50):
            for x in (0.1, 0.9) * 100:
                used.functions.receive(me, (0.0, 0.0, x))
            used.functions.fuse(me)
            assert me.x == pytest.approx(0.5, abs=1e-12)


class TestConsensusInnovations:
    @pytest.mark.parametrize("topology", ["full", "ring", "line"])
    @pytest.mark.parametrize("pull", [0.25, 0.9])
    def test_every_round_is_as_the_equation_says(self, topology, pull):
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

    def test_on_a_ring_the_mean_is_that_of_all_readings(self):
        fields, _, blacks, *_ = lived(INNOVATIONS, robots=10, accuracy=APART, rounds=50, looks=4)
        z = (blacks[1:] / 4 - 0.35) / 0.55
        means = np.cumsum(z.mean(axis=1)) / np.arange(1, 51)
        assert fields["x"][1:].mean(axis=1) == pytest.approx(means, abs=1e-12)

    def test_rounds_without_news_are_not_counted(self):
        """Neither those without readings nor those of a sensor that tells nothing."""
        me, blind = INNOVATIONS.robot(0.9, 0.9), INNOVATIONS.robot(0.3, 0.7)
        for looks in (0.0, 10.0, 0.0, 10.0):
            if looks:
                INNOVATIONS.functions.observe(me, 5.0, looks)
                INNOVATIONS.functions.observe(blind, 5.0, looks)
            INNOVATIONS.functions.fuse(me)
            INNOVATIONS.functions.fuse(blind)
        assert (me.rounds, blind.rounds, blind.x) == (2.0, 0.0, 0.5)
        assert me.x == pytest.approx(0.5, abs=1e-12)


class TestCovarianceIntersection:
    @pytest.mark.parametrize("seed", range(8))
    def test_the_least_variance_is_that_of_one_of_both(self, seed):
        """By brute force over o, and the brain takes what comes out."""
        random = np.random.default_rng(seed)
        (a, b), (mine, theirs) = random.random(2), random.uniform(1, 100, 2)
        o = np.linspace(0, 1, 1001)
        inverse = o * mine + (1 - o) * theirs
        best = np.argmax(inverse)
        assert best == (1000 if mine > theirs else 0)
        expected = (o * a * mine + (1 - o) * b * theirs)[best] / inverse[best]
        me = INTERSECTION.robot(0.8, 0.8)
        me.x, me.Y = a, mine
        INTERSECTION.functions.receive(me, (b, theirs))
        INTERSECTION.functions.fuse(me)
        assert (me.x, me.Y) == pytest.approx((expected, max(mine, theirs)), rel=1e-12)

    @pytest.mark.parametrize("topology", ["full", "ring"])
    def test_every_round_is_as_the_equations_say(self, topology):
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

    def test_equals(self):
        """The own estimate stays where nobody is surer; of several surer ones alike the mean."""
        me = INTERSECTION.robot(0.8, 0.8)
        me.x, me.Y = 0.4, 5.0
        INTERSECTION.functions.receive(me, (0.9, 5.0))
        INTERSECTION.functions.fuse(me)
        assert (me.x, me.Y) == (0.4, 5.0)
        for x, sure in ((0.1, 2.0), (0.6, 7.0), (0.5, 3.0), (0.7, 7.0)):
            INTERSECTION.functions.receive(me, (x, sure))
        INTERSECTION.functions.fuse(me)
        assert (me.x, me.Y) == (pytest.approx(0.65), 7.0)

    def test_talk_gains_nothing_among_robots_of_fixed_variance(self):
        """Sensors alike, readings of one variance: all are equally sure at any time, and talk changes nothing."""
        world = {"robots": 6, "accuracy": 0.8, "rounds": 20, "looks": 3}
        one, other = (lived(INTERSECTION, topology=t, **world) for t in ("full", {"name": "nobody", "edges": []}))
        assert (one[0]["x"] == other[0]["x"]).all()

    @pytest.mark.long
    def test_variances_at_the_estimate_drag_a_swarm_to_an_end(self):
        """Who is far from 1/2 passes for sure and is copied: all end at 0 or 1, though a floor is 0.35 black."""
        used = INTERSECTION.with_parameters({"least_variance": 0.05})
        world = {"robots": 20, "accuracy": 0.7, "rounds": 200, "looks": 10, "topology": "full", "fill_ratio": 0.35}
        ends = [lived(used, trial, **world)[1][-1] for trial in range(3)]
        assert max(abs(end - 0.35).min() for end in ends) > 0.2
        fair = [lived(INTERSECTION, trial, **world)[1][-1] for trial in range(3)]
        assert max(abs(end - 0.35).max() for end in fair) < 0.15


def test_what_is_said_means_what_its_roles_say():
    assert INFORMATION.roles == {"i": "information", "I": "confidence"}
    assert KALMAN.roles == {"u": "information", "U": "confidence", "x": "estimate"}
    assert INNOVATIONS.roles == {"x": "estimate"}
    assert INTERSECTION.roles == {"x": "estimate", "Y": "confidence"}
    for name in ("linear-consensus", "w-msr", "gated-mean"):
        assert brains.load(name).roles == {"x": "estimate", "name": "name"}
    assert INNOVATIONS.uses.name is False
