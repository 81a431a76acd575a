"""How claims about rivals are measured: a number of each setting, and settings held against each other.

A contender is a study's name and the coordinates that pick its brain there; a world is the coordinates of the floor and
the network. What never came within a trial counts as its last round, so that times are bounded from below.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from swarmcensus.paper.evidence import Detail, Evidence, Missing, Range
from swarmcensus.paper.measures import ratio
from swarmcensus.statistics.intervals import Floats, medians

Contender = tuple[str, Mapping[str, Any]]
World = Mapping[str, Any]
Number = Callable[..., Floats]  # of a setting: the sample's, then every resample's
QUORUM = 0.8  # of a swarm: a choice of ours
TITLES = {"fill_ratio": "f"}


def ratios(
    evidence: Evidence,
    right: Range,
    of: Number,
    first: Contender,
    others: Sequence[Contender],
    worlds: Sequence[World],
) -> Iterator[Detail]:
    """A number of the first contender over that of each other one; NaN where the latter is 0."""
    for name, above, below in _pairs(evidence, of, first, others, worlds):
        yield evidence.judge(name, ratio(above, below), right)


def differences(
    evidence: Evidence,
    right: Range,
    of: Number,
    first: Contender,
    others: Sequence[Contender],
    worlds: Sequence[World],
) -> Iterator[Detail]:
    """A number of the first contender less that of each other one."""
    for name, above, below in _pairs(evidence, of, first, others, worlds):
        yield evidence.judge(name, above - below, right)


def numbers(
    evidence: Evidence, right: Range, of: Number, contenders: Sequence[Contender], worlds: Sequence[World]
) -> Iterator[Detail]:
    """A number of each contender by itself."""
    for world in worlds:
        for one in contenders:
            yield evidence.judge(f"{named(one)}, {told(world)}", _of(evidence, of, one, world), right)


def growths(
    evidence: Evidence,
    right: Range,
    of: Number,
    contenders: Sequence[Contender],
    worlds: Sequence[tuple[World, World]],
) -> Iterator[Detail]:
    """What a number comes to in the second of two worlds, over what it is in the first."""
    for before, after in worlds:
        for one in contenders:
            change = ratio(_of(evidence, of, one, after), _of(evidence, of, one, before))
            yield evidence.judge(f"{named(one)}, {told(after)} / {told(before)}", change, right)


def spared(
    evidence: Evidence, right: Range, first: Contender, second: Contender, worlds: Sequence[World], liars: int
) -> Iterator[Detail]:
    """How many more right robots so many that malfunction cost the second than the first."""
    for world in worlds:
        lost = [
            _of(evidence, right_robots, one, {**world, "liars": 0})
            - _of(evidence, right_robots, one, {**world, "liars": liars})
            for one in (first, second)
        ]
        yield evidence.judge(told(world), lost[1] - lost[0], right)


def pattern_against_share(
    evidence: Evidence, right: Range, contenders: Sequence[Contender], patterned: World, plain: World, harder: World
) -> Iterator[Detail]:
    """How many times as long a pattern takes, over how many times as long a harder share of black does."""
    for one in contenders:
        longer, base, slow = (_of(evidence, consensus_time, one, world) for world in (patterned, plain, harder))
        yield evidence.judge(named(one), (longer / base) / (slow / base), right)


def consensus_time(evidence: Evidence, study: str, **where: object) -> Floats:
    """The median round of a first consensus, right or wrong."""
    found = evidence.values(study, "consensus_round", **where)
    return medians(np.minimum(found, _last(evidence, study, where))[:, np.newaxis], evidence.counts)


def decision_time(evidence: Evidence, study: str, **where: object) -> Floats:
    """The mean round of a robot's first decision."""
    found = evidence.values(study, "decision_round", **where)
    return evidence.mean(np.minimum(found, _last(evidence, study, where)).mean(axis=1))


def settling_time(evidence: Evidence, study: str, **where: object) -> Floats:
    """The median K."""
    return evidence.median(study, "convergence_round", **where)


