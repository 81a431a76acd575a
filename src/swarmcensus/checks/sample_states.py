"""States and messages on which a brain is checked, from short and long histories; and calls that check each result."""

import functools
import math
import sys
import traceback
from collections.abc import Iterable, Iterator
from itertools import cycle, product
from typing import Any

import numpy as np

from swarmcensus.brains import Brain, Vector, places
from swarmcensus.simulation import fixed
from swarmcensus.simulation.reference import is_done

ACCURACIES = (0.0, 0.3, 0.5, 0.75, 1.0)  # includes always wrong, blind and perfect sensors
PLAIN = (0.3, 0.6, 0.75, 0.9)  # no two add up to 1, and none is at the edge of a case
EXTREME = ((0.999999, 0.999999), (0.000001, 0.000001), (0.5, 0.500001))  # nearly perfect, always wrong, blind
SEED = 20
LONG = ((0.9, 0.75), (0.3, 0.6), (0.75, 0.6), (1.0, 1.0), (0.5, 0.5), (0.0, 0.75))  # accuracies in long histories
SHARE = 0.43  # share of black readings in them
ROUNDS = 300
STOPS = (1, 2, 3, 5, 9, 17, 33, 65, 129, 200, ROUNDS)  # the rounds after which states are checked
LOOKS = (1, 10, 0, 3, 1, 2, 0)  # readings per round, in turn; and in some rounds many:
MANY_LOOKS = {100: 1000, ROUNDS: 20000}
HEARD = (0, 1, 2, 3, 0, 6, 1, 9, 0, 17, 2)  # messages per round, in turn; and in some rounds many:
MANY_HEARD = {25: 40, 50: 120, 100: 400}
LISTEN_ROUNDS = 40  # rounds in which a brain that may be silent is listened to
CLOSE = 1e-9  # allowed rounding: relative, and absolute for numbers below 1


Draws = np.random.Generator | None


class Violation(Exception):
    """What is wrong with a brain, in a sentence."""


class NotUsed(Exception):
    """A brain does not have the part that a check is about."""


def in_a_line(error: BaseException) -> str:
    """The type of an error, and the first line of its message."""
    return ": ".join([type(error).__name__, *str(error).strip().splitlines()[:1]])


def line_of(brain: Brain, name: str) -> str:
    """A function of the brain with its line, such as "receive (line 18)"."""
    return f"{name} (line {getattr(brain.functions, name).__code__.co_firstlineno})"


def call(brain: Brain, where: str, name: str, me: Any, *given: Any, draws: Draws = None) -> Any:
    """Call a function of the brain, and check `me` afterwards. Raises Violation."""
    return calls(brain, where, name, me, [given], draws)


def calls(brain: Brain, where: str, name: str, me: Any, given: Iterable[tuple[Any, ...]], draws: Draws = None) -> Any:
    """Call a function of the brain several times, and check `me` at the end. Raises Violation.

    A brain that uses luck has a fresh random number in each call. Returns the result of the last call.
    """
    beliefs = me.b, me.w
    function = getattr(brain.functions, name)
    result = None
    is_random = brain.uses.luck and draws is not None
    try:
        for each in given:
            if is_random:
                me.luck = draws.random()  # type: ignore[union-attr]
            result = function(me, *each)
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(brain.path)]
        line = f"line {frames[-1].lineno} ({frames[-1].line})" if frames else "its first line"
        hint = "; MEMORY names all that a robot remembers" if "'Robot' object has no attribute" in str(error) else ""
        raise Violation(f"{name} fails at {line}: {in_a_line(error)}{hint} ({where})") from error
    if (me.b, me.w) != beliefs:
        raise Violation(
            f"{line_of(brain, name)} sets me.b and me.w from {beliefs} to {(me.b, me.w)}: they are only for reading, "
            f"and a belief that changes is a field of MEMORY ({where})"
        )
    for field, value in numbers_in(brain, me):
        if type(value) is float and value == value:
            continue
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise Violation(f"{line_of(brain, name)} makes me.{field} {value!r}, not a number ({where})")
        if value != value or (isinstance(value, int) and value.bit_length() > 1023):
            what = "NaN" if value != value else "a whole number too large for 8 bytes"
            raise Violation(f"{line_of(brain, name)} makes me.{field} {what} ({where})")
    return result


def numbers_in(brain: Brain, me: Any) -> Iterator[tuple[str, Any]]:
    """The numbers in a state's memory by name: "t", or "belief[3]" for an item of a vector."""
    for name, long in brain.lengths.items():
        value = getattr(me, name)
        if long:
            yield from zip(places(name, long), value, strict=True)
        else:
            yield name, value


def number_at(me: Any, place: str) -> Any:
    """The number of this name, "t" or "belief[3]", in a state's memory."""
    name, _, item = place.partition("[")
    return getattr(me, name)[int(item.rstrip("]"))] if item else getattr(me, name)


def hear(brain: Brain, where: str, me: Any, heard: list[Any], draws: Draws = None) -> None:
    """Receive messages one after the other. Raises Violation."""
    calls(brain, where, "receive", me, [(message,) for message in heard], draws)


def copy_of(brain: Brain, me: Any) -> Any:
    """A state with the same fields and beliefs."""
    copy = brain.robot(me.b, me.w)
    for name, long in brain.lengths.items():
        setattr(copy, name, Vector(getattr(me, name)) if long else getattr(me, name))
    for name, uses in (("luck", brain.uses.luck), ("name", brain.uses.name)):
        if uses:
            setattr(copy, name, getattr(me, name))
    return copy


