"""What a brain promises by docs/brain-contract.md, check by check, as CPython runs it; a fault is one sentence."""

import math
import traceback
from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

import numpy as np

from swarmcensus.brains import Brain

ACCURACIES = (0.0, 0.3, 0.5, 0.75, 1.0)  # liars, the blind and the perfect among them
PLAIN = (0.3, 0.6, 0.75, 0.9)  # no two add up to 1, and none is at a case's edge
SEED = 20
CLOSE = 1e-9  # relative, and absolute for numbers below 1: what rounding may change


class Fault(Exception):
    """What is wrong with a brain, in words."""


def in_a_line(error: BaseException) -> str:
    """The kind of an error, and the first line of what it says."""
    return ": ".join([type(error).__name__, *str(error).strip().splitlines()[:1]])


def at(brain: Brain, name: str) -> str:
    """A function of the brain, and the line that it begins in."""
    return f"{name} (line {getattr(brain.functions, name).__code__.co_firstlineno})"


def call(brain: Brain, where: str, name: str, me: Any, *given: Any) -> Any:
    """Call a function of the brain, and see what became of `me`; raises Fault."""
    beliefs = me.b, me.w
    try:
        result = getattr(brain.functions, name)(me, *given)
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(brain.path)]
        line = f"line {frames[-1].lineno} ({frames[-1].line})" if frames else "its first line"
        hint = "; MEMORY names all that a robot remembers" if "'Robot' object has no attribute" in str(error) else ""
        raise Fault(f"{name} fails at {line}: {in_a_line(error)}{hint} ({where})") from error
    if (me.b, me.w) != beliefs:
        raise Fault(
            f"{at(brain, name)} sets me.b and me.w from {beliefs} to {(me.b, me.w)}: they are only for reading, "
            f"and a belief that changes is a field of MEMORY ({where})"
        )
    for field in brain.memory:
        value = getattr(me, field)
        if type(value) is float and value == value:
            continue
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise Fault(f"{at(brain, name)} makes me.{field} {value!r}, not a number ({where})")
        if value != value or (isinstance(value, int) and value.bit_length() > 1023):
            what = "NaN" if value != value else "a whole number too large for 8 bytes"
            raise Fault(f"{at(brain, name)} makes me.{field} {what} ({where})")
    return result


def copy_of(brain: Brain, me: Any) -> Any:
    """A mind with the same fields and beliefs."""
    other = brain.robot(me.b, me.w)
    for name in brain.memory:
        setattr(other, name, getattr(me, name))
    return other


def difference(brain: Brain, one: Any, other: Any, close: float = CLOSE) -> str | None:
    """The first field in which two minds differ by more than rounding."""
    for name in brain.memory:
        x, y = getattr(one, name), getattr(other, name)
        if not math.isclose(x, y, rel_tol=close, abs_tol=close):
            return name
    return None