def consensus_right(evidence: Evidence, study: str, **where: object) -> Floats:
    """The share of trials whose first consensus is right, of those in which one of the options is."""
    found, option = _whole(evidence, study, "consensus", where), evidence.column(study, "right_option", **where)
    return evidence.share(found == option, ~np.isnan(option))


def none_agreed(evidence: Evidence, study: str, **where: object) -> Floats:
    """The share of trials without a consensus."""
    found = _whole(evidence, study, "consensus", where)
    return evidence.share(found < 0, np.ones(len(found)))


def right_robots(evidence: Evidence, study: str, **where: object) -> Floats:
    """The share of robots that are decided for what is right at the end, of all."""
    found, option = _decisions(evidence, study, where)
    return evidence.share((found == option).sum(axis=1), np.isfinite(option[:, 0]) * found.shape[1])


def right_deciders(evidence: Evidence, study: str, **where: object) -> Floats:
    """The same of those that are decided at all."""
    found, option = _decisions(evidence, study, where)
    return evidence.share((found == option).sum(axis=1), np.isfinite(option[:, 0]) * (found >= 0).sum(axis=1))


def quorums(evidence: Evidence, study: str, **where: object) -> Floats:
    """The share of trials that end with QUORUM of the robots for one colour."""
    found, _ = _decisions(evidence, study, where)
    most = np.maximum((found == 0).mean(axis=1), (found == 1).mean(axis=1))
    return evidence.share(most >= QUORUM, np.ones(len(found)))


def final_error(evidence: Evidence, study: str, **where: object) -> Floats:
    """The mean distance of a final estimate from the fill ratio, of the floor where the study asks for that."""
    data = evidence.setting(study, **where)
    floors = data.attrs.get("truth") == "floor"
    truth = evidence.values(study, "true_fill_ratio", **where) if floors else np.full(evidence.trials, data.fill_ratio)
    found = evidence.values(study, "final_estimate", **where)
    return evidence.mean(np.abs(found - truth[:, np.newaxis]).mean(axis=1))


def told(world: World) -> str:
    """A world in words: "f = 0.55, tiles"."""
    return ", ".join(_said(name, value) for name, value in world.items())


def _said(name: str, value: Any) -> str:
    if name == "liars":
        return f"{value or 'no'} liar{'s' * (value > 1)}"
    return value if isinstance(value, str) else f"{TITLES.get(name, name)} = {value:g}"


def named(one: Contender, beside: Contender = ("", {})) -> str:
    """A contender in words, by what it has not in common with another: "w-msr", "threshold = 0.99"."""
    own = {key: value for key, value in one[1].items() if beside[1].get(key) != value}
    return told(own) if own else one[0]


def _pairs(
    evidence: Evidence, of: Number, first: Contender, others: Sequence[Contender], worlds: Sequence[World]
) -> Iterator[tuple[str, Floats, Floats]]:
    for world in worlds:
        for other in others:
            sides = (_of(evidence, of, one, world) for one in (first, other))
            yield (f"{named(first, other)} and {named(other, first)}, {told(world)}", *sides)  # type: ignore[misc]


def _of(evidence: Evidence, of: Number, one: Contender, world: World) -> Floats:
    study, brain = one
    return of(evidence, study, **brain, **world)


def _last(evidence: Evidence, study: str, where: Mapping[str, object]) -> float:
    return float(evidence.setting(study, **where)["rounds"])


def _whole(evidence: Evidence, study: str, variable: str, where: Mapping[str, object]) -> Floats:
    found = evidence.column(study, variable, **where)
    if np.isnan(found).any():  # -1 is no option; NaN a trial that was never run
        raise Missing(f"{study}: trials with {where}")
    return found


def _decisions(evidence: Evidence, study: str, where: Mapping[str, object]) -> tuple[Floats, Floats]:
    """Decisions at the end (trial, robot), and the right one (trial, 1): NaN where none is."""
    option = evidence.column(study, "right_option", **where)
    return _whole(evidence, study, "decision", where), option[:, np.newaxis]
