"""The reference implementation: CPython runs the brain file itself, robot by robot and step by step."""

import functools
import itertools
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.engine import chance, word_of, words
from swarmcensus.engine.constants import DRAW_FUSE, DRAW_OBSERVE, DRAW_STEER
from swarmcensus.simulation.intervals import ENDS
from swarmcensus.simulation.swarming import DECIDED, IS_DONE, free

JAMS = "jams"  # what a robot says that drowns other messages
Said = deque[list[Any]]  # the messages of the last steps, by robot; None of one that sends none, JAMS of one that jams
Heard = tuple[int, Any, tuple[int, ...]]  # a receiver, a message, and the address of the random word of hearing it


class Step(NamedTuple):
    """What happens to robots in a round, in a tick, or in a step of recorded data."""

    blacks: np.ndarray  # (robot): how many of its readings are black; NaN where a robot makes none
    looks: float  # how many readings a robot makes
    heard: Callable[[Said], Iterable[Heard]]  # which messages arrive, given what robots have said
    begins: bool = True  # whether a round begins
    ends: bool = True  # whether a round ends


def live(
    brains: Sequence[Brain], states: Sequence[Any], steps: Iterable[Step], draws: np.ndarray, trial: int,
    said: Said, after: Callable[[int, np.ndarray], object],
) -> None:  # fmt: skip
    """Run states through steps, in the order of calls of every simulation: observe, broadcast, receive, fuse.

    `draws` are the two keys of it. What robots say is added to `said`, of which as many steps are kept as it has room
    for. `after` is called with each robot that has fused, and the random words of its calls of `steer`.
    """
    robots = list(zip(brains, states, strict=True))
    done: list[bool] = []  # robots that make no reading in this round
    for number, step in enumerate(steps, start=1):
        parts = DRAW_OBSERVE, DRAW_FUSE, DRAW_STEER
        seen, fused, steered = (own_draws(draws, trial, number, part, len(states)) for part in parts)
        if step.begins:
            done = [is_done(brain, me) for brain, me in robots]
        for i, (brain, me) in enumerate(robots):
            if not np.isnan(step.blacks[i]) and not done[i]:
                give(brain, me, seen, i)
                brain.functions.observe(me, float(step.blacks[i]), step.looks)
        said.append([message_by(brain, me) for brain, me in robots])
        for receiver, message, place in step.heard(said):
            brain, me = robots[receiver]
            if brain.uses.luck:
                me.luck = chance(np.uint64(word_of(draws[2], draws[3], *place)))
            brain.functions.receive(me, message)
        for i, (brain, me) in enumerate(robots if step.ends else ()):
            give(brain, me, fused, i)
            brain.functions.fuse(me)
            after(i, steered)


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
    """Run states on recorded observations and messages.

    `readings` (step, robot) are 1 for black, 0 for white, NaN where a robot made none. A round ends every `every` steps
    and at the last. `messages` has (receiver, sender) rows for each step; with `periodic` they are heard at the end of
    whole rounds only. `draws` are the two keys of it. Returns each field of the memory, what is decided and intervals,
    and the estimates, as arrays (round, robot), index 0 before any observation.
    """
    states = [brain.robot(float(b[i]), float(w[i]), float(i)) for i in range(readings.shape[1])]
    kept = [[(state_entries(brain, me, False), brain.functions.estimate(me)) for me in states]]
    number = itertools.count()  # of the message among all messages

    def arriving(step: int, pairs: np.ndarray, said: Said) -> Iterator[Heard]:
        for (receiver, sender), k in zip(pairs, itertools.count() if periodic else number, strict=False):
            if speaks(message := said[-1][sender]):
                yield receiver, message, (0, step, 0, k)

    def steps() -> Iterator[Step]:
        for step, (row, pairs) in enumerate(zip(readings, messages, strict=True), start=1):
            whole = step % every == 0
            heard = functools.partial(arriving, step, pairs if whole or not periodic else pairs[:0])
            yield Step(row, 1.0, heard, (step - 1) % every == 0, whole or step == len(readings))

    def after(i: int, _: np.ndarray) -> None:
        if i == 0:
            kept.append([])
        kept[-1].append((state_entries(brain, states[i], True), brain.functions.estimate(states[i])))

    live([brain] * len(states), states, steps(), draws, 0, deque(maxlen=1), after)
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


def speaks(said: Any) -> bool:
    """Whether what a robot says is a message."""
    return said is not None and said is not JAMS


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
