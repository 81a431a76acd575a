"""What chance decides for trials of a setting: sensors, links, groups of robots, failures, speeds, floors.

Each function takes the setting and the study's seed. Numbers of a trial do not depend on which other trials are drawn.
"""

from collections.abc import Sequence

import numpy as np

from swarmcensus import theory
from swarmcensus.engine import Links, address, compile_world
from swarmcensus.engine.constants import LISTED, SENSING
from swarmcensus.studies import Setting, addresses
from swarmcensus.worlds import Accuracy, Chance, Floor, Ground, Misjudgement, Topology, faults

Sides = tuple[np.ndarray, ...]
Where = tuple[int, int, int, int]  # seed, first trial, trials, robots


def groups(setting: Setting, seed: int, first: int, trials: int) -> np.ndarray:
    """Which table of members each robot belongs to (trial, robot): counted from 1, and 0 for none.

    Robots are drawn for each trial, by random numbers that depend only on the size of the swarm. So a larger share
    includes the robots of a smaller one.
    """
    robots = setting.robots
    drawn = np.empty((trials, robots))
    compile_world().draw_uniform(address(seed, "members", robots=robots), first, 0.0, 1.0, drawn)
    order = np.argsort(drawn, axis=1, kind="stable")
    out = np.zeros((trials, robots), np.int64)
    begin = 0
    for number, member in enumerate(setting.members, start=1):
        end = begin + member.count(robots)
        np.put_along_axis(out, order[:, begin:end], number, axis=1)
        begin = end
    return out


def links(setting: Setting, seed: int, first: int, trials: int) -> Links:
    """The links of these trials: who hears whom. Raises ValueError if no graph can be made."""
    topology = Topology("full") if setting.brain.is_oracle else setting.topology
    found = topology.links(setting.robots, seed, first, trials, setting.hears_all, setting.additive)
    is_whole = setting.missing_links == 0.0 or setting.brain.is_oracle
    return found if is_whole else _without_missing(setting, found, seed, first, trials)


def _without_missing(setting: Setting, whole: Links, seed: int, first: int, trials: int) -> Links:
    """The links that are not missing. A pair of neighbours has one draw, so a larger share lacks all of a smaller."""
    robots = setting.robots
    if whole.mode != LISTED:
        everyone = (ends.astype(np.uint32) for ends in np.nonzero(~np.eye(robots, dtype=np.bool_)))
        whole = Links(LISTED, np.array([0, robots * (robots - 1)]), *everyone)
    key = address(seed, "missing links", topology=setting.topology.content, robots=robots)
    kept, starts = [], [0]
    for k in range(trials):
        graph = slice(*(whole.starts if whole.starts.size == 2 else whole.starts[k : k + 2]))
        ends = np.stack([whole.receivers[graph], whole.senders[graph]]).astype(np.int64)
        pairs, which = np.unique(ends.min(axis=0) * robots + ends.max(axis=0), return_inverse=True)
        there = Chance(key, first + k).uniform(len(pairs))[which] >= setting.missing_links
        kept.append(np.flatnonzero(there) + graph.start)
        starts.append(starts[-1] + len(kept[-1]))
    chosen = np.concatenate(kept)
    return Links(LISTED, np.array(starts), whole.receivers[chosen], whole.senders[chosen])


def stops(setting: Setting, seed: int, trial: int) -> np.ndarray:
    """When parts of robots fail, as `swarmcensus.worlds.faults.stops` gives it."""
    times = faults.stops(setting.faults, seed, trial, setting.robots)
    if not setting.brain.is_oracle:
        return times
    lies = np.array([False, *(not m.honest for m in setting.members)])
    return faults.for_an_oracle(times, lies[groups(setting, seed, trial, 1)[0]])


def working(setting: Setting, seed: int, trial: int) -> np.ndarray:
    """Which honest robots of a trial still observe after the last round."""
    times, last = stops(setting, seed, trial), setting.rounds
    honest = np.array([True, *(m.honest for m in setting.members)]).take(groups(setting, seed, trial, 1)[0])
    if not times.size:
        return np.ones(honest.sum(), np.bool_)
    spells = faults.outages(times)[:, :, SENSING]
    down = ((spells[:, 0] <= last) & (spells[:, 1] > last)).any(axis=0) if len(spells) else times[SENSING] <= last
    return np.asarray(~np.asarray(down)[honest])


def speeds(setting: Setting, seed: int, trial: int) -> np.ndarray:
    """The distance that each robot drives straight ahead in a tick, in metres (robot); empty on fixed networks."""
    if setting.body is None:
        return np.zeros(0)
    found = np.full(setting.robots, setting.body.speed)
    group = groups(setting, seed, trial, 1)[0] if setting.members else None
    for number, member in enumerate(setting.members, start=1):
        if member.speed is not None:
            found[group == number] = member.speed
    return found * setting.body.tick


