"""Logs that are not of their folder's recording: by times, numbers and sensors of robots."""

import time
from collections.abc import Mapping
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
        entry = entries.get(member.number, {})
        if why := (
            _wrong_number(member, recording.about)
            or _wrong_time(member, entry, recording.about)
            or _wrong_sensor(member, entry)
        ):
            found.append(Stranger(member.number, why))
    return sorted(found)


def _wrong_number(member: LoggedRobot, about: Mapping[str, Any]) -> str | None:
    """Why a robot is none of those in swarm.json."""
    entries = {str(one["log"]).lower(): one["number"] for one in about.get("robots", []) if "number" in one}
    named = entries.get(member.log.path.name.lower(), member.number)
    if named != member.number:
        return f"{member.log.path.name} is the log of robot {named} in swarm.json"
    return None if not entries or member.number in entries.values() else "swarm.json has no robot of this number"


def _wrong_time(member: LoggedRobot, entry: Mapping[str, Any], about: Mapping[str, Any]) -> str | None:
    """Why a robot's starts are not in the time of swarm.json; robots may not know the time."""
    begun, ended = about.get("started"), about.get("ended")
    apart = APART_HERE if "runs_on" in entry else APART
    for state in member.log.states:
        if state.starts and state.now:
            if begun is not None and state.now < begun - apart:
                return f"it started on {_date(state.now)}, and the swarm on {_date(begun)}"
            if ended is not None and state.now > ended + apart:
                return f"it started on {_date(state.now)}, and the swarm ended on {_date(ended)}"
    return None


def _wrong_sensor(member: LoggedRobot, entry: Mapping[str, Any]) -> str | None:
    """Why a robot has another sensor than in swarm.json."""
    for key in ("b", "w"):
        told = entry.get(key)
        for state in member.log.states:
            own = getattr(state, key)
            if isinstance(told, int | float) and abs(own - told) > INEXACT:
                return f"its log has {key} = {own:g}, and swarm.json {told:g}"
    return None


def _date(ms: float) -> str:
    try:
        return time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(ms / 1000))
    except (ValueError, OverflowError, OSError):
        return f"an impossible date, {ms:g} ms since 1970"
