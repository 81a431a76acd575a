"""How each claim about fixed networks is measured: a function per claim, which yields one detail per setting.

Unless a name says otherwise, settings are the paper's: 100 robots, R = 10, C = 1,000; K is the convergence round.
"""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from swarmcensus import brains
from swarmcensus.conformance import minimalism
from swarmcensus.paper.evidence import ABOVE_ONE, NO, OPEN, YES, Detail, Evidence, Range
from swarmcensus.statistics import intervals
from swarmcensus.statistics.intervals import Floats

NUMBERS = tuple(f"{0.525 + 0.05 * i:.3f}" for i in range(10))  # the homogeneous swarms' accuracies
MIXED = "U(0.525,0.975)"
ALL = (*NUMBERS, MIXED)
FILLS = (0.55, 0.95)
GRID = tuple(itertools.product(FILLS, ALL))
SPARSE = ("ring", "line", "scale-free")
TOPOLOGIES = ("full", *SPARSE)
K, ERROR = "convergence_round", "convergence_error"
BOTH = ((K, "convergence"), (ERROR, "error"))
PAPER_TRIALS = 30


def at(evidence: Evidence, name: str, topology: str, fill: float, accuracy: str) -> Floats:
    """The median of a variable over robots and trials in one setting of the study "topologies"."""
    return evidence.median("topologies", name, topology=topology, robots=100, accuracy=accuracy, fill_ratio=fill)


def tree(evidence: Evidence, study: str, name: str, fill: float, accuracy: str) -> Floats:
    """The median of a variable over robots and trials on the scale-free network of another study."""
    return evidence.median(study, name, topology="scale-free", accuracy=accuracy, fill_ratio=fill)


def alone(evidence: Evidence, name: str, accuracy: str) -> Floats:
    """The median of a variable of the local estimate at f = 0.55, as in the paper's Fig. 2a, without a network."""
    return evidence.median("local", name, robots=100, accuracy=accuracy, fill_ratio=0.55)


def ratio(above: Floats, below: Floats) -> Floats:
    """The quotient; NaN where the divisor is 0, so that such a setting decides nothing."""
    quotient = np.full(above.shape, np.nan)
    np.divide(above, below, out=quotient, where=below != 0)
    return quotient


def low_errors(evidence: Evidence, right: Range, fill: float) -> Iterator[Detail]:
    """Median errors on the ring and on the scale-free network."""
    for topology, accuracy in itertools.product(("ring", "scale-free"), ALL):
        yield evidence.judge(f"{topology}, {accuracy}", at(evidence, ERROR, topology, fill, accuracy), right)


