"""What a brain promises by docs/brain-contract.md, check by check, as CPython runs it; a fault is one sentence."""

import math
from collections.abc import Callable, Iterator
from itertools import cycle, product
from typing import Any

import numpy as np

from swarmcensus.brains import Brain, Vector, numbers, slots
from swarmcensus.conformance import chances
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
    numbers_in,
    of,
    short_lives,
    some,
)
from swarmcensus.simulation.oracle import fixed

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
        if message is None and brain.uses.silence:
            continue
        if not isinstance(message, tuple) or len(message) != len(brain.message):
            raise Fault(f"{said} gives {message!r}, not a tuple of {len(brain.message)} as MESSAGE says ({where})")
        for (name, long), value in zip(brain.message.items(), message, strict=True):
            if long and not (isinstance(value, list | tuple) and len(value) == long):
                raise Fault(f"{said} gives {name} = {value!r}, not a vector of {long} ({where})")
            for one in value if long else (value,):
                if not (isinstance(one, int | float) and abs(one) <= np.finfo(float).max):
                    raise Fault(f"{said} gives {name} = {one!r}, not a finite number ({where})")


def _decides(brain: Brain) -> None:
    """An option or none, and whether it is done, of whatever mind."""
    for where, me in lives(brain) if brain.decides or brain.ends else ():
        if brain.decides:
            choice = call(brain, where, "decide", me)
            if not isinstance(choice, int | float) or choice not in range(-1, brain.options):
                most = brain.options - 1
                raise Fault(
                    f"{at(brain, 'decide')} gives {choice!r}, neither -1 (undecided) nor an option from 0 to {most} "
                    f"({where})"
                )
        if brain.ends and not isinstance(ends := call(brain, where, "done", me), bool | int | float):
            raise Fault(f"{at(brain, 'done')} gives {ends!r}, neither True nor False ({where})")


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
        for name in asked_of(brain):
            before = copy_of(brain, me)
            call(brain, where, name, me)
            changed = difference(brain, before, me, close=0.0)
            if changed:
                x, y = of(before, changed), of(me, changed)
                raise Fault(f"{at(brain, name)} changes me.{changed} from {x!r} to {y!r}: it may only read ({where})")


def asked_of(brain: Brain) -> tuple[str, ...]:
    """The functions that only tell something."""
    return ("broadcast", "estimate", *(name for name in ("steer", "decide", "done") if name in brain.says.functions))


def _same_again(brain: Brain) -> None:
    """Two swarms live the same lives at the same time; one is asked more often."""
    for (where, one), (_, other) in zip(lives(brain), lives(brain), strict=True):
        changed = difference(brain, one, other, close=0.0)
        if changed:
            x, y = of(one, changed), of(other, changed)
            raise Fault(
                f"the same history gives me.{changed} = {x!r} and then {y!r}: something is kept outside of me, by "
                f"{at(brain, 'observe')}, {at(brain, 'receive')} or {at(brain, 'fuse')} ({where})"
            )
        names = [name for name in asked_of(brain) if name != "steer"]
        said = [[fixed(call(brain, where, name, me)) for name in names] for me in (one, other, other, other)]
        for name, first, *again in zip(names, *said, strict=True):
            if any(value != first for value in again):
                raise Fault(
                    f"{at(brain, name)} gives {first!r} and then {next(v for v in again if v != first)!r} of the same "
                    f"mind: something is kept outside of me ({where})"
                )


def _looks_add_up(brain: Brain) -> None:
    """Readings of one colour at once, in parts, and one by one; mixed ones where their order means nothing."""
    if "observe" in brain.uses.lucky:
        chances.looks_add_up(brain, _starts(brain))
        return
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
                        f"{at(brain, 'observe')} makes me.{field} {of(once, field)!r} of {looks} readings at "
                        f"once, {blacks} of them black, and {of(mind, field)!r} of the same {how} ({where})"
                    )


