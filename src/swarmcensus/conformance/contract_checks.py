"""What a brain promises by docs/brain-contract.md, check by check, as CPython runs it; a fault is one sentence."""

from collections.abc import Callable

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.brains.syntax import INTERVAL
from swarmcensus.conformance.message_checks import any_order, sums_add
from swarmcensus.conformance.reading_checks import looks_add_up
from swarmcensus.conformance.sample_minds import (
    Fault,
    NotUsed,
    at,
    call,
    copy_of,
    difference,
    lives,
    of,
)
from swarmcensus.simulation.oracle import fixed


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
    if not (brain.decides or brain.ends or brain.jams):
        raise NotUsed
    for where, me in lives(brain):
        if brain.decides:
            choice = call(brain, where, "decide", me)
            if not isinstance(choice, int | float) or choice not in range(-1, brain.options):
                most = brain.options - 1
                raise Fault(
                    f"{at(brain, 'decide')} gives {choice!r}, neither -1 (undecided) nor an option from 0 to {most} "
                    f"({where})"
                )
        for name in {"done", "jam"} & brain.contents.functions:
            if not isinstance(said := call(brain, where, name, me), bool | int | float):
                raise Fault(f"{at(brain, name)} gives {said!r}, neither True nor False ({where})")


def _bounds(brain: Brain) -> None:
    if not brain.has_interval:
        raise NotUsed
    for where, me in lives(brain):
        said = call(brain, where, "interval", me)
        if not is_interval(said):
            raise Fault(f"{at(brain, 'interval')} gives {said!r}: {INTERVAL} ({where})")


def is_interval(said: object) -> bool:
    """Whether `interval` may return this."""
    if not isinstance(said, tuple) or len(said) != 2 or not all(isinstance(end, int | float) for end in said):
        return False
    return bool(0.0 <= said[0] <= said[1] <= 1.0)


def _steers(brain: Brain) -> None:
    if not brain.steers:
        raise NotUsed
    for where, me in lives(brain):
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
    return (
        "broadcast",
        "estimate",
        *(name for name in ("steer", "decide", "done", "interval", "jam") if name in brain.contents.functions),
    )


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


PROMISES: dict[str, Callable[[Brain], None]] = {
    "remembers numbers in MEMORY's fields, nothing else": _fixed_memory,
    "gives finite messages and estimates in [0, 1]": _finite,
    "steers by a speed and a turn, or not at all": _steers,
    "decides for an option, or not yet": _decides,
    "tells an interval within [0, 1], the low end first": _bounds,
    "functions that tell something only read": _reads_only,
    "the same history gives the same mind": _same_again,
    "readings at once mean the same as one by one": looks_add_up,
    "messages mean the same in any order": any_order,
    "SUMS only add up": sums_add,
}
