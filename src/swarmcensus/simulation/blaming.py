"""Finds the line at which a brain fails by running its trial again in CPython, as machine code reports no line."""

from collections.abc import Container, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from swarmcensus import brains
from swarmcensus.basics.errors import line_of
from swarmcensus.engine.constants import FULL, LUCK_FUSE, LUCK_OBSERVE, LUCK_STEER, PAIRS, SENSING, TALKING
from swarmcensus.engine.random import chance, word_of, words
from swarmcensus.simulation import oracle, sampling
from swarmcensus.simulation.informing import schedule_of
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.rides import record_ride
from swarmcensus.simulation.trials import record_trial
from swarmcensus.studies.settings import Setting

MOST_STEPS = 3_000_000  # robots times rounds: about ten seconds of CPython


def line_of_failure(setting: Setting, seed: int, trial: int, checkpoints: Container[int] = ()) -> str:
    """The place where the brain fails, as ", at my_brain.py, line 12: x = 1 / me.n"; empty if it is not found.

    Readings and links are those of the same trial with a shipped brain: they do not depend on the brain, unless it
    steers. At `checkpoints` robots are asked for intervals.
    """
    if setting.robots * setting.rounds > MOST_STEPS:
        return ""
    try:
        run_in_cpython(setting, seed, trial, checkpoints)
    except Exception as error:
        lines = (line_of(error, brain.path) for brain in setting.brains)
        return next(filter(None, lines), "")
    return ""


def run_in_cpython(setting: Setting, seed: int, trial: int, checkpoints: Container[int] = ()) -> None:
    """Run the trial's minds step by step, like the engine."""
    from swarmcensus.engine.failures import works
    from swarmcensus.engine.minds import heard_by

    alone = tuple(replace(member, brain=None) for member in setting.members)
    known = replace(setting, brain=brains.load("minimalistic"), members=alone)
    given = inputs_of(setting, seed, trial)
    stops = given.stops[0]
    group = given.group[0] if given.group.size else np.zeros(setting.robots, np.int64)
    brain = [setting.brains[one] for one in group]
    b, w = (side[0] for side in given.beliefs)
    minds = [one.robot(float(b[i % b.size]), float(w[i % w.size]), float(i)) for i, one in enumerate(brain)]
    for me in minds:
        for name, value in schedule_of(setting).items():
            setattr(me, name, value)
    for one, me in zip(brain, minds, strict=True):
        one.functions.estimate(me)
    delay = setting.message_delay
    first_heard = delay + (setting.body is None)  # moving robots also hear messages from before the first tick
    looks, threshold, key = setting.observations_per_round, given.radio.threshold, given.radio.key

    def luck(tick: int, part: int) -> np.ndarray:
        words_ = np.zeros(setting.robots, np.uint64)
        if given.luck.size:
            words(given.luck, trial, tick, part, 0, setting.robots, words_)
        return words_

    def say() -> list[Any]:
        return [oracle.said_by(one, me) for one, me in zip(brain, minds, strict=True)]

    def noise() -> list[bool]:
        return [one.jams and bool(one.functions.jam(me)) for one, me in zip(brain, minds, strict=True)]

    said, loud = [say()], [noise()]
    for tick, (blacks, pairs) in enumerate(_readings_and_links(known, seed, trial), start=1):
        seen, fused, steered = (luck(tick, part) for part in (LUCK_OBSERVE, LUCK_FUSE, LUCK_STEER))
        for i, (one, me) in enumerate(zip(brain, minds, strict=True)):
            if not np.isnan(blacks[i]) and works(stops, SENSING, i, tick) and not oracle.is_done(one, me):
                oracle.give(one, me, seen, i)
                one.functions.observe(me, float(blacks[i]), float(looks))
        said.append(say())
        loud.append(noise())
        for message in said[-1] if setting.additive else ():  # a message is added as it is sent
            if message is not None:
                setting.brain.functions.receive(setting.brain.robot(0.0, 0.0), message)
        if tick < first_heard:
            pairs = pairs[:0]
        news, noises = said[max(tick - delay, 0) - tick - 1], loud[max(tick - delay, 0) - tick - 1]
        talking = [works(stops, TALKING, i, tick - delay) for i in range(setting.robots)]
        drowned = {int(to) for to, by in pairs if noises[by] and talking[by]} if any(noises) else set()
        for receiver, sender in pairs:
            if int(receiver) in drowned:
                continue
            message = news[sender]
            lost = threshold > 0 and not heard_by(key, trial, tick, receiver, sender, threshold)
            if not lost and talking[sender] and message is not None:
                if brain[receiver].uses.luck:
                    word = word_of(given.luck[2], given.luck[3], trial, tick, receiver, sender)
                    minds[receiver].luck = chance(np.uint64(word))
                brain[receiver].functions.receive(minds[receiver], message)
        del said[: -1 - delay], loud[: -1 - delay]
        for i, (one, me) in enumerate(zip(brain, minds, strict=True)):
            oracle.give(one, me, fused, i)
            one.functions.fuse(me)
            one.functions.estimate(me)
            for name in ("decide", "done", *(["interval"] if tick in checkpoints else [])):
                if name in one.contents.functions:
                    getattr(one.functions, name)(me)
            if one.steers and setting.body:
                oracle.give(one, me, steered, i)
                one.functions.steer(me)


def _readings_and_links(setting: Setting, seed: int, trial: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
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
    links = sampling.links(setting, seed, trial, 1)
    if links.mode in (FULL, PAIRS):
        pairs = np.argwhere(~np.eye(setting.robots, dtype=np.bool_))
    else:
        pairs = np.stack([links.receivers, links.senders], axis=1).astype(np.int64)
    for row in blacks[1:]:
        yield row.astype(np.float64), pairs
