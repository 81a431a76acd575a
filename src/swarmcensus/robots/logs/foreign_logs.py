"""Logs that are not of their folder's recording: by robots' numbers, the times of their starts, sensors and brains."""

import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from swarmcensus.robots.logs.folders import LoggedRobot, Recording
from swarmcensus.robots.logs.lives import RobotReplay

APART = 60_000  # ms by which the clocks of robots and of swarm.json may differ
INEXACT = 1e-5  # of accuracies that are written in decimal digits


class Stranger(NamedTuple):
    """A robot whose log is not of the recording, and why."""

    robot: int
    reason: str


def strangers_of(recording: Recording, lives: Sequence[RobotReplay]) -> list[Stranger]:
    """The robots whose logs are not of this recording, by number."""
    found = []
    for member, life in zip(recording.members, lives, strict=True):
        if why := next(_reasons(member, life, recording.about), None):
            found.append(Stranger(member.number, why))
    return found


def _reasons(member: LoggedRobot, life: RobotReplay, about: Mapping[str, Any]) -> Iterator[str]:
    """Why a robot's log is not of the recording. A brain of another hash only counts where states differ."""
    logs = {one["number"]: one for one in about.get("robots", []) if "number" in one}
    entry = logs.get(member.number, {})
    if logs and entry.get("log") != member.log.path.name:
        yield f"swarm.json has {entry.get('log', 'no log')} as that of robot {member.number}"
    first, began, ended = member.log.states[0], about.get("started"), about.get("ended")
    for state in member.log.states:
        if state.starts and state.now and began is not None and state.now < began - APART:
            yield f"it started on {_date(state.now)}, and the swarm on {_date(began)}"
        if state.starts and state.now and ended is not None and state.now > ended + APART:
            yield f"it started on {_date(state.now)}, and the swarm ended on {_date(ended)}"
    for key in ("b", "w"):
        stated, own = entry.get(key), getattr(first, key)
        if isinstance(stated, int | float) and abs(own - stated) > INEXACT:
            yield f"its log has {key} = {own:g}, and swarm.json {stated:g}"
    if life.breaks and first.brain != bytes(8) and not member.brain.sha256.startswith(first.brain.hex()):
        hashes = f"{first.brain.hex()}, and that of {member.brain.path} with {member.brain.sha256[:16]}"
        yield f"the hash of its brain's file begins with {hashes}"


def _date(ms: float) -> str:
    try:
        return time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(ms / 1000))
    except (ValueError, OverflowError, OSError):
        return f"an impossible date, {ms:g} ms since 1970"
