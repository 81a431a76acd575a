"""How claims are measured: a statistic of each setting, and its comparison between settings."""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from swarmcensus import brains
from swarmcensus.checks import minimalism
from swarmcensus.evaluation.paper.evidence import NEITHER, NO, YES, Contender, Detail, Evidence, Finding, Where, ratio
from swarmcensus.evaluation.paper.quantities import (
    consensus_time,
    convergence,
    end_of,
    error,
    right_robots,
    rounds,
    unsettled,
    wrong_share,
)
from swarmcensus.support import intervals
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import Floats

Statistic = Callable[[Evidence, Contender, Where], Floats]
Contenders = Sequence[Contender]
Statistics = Sequence[Statistic]
Worlds = Sequence[Where]
PAPER_TRIALS = 30
TITLES = {"fill_ratio": "f", "robots": "N"}


def compared(
    evidence: Evidence, of: Statistics, first: Contenders, others: Contenders, worlds: Worlds,
    how: Callable[[Floats, Floats], Floats],
) -> Iterator[Finding]:  # fmt: skip
    """Statistics of the first contenders compared with those of each other one, in each world."""
    for statistic, one, other, world in itertools.product(of, first, others, worlds):
        name = _name(statistic if len(of) > 1 else None, f"{one.name} / {other.name}", world)
        yield _both(evidence, statistic, name, (one, world), (other, world), how)


ratios = partial(compared, how=ratio)
differences = partial(compared, how=np.subtract)


def changes(
    evidence: Evidence, of: Statistics, contenders: Contenders, before: Where, after: Where, worlds: Worlds = ({},)
) -> Iterator[Finding]:
    """Statistics in one part of each world divided by those in another part of it."""
    for statistic, contender, world in itertools.product(of, contenders, worlds):
        name = _name(statistic if len(of) > 1 else None, contender.name, world)
        name += f", {world_label(after)} / {world_label(before)}"
        pair = (contender, {**world, **after}), (contender, {**world, **before})
        yield _both(evidence, statistic, name, *pair, ratio)


def changed_more(
    evidence: Evidence, of: Statistics, first: Contenders, others: Contenders, worlds: Worlds
) -> Iterator[Finding]:
    """How many times more one statistic changes than another does between two contenders, whichever way they change."""
    for more, less in zip(*(ratios(evidence, [one], first, others, worlds) for one in of), strict=True):
        above, below = (None if x is None else np.maximum(x, 1 / x) for x in (more.statistic, less.statistic))
        yield more if above is None or below is None else more._replace(statistic=above / below)


def _both(
    evidence: Evidence, statistic: Statistic, name: str, one: tuple[Contender, Where], other: tuple[Contender, Where],
    how: Callable[[Floats, Floats], Floats],
) -> Finding:  # fmt: skip
    """Two settings compared; nothing where neither has settled."""
    if statistic in (convergence, rounds) and all(unsettled(evidence, *setting) for setting in (one, other)):
        return Finding(name, None)
    above, below = statistic(evidence, *one), statistic(evidence, *other)
    return Finding(name, how(above, below), _pair(above, below))


def numbers(evidence: Evidence, of: Statistics, contenders: Contenders, worlds: Worlds = ({},)) -> Iterator[Finding]:
    """Statistics of each contender by itself."""
    for statistic, contender, world in itertools.product(of, contenders, worlds):
        yield Finding(_name(None, contender.name, world), statistic(evidence, contender, world))


def unanimous(evidence: Evidence, contenders: Contenders, worlds: Worlds) -> Iterator[Detail]:
    """The share of trials in which all robots are right at the last checkpoint, with Wilson's interval.

    A setting says no if one robot in one trial is wrong, and yes if all are right in at least as many trials as the
    paper ran. In the first case it says how likely the paper's observation is at the measured rate.
    """
    for contender, world in itertools.product(contenders, worlds):
        right = evidence.values(contender, world, "correct")[:, -1]
        trials, hits = len(right), int((right == 1).sum())
        share, low, high = intervals.share_interval(hits, trials)
        says = NO if hits < trials else YES if trials >= PAPER_TRIALS else NEITHER
        wrong = counted(round((1 - right).sum() * evidence.number(contender, world, "robots")), "robot")
        chance = f"probability of {100 * share**PAPER_TRIALS:.0f} %"
        about = f"{wrong} wrong; at this rate the paper's {PAPER_TRIALS} trials are all right with a {chance}"
        yield Detail(_name(None, contender.name, world), share, (low, high), says, about if says == NO else "")


def ranks(
    evidence: Evidence, of: Statistics, contenders: Contenders, accuracies: Sequence[str], worlds: Worlds
) -> Iterator[Finding]:
    """Kendall's rank correlation of accuracy with medians: -1 if each better sensor has a smaller median.

    Swarms that have not settled count as equal.
    """
    first, second = np.triu_indices(len(accuracies), 1)
    for statistic, contender, world in itertools.product(of, contenders, worlds):
        medians = _over(statistic, evidence, contender, world, accuracies)
        if statistic is convergence:
            # after the end of the run no order of K is known
            medians = np.minimum(medians, end_of(evidence, contender, {**world, "accuracy": accuracies[0]}))
        tau = np.sign(medians[second] - medians[first]).mean(0)
        yield Finding(_name(statistic, contender.name, world), np.asarray(tau))