def difference(brain: Brain, first: Any, second: Any, close: float = CLOSE, absolute: float = 0.0) -> str | None:
    """The first number in which two states differ by more than rounding, relative or absolute; None if they agree."""
    if all(getattr(first, name) == getattr(second, name) for name in brain.lengths):
        return None
    for (name, x), (_, y) in zip(numbers_in(brain, first), numbers_in(brain, second), strict=True):
        if not math.isclose(x, y, rel_tol=close, abs_tol=max(close, absolute)):
            return name
    return None


def lives(brain: Brain) -> Iterator[tuple[str, Any]]:
    """States of short histories, then of long ones, each with a description of its history."""
    yield from short_lives(brain)
    yield from long_lives(brain)


def short_lives(brain: Brain) -> Iterator[tuple[str, Any]]:
    """Histories of four rounds: all accuracies; black, white and mixed floors, or no readings; talk or none."""
    random, draws = np.random.default_rng(SEED), np.random.default_rng(SEED + 1)
    floors = (("all black", 1.0), ("all white", 0.0), ("mixed", 0.5), ("none", math.nan))
    for b, w in product(ACCURACIES, ACCURACIES):
        for floor, share in floors:
            for talk in (True, False):
                where = f"b = {b}, w = {w}, readings {floor}, {'with' if talk else 'without'} neighbours"
                me, neighbour = brain.robot(b, w), brain.robot(0.8, 0.7, 1.0)
                yield f"{where}, before the first observation", me
                for looks in (1.0, 1.0, 10.0, 1000.0):
                    if floor != "none":
                        blacks = float(random.binomial(int(looks), share))
                        if not is_done(brain, me):
                            call(brain, where, "observe", me, blacks, looks, draws=draws)
                    blacks = float(random.binomial(int(looks), 0.5))
                    call(brain, where, "observe", neighbour, blacks, looks, draws=draws)
                    if talk:
                        blank = brain.robot(b, w, 2.0)  # has no readings yet
                        for sender in (neighbour, blank):
                            message = call(brain, where, "broadcast", sender)
                            if message is not None or not brain.uses.silence:
                                call(brain, where, "receive", me, fixed(message), draws=draws)
                    call(brain, where, "fuse", me, draws=draws)
                    yield where, me


def long_lives(brain: Brain) -> Iterator[tuple[str, Any]]:
    """Histories of 300 rounds, in which a robot has no, few or very many readings and messages."""
    random, draws = np.random.default_rng(SEED), np.random.default_rng(SEED + 1)
    spoken = [message for _, message in messages(brain)]
    for b, w in LONG:
        me = brain.robot(b, w)
        for k, looks, heard in zip(range(1, ROUNDS + 1), cycle(LOOKS), cycle(HEARD)):
            where = f"b = {b}, w = {w}, in round {k} of a long life"
            looks = MANY_LOOKS.get(k, looks)
            if looks:
                blacks = float(random.binomial(looks, SHARE))
                if not is_done(brain, me):
                    call(brain, where, "observe", me, blacks, float(looks), draws=draws)
            hear(brain, where, me, sample(random, spoken, MANY_HEARD.get(k, heard)), draws)
            call(brain, where, "fuse", me, draws=draws)
            if k in STOPS:
                yield where, me


def sample(random: np.random.Generator, pool: list[Any], count: int) -> list[Any]:
    """A random sample of `count` messages, with repetitions; empty if there are none."""
    return [pool[i] for i in random.integers(len(pool) or 1, size=count if pool else 0).tolist()]


@functools.lru_cache(maxsize=4)  # a brain may be slow with 100,000 readings: once for all checks
def messages(brain: Brain, extreme: bool = True) -> tuple[tuple[str, Any], ...]:
    """Messages of robots before any reading, early and late, each with a description of its history.

    Sensors are of all kinds; if not `extreme`, they are neither perfect nor blind. Invalid messages are left out, as
    another check reports them. Robots that may be silent are listened to for some rounds.
    """
    return tuple(_messages(brain, extreme))


def _messages(brain: Brain, extreme: bool) -> Iterator[tuple[str, Any]]:
    draws = np.random.default_rng(SEED + 2)
    pairs = (*product(ACCURACIES, ACCURACIES), *EXTREME) if extreme else product(PLAIN, PLAIN)
    readings = ((0, 0), (1, 1), (0, 1), (5, 13), (0, 1000), (1000, 1000), (43210, 100000))
    for b, w in pairs:
        for name, (blacks, looks) in enumerate(readings if extreme else readings[:4]):
            speaker = brain.robot(b, w, float(name))
            where = f"b = {b}, w = {w}, {blacks} of {looks} readings black"
            for _ in range(LISTEN_ROUNDS if brain.uses.silence else 1):
                if looks and not is_done(brain, speaker):
                    call(brain, where, "observe", speaker, float(blacks), float(looks), draws=draws)
                if looks:
                    call(brain, where, "fuse", speaker, draws=draws)
                message = call(brain, where, "broadcast", speaker)
                if not fault_of_message(brain, message):
                    yield where, fixed(message)


def fault_of_message(brain: Brain, message: object) -> str:
    """What is wrong with what `broadcast` gives as a message that others hear; empty if nothing is."""
    if not isinstance(message, tuple) or len(message) != len(brain.message):
        return f"{message!r}, not a tuple of {len(brain.message)} as MESSAGE says"
    for (name, long), value in zip(brain.message.items(), message, strict=True):
        if long and not (isinstance(value, list | tuple) and len(value) == long):
            return f"{name} = {value!r}, not a vector of {long}"
        for number in value if long else (value,):
            if not (isinstance(number, int | float) and abs(number) <= sys.float_info.max):
                return f"{name} = {number!r}, not a finite number"
    return ""
