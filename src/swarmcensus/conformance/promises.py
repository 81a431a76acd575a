"""What a brain promises by docs/brain-contract.md, check by check, as CPython runs it; a fault is one sentence."""

import math
from collections.abc import Callable, Iterator
from itertools import cycle, product
from typing import Any

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.conformance.lives import (
    CLOSE,
    PLAIN,
    SEED,
    Fault,
    at,
    call,
    calls,
    copy_of,
    difference,
    hear,
    is_message,
    lives,
    long_lives,
    messages,
    short_lives,
    some,
)

SIZES = (1, 2, 3, 6, 9, 17, 40, 120, 400)  # messages that come together
PARTS = (1, 2, 7, 40, 400, 2000)  # of many readings
FEW = ((10, 10), (0, 10), (5, 10), (200, 200))  # blacks, looks
MANY = ((2000, 2000), (0, 2000), (876, 2000), (20000, 20000), (0, 20000), (8765, 20000))
ONE_BY_ONE = 2000  # and not more: a brain may take its time


def _fixed_memory(brain: Brain) -> None:
    for _ in lives(brain):
        pass  # `call` looks at every mind


def _finite(brain: Brain) -> None:
    for where, me in lives(brain):
        x = call(brain, where, "estimate", me)
        if not (isinstance(x, int | float) and 0.0 <= x <= 1.0):
            raise Fault(f"{at(brain, 'estimate')} gives {x!r}, not a number in [0, 1] ({where})")
        message = call(brain, where, "broadcast", me)
        said = at(brain, "broadcast")
        if not isinstance(message, tuple) or len(message) != len(brain.message):
            raise Fault(f"{said} gives {message!r}, not a tuple of {len(brain.message)} as MESSAGE says ({where})")
        for name, value in zip(brain.message, message, strict=True):
            if not (isinstance(value, int | float) and abs(value) <= np.finfo(float).max):
                raise Fault(f"{said} gives {name} = {value!r}, not a finite number ({where})")


def _steers(brain: Brain) -> None:
    for where, me in lives(brain) if brain.steers else ():
        wish = call(brain, where, "steer", me)
        if not is_wish(wish):
            what = "neither two finite numbers, a speed and a turn, nor None"
            raise Fault(f"{at(brain, 'steer')} gives {wish!r}, {what} ({where})")


def is_wish(wish: object) -> bool:
    """Whether `steer` may return this."""

    def finite(value: object) -> bool:  # for the engine, that is below 1e300
        return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300

    return wish is None or (isinstance(wish, tuple) and len(wish) == 2 and all(map(finite, wish)))


def _reads_only(brain: Brain) -> None:
    for where, me in lives(brain):
        for name in ("broadcast", "estimate", *(("steer",) if brain.steers else ())):
            before = copy_of(brain, me)
            call(brain, where, name, me)
            changed = difference(brain, before, me, close=0.0)
            if changed:
                x, y = getattr(before, changed), getattr(me, changed)
                raise Fault(f"{at(brain, name)} changes me.{changed} from {x!r} to {y!r}: it may only read ({where})")


def _same_again(brain: Brain) -> None:
    """Two swarms live the same lives at the same time; one is asked more often."""
    for (where, one), (_, other) in zip(lives(brain), lives(brain), strict=True):
        changed = difference(brain, one, other, close=0.0)
        if changed:
            x, y = getattr(one, changed), getattr(other, changed)
            raise Fault(
                f"the same history gives me.{changed} = {x!r} and then {y!r}: something is kept outside of me, by "
                f"{at(brain, 'observe')}, {at(brain, 'receive')} or {at(brain, 'fuse')} ({where})"
            )
        said = [
            [call(brain, where, name, me) for name in ("broadcast", "estimate")] for me in (one, other, other, other)
        ]
        for name, first, *again in zip(("broadcast", "estimate"), *said, strict=True):
            if any(value != first for value in again):
                raise Fault(
                    f"{at(brain, name)} gives {first!r} and then {next(v for v in again if v != first)!r} of the same "
                    f"mind: something is kept outside of me ({where})"
                )


