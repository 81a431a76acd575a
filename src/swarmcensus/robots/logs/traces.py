"""Lives as a trace: every robot's estimate and memory by round, as `replay` and `infer` have it."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from swarmcensus.brains import slots
from swarmcensus.robots.logs.clocks import Clock
from swarmcensus.robots.logs.folders import LoggedRobot, Recording
from swarmcensus.robots.logs.lives import RobotReplay
from swarmcensus.robots.logs.logs import State, Tick
from swarmcensus.robots.logs.other_brain import Relived, brain_of
from swarmcensus.robots.logs.replicas import Unfit, replica_of
from swarmcensus.simulation import trace_of
from swarmcensus.support.errors import ResultsError

MOST_VALUES = 2**26  # of a trace


def as_logged(recording: Recording, lives: Sequence[RobotReplay]) -> Relived:
    """The recording as it was: the estimates of the logs, and the memory of states that were lived again."""
    result = Relived(recording.as_it_was, {}, {})
    for member, life in zip(recording.members, lives, strict=True):
        note_logged(result, member, life)
    return result


def note_logged(result: Relived, member: LoggedRobot, life: RobotReplay, first: int = 0) -> None:
    """Add what the blocks of a robot's log say, from the block `first` on."""
    number, blocks = member.number, member.log.blocks
    estimates, memory = result.estimates.setdefault(number, {}), result.memory.setdefault(number, {})
    for at in range(first, len(blocks)):
        block = blocks[at]
        if isinstance(block, Tick):
            estimates[at] = block.estimate
            if at in life.memory:
                memory[at] = life.memory[at]
            result.sent[number] += block.said is not None
            result.heard[number] += len(block.heard)
            if block.said is not None:
                result.said[number, at] = block.said
            if block.heard:
                result.received[number, at] = [(one.sender, one.code) for one in block.heard]
        elif isinstance(block, State) and block.starts:
            try:
                replica = replica_of(member.brain, block)
            except Unfit:
                continue
            estimates[at], memory[at] = replica.estimate, replica.numbers()


def estimates_of(recording: Recording, lived: Relived, clock: Clock) -> np.ndarray:
    """The estimates (round, robot); NaN where a robot was away, or its log lacks the tick."""
    _check_size(recording, clock, 1)
    out = np.full((clock.rounds + 1, len(recording.members)), np.nan)
    for column, member in enumerate(recording.members):
        for at, estimate in lived.estimates.get(member.number, {}).items():
            row = clock.time(member.number, at)
            if isinstance(member.log.blocks[at], Tick) or np.isnan(out[row, column]):  # a start comes after the tick
                out[row, column] = estimate
    return out


def as_trace(recording: Recording, lived: Relived, clock: Clock) -> xr.Dataset:
    """The trace of a recording."""
    trace = trace_of(_fields(recording, lived, clock), estimates_of(recording, lived, clock), lived.brain)
    trace = trace.assign_coords(robot=[member.number for member in recording.members])
    trace["round"].attrs = {"units": "ticks", "long_name": "tick; 0 is before any observation"}
    if not all(member.honest for member in recording.members):
        says = {"long_name": "1 where metrics count the robot"}
        trace["honest"] = ("robot", np.array([member.honest for member in recording.members], np.int8), says)
    title = f"{recording.title}: {lived.brain.label}"
    trace.attrs |= {"title": title, "bins": recording.bins, "delta": recording.delta}
    if recording.fill_ratio is not None:
        trace.attrs["fill_ratio"] = recording.fill_ratio
    return trace


def _fields(recording: Recording, lived: Relived, clock: Clock) -> dict[str, np.ndarray]:
    """The fields of the brain's memory (round, robot) or (round, robot, item)."""
    shape, lengths = (clock.rounds + 1, len(recording.members)), lived.brain.lengths
    width = len(slots(lengths))
    _check_size(recording, clock, width)
    every = np.full((*shape, width), np.nan)
    for column, member in enumerate(recording.members):
        own = member.brain if lived.brain is recording.as_it_was else brain_of(member, lived.brain)
        if own is not None and own.lengths == lengths:  # a liar remembers more
            for at, numbers in lived.memory.get(member.number, {}).items():
                every[clock.time(member.number, at), column] = numbers
    fields, first = {}, 0
    for name in sorted(lengths):
        size = lengths[name]
        fields[name] = every[..., first : first + size] if size else every[..., first]
        first += size or 1
    return fields


def _check_size(recording: Recording, clock: Clock, width: int) -> None:
    """Raise InputError if so many numbers of each robot and tick are too many, as after a forged tick."""
    if (clock.rounds + 1) * len(recording.members) * width > MOST_VALUES:
        raise ResultsError.of(
            recording.folder, f"its logs span {clock.rounds:,} ticks, too many to keep: is one damaged?"
        )


def ends_of(recording: Recording, lived: Relived) -> np.ndarray:
    """The last estimate of each robot (robot,), NaN if none is known."""
    of_robots = (lived.estimates.get(member.number) or {0: np.nan} for member in recording.members)
    return np.array([estimates[max(estimates)] for estimates in of_robots])


def last_estimates(estimates: np.ndarray) -> np.ndarray:
    """Estimates (round, robot) without gaps: a robot that is away counts with what it last believed.

    Before its first start it counts with what it believes then.
    """
    out = estimates.copy()
    for column in out.T:
        there = np.flatnonzero(~np.isnan(column))
        if there.size:
            place = np.searchsorted(there, np.arange(len(column)), side="right") - 1
            column[:] = column[there[np.maximum(place, 0)]]
    return out


def messages_of_robots(recording: Recording, counts: Mapping[int, int]) -> np.ndarray:
    """How many messages each robot has (robot,)."""
    return np.array([float(counts[member.number]) for member in recording.members])
