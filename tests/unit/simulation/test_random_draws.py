"""me.luck: chance that is addressed, fresh at each call of observe, receive, fuse and steer."""

import numpy as np
import pytest

from swarmcensus import brains
from swarmcensus.engine.random import chance
from swarmcensus.studies import addresses
from tests.reference import rounds as reference
from tests.support.second import RANDOM, brain, changed, fixed
from tests.support.small import FAULTS, SEED
from tests.support.trials import record_trial


def lives(source, trial=0, **world):
    (setting,) = fixed(brain(source) if isinstance(source, str) else source, **world)
    return record_trial(setting, SEED, trial)[0]


def test_never_zero_and_never_one():
    assert chance(np.uint64(0)) == 2.0**-53
    assert chance(np.uint64(2**64 - 1)) == 1.0 - 2.0**-53
    assert chance(np.uint64(2**63)) == 0.5 + 2.0**-53
    assert chance(np.uint64(2**63)) == reference.chance(2**63)


@pytest.mark.interpreted
def test_each_message_has_its_own_random_draw():
    """A full network of three: the last message heard is that of the last robot, by its own luck."""
    source = changed(
        ("me.heard = me.luck", "me.heard += me.luck"),
        ("    me.fused = me.luck", "    me.fused = me.heard\n    me.heard = 0.0"),
        source=RANDOM,
    )
    every = lives(source, robots=3, topology="full")["fused"]
    one = {"name": "one", "edges": [[1, 0]], "directed": True}
    (setting,) = fixed(brain(source), robots=3, topology="full")
    key = addresses.draw_keys(setting, SEED)[2:]
    for k in range(1, 9):
        words = [[reference.threefry(reference.key_of(key), (0, k), (i, j))[0] for j in range(3)] for i in range(3)]
        for i in range(3):
            assert every[k, i] == sum(reference.chance(words[i][j]) for j in range(3) if i != j)
    assert (lives(source, robots=3, topology=one)["fused"][:, [1, 2]] == 0).all()


@pytest.mark.interpreted
@pytest.mark.parametrize(
    "world", [{}, {"topology": "full"}, {"link_success": 0.5, "faults": FAULTS}], ids=["ring", "full", "lossy"]
)
def test_it_changes_nothing_else(world):
    """A brain that is given luck and makes nothing of it lives as one that is given none: bit for bit."""
    shipped = brains.load("minimalistic")
    for line in ("    me.heard += 1.0\n", "    total = me.alpha + me.beta\n", "    me.n += blacks\n"):
        asks = shipped.source.replace(line, f"{line}    lot = me.luck\n")
        asks = asks.replace("SUMS =", "NO_SUMS =") if "heard" in line else asks
        assert brain(asks).uses.luck
        plain = brain(asks.replace("    lot = me.luck\n", ""))
        one, other = lives(brain(asks), **world), lives(plain, **world)
        for name in plain.memory:
            assert (one[name] == other[name]).all()
