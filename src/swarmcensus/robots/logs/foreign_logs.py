"""Logs that are not of their folder's recording: by times, numbers and sensors of robots."""

import time
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from swarmcensus.robots.logs.folders import LoggedRobot, Recording

APART = 60_000  # ms by which the clocks of robots and of swarm.json may differ
APART_HERE = 2_000  # the same where one machine ran them: from the first order to the start, and the end of processes
INEXACT = 1e-5  # of accuracies that are written in decimal digits


class Stranger(NamedTuple):
    """A robot whose log is not of the recording, and why."""

    robot: int
    reason: str


def strangers_of(recording: Recording) -> list[Stranger]:
    """The robots whose logs are not of this recording, by number."""
    entries = {one["number"]: one for one in recording.about.get("robots", []) if "number" in one}
    found = []
    for member in recording.members:
        if why := next(_reasons(member, entries.get(member.number, {}), recording.about), None):
            found.append(Stranger(member.number, why))
    return sorted(found)


def _reasons(member: LoggedRobot, entry: Mapping[str, Any], about: Mapping[str, Any]) -> Iterator[str]:
    """Why a robot's log is not of the recording: its number, the times of its starts, or its sensor.

    `entry` is what swarm.json says of the robot. Robots may not know the time.
    """
    numbers = {str(one["log"]).lower(): one["number"] for one in about.get("robots", []) if "number" in one}
    named = numbers.get(member.log.path.name.lower(), member.number)
    if named != member.number:
        yield f"{member.log.path.name} is the log of robot {named} in swarm.json"
    elif numbers and member.number not in numbers.values():
        yield "swarm.json has no robot of this number"
    begun, ended = about.get("started"), about.get("ended")
    apart = APART_HERE if "runs_on" in entry else APART
    for state in member.log.states:
        if state.starts and state.now:
            if begun is not None and state.now < begun - apart:
                yield f"it started on {_date(state.now)}, and the swarm on {_date(begun)}"
            if ended is not None and state.now > ended + apart:
                yield f"it started on {_date(state.now)}, and the swarm ended on {_date(ended)}"
    for key in ("b", "w"):
        stated = entry.get(key)
        for state in member.log.states:
            own = getattr(state, key)
            if isinstance(stated, int | float) and abs(own - stated) > INEXACT:
                yield f"its log has {key} = {own:g}, and swarm.json {stated:g}"


def _date(ms: float) -> str:
    try:
        return time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(ms / 1000))
    except (ValueError, OverflowError, OSError):
        return f"an impossible date, {ms:g} ms since 1970"
