"""Three-valued opinions and their Boolean baseline by hand: beliefs, dances, listening."""

import math
from itertools import product

import numpy as np
import pytest

from swarmcensus import brains
from tests.support.opinions import DANCERS, robot, rounds


def test_beliefs_are_joined_as_published():
    """All nine pairs, by a second way: as intervals of what may be true."""
    _, rule = robot("three-state")
    table = {(0.0, 1.0): 0.5, (1.0, 0.0): 0.5}
    for one, other in product((0.0, 0.5, 1.0), repeat=2):
        expected = table.get((one, other), other if one == 0.5 else one)
        assert rule.joined(one, other) == expected
        assert rule.joined(one, other) == rule.joined(other, one)


def test_beliefs_begin_as_any_set_of_bins():
    """The luck of each of the 1,023 sets that are not empty, in its middle."""
    found = set()
    for number in range(1, 1024):
        me, rule = robot("three-state")
        rounds(me, rule, draws=(number - 0.5) / 1023.0)
        chosen = [k for k in range(10) if number >> k & 1]
        value = 1.0 if len(chosen) == 1 else 0.5
        assert list(me.beliefs) == [value if k in chosen else 0.0 for k in range(10)]
        assert me.site in chosen
        found.add(tuple(me.beliefs))
    assert len(found) == 1023


@pytest.mark.parametrize("name", DANCERS)
def test_it_dances_as_long_as_its_site_is_good(name):
    """Readings of which 0.35 are black, or 0.35 once corrected: quality by the formula, rounded by lot."""
    for b, w, debiased, blacks in ((1.0, 1.0, 0.0, 35.0), (0.9, 0.8, 1.0, 100 * (0.9 * 0.35 + 0.2 * 0.65))):
        me, rule = robot(name, b=b, w=w, debiased=debiased, dance=25.0, width=0.2)
        for draws in np.random.default_rng(7).random(20):
            me.t, me.n, me.luck = 100.0, blacks, float(draws)
            rule.begin(me)
            good = 25.0 * math.exp(-(((me.site + 0.5) / 10 - 0.35) ** 2) / (2 * 0.2**2))
            assert rule.quality(me) == pytest.approx(good, rel=1e-12)
            assert me.steps in {max(math.floor(good), 1.0), math.floor(good) + 1.0}


@pytest.mark.parametrize("name", DANCERS)
def test_dancing_listening_and_waiting(name):
    """Steps of five rounds: it dances its steps, alone it dances again, among listeners it waits, for a while."""
    me, rule = robot(name, every=5.0, dance=3.01, width=50.0, patience=4.0)
    said = (0.0, 4.0, (0.5,) * 10)[: len(brains.load(name).message)]
    rounds(me, rule, count=5)
    assert me.steps == 2.0
    rounds(me, rule, count=4)
    assert me.steps == 2.0
    rounds(me, rule, count=6)
    assert me.steps == 0.0
    assert rule.broadcast(me)[0] == 0.0
    rounds(me, rule, count=5)  # it has heard nobody
    assert me.steps == 3.0
    rounds(me, rule, count=15)
    for waited in (1, 2, 3):
        rounds(me, rule, [said], count=5)
        assert me.steps == -waited
    rounds(me, rule, [said], count=5)
    assert me.steps == 3.0
    me.steps = 0.0
    rounds(me, rule, [said, (1.0, *said[1:])], count=5)  # a dancer among them
    assert me.steps == 3.0
    if name == "weighted-voter":
        assert rule.decide(me) == 4.0
        assert rule.estimate(me) == 0.45


@pytest.mark.parametrize("name", DANCERS)
def test_the_faulty_never_listen(name):
    me, rule = robot(name, every=1.0, dance=1.0, width=50.0, faulty=1.0)
    said = (1.0, 4.0, (0.0,) * 4 + (1.0,) + (0.0,) * 5)[: len(brains.load(name).message)]
    sites = set()
    for draws in np.random.default_rng(8).random(60):
        rounds(me, rule, [said], draws=float(draws))
        assert rule.broadcast(me)[0] == 1.0
        sites.add(me.site)
    assert len(sites) == 10
