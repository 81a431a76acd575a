"""How claims about rivals are measured: a statistic of each setting, and its comparison between settings.

A contender is the name of a study and the coordinates that select its brain; a world is the coordinates of floor and
network. An event that did not happen within a trial counts as if in the last round, so that times are lower bounds.
"""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from swarmcensus.evaluation.paper.evidence import Detail, Evidence, Missing, Range
from swarmcensus.evaluation.paper.measures import ratio
from swarmcensus.support.intervals import Floats, medians

Contender = tuple[str, Mapping[str, Any]]
World = Mapping[str, Any]
Number = Callable[..., Floats]  # statistic of a setting: its value in the sample, then in every resample
QUORUM = 0.8  # share of a swarm; our choice
TITLES = {"fill_ratio": "f"}


def compared(
    evidence: Evidence,
    right: Range,
    of: Number,
    first: Contender,
    others: Sequence[Contender],
    worlds: Sequence[World],
    how: Callable[[Floats, Floats], Floats],
) -> Iterator[Detail]:
    """A statistic of the first contender compared with that of each other one, in each world."""
    for world, other in itertools.product(worlds, others):
        name = f"{label_of(first, other)} and {label_of(other, first)}, {world_label(world)}"
        yield evidence.judge(name, how(*(_of(evidence, of, each, world) for each in (first, other))), right)


ratios = partial(compared, how=ratio)  # NaN where the divisor is 0
differences = partial(compared, how=np.subtract)


def numbers(
    evidence: Evidence, right: Range, of: Number, contenders: Sequence[Contender], worlds: Sequence[World]
) -> Iterator[Detail]:
    """A statistic of each contender by itself."""
    for world in worlds:
        for contender in contenders:
            name = f"{label_of(contender)}, {world_label(world)}"
            yield evidence.judge(name, _of(evidence, of, contender, world), right)


def growths(
    evidence: Evidence,
    right: Range,
    of: Number,
    contenders: Sequence[Contender],
    worlds: Sequence[tuple[World, World]],
) -> Iterator[Detail]:
    """A statistic in the second of two worlds divided by that in the first."""
    for before, after in worlds:
        for contender in contenders:
            change = ratio(_of(evidence, of, contender, after), _of(evidence, of, contender, before))
            name = f"{label_of(contender)}, {world_label(after)} / {world_label(before)}"
            yield evidence.judge(name, change, right)


def spared(
    evidence: Evidence, right: Range, first: Contender, second: Contender, worlds: Sequence[World], liars: int
) -> Iterator[Detail]:
    """The loss of right robots by `liars` liars: that of the second contender minus that of the first."""
    for world in worlds:
        lost = [
            _of(evidence, right_robots, contender, {**world, "liars": 0})
            - _of(evidence, right_robots, contender, {**world, "liars": liars})
            for contender in (first, second)
        ]
        yield evidence.judge(world_label(world), lost[1] - lost[0], right)


def pattern_against_share(
    evidence: Evidence, right: Range, contenders: Sequence[Contender], patterned: World, plain: World, harder: World
) -> Iterator[Detail]:
    """The slowdown by a pattern of the floor divided by the slowdown by a harder fill ratio."""
    for contender in contenders:
        longer, base, slow = (_of(evidence, consensus_time, contender, world) for world in (patterned, plain, harder))
        yield evidence.judge(label_of(contender), (longer / base) / (slow / base), right)


def consensus_time(evidence: Evidence, study: str, **where: object) -> Floats:
    """The median round of a first consensus, right or wrong."""
    rounds = evidence.values(study, "consensus_round", **where)
    return medians(np.minimum(rounds, _last(evidence, study, where))[:, np.newaxis], evidence.counts)


def decision_time(evidence: Evidence, study: str, **where: object) -> Floats:
    """The mean round of a robot's first decision."""
    rounds = evidence.values(study, "decision_round", **where)
    return evidence.mean(np.minimum(rounds, _last(evidence, study, where)).mean(axis=1))


