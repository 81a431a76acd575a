"""Linear consensus, W-MSR and the gated mean: against their equations in NumPy, against liars, and in fixed memory."""

import networkx as nx
import numpy as np
import pytest

from swarmcensus import brains
from swarmcensus.simulation import sampling
from tests.support.lying import CONSTANT
from tests.support.second import brain, fixed
from tests.support.small import SEED
from tests.support.trials import record_trial

LINEAR, WMSR, GATED = (brains.load(name) for name in ("linear-consensus", "w-msr", "gated-mean"))
ALL = [LINEAR, WMSR, GATED]
each = pytest.mark.parametrize("used", ALL, ids=lambda used: used.name)


def liars(robots, says=1.0):
    one = brain(CONSTANT, "constant.py").with_parameters({"says": says})
    return [{"robots": robots, "brain": one, "honest": False}] if robots else []


def lived(used, trial=0, **world):
    """The one setting's trial: x (round, robot), black readings (round, robot), who is honest."""
    (setting,) = fixed(used, **world)
    fields, _, blacks = record_trial(setting, SEED, trial)
    return fields["x"], blacks, sampling.groups(setting, SEED, trial, 1)[0] == 0


def shares(blacks, phase, looks):
    """The share of black of each phase (phase, robot)."""
    return blacks[1:].reshape(-1, phase, blacks.shape[1]).sum(axis=1) / (phase * looks)


def trimmed(own, heard, f):
    """What W-MSR keeps, as its definition says."""
    above, below = (sorted(v for v in heard if side * (v - own) > 0) for side in (1, -1))
    return [v for v in heard if v == own] + above[: max(0, len(above) - f)] + below[f:]


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
@pytest.mark.interpreted
@pytest.mark.parametrize("topology", ["full", "ring"])
@pytest.mark.parametrize(("drop", "lying"), [(None, 2), (0, 2), (1, 1), (2, 3), (30, 1)])
def test_every_phase_is_as_the_equations_say(topology, drop, lying):
    """Linear consensus (None) and W-MSR, with liars who speak from the first phase on."""
    phase, looks, robots = 4, 3, 8
    used = (LINEAR if drop is None else WMSR.with_parameters({"drop": drop})).with_parameters({"phase": phase})
    x, blacks, honest = lived(used, robots=robots, rounds=40, looks=looks, topology=topology, members=liars(lying, 0.9))
    assert honest.sum() == robots - lying

    def keeps(own, heard):
        return heard if drop is None else trimmed(own, heard, drop)

    expected = by_hand(shares(blacks, phase, looks), neighbours(topology, robots), honest, 0.9, keeps)
    assert x[::phase][:, honest] == pytest.approx(expected[:, honest], abs=1e-12)
    held = x[:-1].reshape(-1, phase, robots)[:, :, honest]
    assert (held == held[:, :1]).all()  # nothing changes within a phase


@pytest.mark.long(but_every=3)
@pytest.mark.interpreted
@pytest.mark.parametrize(("says", "gate"), [(0.95, 0.2), (0.6, 0.2), (0.6, 0.05)])
def test_the_gated_mean_is_as_its_rule_says(says, gate):
    phase, looks, robots = 5, 4, 7
    x, blacks, honest = lived(
        GATED.with_parameters({"phase": phase, "gate": gate}),
        robots=robots, rounds=60, looks=looks, topology="full", members=liars(2, says),
    )  # fmt: skip
    votes = shares(blacks, phase, looks)
    for i in np.flatnonzero(honest):
        counted: list[float] = []
        mean = 0.5
        for k in range(len(votes)):
            cast = [says] * 2 + [votes[k - 1, j] for j in np.flatnonzero(honest) if j != i and k > 0]
            counted += [v for v in cast if k < 2 or abs(v - mean) < gate] + [votes[k, i]]
            mean = np.mean(counted)
            assert x[phase * (k + 1), i] == pytest.approx(mean, abs=1e-12)


@pytest.mark.interpreted
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
    assert me.senders == 20
    assert list(zip(me.key, me.said, strict=True)) == kept
