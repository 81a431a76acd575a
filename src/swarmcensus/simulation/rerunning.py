"""Runs a trial again in CPython if its brain fails: machine code names no line."""

import functools
from collections import deque
from collections.abc import Container, Iterator
from dataclasses import replace

import numpy as np

from swarmcensus import brains
from swarmcensus.engine import heard_by, works
from swarmcensus.engine.constants import FULL, PAIRS, SENSING, TALKING
from swarmcensus.simulation import reference, sampling
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.living import Stepped
from swarmcensus.simulation.swarming import foreknowledge
from swarmcensus.studies import Setting
from swarmcensus.support.errors import line_of

MOST_STEPS = 3_000_000  # robots times rounds that are run again: about ten seconds of CPython


def line_of_failure(setting: Setting, seed: int, trial: int, checkpoints: Container[int] = ()) -> str:
    """The place where the brain fails, as ", at my_brain.py, line 12: x = 1 / me.n"; empty if it is not found.

    At `checkpoints` robots are asked for intervals.
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
    """Run the trial's states step by step, like the engine.

    Readings and links are those of the same trial with a shipped brain: they do not depend on the brain, unless it
    steers.
    """
    alone = tuple(replace(member, brain=None) for member in setting.members)
    known = replace(setting, brain=brains.load("minimalistic"), members=alone)
    given = inputs_of(setting, seed, trial)
    stops, radio, moves = given.stops[0], given.radio, setting.body is not None
    group = given.group[0] if given.group.size else np.zeros(setting.robots, np.int64)
    brain_of = [setting.brains[one] for one in group]
    b, w = (side[0] for side in given.beliefs)
    states = [one.robot(float(b[i % b.size]), float(w[i % w.size]), float(i)) for i, one in enumerate(brain_of)]
    for one, me in zip(brain_of, states, strict=True):
        for name, value in foreknowledge(setting).items():
            setattr(me, name, value)
        one.functions.estimate(me)
    now = 0

    def arriving(pairs: np.ndarray, said: reference.Said) -> Iterator[reference.Heard]:
        for message in said[-1] if setting.additive else ():  # a message is added as it is sent
            if reference.speaks(message):
                setting.brain.functions.receive(setting.brain.robot(0.0, 0.0), message)
        if now < radio.delay + (not moves):  # moving robots also hear messages from before the first tick
            return
        news, at = said[0], now - radio.delay
        talking = [works(stops, TALKING, i, at) for i in range(setting.robots)]
        drowned = {int(to) for to, by in pairs if news[by] is reference.JAMS and talking[by]}
        for receiver, sender in pairs:
            gets_through = not radio.threshold or heard_by(radio.key, trial, now, receiver, sender, radio.threshold)
            speaks = talking[sender] and reference.speaks(news[sender])
            if gets_through and speaks and int(receiver) not in drowned:
                yield receiver, news[sender], (trial, now, receiver, sender)

    def steps() -> Iterator[reference.Step]:
        nonlocal now
        for now, (blacks, pairs) in enumerate(_readings_and_links(known, seed, trial), start=1):
            sees = [works(stops, SENSING, i, now) for i in range(setting.robots)]
            heard = functools.partial(arriving, pairs)
            yield reference.Step(np.where(sees, blacks, np.nan), float(setting.observations_per_round), heard)

    def after(i: int, steered: np.ndarray) -> None:
        one, me = brain_of[i], states[i]
        one.functions.estimate(me)
        for name in ("decide", "done", *(["interval"] if now in checkpoints else [])):
            if name in one.contents.functions:
                getattr(one.functions, name)(me)
        if one.steers and moves:
            reference.give(one, me, steered, i)
            one.functions.steer(me)

    said: reference.Said = deque(maxlen=radio.delay + 1)
    if moves:
        said.append([reference.message_by(one, me) for one, me in zip(brain_of, states, strict=True)])
    reference.live(brain_of, states, steps(), given.draws, trial, said, after)


def _readings_and_links(setting: Setting, seed: int, trial: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """By round or tick: black readings of each robot, NaN where it made none, and rows of receiver and sender."""
    trace = Stepped(setting, seed, trial, use=setting.use)
    if trace.moves:
        for stretch, _ in trace.parts(1, trace.rounds + 1):
            both = np.concatenate([stretch.links, stretch.links[:, [0, 2, 1]]])
            both = both[np.lexsort(both.T[::-1])]
            ends = np.searchsorted(both[:, 0], stretch.first + np.arange(len(stretch.readings) + 1))
            for row, readings in enumerate(stretch.readings):
                yield readings, both[ends[row] : ends[row + 1], 1:]
        return
    links = sampling.links(setting, seed, trial, 1)
    if links.mode in (FULL, PAIRS):
        pairs = np.argwhere(~np.eye(setting.robots, dtype=np.bool_))
    else:
        pairs = np.stack([links.receivers, links.senders], axis=1).astype(np.int64)
    for row in trace.blacks()[1:]:
        yield row, pairs
