"""Why claims do not hold: computed numbers, with reasons where the data support them."""

from collections.abc import Sequence

import numpy as np

from swarmcensus import brains
from swarmcensus.evaluation.paper import measures
from swarmcensus.evaluation.paper.evidence import BELOW_ONE, NO, YES, Detail, Evidence
from swarmcensus.evaluation.paper.measures import D1, D10, ERROR, MIXED, SPARSE, K
from swarmcensus.support.bins import right_bin
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import Floats
from swarmcensus.worlds import parse_accuracy

ROUND = 10  # observations in a communication round
LATE = 0.9  # share of a run after which an estimate may not have settled yet
FEW = 0.25  # share of a swarm that counts as few robots


def mixed(_: Evidence, details: Sequence[Detail], fill: float) -> str:
    """Why a heterogeneous swarm is not like b = w = 0.75: the accuracy of equal Fisher information."""
    ahead, behind = _sides(details)
    low, high = parse_accuracy(MIXED).black.numbers
    drawn = low + (high - low) * (np.arange(10_000) + 0.5) / 10_000
    sentences = [f"Beyond the margin, the heterogeneous swarm is {_parts(('ahead', ahead), ('behind', behind))}."]
    sentences.append(
        f"The mean of {MIXED} is {drawn.mean():.2f}, but robots are weighted by the Fisher information of their "
        f"readings. Its mean over the swarm is that of b = w = {worth(drawn, fill):.2f} at f = {fill}."
    )
    if worth(drawn, fill) > drawn.mean() and ahead and not behind:
        sentences.append("Good sensors count for more than poor ones cost.")
    return " ".join(sentences)


def worth(accuracies: Floats, fill: float) -> float:
    """The b = w of readings with as much Fisher information on f as those of the `accuracies`, b = w, on average.

    With s = 2b - 1 a reading is black with probability p = 1/2 + s (f - 1/2) and carries s² / (p (1 - p)).
    """
    squared, off = (2.0 * accuracies - 1.0) ** 2, (fill - 0.5) ** 2
    mean = float(np.mean(squared / (0.25 - squared * off)))
    return 0.5 + 0.5 * float(np.sqrt(0.25 * mean / (1.0 + mean * off)))


def agreed_bias(accuracy: float, fill: float, looks: int) -> tuple[float, float]:
    """The bias of the mean of local estimates weighted by confidence, and the share of these estimates at 0 or 1.

    Each estimate is of `looks` readings by a sensor with b = w = `accuracy`. Exact, by the binomial distribution of
    black readings.
    """
    brain = brains.load("minimalistic")
    black = np.arange(looks + 1)
    factorials = np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, looks + 1)))])
    p = accuracy * fill + (1.0 - accuracy) * (1.0 - fill)
    odds = np.exp(
        factorials[-1] - factorials - factorials[::-1] + black * np.log(p) + (looks - black) * np.log(1.0 - p)
    )
    me, messages = brain.robot(accuracy, accuracy), np.empty((looks + 1, 2))
    for n in black:
        me.t = me.n = 0.0
        brain.functions.observe(me, float(n), float(looks))
        messages[n] = brain.functions.broadcast(me)
    estimates, weights = messages[:, 0], odds * messages[:, 1]
    return float(weights @ estimates / weights.sum() - fill), float(odds[(estimates == 0) | (estimates == 1)].sum())


def blacker_full(evidence: Evidence, details: Sequence[Detail]) -> str:
    """Why a fully connected swarm takes longer at f = 0.95: the bias of clipped local estimates."""
    later = max((d for d in details if d.verdict == NO), key=lambda d: d.value)
    accuracy = later.setting.removeprefix("full, ")
    rounds = [float(measures.at(evidence, K, "full", f, accuracy)[0]) for f in (0.55, 0.95)]
    swarm = accuracy if accuracy == MIXED else f"b = w = {accuracy}"
    sentences = [f"Latest, {swarm} settles after a median of {rounds[1]:g} rounds, not {rounds[0]:g}."]
    sentences.append(
        "The local estimate of Eq. 4 is cut off at the ends, and the blacker floor lies close to one of them. So its "
        "errors there lean to one side, and no averaging over robots removes that."
    )
    if accuracy != MIXED:
        looks = [max(1, round(ROUND * k)) for k in rounds]
        (soon, cut), (late, _), (other, _) = (
            agreed_bias(float(accuracy), f, n) for f, n in ((0.95, looks[0]), (0.95, looks[1]), (0.55, looks[0]))
        )
        sentences.append(
            "In closed form, the mean that a large swarm agrees on is off by "
            f"{soon:+.3f} at f = 0.95 after {looks[0]:,} observations a robot, of whose local estimates "
            f"{100 * cut:.0f} % are cut off; at f = 0.55 it is off by {other:+.3f} then. "
            f"After {looks[1]:,} it is off by {late:+.3f}."
        )
        if abs(soon) > max(abs(late), abs(other)):
            sentences.append("The swarm settles as this fades.")
    if all(d.verdict != NO for d in measures.blacker(evidence, BELOW_ONE, SPARSE)):
        sentences.append("In a sparse network each robot averages over few, and noise outweighs the bias.")
    return " ".join(sentences)


