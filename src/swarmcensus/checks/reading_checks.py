"""Checks of readings: many at once mean the same as one by one."""

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.checks import random_checks
from swarmcensus.checks.sample_states import (
    CLOSE,
    PLAIN,
    SEED,
    Violation,
    call,
    copy_of,
    difference,
    hear,
    line_of,
    long_lives,
    messages,
    number_at,
    sample,
)

PARTS = (1, 2, 7, 40, 400, 2000)  # sizes of parts of many readings
FEW = ((10, 10), (0, 10), (5, 10), (200, 200))  # black readings, all readings
MANY = ((2000, 2000), (0, 2000), (876, 2000), (20000, 20000), (0, 20000), (8765, 20000))
MOST_ONE_BY_ONE = 2000  # readings that are made one by one: a brain may be slow


def readings_add_up(brain: Brain) -> None:
    """Readings of one colour at once, in parts, and one by one; of both colours too, if their order does not matter."""
    if "observe" in brain.uses.random:
        random_checks.readings_add_up(brain, _starts(brain))
        return
    for where, start, cases in _starts(brain):
        for blacks, looks in cases:
            halves = [(3, 3), (looks - 3, looks - 3)]
            if blacks < looks:  # two parts of unequal size, in each of which some readings may be black
                halves = [(blacks // 2, looks // 2 - 1), (blacks - blacks // 2, looks - looks // 2 + 1)]
            ways = [("in two parts", halves)]
            if looks <= MOST_ONE_BY_ONE:
                ways.append(("one by one", _parts(blacks, looks, (1,))))
            if looks > 200:
                ways.append((f"in parts of 1 to {max(PARTS)}", _parts(blacks, looks, PARTS)))
            states = [(how, random_checks.after_readings(brain, where, start, way)) for how, way in ways]
            if 0 < blacks < looks:
                turned = random_checks.after_readings(brain, where, start, ways[-1][1][::-1])  # the white ones first
                if difference(brain, states[-1][1], turned):
                    continue  # a brain that forgets: the order matters, but `observe` does not receive it
                states.append((f"{ways[-1][0]}, the white ones first", turned))
            once = random_checks.after_readings(brain, where, start, [(blacks, looks)])
            for how, state in states:
                field = difference(brain, once, state, CLOSE * max(1.0, looks / 1000.0))  # as rounding adds up
                if field:
                    at_once, in_parts = number_at(once, field), number_at(state, field)
                    raise Violation(
                        f"{line_of(brain, 'observe')} makes me.{field} {at_once!r} of {looks} readings at once, "
                        f"{blacks} of them black, and {in_parts!r} of the same {how} ({where})"
                    )


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
    for size in random_checks.split(looks, sizes):
        parts.append((min(size, blacks), size))
        blacks -= parts[-1][0]
    return parts
