"""Checks of received messages: their order does not matter, and SUMS only add up."""

import math
from functools import partial
from itertools import islice
from typing import Any

import numpy as np

from swarmcensus.brains import Brain, Vector, numbers, slots
from swarmcensus.checks.sample_states import (
    CLOSE,
    SEED,
    Draws,
    NotUsed,
    Violation,
    call,
    copy_of,
    fault_of_message,
    hear,
    line_of,
    lives,
    long_lives,
    messages,
    number_at,
    numbers_in,
    sample,
    short_lives,
)
from swarmcensus.checks.ways import odd_one
from swarmcensus.simulation import fixed
from swarmcensus.support.formatting import counted

SIZES = (1, 2, 3, 6, 9, 17, 40, 120, 400)  # messages that come together
FEW = (2, 3, 9, 17, 40, 120)  # the same, where each order is tried with many random numbers


def any_order(brain: Brain) -> None:
    """The same messages lead to the same state in any order, or to the same distribution of states if luck is used."""
    heard = [call(brain, "before the first observation", "broadcast", brain.robot(0.8, 0.7))]
    for b, w, blacks in ((0.9, 0.6, 3.0), (0.6, 0.75, 11.0), (0.3, 0.6, 5.0), (0.75, 0.75, 8.0), (0.9, 0.9, 1.0)):
        speaker = brain.robot(b, w)
        where = f"b = {b}, w = {w}, {blacks:g} of 13 readings black"
        call(brain, where, "observe", speaker, blacks, 13.0)
        heard.append(call(brain, where, "broadcast", speaker))
    heard = [fixed(message) for message in heard if not fault_of_message(brain, message)]
    pools = [[message for _, message in messages(brain, extreme)] for extreme in (False, True)]
    if not heard and not any(pools):  # the brain is always silent
        raise NotUsed
    few = "receive" in brain.uses.random  # distributions take long
    for where, me in islice(short_lives(brain), 0, 600 if few else None, 50 if few else 1):
        _check_orders(brain, where, me, heard)
    random = np.random.default_rng(SEED)
    for k, (where, me) in enumerate(islice(long_lives(brain), 0, None, 3 if few else 1)):
        pool, size = (pools[0], FEW[k % len(FEW)]) if few else (pools[k // len(SIZES) % 2], SIZES[k % len(SIZES)])
        _check_orders(brain, where, me, sample(random, pool, size))


def _check_orders(brain: Brain, where: str, me: Any, heard: list[Any]) -> None:
    """The same messages in many orders, then `fuse`."""

    def after(order: list[Any], draws: Draws) -> Any:
        state = copy_of(brain, me)
        hear(brain, where, state, order, draws)
        call(brain, where, "fuse", state, draws=draws)  # without draws, with the same random numbers for all orders
        return state

    orders = [heard, heard[::-1], heard[3:] + heard[:3], heard[::2] + heard[1::2], sorted(heard)]
    orders = orders[:2] if "receive" in brain.uses.random else orders
    # rounding of sums over the messages, which matters if sums of large numbers are close to 0
    close = sum(1e-13 * value * value for message in heard for value in flat(message))
    if found := odd_one(brain, "receive", [partial(after, order) for order in orders], absolute=close):
        k, field, x, y = found
        raise Violation(
            f"{line_of(brain, 'receive')}, with fuse after it, makes me.{field} {x} of the messages "
            f"{_as_text(heard)} and {y} of {_as_text(orders[k])}: the order of messages should not matter ({where})"
        )


def _as_text(heard: list[Any]) -> str:
    if len(heard) <= 6:
        return str(heard)
    return f"[{', '.join(map(str, heard[:3]))}, ..., {heard[-1]}] ({len(heard)} in all)"


def sums_add(brain: Brain) -> None:
    """In any state a message adds to SUMS what it adds in a blank state, and changes nothing else."""
    for name in brain.sums:
        if any(numbers({name: brain.memory[name]})):
            raise Violation(f"MEMORY[{name!r}] is {brain.memory[name]}: a field of SUMS starts at 0")
    if not brain.sums:
        raise NotUsed
    pools = [
        [(message, _additions(brain, where, message)) for where, message in messages(brain, extreme)]
        for extreme in (False, True)
    ]
    if not all(pools):
        return  # another check reports what is not a message
    random = np.random.default_rng(SEED)
    for k, (where, me) in enumerate(lives(brain)):
        own = fixed(call(brain, where, "broadcast", me))
        if own is None:
            continue
        message_and_sums = (own, _additions(brain, where, own)) if k % 2 else pools[1][k % len(pools[1])]
        for state in (copy_of(brain, me), _random_state(brain, random)):
            for _ in range(2):
                _check_sums(brain, where, state, [message_and_sums])
    for k, (where, me) in enumerate(long_lives(brain)):
        _check_sums(brain, where, copy_of(brain, me), sample(random, pools[k % 2], max(SIZES)))


def _additions(brain: Brain, where: str, message: Any) -> dict[str, float]:
    """What a message should add to each number of a state: for SUMS what it adds in a blank state, else 0."""
    blank = brain.robot(0.8, 0.7)
    call(brain, where, "receive", blank, message)
    summed = {*slots({name: brain.lengths[name] for name in brain.sums})}
    began = numbers_in(brain, brain.robot(0.8, 0.7))
    pairs = zip(numbers_in(brain, blank), began, strict=True)
    return {name: x - was if name in summed else 0.0 for (name, x), (_, was) in pairs}


def _check_sums(brain: Brain, where: str, state: Any, heard: list[tuple[Any, dict[str, float]]]) -> None:
    """Check that messages in a row add to SUMS what each of them adds in a blank state. Raises Violation."""
    before = copy_of(brain, state)
    hear(brain, where, state, [message for message, _ in heard])
    for name, was in numbers_in(brain, before):
        grown = number_at(state, name) - was
        parts = [added[name] for _, added in heard]
        expected = sum(parts)
        rounding = 1e-12 * (max(1.0, abs(was)) + sum(map(abs, parts)))
        if not math.isclose(grown, expected, rel_tol=CLOSE, abs_tol=rounding):
            what = f"of {counted(len(heard), 'message')} in a row " if len(heard) > 1 else ""
            raise Violation(
                f"{line_of(brain, 'receive')} adds {grown!r} to me.{name} {what}in some state, and "
                f"{expected!r} in a blank one that assumes b = 0.8, w = 0.7: with SUMS it may only add to "
                f"{', '.join(brain.sums)}, and what it adds depends on the message alone ({where})"
            )


def _random_state(brain: Brain, random: np.random.Generator) -> Any:
    """A state of random numbers, on which the growth of a sum may not depend."""
    state = brain.robot(float(random.random()), float(random.random()))
    fields = len(slots(brain.lengths))
    values = (random.choice([-1.0, 1.0], fields) * 10.0 ** random.uniform(-2, 6, fields)).tolist()
    for name, long in brain.lengths.items():
        setattr(state, name, Vector(values.pop() for _ in range(long)) if long else values.pop())
    return state


def flat(message: Any) -> list[float]:
    """The numbers of a message."""
    return [number for part in message for number in (part if isinstance(part, tuple) else (part,))]
