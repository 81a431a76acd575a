"""Which line of a brain fails: its trial again in CPython, for machine code does not say."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from swarmcensus import brains
from swarmcensus.basics.errors import line_of
from swarmcensus.engine.modes import FULL, LUCK_FUSE, LUCK_OBSERVE, LUCK_STEER, PAIRS, SENSING, TALKING
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.oracle import fixed, give, is_done, own_luck
from swarmcensus.simulation.rides import record_ride
from swarmcensus.simulation.trials import record_trial
from swarmcensus.studies.settings import Setting

MOST_STEPS = 3_000_000  # of robots and rounds: some ten seconds of CPython


def line_of_failure(setting: Setting, seed: int, trial: int) -> str:
    """Where the brain fails in this trial, as ", at my_brain.py, line 12: x = 1 / me.n"; empty where it cannot be told.

    What robots see and whom they hear is taken from the same trial with a shipped brain: it is the same, but for
    brains that steer.
    """
    if setting.robots * setting.rounds > MOST_STEPS:
        return ""
    try:
        _live(setting, seed, trial)
    except Exception as error:
        return next(filter(None, (line_of(error, brain.path) for brain in setting.crew)), "")
    return ""


def _live(setting: Setting, seed: int, trial: int) -> None:
    """The trial's minds, step by step, as the engine runs them."""
    from swarmcensus.engine.minds import heard_by
    from swarmcensus.engine.random import chance, word_of

    others = tuple(replace(member, brain=None) for member in setting.members)
    known = replace(setting, brain=brains.load("minimalistic"), members=others)
    given = inputs_of(setting, seed, trial)
    stops, luck, robots = given.stops[0], given.luck, setting.robots
    group = given.group[0] if given.group.size else np.zeros(robots, np.int64)
    own = [setting.crew[k] for k in group]
    b, w = (belief[0] for belief in given.beliefs)
    minds = [brain.robot(float(b[i % b.size]), float(w[i % w.size]), float(i)) for i, brain in enumerate(own)]
    delay = setting.body.message_delay if setting.body else 0
    looks, threshold, key = setting.observations_per_round, given.loss_threshold, given.losses

    def works(part: int, robot: int, tick: int) -> bool:
        return stops.shape[1] == 0 or bool(tick < stops[part, robot])

    def lucky(part: int) -> Iterator[tuple[int, brains.Brain, Any]]:
        for i, (brain, me) in enumerate(zip(own, minds, strict=True)):
            give(brain, me, own_luck(brain, luck, trial, tick, part, robots), i)
            yield i, brain, me

    said = [[fixed(brain.functions.broadcast(me)) for brain, me in zip(own, minds, strict=True)]]
    for tick, (blacks, pairs) in enumerate(_lived(known, seed, trial), start=1):
        for i, brain, me in lucky(LUCK_OBSERVE):
            if not np.isnan(blacks[i]) and works(SENSING, i, tick) and not is_done(brain, me):
                brain.functions.observe(me, float(blacks[i]), float(looks))
        said.append([fixed(brain.functions.broadcast(me)) for brain, me in zip(own, minds, strict=True)])
        for message in said[-1] if setting.additive else ():  # what it adds is found when it is said
            if message is not None:
                setting.brain.functions.receive(setting.brain.robot(0.0, 0.0), message)
        for receiver, sender in pairs if tick >= delay else ():
            lost = threshold > 0 and not heard_by(key, trial, tick, receiver, sender, threshold)
            message = said[-1 - delay][sender]
            if not lost and works(TALKING, sender, tick - delay) and message is not None:
                if own[receiver].uses.luck:
                    minds[receiver].luck = chance(np.uint64(word_of(luck[2], luck[3], trial, tick, receiver, sender)))
                own[receiver].functions.receive(minds[receiver], message)
        del said[: -1 - delay]
        for _, brain, me in lucky(LUCK_FUSE):
            brain.functions.fuse(me)
            for name in ("estimate", *(name for name in ("decide", "done") if name in brain.says.functions)):
                getattr(brain.functions, name)(me)
        for _, brain, me in lucky(LUCK_STEER) if setting.body else ():
            if brain.steers:
                brain.functions.steer(me)


def _lived(setting: Setting, seed: int, trial: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """By round or tick: black readings of each robot, NaN where it made none, and rows of receiver and sender."""
    if setting.body is not None:
        ride = record_ride(setting, seed, trial)
        both = np.concatenate([ride.links, ride.links[:, [0, 2, 1]]])
        both = both[np.lexsort(both.T[::-1])]
        first = np.searchsorted(both[:, 0], np.arange(setting.rounds + 2))
        for tick in range(1, setting.rounds + 1):
            yield ride.readings[tick], both[first[tick] : first[tick + 1], 1:]
        return
    _, _, blacks = record_trial(setting, seed, trial)
    links = setting.links(seed, trial, 1)
    if links.mode in (FULL, PAIRS):
        pairs = np.argwhere(~np.eye(setting.robots, dtype=np.bool_))
    else:
        pairs = np.stack([links.receivers, links.senders], axis=1).astype(np.int64)
    for row in blacks[1:]:
        yield row.astype(np.float64), pairs
