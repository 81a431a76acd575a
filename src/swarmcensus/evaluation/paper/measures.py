"""How each claim of the paper is measured: a function that yields one detail per setting, or a note on the data.

Unless a name says otherwise, R = 10 and C = 1,000 on fixed networks, with 100 robots; 25 robots move for 10,000 ticks,
and K counts ticks. Swarms that move at the same density share their trajectories in each trial, so that the joint
bootstrap of trials compares them as pairs.
"""

import itertools
from collections.abc import Iterator, Sequence

import numpy as np

from swarmcensus import brains
from swarmcensus.checks import minimalism
from swarmcensus.evaluation.paper.evidence import ABOVE_ONE, BELOW_ZERO, NO, OPEN, YES, Detail, Evidence, Range
from swarmcensus.support import intervals
from swarmcensus.support.intervals import Floats

NUMBERS = tuple(f"{0.525 + 0.05 * i:.3f}" for i in range(10))  # the homogeneous swarms' accuracies
MIXED = "U(0.525,0.975)"
ALL = (*NUMBERS, MIXED)
FILLS = (0.55, 0.95)
GRID = tuple(itertools.product(FILLS, ALL))
SPARSE = ("ring", "line", "scale-free")
TOPOLOGIES = ("full", *SPARSE)
K, ERROR = "convergence_round", "convergence_error"
BOTH = ((K, "convergence"), (ERROR, "error"))
IMPAIRED = "0.625"
WORST = NUMBERS[:4]  # b = w up to 0.675
PAPER_TRIALS = 30
D1, D10 = "D = 1", "D = 10"
# The study of each swarm, and the coordinates that select its settings there. At the last two R = 1.
SWARMS: dict[str, tuple[str, dict[str, object]]] = {
    **{topology: ("topologies", {"topology": topology, "robots": 100}) for topology in TOPOLOGIES},
    D1: ("moving", {"density": 1.0, "robots": 25}),
    D10: ("moving", {"density": 10.0, "robots": 25}),
    "same-observations": ("same-observations", {"topology": "scale-free"}),
    "same-rounds": ("same-rounds", {"topology": "scale-free"}),
}


def at(evidence: Evidence, name: str, swarm: str, fill: float, accuracy: str) -> Floats:
    """The median of a variable over robots and trials in one setting of a swarm of `SWARMS`."""
    study, where = SWARMS[swarm]
    return evidence.median(study, name, accuracy=accuracy, fill_ratio=fill, **where)


def alone(evidence: Evidence, name: str, accuracy: str) -> Floats:
    """The median of a variable of the local estimate at f = 0.55, as in the paper's Fig. 2a, without a network."""
    return evidence.median("local", name, robots=100, accuracy=accuracy, fill_ratio=0.55)


def right_robots(evidence: Evidence, swarm: str, fill: float, accuracy: str) -> Floats:
    """The share of robots in the right bin, (trial, checkpoint)."""
    study, where = SWARMS[swarm]
    return evidence.values(study, "correct", accuracy=accuracy, fill_ratio=fill, **where)


def ratio(above: Floats, below: Floats) -> Floats:
    """The quotient; NaN where the divisor is 0, so that such a setting decides nothing."""
    quotient = np.full(above.shape, np.nan)
    np.divide(above, below, out=quotient, where=below != 0)
    return quotient


def errors(
    evidence: Evidence, right: Range, swarms: Sequence[str], fills: Sequence[float], accuracies: Sequence[str] = ALL
) -> Iterator[Detail]:
    """Median errors. Settings are named by what differs between them."""
    for swarm, accuracy, fill in itertools.product(swarms, accuracies, fills):
        parts = [swarm, *[accuracy] * (len(accuracies) > 1), *[f"f = {fill}"] * (len(fills) > 1)]
        yield evidence.judge(", ".join(parts), at(evidence, ERROR, swarm, fill, accuracy), right)


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


def swarm_ratios(evidence: Evidence, right: Range, of: Sequence[str], above: str, below: str) -> Iterator[Detail]:
    """Medians of one swarm divided by those of another. Where there are several, each is named."""
    for name, (f, accuracy) in itertools.product(of, GRID):
        both = ratio(at(evidence, name, above, f, accuracy), at(evidence, name, below, f, accuracy))
        yield evidence.judge(f"{dict(BOTH)[name]}, " * (len(of) > 1) + f"{accuracy}, f = {f}", both, right)


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


def grows(evidence: Evidence, right: Range, swarms: Sequence[str]) -> Iterator[Detail]:
    """Kendall's rank correlation of accuracy with median K and with median error.

    It is -1 if each better sensor has a smaller median.
    """
    first, second = np.triu_indices(len(NUMBERS), 1)
    for (name, what), swarm, f in itertools.product(BOTH, swarms, FILLS):
        medians = np.array([at(evidence, name, swarm, f, accuracy) for accuracy in NUMBERS])
        tau = np.sign(medians[second] - medians[first]).mean(0)
        yield evidence.judge(f"{what}, {swarm}, f = {f}", np.asarray(tau), right)


