"""What a brain promises about the messages it hears: they come in no order, and SUMS only add up."""

import math
from typing import Any

import numpy as np

from swarmcensus.basics.formatting import counted
from swarmcensus.brains import Brain, Vector, numbers, slots
from swarmcensus.conformance import random_checks
from swarmcensus.conformance.sample_minds import (
    CLOSE,
    SEED,
    Fault,
    NotUsed,
    at,
    call,
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


def any_order(brain: Brain) -> None:
    """The same messages leave the same mind, whatever their order; where there is luck, the same chances of it."""
    if "receive" in brain.uses.lucky:
        random_checks.any_order(brain)
        return
    heard = [call(brain, "before the first observation", "broadcast", brain.robot(0.8, 0.7))]
    for b, w, blacks in ((0.9, 0.6, 3.0), (0.6, 0.75, 11.0), (0.3, 0.6, 5.0), (0.75, 0.75, 8.0), (0.9, 0.9, 1.0)):
        other = brain.robot(b, w)
        where = f"b = {b}, w = {w}, {blacks:g} of 13 readings black"
        call(brain, where, "observe", other, blacks, 13.0)
        heard.append(call(brain, where, "broadcast", other))
    heard = [fixed(message) for message in heard if is_message(brain, message)]
    pools = [[message for _, message in messages(brain, extreme)] for extreme in (False, True)]
    if not heard and not any(pools):  # it is always silent
        raise NotUsed
    for where, me in short_lives(brain):
        _in_orders(brain, where, me, heard)
    random = np.random.default_rng(SEED)
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


def sums_add(brain: Brain) -> None:
    """A message adds to SUMS what it adds in a blank mind, and to nothing else, whatever the mind."""
    for name in brain.sums:
        if any(numbers({name: brain.memory[name]})):
            raise Fault(f"MEMORY[{name!r}] is {brain.memory[name]}: a field of SUMS starts at 0")
    if not brain.sums:
        raise NotUsed
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
            what = f"of {counted(len(heard), 'message')} in a row " if len(heard) > 1 else ""
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
