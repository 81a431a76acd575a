"""Which line of a brain fails: its trial again in CPython, for machine code does not say."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from swarmcensus import brains
from swarmcensus.basics.errors import line_of
from swarmcensus.engine.modes import FULL, PAIRS, SENSING, TALKING
from swarmcensus.simulation.inputs import inputs_of
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
        return line_of(error, setting.brain.path)
    return ""


def _live(setting: Setting, seed: int, trial: int) -> None:
    """The trial's minds, step by step, as the engine runs them."""
    from swarmcensus.engine.minds import heard_by

    known = replace(setting, brain=brains.load("minimalistic"))
    given = inputs_of(setting, seed, trial)
    functions, stops = setting.brain.functions, given.stops[0]
    b, w = (belief[0] for belief in given.beliefs)
    minds = [setting.brain.robot(float(b[i % b.size]), float(w[i % w.size])) for i in range(setting.robots)]
    delay = setting.body.message_delay if setting.body else 0
    looks, threshold, key = setting.observations_per_round, given.loss_threshold, given.losses

    def works(part: int, robot: int, tick: int) -> bool:
        return stops.shape[1] == 0 or bool(tick < stops[part, robot])

    said = [[functions.broadcast(me) for me in minds]]
    for tick, (blacks, pairs) in enumerate(_lived(known, seed, trial), start=1):
        for i, me in enumerate(minds):
            if not np.isnan(blacks[i]) and works(SENSING, i, tick):
                functions.observe(me, float(blacks[i]), float(looks))
        said.append([functions.broadcast(me) for me in minds])
        for message in said[-1] if setting.brain.sums else ():  # what it adds is found when it is said
            functions.receive(setting.brain.robot(0.0, 0.0), message)
        for receiver, sender in pairs if tick >= delay else ():
            lost = threshold > 0 and not heard_by(key, trial, tick, receiver, sender, threshold)
            if not lost and works(TALKING, sender, tick - delay):
                functions.receive(minds[receiver], said[-1 - delay][sender])
        del said[: -1 - delay]
        for me in minds:
            functions.fuse(me)
            functions.estimate(me)
            if setting.brain.steers and setting.body:
                functions.steer(me)


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
