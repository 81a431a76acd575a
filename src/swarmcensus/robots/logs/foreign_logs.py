"""Logs that are not of their folder's recording: by robots' numbers, the times of their starts, sensors and brains."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np

from swarmcensus.robots.logs.folders import LoggedRobot, Recording

APART = 60_000  # ms by which the clocks of robots and of swarm.json may differ
INEXACT = 1e-5  # of accuracies that are written in decimal digits


def strangers_of(recording: Recording, differ: Collection[int] = ()) -> dict[int, str]:
    """Why logs are not of this recording, by the numbers of their robots; `differ`: those with states that differ."""
    why = {one.number: next(_reasons(one, one.number in differ, recording.about), "") for one in recording.members}
    return {number: reason for number, reason in why.items() if reason}


def _reasons(member: LoggedRobot, differs: bool, about: Mapping[str, Any]) -> Iterator[str]:
    """Why a robot's log is not of the recording. A brain of another hash only counts where states differ."""
    logs = {one["number"]: one for one in about.get("robots", []) if "number" in one}
    entry = logs.get(member.number, {})
    if logs and entry.get("log") != member.log.path.name:
        yield f"swarm.json has {entry.get('log', 'no log')} as that of robot {member.number}"
    first, began, ended = member.log.states[0], about.get("started"), about.get("ended")
    for start in (state.now for state in member.log.states if state.starts and state.now):
        if began is not None and start < began - APART:
            yield f"it started on {_date(start)}, and the swarm on {_date(began)}"
        if ended is not None and start > ended + APART:
            yield f"it started on {_date(start)}, and the swarm ended on {_date(ended)}"
    for key in ("b", "w"):
        stated, own = entry.get(key), getattr(first, key)
        if isinstance(stated, int | float) and abs(own - stated) > INEXACT:
            yield f"its log has {key} = {own:g}, and swarm.json {stated:g}"
    if differs:
        yield from other_hashes(member)


def other_hashes(member: LoggedRobot) -> Iterator[str]:
    """Which hash the brain's file had on the robot, if it is not that of the file that was run."""
    brain, logged = member.brain, member.log.states[0].brain
    if logged != bytes(8) and not brain.sha256.startswith(logged.hex()):
        hashes = f"{logged.hex()}, and that of {brain.path} with {brain.sha256[:16]}"
        yield f"the hash of its brain's file begins with {hashes}"


def _date(ms: float) -> str:
    return f"{np.datetime64(min(int(ms), 2**62), 'ms').astype('M8[s]')} UTC"
