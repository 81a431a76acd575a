"""Checks of readings: many at once mean the same as one by one."""

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import cycle, islice, product
from typing import Any

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.checks.sample_states import (
    CLOSE,
    PLAIN,
    SEED,
    Draws,
    Violation,
    call,
    calls,
    copy_of,
    hear,
    line_of,
    long_lives,
    messages,
    sample,
)
from swarmcensus.checks.ways import odd_one

PARTS = (1, 2, 7, 40, 400, 2000)  # sizes of parts of many readings
FEW = ((10, 10), (0, 10), (5, 10), (200, 200))  # black readings, all readings
MANY = ((2000, 2000), (0, 2000), (876, 2000), (20000, 20000), (0, 20000), (8765, 20000))
OF_ONE_COLOUR = tuple((looks * black, looks) for black in (1, 0) for looks in (10, 20, 200, 2000))
MOST_ONE_BY_ONE = 2000  # readings that are made one by one: a brain may be slow
FEWER = 20  # of these, where they are made with many random numbers
STATES = 24  # that are examined then


def readings_add_up(brain: Brain) -> None:
    """Readings of one colour at once, in parts, and one by one; of both colours too, if their order does not matter.

    If luck is used, the distributions of states are the same.
    """
    few = "observe" in brain.uses.random  # distributions take long
    for where, start, usual in islice(_starts(brain), 0, 8 * STATES if few else None, 8 if few else 1):
        for blacks, looks in OF_ONE_COLOUR if few else usual:
            halves = [(min(3, blacks), 3), (blacks - min(3, blacks), looks - 3)]
            if 0 < blacks < looks:  # two parts of unequal size, in each of which some readings may be black
                halves = [(blacks // 2, looks // 2 - 1), (blacks - blacks // 2, looks - looks // 2 + 1)]
            ways = {"at once": [(blacks, looks)], "in two parts": halves}
            if looks <= (FEWER if few else MOST_ONE_BY_ONE):
                ways["one by one"] = _parts(blacks, looks, (1,))
            if looks > 200:
                ways[f"in parts of 1 to {max(PARTS)}"] = _parts(blacks, looks, PARTS)
            if 0 < blacks < looks:
                how, way = [*ways.items()][-1]
                if odd_one(brain, "observe", [partial(_after, brain, where, start, one) for one in (way, way[::-1])]):
                    continue  # a brain that forgets: the order matters, but `observe` does not receive it
                ways[f"{how}, the white ones first"] = way[::-1]
            close = CLOSE * max(1.0, looks / 1000.0)  # as rounding adds up
            after = [partial(_after, brain, where, start, way) for way in ways.values()]
            if found := odd_one(brain, "observe", after, close):
                k, field, x, y = found
                raise Violation(
                    f"{line_of(brain, 'observe')} makes me.{field} {x} of {looks} readings at once, {blacks} of them "
                    f"black, and {y} of the same {[*ways][k]} ({where})"
                )


def _after(brain: Brain, where: str, me: Any, way: Sequence[tuple[float, float]], draws: Draws) -> Any:
    """A copy of a state after readings: how many of each part are black, and how many there are."""
    state = copy_of(brain, me)
    calls(brain, where, "observe", state, [(float(blacks), float(looks)) for blacks, looks in way], draws)
    return state


def _starts(brain: Brain) -> Iterator[tuple[str, Any, tuple[tuple[int, int], ...]]]:
    """States to make readings: blank, young, and from long histories, after `fuse` and after `receive`."""
    draws = np.random.default_rng(SEED + 1)
    for b, w in product(PLAIN, PLAIN):
        for before in (0.0, 16.0):
            start = brain.robot(b, w)
            where = f"b = {b}, w = {w}, after {before:g} readings"
            if before:
                call(brain, where, "observe", start, 7.0, before, draws=draws)
                call(brain, where, "fuse", start, draws=draws)
            yield where, start, FEW
    heard = [message for _, message in messages(brain, extreme=False)]
    random = np.random.default_rng(SEED)
    blank = brain.robot(0.9, 0.75)
    yield f"b = {blank.b}, w = {blank.w}, before the first observation", blank, MANY
    for k, (where, me) in enumerate(long_lives(brain)):
        if me.b in PLAIN and me.w in PLAIN:
            many = MANY if "in round 65 " in where else ()
            yield where, me, FEW[:3] + many
            hears = copy_of(brain, me)
            hear(brain, where, hears, sample(random, heard, 1 + k % 9), draws)
            yield f"{where}, having heard others", hears, FEW[:3]


def _parts(blacks: int, looks: int, sizes: tuple[int, ...]) -> list[tuple[int, int]]:
    """Parts with these sizes in turn, the black readings first."""
    parts: list[tuple[int, int]] = []
    for size in cycle(sizes):
        if not looks:
            break
        part = min(size, looks)
        parts.append((min(part, blacks), part))
        blacks, looks = blacks - parts[-1][0], looks - part
    return parts
