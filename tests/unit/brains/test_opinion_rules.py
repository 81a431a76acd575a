"""The rules for opinions, two-valued and three-valued, by hand on tiny histories in CPython."""

import math
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from swarmcensus import brains
from tests.support.opinions import BINARY, DANCERS, SWITCHERS, TELLERS, robot, rounds, telling


@pytest.mark.parametrize("name", BINARY)
def test_the_first_opinions_are_an_exact_split(name):
    for share in (Fraction(1, 2), Fraction(0), Fraction(1), Fraction(1, 4), Fraction(3, 10), Fraction(17, 20)):
        held = []
        for number in range(100):
            me, rule = robot(name, number, black_first=float(share))
            assert rule.estimate(me) == rule.decide(me)
            held.append(rule.estimate(me))
            rounds(me, rule)
            assert rule.estimate(me) == held[-1]
        assert set(held) <= {0.0, 1.0}
        for robots in range(1, 101):
            expected = math.floor(robots * share + Fraction(1, 2))
            exact = (robots * share).denominator == 1
            assert abs(sum(held[:robots]) - expected) <= (0 if exact or share == Fraction(1, 2) else 1)


@pytest.mark.parametrize("name", BINARY)
def test_the_quality_is_the_share_of_the_own_colour(name):
    """3 of 10 readings are black; then corrected for b = 0.9, w = 0.6; and where there is nothing to learn from."""
    extra = 1.0 if name in TELLERS else 0.0
    for number, opinion in ((0, 1.0), (1, 0.0)):
        for b, w, debiased, black in (
            (0.9, 0.6, 0.0, 0.3), (0.9, 0.9, 1.0, (0.3 + 0.9 - 1.0) / 0.8), (0.8, 0.6, 1.0, 0.0),
            (0.2, 0.1, 1.0, (0.3 + 0.1 - 1.0) / -0.7), (0.3, 0.7, 1.0, 0.5),
        ):  # fmt: skip
            me, rule = robot(name, number, b=b, w=w, debiased=debiased)
            rounds(me, rule, blacks=3.0, looks=10.0)
            assert me.opinion == opinion
            share = black if opinion else 1.0 - black
            found = rule.share(me, opinion) if name == "direct-comparison" else rule.quality(me)
            assert found == pytest.approx(share * 10.0 / (10.0 + extra), abs=1e-15)
    me, rule = robot(name)
    rounds(me, rule, looks=0.0)
    assert (rule.share(me, 1.0) if name == "direct-comparison" else rule.quality(me)) == 0.0


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("name", BINARY)
def test_a_cycle_knows_nothing_of_the_readings_before(name, number):
    """Of three cycles each has other readings, and tells for as long as those of its own exploration say."""
    draws, own = 0.3, 1.0 - number
    me, rule = robot(name, number, **({"miscommunication": 0.0, "asocial": 0.0} if name in SWITCHERS else {}))
    first = 1.0 if name in TELLERS else 0.0
    explored = [5.0, 4.0, 4.0]  # the first exploration is one round longer
    for cycle, (alike, looks) in enumerate([(1000.0, 1000.0), (2.0, 4.0), (90.0, 100.0)]):
        seen = 0.0
        while rule.broadcast(me) is None:
            rounds(me, rule, draws=draws, blacks=alike if own else looks - alike, looks=looks)
            seen += 1.0
        assert seen == explored[cycle]
        mine, all_of_them = alike * seen, looks * seen + first
        larger = max(mine, looks * seen - mine) if name == "direct-comparison" else mine
        if name == "direct-comparison":
            assert rule.broadcast(me) == (own, mine / all_of_them, float(number))
        told = 0
        while rule.broadcast(me) is not None:
            rounds(me, rule, draws=draws, blacks=0.0 if own else 50.0, looks=50.0)  # of the other colour
            told += 1
        assert told == math.ceil(-6.0 * larger / all_of_them * math.log(draws)) + (2 if name in TELLERS else 0)
    assert me.opinion == own


@pytest.mark.parametrize(("own", "others", "adopted"), [
    (1, [], 1), (1, [0], 1), (1, [0, 0], 0), (0, [1, 1, 0], 0), (0, [1, 1, 1, 0], 1), (0, [1, 1, 0, 0], 0),
    (1, [0, 0, 1, 1], 1), (1, [0, 0, 0, 0, 0, 0], 0),
])  # fmt: skip
def test_the_majority_is_of_the_kept_and_oneself(own, others, adopted):
    me, rule = telling("majority", number=1 - own, senders=4.0)
    said = [(float(opinion), 10.0 + k) for k, opinion in enumerate(others)]
    rounds(me, rule, said + said[::-1])
    assert me.opinion == adopted


