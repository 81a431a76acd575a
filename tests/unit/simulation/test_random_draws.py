"""me.luck: chance that is addressed, fresh at each call of observe, receive, fuse and steer."""

from dataclasses import replace

import numpy as np
import pytest

from swarmcensus import brains
from swarmcensus.engine.random import chance
from swarmcensus.simulation import sampling
from swarmcensus.simulation.rides import record_ride
from swarmcensus.simulation.trials import Metrics, record_trial, run_batch
from swarmcensus.studies import addresses
from tests.reference import rounds as reference
from tests.support.second import ALL, MEANS, OURS, RANDOM, STEER, brain, changed, fixed, moving
from tests.support.small import FAULTS, GO, SEED


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


@pytest.mark.interpreted
def test_two_brains_have_the_same():
    """So that they differ by what they are, and not by chance: whatever one of them does not ask for."""
    both, fused = lives(RANDOM), lives(changed(("me.seen = me.luck", "me.seen = 0.0"), source=RANDOM))
    assert (both["fused"] == fused["fused"]).all()
    assert (both["heard"] == fused["heard"]).all()
    assert (lives(RANDOM, accuracy=0.9)["fused"] == both["fused"]).all()


@pytest.mark.interpreted
def test_a_round_without_a_reading_costs_none():
    """A sensor that fails changes no other luck."""
    failed = lives(RANDOM, faults=[{"at": 3, "robots": 2, "stop": "sensing"}])
    whole = lives(RANDOM)
    assert (failed["fused"] == whole["fused"]).all()
    assert (failed["heard"] == whole["heard"]).all()
    assert (failed["seen"] == whole["seen"]).all(axis=0).sum() == 3


@pytest.mark.interpreted
def test_on_the_move_and_of_robots_that_steer():
    """A brain whose steering is by lot has the same luck elsewhere as one that walks at random."""
    walks, steers = (record_ride(moving(brain(s)), SEED, 0).fields for s in (RANDOM, RANDOM + STEER))
    assert (walks["fused"] == steers["fused"]).all()
    assert len(np.unique(walks["fused"][1:])) == 25 * 6


@pytest.mark.interpreted
def test_in_a_mixed_swarm_all_are_as_lucky_as_alone():
    (mixed,) = fixed(brain(RANDOM), members=[{"robots": 2, "brain": brain(MEANS, "means.py")}])
    who = sampling.groups(mixed, SEED, 0, 1)[0]
    one, other = record_trial(mixed, SEED, 0)[0], record_trial(replace(mixed, members=()), SEED, 0)[0]
    for name in OURS:
        assert (one[name][:, who == 0] == other[name][:, who == 0]).all()
        assert np.isnan(one[name][:, who == 1]).all()


def test_local_estimates_ignore_the_network():
    final = [
        run_batch(setting, SEED, 0, 2, Metrics(0.01, 10, ()), GO, local=True).final
        for setting in fixed(brain(ALL), topology=["ring", "full", "line"], link_success=[1.0, 0.5])
    ]
    assert all((one == final[0]).all() for one in final)


@pytest.mark.interpreted
def test_a_field_of_ones_own_may_be_called_luck():
    own = changed(("MEMORY = {", 'MEMORY = {"luck": 7.0, '), ("me.n += blacks", "me.n += blacks\n    me.luck += 1.0"))
    assert not brain(own).uses.luck
    assert (lives(own)["luck"][-1] == 15.0).all()