def settling_time(evidence: Evidence, study: str, **where: object) -> Floats:
    """The median K."""
    return evidence.median(study, "convergence_round", **where)


def consensus_right(evidence: Evidence, study: str, **where: object) -> Floats:
    """The share of trials with a right first consensus, among those that have a right option."""
    consensus, option = _whole(evidence, study, "consensus", where), evidence.column(study, "right_option", **where)
    return evidence.share(consensus == option, ~np.isnan(option))


def none_agreed(evidence: Evidence, study: str, **where: object) -> Floats:
    """The share of trials without a consensus."""
    consensus = _whole(evidence, study, "consensus", where)
    return evidence.share(consensus < 0, np.ones(len(consensus)))


def right_robots(evidence: Evidence, study: str, **where: object) -> Floats:
    """The share of all robots that have decided for the right option at the end."""
    decisions, option = _decisions(evidence, study, where)
    return evidence.share((decisions == option).sum(axis=1), np.isfinite(option[:, 0]) * decisions.shape[1])


def right_deciders(evidence: Evidence, study: str, **where: object) -> Floats:
    """The share of robots that have decided for the right option, among those that have decided at the end."""
    decisions, option = _decisions(evidence, study, where)
    return evidence.share((decisions == option).sum(axis=1), np.isfinite(option[:, 0]) * (decisions >= 0).sum(axis=1))


def quorums(evidence: Evidence, study: str, **where: object) -> Floats:
    """The share of trials that end with QUORUM of the robots for one colour."""
    decisions, _ = _decisions(evidence, study, where)
    most = np.maximum((decisions == 0).mean(axis=1), (decisions == 1).mean(axis=1))
    return evidence.share(most >= QUORUM, np.ones(len(decisions)))


def final_error(evidence: Evidence, study: str, **where: object) -> Floats:
    """The mean error of final estimates, from the floor's own fill ratio where the study's `truth` is "floor"."""
    data = evidence.setting(study, **where)
    floors = data.attrs.get("truth") == "floor"
    truth = evidence.values(study, "true_fill_ratio", **where) if floors else np.full(evidence.trials, data.fill_ratio)
    estimates = evidence.values(study, "final_estimate", **where)
    return evidence.mean(np.abs(estimates - truth[:, np.newaxis]).mean(axis=1))


def world_label(world: World) -> str:
    """A world in words, such as "f = 0.55, tiles"."""
    return ", ".join(_coordinate(name, value) for name, value in world.items())


def _coordinate(name: str, value: Any) -> str:
    if name == "liars":
        return f"{value or 'no'} liar{'s' * (value > 1)}"
    return value if isinstance(value, str) else f"{TITLES.get(name, name)} = {value:g}"


def label_of(contender: Contender, other: Contender = ("", {})) -> str:
    """A contender in words, by the coordinates that differ from another's, such as "w-msr" or "threshold = 0.99"."""
    study, coordinates = contender
    own = {key: value for key, value in coordinates.items() if other[1].get(key) != value}
    return world_label(own) if own else study


def _of(evidence: Evidence, of: Number, contender: Contender, world: World) -> Floats:
    study, brain = contender
    return of(evidence, study, **brain, **world)


def _last(evidence: Evidence, study: str, where: Mapping[str, object]) -> float:
    return float(evidence.setting(study, **where)["rounds"])


def _whole(evidence: Evidence, study: str, variable: str, where: Mapping[str, object]) -> Floats:
    """A variable of one setting. Raises Missing if trials were not run."""
    values = evidence.column(study, variable, **where)
    if np.isnan(values).any():  # a trial that was never run; -1 means no option
        raise Missing(f"{study}: trials with {where}")
    return values


def _decisions(evidence: Evidence, study: str, where: Mapping[str, object]) -> tuple[Floats, Floats]:
    """Decisions at the end (trial, robot), and the right option (trial, 1), NaN if there is none."""
    option = evidence.column(study, "right_option", **where)
    return _whole(evidence, study, "decision", where), option[:, np.newaxis]