def ground(setting: Setting, seed: int, trial: int) -> Ground:
    """The floor of a trial; only of robots that move."""
    setting = addresses.in_trial(setting, seed, trial)
    assert setting.body is not None
    floor, side, key = setting.floor or Floor(), setting.arena_side, addresses.floor_key(setting, seed)
    last = min(setting.rounds, setting.change.end) if setting.change else 1
    return Ground(floor, setting.body, side, setting.fill_ratios(np.arange(1, last + 1)), key, trial)


def accuracies(setting: Setting, seed: int, first: int, trials: int) -> Sides:
    """True b and w, then assumed b and w, each (trial, robot) or (trial, 1)."""
    where = (seed, first, trials, setting.robots)
    if any(m.accuracy or m.assumed_accuracy for m in setting.members):
        drawn = _of_members(setting, groups(setting, seed, first, trials), where)
    else:
        drawn = _of_swarm(setting, where)
    return drawn[:2] * 2 if setting.brain.is_oracle else drawn


def belief_error(setting: Setting, seed: int, first: int, trials: int) -> float:
    """The error that wrong beliefs leave in a swarm that pools all readings (`theory.belief_error`).

    NaN if robots know their sensors, or f is not one number.
    """
    beliefs = [setting.assumed_accuracy, *(member.assumed_accuracy for member in setting.members)]
    if setting.spread or setting.change or not any(beliefs):
        return float("nan")
    return theory.belief_error(setting.fill_ratio, *accuracies(setting, seed, first, trials))[1]


def drifts(setting: Setting, seed: int, first: int, trials: int, start: np.ndarray) -> np.ndarray:
    """How robots' accuracies drift: their gain a round, their least and their greatest, (trial, 3, robot).

    (trial, 3, 1) where all robots drift equally, (trial, 3, 0) where none drifts. `start` is b of round 1, (trial,
    robot) or (trial, 1). An accuracy that starts beyond its bound stays.
    """
    kinds = [setting.accuracy, *(member.accuracy or setting.accuracy for member in setting.members)]
    if all(accuracy.drift is None for accuracy in kinds):
        return np.zeros((len(start), 3, 0))
    differ = any(member.accuracy for member in setting.members)
    numbers = np.array([(0.0, 0.0, 1.0) if a.drift is None else a.drift.numbers for a in kinds])
    which = groups(setting, seed, first, trials) if differ else np.zeros(start.shape, int)
    slope, least, most = np.moveaxis(numbers[which], -1, 0)
    return np.ascontiguousarray(np.stack([slope, np.minimum(least, start), np.maximum(most, start)], axis=1))


def _of_swarm(setting: Setting, where: Where) -> Sides:
    """The accuracies where members have none of their own. Without assumed ones, robots know theirs."""
    own, assumed = _drawn(setting.accuracy, "accuracy", where, ()), setting.assumed_accuracy
    return *own, *(own if assumed is None else _drawn(assumed, "assumed", where, own))


def _of_members(setting: Setting, group: np.ndarray, where: Where) -> Sides:
    """The accuracies where members have some of their own: they assume what their table says, else what the swarm does.

    `group` (trial, robot) is from `groups`.
    """
    of_swarm = [np.broadcast_to(side, group.shape) for side in _of_swarm(setting, where)]
    own, assumed = of_swarm[:2], setting.assumed_accuracy
    for number, member in enumerate(setting.members, start=1):
        if member.accuracy:
            drawn = _drawn(member.accuracy, f"accuracy of members {number}", where, ())
            own = _replaced(group == number, drawn, own)
    believed = own if assumed is None else of_swarm[2:]
    for number, member in enumerate(setting.members, start=1):
        belief = member.assumed_accuracy
        if not belief and member.accuracy and isinstance(assumed, Misjudgement):
            belief = assumed
        if belief:
            drawn = _drawn(belief, f"assumed by members {number}", where, own)
            believed = _replaced(group == number, drawn, believed)
    return tuple(np.ascontiguousarray(side) for side in (*own, *believed))


def _drawn(what: Accuracy | Misjudgement, purpose: str, where: Where, true: Sequence[np.ndarray]) -> Sides:
    seed, first, trials, robots = where
    if isinstance(what, Misjudgement):
        return what.draw(seed, first, trials, robots, (true[0], true[1]))
    return what.draw(seed, purpose, first, trials, robots)


def _replaced(which: np.ndarray, new: Sequence[np.ndarray], old: Sequence[np.ndarray]) -> list[np.ndarray]:
    return [np.where(which, after, before) for after, before in zip(new, old, strict=True)]