def gains(
    evidence: Evidence, contenders: Contenders, others: Contenders, accuracies: Sequence[str], worlds: Worlds
) -> Iterator[Finding]:
    """The gain in median error by communication of the poorer half of sensors minus that of the better half.

    It is a share of the mean error of robots alone.
    """
    half = len(accuracies) // 2
    for contender, world in itertools.product(contenders, worlds):
        by_itself, together = (_over(error, evidence, who, world, accuracies) for who in (others[0], contender))
        saved = by_itself - together
        gain = ratio(saved[:half].mean(0) - saved[half:].mean(0), by_itself.mean(0))
        yield Finding(_name(None, contender.name, world), gain)


def between(
    evidence: Evidence, of: Statistics, contenders: Contenders, accuracy: str, middle: Sequence[str], worlds: Worlds
) -> Iterator[Finding]:
    """Medians at one accuracy divided by the geometric mean of those at the accuracies on both sides of the middle."""
    for statistic, contender, world in itertools.product(of, contenders, worlds):
        one, below, above = _over(statistic, evidence, contender, world, (accuracy, *middle))
        yield Finding(_name(statistic, contender.name, world), ratio(one, np.sqrt(below * above)))


def sooner_right(
    evidence: Evidence, first: Contenders, others: Contenders, accuracies: Sequence[str], worlds: Worlds
) -> Iterator[Finding]:
    """The share of wrong robots over all checkpoints and accuracies, divided by that of another contender."""
    for one, other, world in itertools.product(first, others, worlds):
        above, below = (_over(wrong_share, evidence, who, world, accuracies).mean(axis=0) for who in (one, other))
        yield Finding(_name(None, f"{one.name} / {other.name}", world), ratio(above, below), _pair(above, below))


def spared(evidence: Evidence, first: Contenders, others: Contenders, worlds: Worlds, liars: int) -> Iterator[Finding]:
    """The share of right robots that `liars` liars cost another contender, minus what they cost the first."""
    for one, other, world in itertools.product(first, others, worlds):
        lost = [
            right_robots(evidence, who, {**world, "liars": 0}) - right_robots(evidence, who, {**world, "liars": liars})
            for who in (other, one)
        ]
        yield Finding(world_label(world), lost[0] - lost[1], _pair(*lost))


def pattern_against_share(
    evidence: Evidence, contenders: Contenders, patterned: Where, plain: Where, harder: Where
) -> Iterator[Finding]:
    """The slowdown by a pattern of the floor divided by the slowdown by a harder fill ratio."""
    for contender in contenders:
        longer, base, slow = (consensus_time(evidence, contender, world) for world in (patterned, plain, harder))
        yield Finding(contender.name, ratio(longer / base, slow / base), _pair(longer / base, slow / base))


def minimal(evidence: Evidence) -> Iterator[Finding]:
    """What a robot needs after many observations in a large swarm, minus what it needs at first in a small one."""
    table = minimalism.footprints(brains.load("minimalistic"))
    least = table[minimalism.SWARMS[0], minimalism.AGES[0]]
    for name, few in least.items():
        growth = max(footprint[name] for footprint in table.values()) - few
        unit = "numbers" if name in ("memory", "message") else "lines"
        yield Finding(f"{name}, {few} {unit}", np.array([float(growth)]))


def _over(
    statistic: Statistic, evidence: Evidence, contender: Contender, world: Where, accuracies: Sequence[str]
) -> Floats:
    """A statistic at each of these accuracies, (accuracy, sample and resample)."""
    return np.array([statistic(evidence, contender, {**world, "accuracy": accuracy}) for accuracy in accuracies])


def _name(statistic: Statistic | None, contenders: str, world: Where) -> str:
    """A setting in words: the statistic if it is not the only one, contenders, and the world if there are several."""
    parts = [statistic.__name__.replace("_", " ") if statistic else "", contenders, world_label(world)]
    return ", ".join(filter(None, parts))


def _pair(one: Floats, other: Floats) -> str:
    """The two numbers of a sample that are compared."""
    return " and ".join(f"{x[0]:.0f}" if abs(x[0]) >= 100 else f"{x[0]:.3g}" for x in (one, other))


def world_label(world: Mapping[str, Any]) -> str:
    """A world in words, such as "f = 0.55, tiles"."""
    parts = []
    for name, value in world.items():
        text = value if isinstance(value, str) else f"{TITLES.get(name, name)} = {value:g}"
        parts.append(f"{value or 'no'} liar{'s' * (value > 1)}" if name == "liars" else text)
    return ", ".join(parts)
