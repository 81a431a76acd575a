"""The rules for opinions by hand, on tiny histories in CPython, and CPython against the engine."""

import math
from fractions import Fraction

import numpy as np
import pytest

from tests.support.opinions import BINARY, SWITCHERS, TELLERS, robot, rounds, telling


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
            (0.9, 0.6, 0.0, 0.3),
            (0.9, 0.9, 1.0, (0.3 + 0.9 - 1.0) / 0.8),
            (0.8, 0.6, 1.0, 0.0),
            (0.2, 0.1, 1.0, (0.3 + 0.1 - 1.0) / -0.7),
            (0.3, 0.7, 1.0, 0.5),
        ):
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


@pytest.mark.parametrize(
    ("own", "others", "adopted"),
    [(1, [], 1), (1, [0], 1), (1, [0, 0], 0), (0, [1, 1, 0], 0), (0, [1, 1, 1, 0], 1), (0, [1, 1, 0, 0], 0),
     (1, [0, 0, 1, 1], 1), (1, [0, 0, 0, 0, 0, 0], 0)],
)  # fmt: skip
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


@pytest.mark.parametrize(
    ("name", "own", "heard", "adopted"),
    [
        *(("cross-inhibition", *row) for row in ((1, 0, NONE), (0, 1, NONE), (1, 1, 1), (0, 0, 0), (1, None, 1))),
        *(("cross-inhibition", NONE, heard, adopted) for heard, adopted in ((1, 1), (0, 0), (None, NONE))),
        *(("direct-switching", *row) for row in ((1, 0, 0), (0, 1, 1), (1, 1, 1), (0, 0, 0), (1, None, 1))),
    ],
)  # fmt: skip
def test_what_becomes_of_an_opinion(name, own, heard, adopted):
    me, rule = telling(name, miscommunication=0.0, asocial=0.0)
    me.opinion = float(own)
    assert (rule.broadcast(me) is None) == (own == NONE)
    assert rule.decide(me) == (-1.0 if own == NONE else own)
    rounds(me, rule, [] if heard is None else [(float(heard),)])
    assert me.opinion == adopted
    assert rule.estimate(me) == adopted
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