def full_agrees(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """The largest spread of final estimates within a fully connected trial: exact, without an interval."""
    for robots, (f, accuracy) in itertools.product((10, 100), GRID):
        final = evidence.values(
            "topologies", "final_estimate", topology="full", robots=robots, accuracy=accuracy, fill_ratio=f
        )
        spread = float(np.ptp(final, axis=1).max())
        yield Detail(f"N = {robots}, {accuracy}, f = {f}", spread, None, YES if spread < right[1] else NO)


def full_first(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """K of the fully connected network divided by K of each other topology."""
    for topology, (f, accuracy) in itertools.product(SPARSE, GRID):
        faster = ratio(at(evidence, K, "full", f, accuracy), at(evidence, K, topology, f, accuracy))
        yield evidence.judge(f"full / {topology}, {accuracy}, f = {f}", faster, right)


def ring_like_line(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """Line divided by ring, for convergence and for error."""
    for (name, what), (f, accuracy) in itertools.product(BOTH, GRID):
        both = ratio(at(evidence, name, "line", f, accuracy), at(evidence, name, "ring", f, accuracy))
        yield evidence.judge(f"{what}, {accuracy}, f = {f}", both, right)


def informed_first(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """K of the informed estimate divided by K of the local one, both in observations."""
    for topology, accuracy in itertools.product(TOPOLOGIES, ALL):
        together = 10 * at(evidence, K, topology, 0.55, accuracy)
        faster = ratio(together, alone(evidence, "local_convergence_step", accuracy))
        yield evidence.judge(f"{topology}, {accuracy}", faster, right)


def helps_poor(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """The gain in median error by communication: its mean over the five poorer sensors minus that over the better."""
    for topology in TOPOLOGIES:
        gains = np.array([
            alone(evidence, "local_convergence_error", accuracy) - at(evidence, ERROR, topology, 0.55, accuracy)
            for accuracy in NUMBERS
        ])  # fmt: skip
        yield evidence.judge(topology, gains[:5].mean(0) - gains[5:].mean(0), right)


def rank_correlation(medians: Sequence[Floats]) -> Floats:
    """Kendall's rank correlation of accuracies with medians; -1 if each better sensor has a smaller median."""
    first, second = np.triu_indices(len(NUMBERS), 1)
    stacked = np.array(medians)
    return np.asarray(np.sign(stacked[second] - stacked[first]).mean(0))


def grows(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """The rank correlation of accuracy with median K and with median error."""
    for (name, what), topology, f in itertools.product(BOTH, TOPOLOGIES, FILLS):
        tau = rank_correlation([at(evidence, name, topology, f, accuracy) for accuracy in NUMBERS])
        yield evidence.judge(f"{what}, {topology}, f = {f}", tau, right)


def steps_back(evidence: Evidence) -> str:
    """A note on the steps of accuracy that slow a swarm on a fixed network; see `slower_steps`."""
    return slower_steps(
        evidence, {f"{t}, f = {f}": partial(at, evidence, K, t, f) for t, f in itertools.product(TOPOLOGIES, FILLS)}
    )


def slower_steps(evidence: Evidence, swarms: Mapping[str, Callable[[str], Floats]]) -> str:
    """The single steps of accuracy that make a swarm slower, where the whole interval of the ratio is above 1.

    `swarms` gives K by accuracy for each kind of swarm.
    """
    steps = list(itertools.product(swarms.items(), itertools.pairwise(NUMBERS)))
    back = []
    for (swarm, rounds), (worse, better) in steps:
        if evidence.judge("", ratio(rounds(better), rounds(worse)), ABOVE_ONE).verdict == YES:
            back.append(f"{swarm}, {worse} to {better}")
    if not back:
        return f"Of {len(steps)} single steps of accuracy, none slows a swarm beyond doubt."
    return f"Of {len(steps)} single steps of accuracy, {len(back)} slow the swarm: {'; '.join(back)}."


def mixed_like_middle(evidence: Evidence, right: Range, fill: float) -> Iterator[Detail]:
    """The heterogeneous swarm divided by the geometric mean of b = w = 0.725 and 0.775, which stands for 0.75."""
    for (name, what), topology in itertools.product(BOTH, TOPOLOGIES):
        below, above = (at(evidence, name, topology, fill, accuracy) for accuracy in ("0.725", "0.775"))
        both = ratio(at(evidence, name, topology, fill, MIXED), np.sqrt(below * above))
        yield evidence.judge(f"{what}, {topology}", both, right)


def blacker_first(evidence: Evidence, right: Range, topologies: Sequence[str]) -> Iterator[Detail]:
    """K at f = 0.95 divided by K at f = 0.55."""
    for topology, accuracy in itertools.product(topologies, ALL):
        faster = ratio(at(evidence, K, topology, 0.95, accuracy), at(evidence, K, topology, 0.55, accuracy))
        yield evidence.judge(f"{topology}, {accuracy}", faster, right)


def same_observations(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """R = 1 divided by R = 10 for the same number of observations: K in observations, and error."""
    for (name, what), (f, accuracy) in itertools.product(BOTH, GRID):
        seldom = (10 if name == K else 1) * at(evidence, name, "scale-free", f, accuracy)
        often = tree(evidence, "same-observations", name, f, accuracy)
        yield evidence.judge(f"{what}, {accuracy}, f = {f}", ratio(often, seldom), right)


def same_rounds(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """R = 1 divided by R = 10 for the same number of rounds: K in rounds."""
    for f, accuracy in GRID:
        often = tree(evidence, "same-rounds", K, f, accuracy)
        slower = ratio(often, at(evidence, K, "scale-free", f, accuracy))
        yield evidence.judge(f"{accuracy}, f = {f}", slower, right)


def right_robots(evidence: Evidence, topology: str, fill: float, accuracy: str) -> Floats:
    """The share of robots in the right bin, (trial, checkpoint)."""
    return evidence.values("topologies", "correct", topology=topology, robots=100, accuracy=accuracy, fill_ratio=fill)


def consensus(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """The share of trials in which all robots are right after the last round."""
    for f, accuracy in itertools.product(FILLS, NUMBERS[3:]):
        robots = right_robots(evidence, "scale-free", f, accuracy)
        yield unanimous(f"{accuracy}, f = {f}", robots, right)


def unanimous(setting: str, robots: Floats, right: Range) -> Detail:
    """The share of trials in which all robots are right at the last checkpoint, with Wilson's interval.

    `robots` is the share of right robots (trial, checkpoint). The verdict is no if one robot in one trial is wrong, and
    yes if all are right in at least as many trials as the paper ran.
    """
    trials = len(robots)
    share, low, high = intervals.share_interval(int((robots[:, -1] == 1).sum()), trials)
    return Detail(setting, share, (low, high), NO if share < right[0] else YES if trials >= PAPER_TRIALS else OPEN)


def sooner_right(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """Share of wrong robots on ring and line minus that on scale-free, over all checkpoints and accuracies."""
    for topology, f in itertools.product(("ring", "line"), FILLS):
        more = [
            right_robots(evidence, topology, f, accuracy) - right_robots(evidence, "scale-free", f, accuracy)
            for accuracy in NUMBERS[3:]
        ]
        yield evidence.judge(f"{topology}, f = {f}", evidence.mean(-np.mean(more, axis=(0, 2))), right)


def minimal(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """What a robot needs after many observations in a large swarm, minus what it needs at first in a small one."""
    table = minimalism.footprints(brains.load("minimalistic"))
    least = table[minimalism.SWARMS[0], minimalism.AGES[0]]
    for name, few in least.items():
        growth = max(footprint[name] for footprint in table.values()) - few
        unit = "numbers" if name in ("memory", "message") else "lines"
        yield Detail(f"{name}, {few} {unit}", float(growth), None, YES if growth <= right[1] else NO)