def test_majority_samples_distinct_senders():
    """By brute force: 30 senders in any order, one of them with two opinions; as many as asked for stay."""
    random = np.random.default_rng(5)
    said = [(float(k % 2), float(k)) for k in range(30)] + [(0.0, 7.0)]
    for senders in (1, 2, 3, 4, 9):
        me, rule = telling("majority", senders=float(senders))
        lots = {}
        for opinion, name in said:
            lot = rule.drawn(me, name, opinion)
            lots[name] = min(lots.get(name, (2.0, 0.0)), (lot, opinion))
        expected = sorted(lots.values())[: min(senders, 4)]
        for k in random.permutation(np.repeat(np.arange(len(said)), 2)):
            rule.receive(me, said[k])
        kept = list(zip(me.lots, me.kept, strict=True))
        assert kept == expected + [(2.0, 0.0)] * (4 - len(expected))


def test_direct_comparison_adopts_what_is_better():
    for quality, adopted in ((0.0, 1.0), (0.6, 1.0), (2.0 / 3.0, 1.0), (0.7, 0.0)):
        me, rule = telling("direct-comparison")
        assert rule.broadcast(me) == (1.0, 2.0 / 3.0, 0.0)  # two readings, both black, and one more
        rounds(me, rule, [(0.0, quality, 9.0)])
        assert me.opinion == adopted


NONE = 0.5


@pytest.mark.parametrize(("name", "own", "heard", "adopted"), [
    *(("cross-inhibition", *row) for row in ((1, 0, NONE), (0, 1, NONE), (1, 1, 1), (0, 0, 0), (1, None, 1))),
    *(("cross-inhibition", NONE, heard, adopted) for heard, adopted in ((1, 1), (0, 0), (None, NONE))),
    *(("direct-switching", *row) for row in ((1, 0, 0), (0, 1, 1), (1, 1, 1), (0, 0, 0), (1, None, 1))),
])  # fmt: skip
def test_what_becomes_of_an_opinion(name, own, heard, adopted):
    me, rule = telling(name, miscommunication=0.0, asocial=0.0)
    me.opinion = float(own)
    assert (rule.broadcast(me) is None, rule.decide(me)) == (own == NONE, -1.0 if own == NONE else own)
    rounds(me, rule, [] if heard is None else [(float(heard),)])
    assert (me.opinion, rule.estimate(me)) == (adopted, adopted)
    assert rule.broadcast(me) is None


@pytest.mark.parametrize("name", TELLERS)
def test_only_the_last_rounds_are_listened_to(name):
    other = (0.0, 1.0) if name == "direct-comparison" else (0.0,)
    heard = [(*other, float(sender)) for sender in (7, 8, 9)]
    for left, adopts in ((4.0, False), (3.0, False), (2.0, True), (1.0, True)):
        me, rule = telling(name)
        me.left = left
        rounds(me, rule, heard)
        rounds(me, rule, count=int(left) - 1)
        assert rule.broadcast(me) is None
        assert me.opinion == (0.0 if adopts else 1.0)
    me, rule = robot(name)  # who explores does not listen
    rounds(me, rule, heard, count=2)
    assert (me.opinion, me.t) == (1.0, 2.0)


# ---- three-valued opinions and their Boolean baseline by hand: beliefs, dances, listening
def test_beliefs_are_joined_as_published():
    """All nine pairs, by a second way: as intervals of what may be true."""
    _, rule = robot("three-state")
    table = {(0.0, 1.0): 0.5, (1.0, 0.0): 0.5}
    for one, other in product((0.0, 0.5, 1.0), repeat=2):
        expected = table.get((one, other), other if one == 0.5 else one)
        assert rule.joined(one, other) == rule.joined(other, one) == expected


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
    for count in (5, 4):
        rounds(me, rule, count=count)
        assert me.steps == 2.0
    rounds(me, rule, count=6)
    assert (me.steps, rule.broadcast(me)[0]) == (0.0, 0.0)
    rounds(me, rule, count=5)  # it has heard nobody
    assert me.steps == 3.0
    rounds(me, rule, count=15)
    for steps in (-1.0, -2.0, -3.0, 3.0):
        rounds(me, rule, [said], count=5)
        assert me.steps == steps
    me.steps = 0.0
    rounds(me, rule, [said, (1.0, *said[1:])], count=5)  # a dancer among them
    assert me.steps == 3.0
    if name == "weighted-voter":
        assert (rule.decide(me), rule.estimate(me)) == (4.0, 0.45)


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
