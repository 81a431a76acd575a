"""The accuracies that robots have and those that they believe in, of swarms whose members differ too."""

from collections.abc import Callable, Sequence

import numpy as np

from swarmcensus.studies.members import Member
from swarmcensus.worlds.sensors import Accuracy, Misjudgement

Sides = tuple[np.ndarray, ...]
Where = tuple[int, int, int, int]  # seed, first trial, trials, robots


def accuracies(true: Accuracy, assumed: Accuracy | Misjudgement | None, where: Where) -> Sides:
    """True b and w, then assumed b and w, each (trial, robot) or (trial, 1); `assumed` None: robots know theirs."""
    had = _drawn(true, "accuracy", where, ())
    return *had, *(had if assumed is None else _drawn(assumed, "assumed", where, had))


def mixed_accuracies(
    true: Accuracy,
    assumed: Accuracy | Misjudgement | None,
    members: Sequence[Member],
    who: np.ndarray,
    where: Where,
) -> Sides:
    """The same where members have their own: what they assume is as for the swarm, but for what they are told.

    `who` (trial, robot) numbers members from 1 on.
    """
    found = [np.broadcast_to(side, who.shape) for side in accuracies(true, assumed, where)]
    had = found[:2]
    for number, member in enumerate(members, start=1):
        if member.accuracy:
            drawn = _drawn(member.accuracy, f"accuracy of members {number}", where, ())
            had = _told(who == number, drawn, had)
    believed = had if assumed is None else found[2:]
    for number, member in enumerate(members, start=1):
        told = member.assumed_accuracy
        if not told and member.accuracy and isinstance(assumed, Misjudgement):
            told = assumed
        if told:
            drawn = _drawn(told, f"assumed by members {number}", where, had)
            believed = _told(who == number, drawn, believed)
    return tuple(np.ascontiguousarray(side) for side in (*had, *believed))


def drifts(true: Accuracy, members: Sequence[Member], who: Callable[[], np.ndarray], start: np.ndarray) -> np.ndarray:
    """What robots' accuracies gain a round, and their least and greatest: (trial, 3, robot), or alike (trial, 3, 1).

    (trial, 3, 0) where nobody's drift. `who` tells the numbers of members, from 1 on; `start` are the accuracies b of
    round 1, (trial, robot) or (trial, 1). One that starts beyond its bound stays.
    """
    every = [true, *(member.accuracy or true for member in members)]
    if all(one.drift is None for one in every):
        return np.zeros((len(start), 3, 0))
    apart = any(member.accuracy for member in members)
    sides = np.array([(0.0, 0.0, 1.0) if one.drift is None else one.drift.numbers for one in every])
    slope, least, most = np.moveaxis(sides[who() if apart else np.zeros(start.shape, int)], -1, 0)
    return np.ascontiguousarray(np.stack([slope, np.minimum(least, start), np.maximum(most, start)], axis=1))


def _drawn(what: Accuracy | Misjudgement, purpose: str, where: Where, had: Sequence[np.ndarray]) -> Sides:
    seed, first, trials, robots = where
    if isinstance(what, Misjudgement):
        return what.draw(seed, first, trials, robots, (had[0], had[1]))
    return what.draw(seed, purpose, first, trials, robots)


def _told(whose: np.ndarray, theirs: Sequence[np.ndarray], others: Sequence[np.ndarray]) -> list[np.ndarray]:
    return [np.where(whose, side, other) for side, other in zip(theirs, others, strict=True)]
