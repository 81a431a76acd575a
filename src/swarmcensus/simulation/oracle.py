"""The reference implementation: CPython runs the brain file itself, robot by robot and step by step."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.engine.constants import LUCK_FUSE, LUCK_OBSERVE
from swarmcensus.engine.random import chance, word_of, words
from swarmcensus.simulation.intervals import ENDS
from swarmcensus.simulation.swarming import DECIDED, IS_DONE, free


def follow(
    brain: Brain,
    b: np.ndarray,
    w: np.ndarray,
    blacks: np.ndarray,
    looks: int,
    every: int,
    periodic: bool,
    messages: Iterable[np.ndarray],
    luck: np.ndarray,
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Run minds on recorded observations and messages.

    `blacks` (step, robot) counts the black ones of `looks` readings, NaN where a robot made none. A round ends
    every `every` steps and at the last. `messages` has (receiver, sender) rows for each step; with `periodic`
    they are heard at the end of whole rounds only. `luck` are the two keys of it. Returns each field of the memory,
    what is decided and intervals, and the estimates, as arrays (round, robot), index 0 before any observation.
    """
    functions = brain.functions
    minds = [brain.robot(float(b[i]), float(w[i]), float(i)) for i in range(blacks.shape[1])]
    memories: list[list[dict[str, Any]]] = []
    estimates: list[list[float]] = []

    def keep() -> None:
        memories.append([kept_of(brain, me, bool(memories)) for me in minds])
        estimates.append([functions.estimate(me) for me in minds])

    keep()
    number = 0  # of the message among all messages
    ended: list[bool] = []  # robots that make no reading in this round
    for step, pairs in zip(range(len(blacks)), messages, strict=True):
        whole = (step + 1) % every == 0
        seen, fused = (own_luck(brain, luck, 0, step + 1, part, len(minds)) for part in (LUCK_OBSERVE, LUCK_FUSE))
        if step % every == 0:
            ended = [is_done(brain, me) for me in minds]
        for i, (me, count) in enumerate(zip(minds, blacks[step], strict=True)):
            if not np.isnan(count) and not ended[i]:
                give(brain, me, seen, i)
                functions.observe(me, float(count), float(looks))
        said = [said_by(brain, me) for me in minds]
        if periodic:
            number = 0
        if whole or not periodic:
            for receiver, sender in pairs:
                if said[sender] is not None:
                    if brain.uses.luck:
                        word = word_of(luck[2], luck[3], 0, step + 1, 0, number)
                        minds[receiver].luck = chance(np.uint64(word))
                    functions.receive(minds[receiver], said[sender])
                number += 1
        if whole or step == len(blacks) - 1:
            for i, me in enumerate(minds):
                give(brain, me, fused, i)
                functions.fuse(me)
            keep()
    names = memories[0][0]
    return {name: np.array([[m[name] for m in row] for row in memories]) for name in names}, np.array(estimates)


def kept_of(brain: Brain, me: Any, decides: bool) -> dict[str, Any]:
    """The entries of a mind in a trace: its fields, its decision (from the first round on) and its interval."""
    fields = {name: list(v) if isinstance(v := getattr(me, name), list) else v for name in brain.memory}
    if brain.decides:
        fields[free(DECIDED, brain.memory)] = float(brain.functions.decide(me)) if decides else -1.0
    if brain.ends:
        fields[free(IS_DONE, brain.memory)] = float(bool(brain.functions.done(me)))
    if brain.has_interval:
        ends = zip(ENDS, brain.functions.interval(me), strict=True)
        fields |= {free(name, brain.memory): float(end) for name, end in ends}
    return fields


def is_done(brain: Brain, me: Any) -> bool:
    """Whether a robot is done."""
    return brain.ends and bool(brain.functions.done(me))


def said_by(brain: Brain, me: Any) -> Any:
    """The message of a robot; None if it sends none or jams."""
    return None if brain.jams and brain.functions.jam(me) else fixed(brain.functions.broadcast(me))


def fixed(message: Any) -> Any:
    """A copy of a message, since the robot may change its vectors later."""
    if not isinstance(message, tuple):  # no message, or an invalid one, which is reported elsewhere
        return message
    return tuple(tuple(part) if isinstance(part, list) else part for part in message)


def own_luck(brain: Brain, luck: np.ndarray, trial: int, tick: int, part: int, robots: int) -> np.ndarray:
    """A random word for each robot's call of `observe`, `fuse` or `steer`; empty if the brain uses none."""
    out = np.zeros(robots if brain.uses.luck else 0, np.uint64)
    if out.size:
        words(luck, trial, tick, part, 0, robots, out)
    return out


def give(brain: Brain, me: Any, luck: np.ndarray, robot: int) -> None:
    """Set the random number of a call."""
    if brain.uses.luck:
        me.luck = chance(luck[robot])
