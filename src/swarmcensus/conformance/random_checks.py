"""What a brain with luck promises: not the same mind, but the same chances of each."""

import math
from collections.abc import Callable, Iterable
from functools import partial
from itertools import cycle, islice, product
from typing import Any

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.conformance.sample_minds import (
    SEED,
    Fault,
    at,
    call,
    calls,
    copy_of,
    hear,
    long_lives,
    messages,
    numbers_in,
    short_lives,
    some,
)

DRAWS = 400  # of each of two laws
FALSE_ALARM = 1e-9  # of one comparison: a check makes some thousands
SIZES = (2, 3, 9, 17, 40, 120)
LOOKS = (10, 20, 200, 2000)  # readings of one colour, in each of these ways:
PARTS = {"one by one": (1,), "in two parts": (7, 10**9), "in parts of 1 to 400": (1, 2, 7, 40, 400)}
ONE_BY_ONE = 20
MINDS = 24  # that are tried, out of all lives
Numbers = dict[str, np.ndarray]


def any_order(brain: Brain) -> None:
    """The same messages in two orders, then `fuse`: each number that is remembered has the same law. Raises Fault."""
    random = np.random.default_rng(SEED)
    said = [message for _, message in messages(brain, extreme=False)]
    if not said:
        return
    for k, (where, me) in enumerate(_some_minds(brain)):
        heard = some(random, said, SIZES[k % len(SIZES)])
        laws = [_law(brain, partial(_heard, brain, where, me, order)) for order in (heard, heard[::-1])]
        field = _unlike(*laws)
        if field:
            raise Fault(
                f"{at(brain, 'receive')}, with fuse after it, gives me.{field} another law, {_told(laws[0][field])}, "
                f"by the messages {heard} than by the same in the other order, {_told(laws[1][field])}: they come in "
                f"no order that means anything ({where})"
            )


def looks_add_up(brain: Brain, starts: Iterable[tuple[str, Any, tuple[tuple[int, int], ...]]]) -> None:
    """Readings of one colour at once and in parts: each number has the same law. Raises Fault."""
    for where, start, _ in islice(starts, 0, 8 * MINDS, 8):
        for black, looks in product((1.0, 0.0), LOOKS):
            once = _law(brain, partial(_seen, brain, where, start, [(looks * black, float(looks))]))
            for how, sizes in PARTS.items():
                way = [(size * black, float(size)) for size in split(looks, sizes)]
                if len(way) > max(ONE_BY_ONE, looks // 20):
                    continue
                laws = [once, _law(brain, partial(_seen, brain, where, start, way))]
                field = _unlike(*laws)
                if not field:
                    continue
                raise Fault(
                    f"{at(brain, 'observe')} gives me.{field} another law, {_told(laws[0][field])}, by {looks} "
                    f"readings at once than by the same {how}, {_told(laws[1][field])} ({where})"
                )


def split(looks: int, sizes: tuple[int, ...]) -> list[int]:
    """Parts of these sizes, again and again."""
    parts: list[int] = []
    for size in cycle(sizes):
        if not looks:
            break
        parts.append(min(size, looks))
        looks -= parts[-1]
    return parts


def _some_minds(brain: Brain) -> Iterable[tuple[str, Any]]:
    """A few of all lives, young and old."""
    yield from islice(short_lives(brain), 0, 50 * MINDS // 2, 50)
    yield from islice(long_lives(brain), 0, 3 * MINDS // 2, 3)


def _heard(brain: Brain, where: str, me: Any, order: list[Any], luck: np.random.Generator) -> Any:
    mind = copy_of(brain, me)
    hear(brain, where, mind, order, luck)
    call(brain, where, "fuse", mind, luck=luck)
    return mind


def _seen(brain: Brain, where: str, me: Any, way: list[tuple[float, float]], luck: np.random.Generator) -> Any:
    mind = copy_of(brain, me)
    calls(brain, where, "observe", mind, way, luck)
    return mind


def _law(brain: Brain, lived: Callable[[np.random.Generator], Any]) -> Numbers:
    """Each remembered number of many minds that differ in their luck alone."""
    luck = np.random.default_rng(SEED)
    found = [dict(numbers_in(brain, lived(luck))) for _ in range(DRAWS)]
    return {name: np.array([one[name] for one in found], np.float64) for name in found[0]}


def _unlike(one: Numbers, other: Numbers) -> str | None:
    """The first number whose two laws differ by more than chance: Smirnov's test of two samples, asymptotically."""
    beyond = math.sqrt(-math.log(FALSE_ALARM / 2.0) / DRAWS)
    for name, mine in one.items():
        values = np.sort(np.concatenate([mine, other[name]]))
        values = values + 1e-9 * np.maximum(1.0, abs(values))  # what differs by rounding is alike
        shares = [np.searchsorted(np.sort(law), values, side="right") / DRAWS for law in (mine, other[name])]
        if np.abs(shares[0] - shares[1]).max() > beyond:
            return name
    return None


def _told(law: np.ndarray) -> str:
    return f"of mean {law.mean():.3g} and standard deviation {law.std():.3g}"
