"""Logs that are not of their folder's recording: by times, numbers and sensors of robots, and what these heard."""

import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from swarmcensus.robots.logs.folders import LoggedRobot, Recording
from swarmcensus.robots.logs.logs import Heard, State, Tick
from swarmcensus.support.formatting import counted

APART = 60_000  # ms by which the clocks of robots and of swarm.json may differ
APART_HERE = 2_000  # the same where one machine ran them: from the first order to the start, and the end of processes
INEXACT = 1e-5  # of accuracies that are written in decimal digits
LAP = 0x10000  # ticks, whose low two bytes come again

Pair = tuple[int, int]  # receiver and sender


class Stranger(NamedTuple):
    """A robot whose log is not of the recording, or two of which one is not, and why."""

    robots: tuple[int, ...]
    reason: str


@dataclass
class _Heard:
    """What the logs of senders hold of the messages that robots heard."""

    same: set[Pair] = field(default_factory=set)
    missing: Counter[Pair] = field(default_factory=Counter)
    other: dict[Pair, tuple[int, Heard]] = field(default_factory=dict)  # the receiver's tick and the first such message


@dataclass
class _Life:
    """What a robot said from one start to the next."""

    first: int  # the tick after which it began; 0 if its start is damaged
    last: int  # that its log has
    said: dict[int, bytes | None]


def strangers_of(recording: Recording) -> list[Stranger]:
    """The robots whose logs are not of this recording, by number. Ticks that a log lacks are no reason."""
    entries = {one["number"]: one for one in recording.about.get("robots", []) if "number" in one}
    found = []
    for member in recording.members:
        entry = entries.get(member.number, {})
        why = _unknown(member, recording.about) or _untimely(member, entry, recording.about) or _unlike(member, entry)
        if why:
            found.append(Stranger((member.number,), why))
    heard = _heard(recording, {number for one in found for number in one.robots})
    return sorted([*found, *_without_messages(recording, heard), *_contradicting(heard)])


def _unknown(member: LoggedRobot, about: Mapping[str, Any]) -> str | None:
    """Why a robot is none of those in swarm.json."""
    entries = {str(one["log"]).lower(): one["number"] for one in about.get("robots", []) if "number" in one}
    named = entries.get(member.log.path.name.lower(), member.number)
    if named != member.number:
        return f"{member.log.path.name} is the log of robot {named} in swarm.json"
    return None if not entries or member.number in entries.values() else "swarm.json has no robot of this number"


def _untimely(member: LoggedRobot, entry: Mapping[str, Any], about: Mapping[str, Any]) -> str | None:
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


def _unlike(member: LoggedRobot, entry: Mapping[str, Any]) -> str | None:
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


def _lives_of(member: LoggedRobot) -> dict[int, list[_Life]]:
    """A robot's lives by the low byte of their boot count, which messages have."""
    boots: dict[int, list[_Life]] = defaultdict(list)
    boot, life = -1, _Life(0, 0, {})
    for block in member.log.blocks:
        if isinstance(block, State) and (block.starts or block.boot != boot or block.tick < life.last):
            boot, life = block.boot, _Life(block.tick if block.starts else 0, block.tick, {})
            boots[boot & 0xFF].append(life)
        elif isinstance(block, Tick):
            life.said[block.tick], life.last = block.said, block.tick
    return boots


def _heard(recording: Recording, left_out: set[int]) -> _Heard:
    """Compare what robots heard with the logs of the senders, but for robots that are left out."""
    members = {member.number: member for member in recording.members if member.number not in left_out}
    said = {number: _lives_of(member) for number, member in members.items()}
    lengths = [[life.last - life.first for lives in boots.values() for life in lives] for boots in said.values()]
    longest = max(map(sum, lengths), default=0)
    out = _Heard()
    for member in members.values():
        for block in member.log.blocks:
            if not isinstance(block, Tick):
                continue
            for one in block.heard:
                pair = member.number, one.sender
                if one.sender not in said or pair in out.other:
                    continue
                lives = said[one.sender].get(one.boot)
                if lives and lives[-1].said.get(one.tick) == one.code:  # as almost all
                    out.same.add(pair)
                    continue
                found = _found(one, lives, longest) if lives else _of_other_boots(one, members[one.sender])
                if found == "same":
                    out.same.add(pair)
                elif found == "missing":
                    out.missing[pair] += 1
                elif found == "other":
                    out.other[pair] = block.tick, one
    return out


def _found(one: Heard, lives: Sequence[_Life], longest: int) -> Literal["same", "other", "missing", "unknown"]:
    """Whether lives of a sender hold a message; unknown if one may have had the message's tick, and its log lacks it.

    A life may have gone on after its log ended, for half a lap or as long as a log of the recording.
    """
    out: Literal["other", "missing", "unknown"] = "missing"
    for life in lives:
        begun = life.first + 1
        end = max(life.last, life.first + max(longest, LAP // 2))
        for tick in range(begun + (one.tick - begun) % LAP, end + 1, LAP):
            if tick not in life.said:
                out = "unknown"
            elif life.said[tick] == one.code:
                return "same"
            elif out == "missing":
                out = "other"
    return out


def _of_other_boots(one: Heard, sender: LoggedRobot) -> Literal["missing", "unknown"]:
    """Whether a message is from before its sender's log; from after it, the log may have been full."""
    first = sender.log.blocks[0]
    if not isinstance(first, State) or not first.starts:
        return "unknown"
    before = (first.boot - one.boot) & 0xFF
    return "missing" if before < 128 and before <= first.boot else "unknown"


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
            f"tick {tick} a message of robot {sender}, tick {one.tick}, that the log of robot {sender} has otherwise "
            "(it was forged, or the logs are of two recordings)",
        )
        left = {pair: what for pair, what in left.items() if worst not in pair}
