"""Filters and consensus: against their equations in NumPy, the pooled likelihood by brute force, and against liars."""

import networkx as nx
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from swarmcensus import brains
from swarmcensus.simulation import sampling
from tests.support.lying import CONSTANT
from tests.support.second import brain, fixed
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
        i, more = told(b, w, blacks[k], 3, variances(b, w, x, least))
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
    counts, looks = blacks[1:].sum(axis=0), 5 * rounds

    def cost(f):
        q = b * f + (1 - w) * (1 - f)
        return -(counts * np.log(q) + (looks - counts) * np.log(1 - q)).sum()

    found = minimize_scalar(cost, bounds=(0, 1), method="bounded", options={"xatol": 1e-12}).x
    assert curves[-1] == pytest.approx(found, abs=1e-6)


@pytest.mark.parametrize("topology", ["full", "ring", "line"])
@pytest.mark.parametrize(("pull", "noise"), [(1.0, 0.0), (3.0, 0.01), (0.0, 0.0), (50.0, 0.01)])
def test_every_round_of_kalman_consensus_is_as_the_equations_say(topology, pull, noise):
    used = KALMAN.with_parameters({"pull": pull, "noise": noise})
    fields, _, blacks, b, w = lived(used, robots=6, accuracy=MIXED, rounds=25, looks=2, topology=topology)
    hears = adjacency(topology, 6)
    x, p = np.full(6, 0.5), np.full(6, 1 / 12)
    for k in range(1, 26):
        u, sure = told(b, w, blacks[k], 2, variances(b, w, np.clip(x, 0, 1), 0.05))
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
    fields, _, blacks, b, w = lived(INNOVATIONS.with_parameters({"pull": pull}), robots=6, accuracy=MIXED, rounds=30,
                                    looks=3, topology=topology)  # fmt: skip
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
        i, more = told(b, w, blacks[k], 2, variances(b, w, np.clip(x, 0, 1), 0.05))
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


# ---- linear consensus, W-MSR and the gated mean: against their equations in NumPy, against liars, and in fixed memory
LINEAR, WMSR, GATED = (brains.load(name) for name in ("linear-consensus", "w-msr", "gated-mean"))
ALL = [LINEAR, WMSR, GATED]
each = pytest.mark.parametrize("used", ALL, ids=lambda used: used.name)


def liars(robots, says=1.0):
    one = brain(CONSTANT, "constant.py").with_parameters({"says": says})
    return [{"robots": robots, "brain": one, "honest": False}] if robots else []


def lived_among(used, trial=0, **world):
    """The one setting's trial: x (round, robot), black readings (round, robot), who is honest."""
    (setting,) = fixed(used, **world)
    fields, _, blacks = record_trial(setting, SEED, trial)
    return fields["x"], blacks, sampling.groups(setting, SEED, trial, 1)[0] == 0


def shares(blacks, phase, looks):
    """The share of black of each phase (phase, robot)."""
    return blacks[1:].reshape(-1, phase, blacks.shape[1]).sum(axis=1) / (phase * looks)


def by_hand(seen, hears, honest, says, keeps):
    x = [np.where(honest, 0.5, says)]
    for k, share in enumerate(seen, start=1):
        after = x[-1].copy()
        for i in np.flatnonzero(honest):
            heard = [x[-1][j] for j in hears[i] if not honest[j] or k > 3]
            values = [share[i], *keeps(x[-1][i], heard)]
            after[i] += (np.mean(values) - after[i]) / k
        x.append(after)
    return np.array(x)


def neighbours(topology, robots):
    graph = nx.complete_graph(robots) if topology == "full" else nx.cycle_graph(robots)
    return [list(graph[i]) for i in range(robots)]


@pytest.mark.long(but=["None-2-full", "1-1-ring", "2-3-full", "30-1-ring"])
@pytest.mark.parametrize("topology", ["full", "ring"])
@pytest.mark.parametrize(("drop", "lying"), [(None, 2), (0, 2), (1, 1), (2, 3), (30, 1)])
def test_every_phase_is_as_the_equations_say(topology, drop, lying):
    """Linear consensus (None) and W-MSR, with liars who speak from the first phase on."""
    phase, looks, robots = 4, 3, 8
    used = (LINEAR if drop is None else WMSR.with_parameters({"drop": drop})).with_parameters({"phase": phase})
    x, blacks, honest = lived_among(used, robots=robots, rounds=40, looks=looks, topology=topology,
                                    members=liars(lying, 0.9))  # fmt: skip
    assert honest.sum() == robots - lying

    def keeps(own, heard):
        if drop is None:
            return heard
        above, below = (sorted(v for v in heard if side * (v - own) > 0) for side in (1, -1))
        return [v for v in heard if v == own] + above[: max(0, len(above) - drop)] + below[drop:]

    expected = by_hand(shares(blacks, phase, looks), neighbours(topology, robots), honest, 0.9, keeps)
    assert x[::phase][:, honest] == pytest.approx(expected[:, honest], abs=1e-12)
    held = x[:-1].reshape(-1, phase, robots)[:, :, honest]
    assert (held == held[:, :1]).all()  # nothing changes within a phase


@pytest.mark.long(but_every=3)
@pytest.mark.parametrize(("says", "gate"), [(0.95, 0.2), (0.6, 0.2), (0.6, 0.05)])
def test_the_gated_mean_is_as_its_rule_says(says, gate):
    phase, looks, robots = 5, 4, 7
    x, blacks, honest = lived_among(GATED.with_parameters({"phase": phase, "gate": gate}), robots=robots, rounds=60,
                                    looks=looks, topology="full", members=liars(2, says))  # fmt: skip
    votes = shares(blacks, phase, looks)
    for i in np.flatnonzero(honest):
        counted: list[float] = []
        mean = 0.5
        for k in range(len(votes)):
            cast = [says] * 2 + [votes[k - 1, j] for j in np.flatnonzero(honest) if j != i and k > 0]
            counted += [v for v in cast if k < 2 or abs(v - mean) < gate] + [votes[k, i]]
            mean = np.mean(counted)
            assert x[phase * (k + 1), i] == pytest.approx(mean, abs=1e-12)


@each
def test_receiver_samples_twenty_senders(used):
    """Against a dict of Python that remembers everybody; ten rounds of one phase, each in an order of its own."""
    random = np.random.default_rng(4)
    me = used.with_parameters({"phase": 100.0}).robot(0.8, 0.8)
    me.salt = 123456.0
    last: dict[float, float] = {}
    for _ in range(10):
        speakers = random.permutation(60)[: random.integers(60)]
        said = {float(name): float(random.random()) for name in speakers}
        forged = {name: float(random.random()) for name in list(said)[:5]}  # the same names once more
        messages = [(x, name) for one in (said, forged) for name, x in one.items()]
        last |= said | {name: min(x, said[name]) for name, x in forged.items()}
        for k in random.permutation(len(messages)):
            used.functions.receive(me, messages[k])
        used.functions.fuse(me)
    kept = sorted((used.functions.place(name, me.salt), x) for name, x in last.items())[:20]
    assert len(last) > 40
    assert (me.senders, list(zip(me.key, me.said, strict=True))) == (20, kept)