def lives(brain: Brain) -> Iterator[tuple[str, Any]]:
    """Minds in the course of short lives: all accuracies; floors all black, all white and mixed, or no readings; talk
    or none.
    """
    random = np.random.default_rng(SEED)
    floors = (("all black", 1.0), ("all white", 0.0), ("mixed", 0.5), ("none", math.nan))
    for b, w in product(ACCURACIES, ACCURACIES):
        for floor, share in floors:
            for talk in (True, False):
                where = f"b = {b}, w = {w}, readings {floor}, {'with' if talk else 'without'} neighbours"
                me, other = brain.robot(b, w), brain.robot(0.8, 0.7)
                yield f"{where}, before the first observation", me
                for looks in (1.0, 1.0, 10.0, 1000.0):
                    if floor != "none":
                        call(brain, where, "observe", me, float(random.binomial(int(looks), share)), looks)
                    call(brain, where, "observe", other, float(random.binomial(int(looks), 0.5)), looks)
                    if talk:
                        call(brain, where, "receive", me, call(brain, where, "broadcast", other))
                        blank = brain.robot(b, w)  # knows nothing yet
                        call(brain, where, "receive", me, call(brain, where, "broadcast", blank))
                    call(brain, where, "fuse", me)
                    yield where, me


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
    """Readings of one colour at once, in two parts, and one by one; mixed ones where their order means nothing."""
    for b, w in product(PLAIN, PLAIN):
        for before in (0.0, 16.0):
            start = brain.robot(b, w)
            where = f"b = {b}, w = {w}, after {before:g} readings"
            if before:
                call(brain, where, "observe", start, 7.0, before)
                call(brain, where, "fuse", start)
            for blacks, looks in ((10, 10), (0, 10), (5, 10), (200, 200)):
                whites = looks - blacks
                once = _seen(brain, where, start, [(blacks, looks)])
                ways = [
                    [(blacks // 2, looks // 2 - 1), (blacks - blacks // 2, looks - looks // 2 + 1)],
                    [(1, 1)] * blacks + [(0, 1)] * whites,
                    [(0, 1)] * whites + [(1, 1)] * blacks,
                ]
                if blacks == looks:
                    ways[0] = [(3, 3), (looks - 3, looks - 3)]
                minds = [_seen(brain, where, start, way) for way in ways]
                if blacks and whites and difference(brain, minds[1], minds[2]):
                    continue  # a brain that forgets: `observe` is not told in which order they came
                for mind, how in zip(minds, ("in two parts", "one by one", "one by one"), strict=True):
                    field = difference(brain, once, mind)
                    if field:
                        raise Fault(
                            f"{at(brain, 'observe')} makes me.{field} {getattr(once, field)!r} of {looks} readings at "
                            f"once, {blacks} of them black, and {getattr(mind, field)!r} of the same {how} ({where})"
                        )


def _seen(brain: Brain, where: str, start: Any, readings: list[tuple[int, int]]) -> Any:
    me = copy_of(brain, start)
    for blacks, looks in readings:
        call(brain, where, "observe", me, float(blacks), float(looks))
    return me


def _any_order(brain: Brain) -> None:
    heard = [call(brain, "before the first observation", "broadcast", brain.robot(0.8, 0.7))]
    for b, w, blacks in ((0.9, 0.6, 3.0), (0.6, 0.75, 11.0), (0.3, 0.6, 5.0), (0.75, 0.75, 8.0), (0.9, 0.9, 1.0)):
        other = brain.robot(b, w)
        where = f"b = {b}, w = {w}, {blacks:g} of 13 readings black"
        call(brain, where, "observe", other, blacks, 13.0)
        heard.append(call(brain, where, "broadcast", other))
    orders = [heard, heard[::-1], heard[3:] + heard[:3], heard[::2] + heard[1::2]]
    for where, me in lives(brain):
        minds = []
        for order in orders:
            mind = copy_of(brain, me)
            for message in order:
                call(brain, where, "receive", mind, message)
            call(brain, where, "fuse", mind)
            minds.append(mind)
        for mind, order in zip(minds, orders, strict=True):
            field = difference(brain, minds[0], mind)
            if field:
                x, y = getattr(minds[0], field), getattr(mind, field)
                raise Fault(
                    f"{at(brain, 'receive')}, with fuse after it, makes me.{field} {x!r} of the messages {heard} and "
                    f"{y!r} of {order}: they come in no order that means anything ({where})"
                )


def _sums_add(brain: Brain) -> None:
    for name in brain.sums:
        if brain.memory[name] != 0.0:
            raise Fault(f"MEMORY[{name!r}] is {brain.memory[name]}: a field of SUMS starts at 0")
    random = np.random.default_rng(SEED)
    for where, me in lives(brain) if brain.sums else ():
        message = call(brain, where, "broadcast", me)
        blank = brain.robot(0.8, 0.7)
        call(brain, where, "receive", blank, message)
        for mind in (copy_of(brain, me), _any_mind(brain, random)):
            for _ in range(2):
                before = copy_of(brain, mind)
                try:
                    call(brain, where, "receive", mind, message)
                except Fault as fault:
                    raise Fault(
                        f"{fault}, in a mind {_fields(before)}: by SUMS it depends on the message alone"
                    ) from None
                for name in brain.memory:
                    was = getattr(before, name)
                    added = getattr(mind, name) - was
                    expected = getattr(blank, name) - brain.memory[name] if name in brain.sums else 0.0
                    if not math.isclose(added, expected, rel_tol=CLOSE, abs_tol=CLOSE * max(1.0, abs(was))):
                        raise Fault(
                            f"{at(brain, 'receive')} adds {added!r} to me.{name} in a mind {_fields(before)}, and "
                            f"{expected!r} in a blank one that believes in b = 0.8, w = 0.7: by SUMS it adds to "
                            f"{', '.join(brain.sums)} alone, and what it adds depends on the message alone ({where})"
                        )


def _any_mind(brain: Brain, random: np.random.Generator) -> Any:
    """Whatever numbers: what a sum grows by may not depend on them."""
    mind = brain.robot(float(random.random()), float(random.random()))
    fields = len(brain.memory)
    values = random.choice([-1.0, 1.0], fields) * 10.0 ** random.uniform(-2, 4, fields)
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
