"""Logs that are not of their folder's recording: by their times, their robots' numbers, and what robots heard."""

import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from swarmcensus.robots.logs.folders import LoggedRobot, Recording
from swarmcensus.robots.logs.logs import Heard, State, Tick
from swarmcensus.support.formatting import counted

APART = 60_000  # ms by which the clocks of robots and of swarm.json may differ

Pair = tuple[int, int]  # receiver and sender


class Stranger(NamedTuple):
    """A robot whose log is not of the recording, or two of which one is not, and why."""

    robots: tuple[int, ...]
    reason: str


@dataclass
class _Heard:
    """What the logs of senders hold of the messages that robots heard."""

    same: Counter[Pair]
    missing: Counter[Pair]  # in ticks that the sender's log lacks
    other: dict[
        Pair, tuple[int, Heard]
    ]  # the receiver's tick and the first message that the sender's log has otherwise


def strangers_of(recording: Recording) -> list[Stranger]:
    """The robots whose logs are not of this recording, by number. Ticks that a log lacks are no reason."""
    found = [
        Stranger((member.number,), reason)
        for member in recording.members
        if (reason := _unknown(member, recording.about) or _untimely(member, recording.about))
    ]
    heard = _heard(recording, {number for one in found for number in one.robots})
    return sorted([*found, *_without_messages(recording, heard), *_contradicting(heard)])


def _unknown(member: LoggedRobot, about: Mapping[str, Any]) -> str | None:
    """Why a robot is none of those in swarm.json."""
    entries = {str(one["log"]): one["number"] for one in about.get("robots", []) if "number" in one}
    named = entries.get(member.log.path.name, member.number)
    if named != member.number:
        return f"{member.log.path.name} is the log of robot {named} in swarm.json"
    return None if not entries or member.number in entries.values() else "swarm.json has no robot of this number"


def _untimely(member: LoggedRobot, about: Mapping[str, Any]) -> str | None:
    """Why a robot's starts are not in the time of swarm.json; robots may not know the time."""
    begun, ended = (about.get(key) for key in ("started", "ended"))
    for state in member.log.states:
        if state.starts and state.now:
            if isinstance(begun, int | float) and state.now < begun - APART:
                return f"it started on {_date(state.now)}, and the swarm on {_date(begun)}"
            if isinstance(ended, int | float) and state.now > ended + APART:
                return f"it started on {_date(state.now)}, and the swarm ended on {_date(ended)}"
    return None


def _date(ms: float) -> str:
    try:
        return time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(ms / 1000))
    except (ValueError, OverflowError, OSError):
        return f"an impossible date, {ms:g} ms since 1970"


def _said(member: LoggedRobot) -> dict[int, dict[int, Any]]:
    """What a robot said, by the low bytes of boot count and tick, which messages have; a set if several ticks do."""
    boots: dict[int, dict[int, Any]] = defaultdict(dict)
    ticks = boots[0]
    for block in member.log.blocks:
        if isinstance(block, Tick):
            tick = block.tick & 0xFFFF
            if tick not in ticks:
                ticks[tick] = block.said
            else:
                before = ticks[tick]
                ticks[tick] = {*(before if isinstance(before, set) else (before,)), block.said}
        elif isinstance(block, State):
            ticks = boots[block.boot & 0xFF]
    return boots


def _heard(recording: Recording, left_out: set[int]) -> _Heard:
    """Compare what robots heard with the logs of the senders, but for robots that are left out."""
    said = {member.number: _said(member) for member in recording.members if member.number not in left_out}
    out = _Heard(Counter(), Counter(), {})
    for member in recording.members:
        if member.number not in said:
            continue
        for block in member.log.blocks:
            if not isinstance(block, Tick):
                continue
            for one in block.heard:
                sender, boot, tick, code = one
                if sender in said:
                    known = said[sender][boot]
                    if tick not in known:
                        out.missing[member.number, sender] += 1
                    elif code == known[tick] or (isinstance(known[tick], set) and code in known[tick]):
                        out.same[member.number, sender] += 1
                    else:
                        out.other.setdefault((member.number, sender), (block.tick, one))
    return out


def _without_messages(recording: Recording, heard: _Heard) -> Iterable[Stranger]:
    """Robots that no message connects with another one, although others heard them, or they others."""
    connected = {number for pair in [*heard.same, *heard.other] for number in pair}
    apart: Counter[int] = Counter()
    for pair, count in heard.missing.items():
        apart.update(dict.fromkeys(pair, count))
    for member in recording.members:
        if member.number in apart and member.number not in connected and member.log.ticks:
            messages = counted(apart[member.number], "message")
            why = f"of {messages} that it heard or others heard from it, no sender's log has any"
            yield Stranger((member.number,), why)


def _contradicting(heard: _Heard) -> Iterable[Stranger]:
    """The fewest robots, about, without whom no two logs contradict each other."""
    left = dict(heard.other)
    while left:
        partners: dict[int, set[int]] = defaultdict(set)
        for receiver, sender in left:
            partners[receiver].add(sender)
            partners[sender].add(receiver)
        worst = max(sorted(partners), key=lambda number: len(partners[number]))
        (receiver, sender), (tick, one) = next(item for item in left.items() if worst in item[0])
        others = len(partners[worst])
        yield Stranger(
            (worst,) if others > 1 else (receiver, sender),
            f"{f'its log and {others} others contradict each other: ' if others > 1 else ''}robot {receiver} heard in "
            f"tick {tick} a message of robot {sender}, tick {one.tick}, that the log of robot {sender} has otherwise: "
            "it was forged, or the logs are of two recordings",
        )
        left = {pair: what for pair, what in left.items() if worst not in pair}
