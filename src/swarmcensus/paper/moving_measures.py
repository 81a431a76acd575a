"""How each claim about robots that move is measured: a function per claim, which yields one detail per setting.

25 robots, 10,000 ticks; K counts ticks. Settings of the same density share their trajectories in each trial, so that
the joint bootstrap of trials compares them as pairs.
"""

import itertools
from collections.abc import Iterator
from functools import partial

import numpy as np

from swarmcensus.paper.evidence import BELOW_ZERO, YES, Detail, Evidence, Range
from swarmcensus.paper.measures import (
    ALL,
    BOTH,
    ERROR,
    FILLS,
    GRID,
    MIXED,
    NUMBERS,
    K,
    rank_correlation,
    ratio,
    right_robots,
    slower_steps,
    tree,
    unanimous,
)
from swarmcensus.statistics import intervals
from swarmcensus.statistics.intervals import Floats

DENSITIES = (1.0, 10.0)
IMPAIRED = "0.625"
WORST = NUMBERS[:4]  # b = w up to 0.675


def at(evidence: Evidence, name: str, density: float, fill: float, accuracy: str) -> Floats:
    """The median of a variable over robots and trials in one setting."""
    return evidence.median("moving", name, density=density, robots=25, accuracy=accuracy, fill_ratio=fill)


def right_movers(evidence: Evidence, fill: float, accuracy: str) -> Floats:
    """The share of robots in the right bin at D = 1, (trial, checkpoint)."""
    return evidence.values("moving", "correct", density=1.0, robots=25, accuracy=accuracy, fill_ratio=fill)


def denser(evidence: Evidence, right: Range, name: str) -> Iterator[Detail]:
    """A median at D = 10 divided by that at D = 1."""
    for f, accuracy in GRID:
        change = ratio(at(evidence, name, 10.0, f, accuracy), at(evidence, name, 1.0, f, accuracy))
        yield evidence.judge(f"{accuracy}, f = {f}", change, right)


def blacker_better(evidence: Evidence, right: Range, name: str) -> Iterator[Detail]:
    """A median at f = 0.95 divided by that at f = 0.55."""
    for density, accuracy in itertools.product(DENSITIES, ALL):
        change = ratio(at(evidence, name, density, 0.95, accuracy), at(evidence, name, density, 0.55, accuracy))
        yield evidence.judge(f"D = {density:g}, {accuracy}", change, right)


def grows(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """The rank correlation of accuracy with median K and with median error."""
    for (name, what), density, f in itertools.product(BOTH, DENSITIES, FILLS):
        tau = rank_correlation([at(evidence, name, density, f, accuracy) for accuracy in NUMBERS])
        yield evidence.judge(f"{what}, D = {density:g}, f = {f}", tau, right)


def steps_back(evidence: Evidence) -> str:
    """A note on the steps of accuracy that slow a swarm that moves; see `slower_steps`."""
    kinds = itertools.product(DENSITIES, FILLS)
    return slower_steps(evidence, {f"D = {d:g}, f = {f}": partial(at, evidence, K, d, f) for d, f in kinds})


def impaired(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """The median error of b = w = 0.625."""
    for density, f in itertools.product(DENSITIES, FILLS):
        yield evidence.judge(f"D = {density:g}, f = {f}", at(evidence, ERROR, density, f, IMPAIRED), right)


def expense(evidence: Evidence) -> str:
    """A note on the cost in time of poor sensors: their K divided by that of the best sensors."""
    parts = []
    for density, f in itertools.product(DENSITIES, FILLS):
        slower = ratio(at(evidence, K, density, f, IMPAIRED), at(evidence, K, density, f, NUMBERS[-1]))
        _, low, high = intervals.interval(slower)
        parts.append(f"{low:.1f} to {high:.1f} (D = {density:g}, f = {f})")
    return f"The expense, K over that of b = w = {NUMBERS[-1]}, {100 * intervals.LEVEL:g} %: {', '.join(parts)}."


def consensus(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """The share of trials in which all robots are right after the last tick."""
    for f, accuracy in itertools.product(FILLS, NUMBERS[3:]):
        yield unanimous(f"{accuracy}, f = {f}", right_movers(evidence, f, accuracy), right)


def mixed_consensus(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """The share of trials in which all robots of the heterogeneous swarm are right after the last tick."""
    for f in FILLS:
        yield unanimous(f"f = {f}", right_movers(evidence, f, MIXED), right)


def mixed_sooner(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """Share of wrong robots in the heterogeneous swarm minus that in the worst swarm that it is compared with."""
    for f in FILLS:
        yield evidence.judge(f"f = {f}", np.min([_less_wrong(evidence, f, a) for a in WORST], axis=0), right)


def overtaken(evidence: Evidence) -> str:
    """A note on the swarms that the heterogeneous one beats with the whole interval."""
    parts = []
    for f in FILLS:
        beaten = [a for a in WORST if evidence.judge("", _less_wrong(evidence, f, a), BELOW_ZERO).verdict == YES]
        parts.append(f"at f = {f}: {', '.join(beaten) or 'none'}")
    return f"Swarms that it leaves behind beyond doubt: {'; '.join(parts)}."


def _less_wrong(evidence: Evidence, fill: float, accuracy: str) -> Floats:
    """Share of wrong robots in the heterogeneous swarm minus that in another, over all checkpoints."""
    gain = right_movers(evidence, fill, MIXED) - right_movers(evidence, fill, accuracy)
    return evidence.mean(-gain.mean(axis=1))


def like_tree(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """Share of right robots at D = 1 divided by that on the scale-free network, at the same numbers of observations."""
    for f, accuracy in GRID:
        moving = evidence.mean(right_movers(evidence, f, accuracy).mean(axis=1))
        fixed = evidence.mean(right_robots(evidence, "scale-free", f, accuracy).mean(axis=1))
        yield evidence.judge(f"{accuracy}, f = {f}", ratio(moving, fixed), right)


def settled_like_tree(evidence: Evidence) -> str:
    """A note on K and error, divided by those of the scale-free network at R = 1: smallest and largest ratio."""
    parts = []
    for name, what in BOTH:
        both = [
            float(ratio(at(evidence, name, 1.0, f, a), tree(evidence, "same-observations", name, f, a))[0])
            for f, a in GRID
        ]
        parts.append(f"median {what} is {min(both):.2f} to {max(both):.2f} times")
    return f"At R = 1, where a round is an observation too: {' and '.join(parts)} that of the scale-free network."