def _looks_add_up(brain: Brain) -> None:
    """Readings of one colour at once, in parts, and one by one; mixed ones where their order means nothing."""
    for where, start, cases in _starts(brain):
        for blacks, looks in cases:
            ways = [("in two parts", _halves(blacks, looks))]
            if looks <= ONE_BY_ONE:
                ways.append(("one by one", _parts(blacks, looks, (1,))))
            if looks > 200:
                ways.append((f"in parts of 1 to {max(PARTS)}", _parts(blacks, looks, PARTS)))
            minds = [(how, _seen(brain, where, start, way)) for how, way in ways]
            if 0 < blacks < looks:
                turned = _seen(brain, where, start, ways[-1][1][::-1])  # the white ones first
                if difference(brain, minds[-1][1], turned):
                    continue  # a brain that forgets: `observe` is not told in which order they came
                minds.append((f"{ways[-1][0]}, the white ones first", turned))
            once = _seen(brain, where, start, [(blacks, looks)])
            for how, mind in minds:
                field = difference(brain, once, mind, CLOSE * max(1.0, looks / 1000.0))  # as rounding adds up
                if field:
                    raise Fault(
                        f"{at(brain, 'observe')} makes me.{field} {getattr(once, field)!r} of {looks} readings at "
                        f"once, {blacks} of them black, and {getattr(mind, field)!r} of the same {how} ({where})"
                    )


def _starts(brain: Brain) -> Iterator[tuple[str, Any, tuple[tuple[int, int], ...]]]:
    """Minds that are to make readings: blank, young, and in a long life, after `fuse` and after `receive`."""
    for b, w in product(PLAIN, PLAIN):
        for before in (0.0, 16.0):
            start = brain.robot(b, w)
            where = f"b = {b}, w = {w}, after {before:g} readings"
            if before:
                call(brain, where, "observe", start, 7.0, before)
                call(brain, where, "fuse", start)
            yield where, start, FEW
    said = [message for _, message in messages(brain, extreme=False)]
    random = np.random.default_rng(SEED)
    blank = brain.robot(0.9, 0.75)
    yield f"b = {blank.b}, w = {blank.w}, before the first observation", blank, MANY
    for k, (where, me) in enumerate(long_lives(brain)):
        if me.b in PLAIN and me.w in PLAIN:
            many = MANY if "in round 65 " in where else ()
            yield where, me, FEW[:3] + many
            hears = copy_of(brain, me)
            hear(brain, where, hears, some(random, said, 1 + k % 9))
            yield f"{where}, having heard others", hears, FEW[:3]