def denser_first(evidence: Evidence, details: Sequence[Detail]) -> str:
    """Which settings density makes faster and slower, and whether the slower ones have settled at all."""
    sooner, later = ([d for d in details if d.verdict == which] for which in (YES, NO))
    sentences = [f"Beyond doubt, robots settle {_parts(('sooner', sooner), ('later', later))}."]
    ticks = float(evidence.datasets["moving"]["checkpoint"].values[-1])
    settled = min(
        float(measures.at(evidence, K, density, f, accuracy)[0])
        for accuracy, f in map(_swarm, later)
        for density in (D1, D10)
    )
    if settled > LATE * ticks:
        sentences.append(
            "Those that are later have not settled when the run ends: their medians are "
            f"{100 * settled / ticks:.1f} % of it or more, and K is when the last jump came. An estimate jumps when "
            "the robots around it change and the new ones have seen otherwise, which in a crowd happens all the time."
        )
    closer = [
        d
        for d, (accuracy, f) in zip(later, map(_swarm, later), strict=True)
        if evidence.judge("", _error_ratio(evidence, accuracy, f), BELOW_ONE).verdict == YES
    ]
    those = counted(len(later), "setting")
    sentences.append(f"The error of their estimates falls beyond doubt in {len(closer)} of these {those}.")
    return " ".join(sentences)


def denser_alike(evidence: Evidence, details: Sequence[Detail]) -> str:
    """Which errors density changes, by which factor, and by how much in absolute terms."""
    fall, rise = _sides(details)
    sentences = [f"Beyond the margin, median errors {_parts(('fall', fall), ('rise', rise))}."]
    if fall and not rise:
        sentences.append("In a crowd each robot averages over more neighbours.")
    both = {
        d.setting: [float(measures.at(evidence, ERROR, density, f, a)[0]) for density in (D1, D10)]
        for d, (a, f) in zip(details, map(_swarm, details), strict=True)
    }
    most = max(both, key=lambda name: abs(both[name][1] - both[name][0]))
    sentences.append(
        f"In absolute terms, the largest change of all is from {both[most][0]:.4f} to {both[most][1]:.4f} ({most})."
    )
    return " ".join(sentences)


def mixed_consensus(evidence: Evidence, details: Sequence[Detail]) -> str:
    """How many robots are wrong in how many trials, and whether these swarms had been unanimous before."""
    sentences, largest = [], 0.0
    for d in details:
        if d.verdict != NO:
            continue
        f = float(d.setting.removeprefix("f = "))
        right = measures.right_robots(evidence, D1, f, MIXED)
        final = evidence.values("moving", "final_estimate", density=1.0, robots=25, accuracy=MIXED, fill_ratio=f)
        split = np.flatnonzero(right[:, -1] < 1)
        low, high = right_bin(f)
        wrong = sorted(((final[split] < low) | (final[split] >= high)).sum(axis=1).tolist())
        before = int((right[split, :-1] == 1).any(axis=1).sum())
        largest = max(largest, *(1.0 - right[split, -1]))
        sentences.append(
            f"At f = {f}, not unanimous in the end: {len(split)} of {len(right)} swarms, "
            f"with {_span(wrong)} of {final.shape[1]} robots wrong. "
            f"Unanimous at an earlier checkpoint had been {before} of them."
        )
    if largest <= FEW:
        sentences.append(
            "Few robots make the difference: one whose sensor is poor goes by what those around it believe, and for "
            "a while these may be few, or poor themselves."
        )
    return " ".join(sentences)


def _error_ratio(evidence: Evidence, accuracy: str, fill: float) -> Floats:
    above, below = (measures.at(evidence, ERROR, density, fill, accuracy) for density in (D10, D1))
    return measures.ratio(above, below)


def _swarm(detail: Detail) -> tuple[str, float]:
    accuracy, _, fill = detail.setting.rpartition(", f = ")
    return accuracy, float(fill)


def _sides(details: Sequence[Detail]) -> tuple[list[Detail], list[Detail]]:
    """Settings on the wrong side of the threshold: those with a ratio below 1, and those above."""
    wrong = [d for d in details if d.verdict == NO]
    return [d for d in wrong if d.value < 1], [d for d in wrong if d.value >= 1]


def _parts(*parts: tuple[str, Sequence[Detail]]) -> str:
    """What happens in which settings, and by how much, such as "later in 1 setting, by 0.6 % (...)"."""
    return " and ".join(f"{what} {_where(details)}" for what, details in parts)


def _where(details: Sequence[Detail]) -> str:
    if not details:
        return "in none"
    by = _span([f"{100 * abs(d.value - 1):.1f}" for d in sorted(details, key=lambda d: abs(d.value - 1))])
    return f"in {counted(len(details), 'setting')}, by {by} % ({'; '.join(d.setting for d in details)})"


def _span(ordered: Sequence[object]) -> str:
    first, last = str(ordered[0]), str(ordered[-1])
    return first if first == last else f"{first} to {last}"
