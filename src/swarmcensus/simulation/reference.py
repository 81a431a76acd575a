"""The reference implementation: CPython runs the brain file itself, robot by robot and step by step."""

import itertools
from collections.abc import Iterable
from typing import Any

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.engine import chance, word_of, words
from swarmcensus.engine.constants import DRAW_FUSE, DRAW_OBSERVE
from swarmcensus.simulation.intervals import ENDS
from swarmcensus.simulation.swarming import DECIDED, IS_DONE, free

JAMS = "jams"  # what a robot says that drowns other messages


def follow(
    brain: Brain,
    b: np.ndarray,
    w: np.ndarray,
    readings: np.ndarray,
    every: int,
    periodic: bool,
    messages: Iterable[np.ndarray],
    draws: np.ndarray,
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Run states on recorded observations and messages, in the order of calls of every simulation.

    `readings` (step, robot) are 1 for black, 0 for white, NaN where a robot made none. A round ends every `every` steps
    and at the last. `messages` has (receiver, sender) rows for each step; with `periodic` they are heard at the end of
    whole rounds only. `draws` are the two keys of it. Returns each field of the memory, what is decided and intervals,
    and the estimates, as arrays (round, robot), index 0 before any observation.
    """
    states = [brain.robot(float(b[i]), float(w[i]), float(i)) for i in range(readings.shape[1])]
    kept = [[(state_entries(brain, me, False), brain.functions.estimate(me)) for me in states]]
    number = itertools.count()  # of the message among all messages
    done: list[bool] = []  # robots that make no reading in this round
    for step, (row, pairs) in enumerate(zip(readings, messages, strict=True), start=1):
        seen, fused = (own_draws(draws, 0, step, part, len(states)) for part in (DRAW_OBSERVE, DRAW_FUSE))
        if (step - 1) % every == 0:
            done = [is_done(brain, me) for me in states]
        for i, me in enumerate(states):
            if not np.isnan(row[i]) and not done[i]:
                give(brain, me, seen, i)
                brain.functions.observe(me, float(row[i]), 1.0)
        said = [message_by(brain, me) for me in states]
        whole = step % every == 0
        heard = pairs if whole or not periodic else pairs[:0]
        for (receiver, sender), k in zip(heard, itertools.count() if periodic else number, strict=False):
            if said[sender] is None or said[sender] is JAMS:
                continue
            if brain.uses.luck:
                states[receiver].luck = chance(np.uint64(word_of(draws[2], draws[3], 0, step, 0, k)))
            brain.functions.receive(states[receiver], said[sender])
        if whole or step == len(readings):
            for i, me in enumerate(states):
                give(brain, me, fused, i)
                brain.functions.fuse(me)
            kept.append([(state_entries(brain, me, True), brain.functions.estimate(me)) for me in states])
    fields = {name: np.array([[fields[name] for fields, _ in row] for row in kept]) for name in kept[0][0][0]}
    return fields, np.array([[estimate for _, estimate in row] for row in kept])


def state_entries(brain: Brain, me: Any, decides: bool) -> dict[str, Any]:
    """The entries of a state in a trace: its fields, its decision (from the first round on) and its interval."""
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


def message_by(brain: Brain, me: Any) -> Any:
    """The message of a robot; None if it sends none, JAMS if it jams."""
    return JAMS if brain.jams and brain.functions.jam(me) else fixed(brain.functions.broadcast(me))


def fixed(message: Any) -> Any:
    """A copy of a message, since the robot may change its vectors later."""
    if not isinstance(message, tuple):  # no message, or an invalid one, which is reported elsewhere
        return message
    return tuple(tuple(part) if isinstance(part, list) else part for part in message)


def own_draws(draws: np.ndarray, trial: int, tick: int, part: int, robots: int) -> np.ndarray:
    """A random word for each robot's call of `observe`, `fuse` or `steer`; empty where no brain uses any."""
    out = np.zeros(robots if draws.size else 0, np.uint64)
    if out.size:
        words(draws, trial, tick, part, 0, robots, out)
    return out


def give(brain: Brain, me: Any, draws: np.ndarray, robot: int) -> None:
    """Set the random number of a call."""
    if brain.uses.luck:
        me.luck = chance(draws[robot])