def _halves(blacks: int, looks: int) -> list[tuple[int, int]]:
    """Two parts of unequal size."""
    if blacks == looks:
        return [(3, 3), (looks - 3, looks - 3)]
    return [(blacks // 2, looks // 2 - 1), (blacks - blacks // 2, looks - looks // 2 + 1)]


def _parts(blacks: int, looks: int, sizes: tuple[int, ...]) -> list[tuple[int, int]]:
    """Parts of these sizes, again and again, the black readings first."""
    parts: list[tuple[int, int]] = []
    for most in cycle(sizes):
        if not looks:
            break
        size = min(most, looks)
        black = min(size, blacks)
        parts.append((black, size))
        blacks, looks = blacks - black, looks - size
    return parts


def _seen(brain: Brain, where: str, start: Any, readings: list[tuple[int, int]]) -> Any:
    me = copy_of(brain, start)
    calls(brain, where, "observe", me, [(float(blacks), float(looks)) for blacks, looks in readings])
    return me


def _any_order(brain: Brain) -> None:
    heard = [call(brain, "before the first observation", "broadcast", brain.robot(0.8, 0.7))]
    for b, w, blacks in ((0.9, 0.6, 3.0), (0.6, 0.75, 11.0), (0.3, 0.6, 5.0), (0.75, 0.75, 8.0), (0.9, 0.9, 1.0)):
        other = brain.robot(b, w)
        where = f"b = {b}, w = {w}, {blacks:g} of 13 readings black"
        call(brain, where, "observe", other, blacks, 13.0)
        heard.append(call(brain, where, "broadcast", other))
    heard = [message for message in heard if is_message(brain, message)]
    for where, me in short_lives(brain):
        _in_orders(brain, where, me, heard)
    random = np.random.default_rng(SEED)
    pools = [[message for _, message in messages(brain, extreme)] for extreme in (False, True)]
    for k, (where, me) in enumerate(long_lives(brain)):
        pool = pools[k // len(SIZES) % 2]
        _in_orders(brain, where, me, some(random, pool, SIZES[k % len(SIZES)]))


def _in_orders(brain: Brain, where: str, me: Any, heard: list[Any]) -> None:
    """The same messages in many orders, then `fuse`."""
    orders = [heard, heard[::-1], heard[3:] + heard[:3], heard[::2] + heard[1::2], sorted(heard)]
    # the sums that are formed of messages differ by so much, where those of large numbers come near 0
    close = sum(1e-13 * value * value for message in heard for value in message)
    minds = []
    for order in orders:
        mind = copy_of(brain, me)
        hear(brain, where, mind, order)
        call(brain, where, "fuse", mind)
        minds.append(mind)
    for mind, order in zip(minds, orders, strict=True):
        field = difference(brain, minds[0], mind, absolute=close)
        if field:
            x, y = getattr(minds[0], field), getattr(mind, field)
            raise Fault(
                f"{at(brain, 'receive')}, with fuse after it, makes me.{field} {x!r} of the messages {_shown(heard)} "
                f"and {y!r} of {_shown(order)}: they come in no order that means anything ({where})"
            )


def _shown(heard: list[Any]) -> str:
    if len(heard) <= 6:
        return str(heard)
    return f"[{', '.join(map(str, heard[:3]))}, ..., {heard[-1]}] ({len(heard)} in all)"


def _sums_add(brain: Brain) -> None:
    for name in brain.sums:
        if brain.memory[name] != 0.0:
            raise Fault(f"MEMORY[{name!r}] is {brain.memory[name]}: a field of SUMS starts at 0")
    if not brain.sums:
        return
    pools = [
        [(message, _added(brain, where, message)) for where, message in messages(brain, extreme)]
        for extreme in (False, True)
    ]
    if not all(pools):
        return  # what is no message is another check's to say
    random = np.random.default_rng(SEED)
    for k, (where, me) in enumerate(lives(brain)):
        own = call(brain, where, "broadcast", me)
        one = (own, _added(brain, where, own)) if k % 2 else pools[1][k % len(pools[1])]
        for mind in (copy_of(brain, me), _any_mind(brain, random)):
            for _ in range(2):
                _adds(brain, where, mind, [one])
    for k, (where, me) in enumerate(long_lives(brain)):
        _adds(brain, where, copy_of(brain, me), some(random, pools[k % 2], max(SIZES)))


def _added(brain: Brain, where: str, message: Any) -> dict[str, float]:
    """What a message adds to each field of a blank mind, and what is not in SUMS may not grow at all."""
    blank = brain.robot(0.8, 0.7)
    call(brain, where, "receive", blank, message)
    return {name: getattr(blank, name) - brain.memory[name] if name in brain.sums else 0.0 for name in brain.memory}


def _adds(brain: Brain, where: str, mind: Any, heard: list[tuple[Any, dict[str, float]]]) -> None:
    """Messages in a row add to SUMS what each of them adds in a blank mind."""
    before = copy_of(brain, mind)
    try:
        hear(brain, where, mind, [message for message, _ in heard])
    except Fault as fault:
        raise Fault(f"{fault}, in a mind {_fields(before)}: by SUMS it depends on the message alone") from None
    for name in brain.memory:
        was = getattr(before, name)
        grown = getattr(mind, name) - was
        parts = [added[name] for _, added in heard]
        expected = sum(parts)
        rounding = 1e-12 * (max(1.0, abs(was)) + sum(map(abs, parts)))
        if not math.isclose(grown, expected, rel_tol=CLOSE, abs_tol=rounding):
            what = f"of {len(heard)} messages in a row " if len(heard) > 1 else ""
            raise Fault(
                f"{at(brain, 'receive')} adds {grown!r} to me.{name} {what}in a mind {_fields(before)}, and "
                f"{expected!r} in a blank one that believes in b = 0.8, w = 0.7: by SUMS it adds to "
                f"{', '.join(brain.sums)} alone, and what it adds depends on the message alone ({where})"
            )


def _any_mind(brain: Brain, random: np.random.Generator) -> Any:
    """Whatever numbers: what a sum grows by may not depend on them."""
    mind = brain.robot(float(random.random()), float(random.random()))
    fields = len(brain.memory)
    values = random.choice([-1.0, 1.0], fields) * 10.0 ** random.uniform(-2, 6, fields)
    for name, value in zip(brain.memory, values.tolist(), strict=True):
        setattr(mind, name, value)
    return mind


def _fields(mind: Any) -> str:
    return "with " + ", ".join(f"{name} = {getattr(mind, name):.6g}" for name in mind.__slots__)


PROMISES: dict[str, Callable[[Brain], None]] = {
    "remembers numbers in MEMORY's fields, nothing else": _fixed_memory,
    "gives finite messages and estimates in [0, 1]": _finite,
    "steers by a speed and a turn, or not at all": _steers,
    "broadcast, estimate and steer only read": _reads_only,
    "the same history gives the same mind": _same_again,
    "readings at once mean the same as one by one": _looks_add_up,
    "messages mean the same in any order": _any_order,
    "SUMS only add up": _sums_add,
}