def steps_back(evidence: Evidence, swarms: Sequence[str]) -> str:
    """A note on the single steps of accuracy that make a swarm slower, with the whole interval of the ratio above 1."""
    steps = list(itertools.product(swarms, FILLS, itertools.pairwise(NUMBERS)))
    back = []
    for swarm, f, (worse, better) in steps:
        slower = ratio(at(evidence, K, swarm, f, better), at(evidence, K, swarm, f, worse))
        if evidence.judge("", slower, ABOVE_ONE).verdict == YES:
            back.append(f"{swarm}, f = {f}, {worse} to {better}")
    if not back:
        return f"Of {len(steps)} single steps of accuracy, none slows a swarm beyond doubt."
    return f"Of {len(steps)} single steps of accuracy, {len(back)} slow the swarm: {'; '.join(back)}."


def mixed_like_middle(evidence: Evidence, right: Range, fill: float) -> Iterator[Detail]:
    """The heterogeneous swarm divided by the geometric mean of b = w = 0.725 and 0.775, which stands for 0.75."""
    for (name, what), topology in itertools.product(BOTH, TOPOLOGIES):
        below, above = (at(evidence, name, topology, fill, accuracy) for accuracy in ("0.725", "0.775"))
        both = ratio(at(evidence, name, topology, fill, MIXED), np.sqrt(below * above))
        yield evidence.judge(f"{what}, {topology}", both, right)


def blacker(evidence: Evidence, right: Range, swarms: Sequence[str], of: str = K) -> Iterator[Detail]:
    """A median at f = 0.95 divided by that at f = 0.55."""
    for swarm, accuracy in itertools.product(swarms, ALL):
        both = ratio(at(evidence, of, swarm, 0.95, accuracy), at(evidence, of, swarm, 0.55, accuracy))
        yield evidence.judge(f"{swarm}, {accuracy}", both, right)


def same_observations(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """R = 1 divided by R = 10 for the same number of observations: K in observations, and error."""
    for (name, what), (f, accuracy) in itertools.product(BOTH, GRID):
        seldom = (10 if name == K else 1) * at(evidence, name, "scale-free", f, accuracy)
        often = at(evidence, name, "same-observations", f, accuracy)
        yield evidence.judge(f"{what}, {accuracy}, f = {f}", ratio(often, seldom), right)


def consensus(evidence: Evidence, right: Range, swarm: str) -> Iterator[Detail]:
    """The share of trials in which all robots are right at the end."""
    for f, accuracy in itertools.product(FILLS, NUMBERS[3:]):
        yield unanimous(f"{accuracy}, f = {f}", right_robots(evidence, swarm, f, accuracy), right)


def mixed_consensus(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """The share of trials in which all robots of the heterogeneous swarm that moves are right at the end."""
    for f in FILLS:
        yield unanimous(f"f = {f}", right_robots(evidence, D1, f, MIXED), right)


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
    gain = right_robots(evidence, D1, fill, MIXED) - right_robots(evidence, D1, fill, accuracy)
    return evidence.mean(-gain.mean(axis=1))


def expense(evidence: Evidence) -> str:
    """A note on the cost in time of poor sensors: their K divided by that of the best sensors."""
    parts = []
    for swarm, f in itertools.product((D1, D10), FILLS):
        slower = ratio(at(evidence, K, swarm, f, IMPAIRED), at(evidence, K, swarm, f, NUMBERS[-1]))
        _, low, high = intervals.interval(slower)
        parts.append(f"{low:.1f} to {high:.1f} ({swarm}, f = {f})")
    return f"The expense, K over that of b = w = {NUMBERS[-1]}, {100 * intervals.LEVEL:g} %: {', '.join(parts)}."


def like_tree(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """Share of right robots at D = 1 divided by that on the scale-free network, at the same numbers of observations."""
    for f, accuracy in GRID:
        moving = evidence.mean(right_robots(evidence, D1, f, accuracy).mean(axis=1))
        fixed = evidence.mean(right_robots(evidence, "scale-free", f, accuracy).mean(axis=1))
        yield evidence.judge(f"{accuracy}, f = {f}", ratio(moving, fixed), right)


def settled_like_tree(evidence: Evidence) -> str:
    """A note on K and error, divided by those of the scale-free network at R = 1: smallest and largest ratio."""
    parts = []
    for name, what in BOTH:
        both = [
            float(ratio(at(evidence, name, D1, f, a), at(evidence, name, "same-observations", f, a))[0])
            for f, a in GRID
        ]
        parts.append(f"median {what} is {min(both):.2f} to {max(both):.2f} times")
    return f"At R = 1, where a round is an observation too: {' and '.join(parts)} that of the scale-free network."


def minimal(evidence: Evidence, right: Range) -> Iterator[Detail]:
    """What a robot needs after many observations in a large swarm, minus what it needs at first in a small one."""
    table = minimalism.footprints(brains.load("minimalistic"))
    least = table[minimalism.SWARMS[0], minimalism.AGES[0]]
    for name, few in least.items():
        growth = max(footprint[name] for footprint in table.values()) - few
        unit = "numbers" if name in ("memory", "message") else "lines"
        yield Detail(f"{name}, {few} {unit}", float(growth), None, YES if growth <= right[1] else NO)