def _starts(brain: Brain) -> Iterator[tuple[str, Any, tuple[tuple[int, int], ...]]]:
    """Minds that are to make readings: blank, young, and in a long life, after `fuse` and after `receive`."""
    luck = np.random.default_rng(SEED + 1)
    for b, w in product(PLAIN, PLAIN):
        for before in (0.0, 16.0):
            start = brain.robot(b, w)
            where = f"b = {b}, w = {w}, after {before:g} readings"
            if before:
                call(brain, where, "observe", start, 7.0, before, luck=luck)
                call(brain, where, "fuse", start, luck=luck)
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
            hear(brain, where, hears, some(random, said, 1 + k % 9), luck)
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
    if "receive" in brain.uses.lucky:
        chances.any_order(brain)
        return
    heard = [call(brain, "before the first observation", "broadcast", brain.robot(0.8, 0.7))]
    for b, w, blacks in ((0.9, 0.6, 3.0), (0.6, 0.75, 11.0), (0.3, 0.6, 5.0), (0.75, 0.75, 8.0), (0.9, 0.9, 1.0)):
        other = brain.robot(b, w)
        where = f"b = {b}, w = {w}, {blacks:g} of 13 readings black"
        call(brain, where, "observe", other, blacks, 13.0)
        heard.append(call(brain, where, "broadcast", other))
    heard = [fixed(message) for message in heard if is_message(brain, message)]
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
    close = sum(1e-13 * value * value for message in heard for value in flat(message))
    minds = []
    for order in orders:
        mind = copy_of(brain, me)
        hear(brain, where, mind, order)
        call(brain, where, "fuse", mind)  # with the luck of the mind that it was, whatever the order
        minds.append(mind)
    for mind, order in zip(minds, orders, strict=True):
        field = difference(brain, minds[0], mind, absolute=close)
        if field:
            x, y = of(minds[0], field), of(mind, field)
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
        if any(numbers({name: brain.memory[name]})):
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
        own = fixed(call(brain, where, "broadcast", me))
        if own is None:
            continue
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
    summed = {*slots({name: brain.lengths[name] for name in brain.sums})}
    began = numbers_in(brain, brain.robot(0.8, 0.7))
    pairs = zip(numbers_in(brain, blank), began, strict=True)
    return {name: x - was if name in summed else 0.0 for (name, x), (_, was) in pairs}


def _adds(brain: Brain, where: str, mind: Any, heard: list[tuple[Any, dict[str, float]]]) -> None:
    """Messages in a row add to SUMS what each of them adds in a blank mind."""
    before = copy_of(brain, mind)
    try:
        hear(brain, where, mind, [message for message, _ in heard])
    except Fault as fault:
        raise Fault(f"{fault}, in a mind {_fields(before)}: by SUMS it depends on the message alone") from None
    for name, was in numbers_in(brain, before):
        grown = of(mind, name) - was
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
    fields = len(slots(brain.lengths))
    values = (random.choice([-1.0, 1.0], fields) * 10.0 ** random.uniform(-2, 6, fields)).tolist()
    for name, long in brain.lengths.items():
        setattr(mind, name, Vector(values.pop() for _ in range(long)) if long else values.pop())
    return mind


def flat(message: Any) -> list[float]:
    """The numbers of a message."""
    return [one for part in message for one in (part if isinstance(part, tuple) else (part,))]


def _fields(mind: Any) -> str:
    values = ((name, getattr(mind, name)) for name in mind.__slots__)
    shown = (f"{name} = {[*v] if isinstance(v, list | tuple) else f'{v:.6g}'}" for name, v in values)
    return "with " + ", ".join(shown)


PROMISES: dict[str, Callable[[Brain], None]] = {
    "remembers numbers in MEMORY's fields, nothing else": _fixed_memory,
    "gives finite messages and estimates in [0, 1]": _finite,
    "steers by a speed and a turn, or not at all": _steers,
    "decides for an option, or not yet": _decides,
    "broadcast, estimate and steer only read": _reads_only,
    "the same history gives the same mind": _same_again,
    "readings at once mean the same as one by one": _looks_add_up,
    "messages mean the same in any order": _any_order,
    "SUMS only add up": _sums_add,
}
