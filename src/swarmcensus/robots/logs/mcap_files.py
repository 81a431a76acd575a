"""Logs of a folder of robots as one MCAP file, which Foxglove and other tools of robotics open."""

import heapq
import json
import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from swarmcensus.robots.logs.answers import gaps_in
from swarmcensus.robots.logs.clocks import LogTimes
from swarmcensus.robots.logs.folders import LoggedRobot, Recording, read_recording
from swarmcensus.robots.logs.logs import State, Tick
from swarmcensus.robots.logs.replicas import Unfit, replica_of
from swarmcensus.runtime.runtime import Messages
from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.formatting import counted

NANO = 10**6  # nanoseconds of a millisecond
LATEST = 2**63 - 1  # ns that a file holds
NUMBER, WHOLE = {"type": "number"}, {"type": "integer"}
WHEN = {"tick": WHOLE, "boot": WHOLE}  # of the robot whose channel it is
CONTENT = {"numbers": {"type": "object", "additionalProperties": True}, "code": {"type": "string"}}
CHANNELS: dict[str, dict[str, Any]] = {
    "estimate": {"estimate": NUMBER, **WHEN},
    "reading": {"blacks": WHOLE, "looks": WHOLE, **WHEN},
    "said": {**CONTENT, **WHEN},
    "heard": {"sender": WHOLE, "sender_boot": WHOLE, "sender_tick": WHOLE, **CONTENT, **WHEN},
    "fill_ratio": {"fill_ratio": NUMBER},
}
TRUTH = "/swarm/fill_ratio"


class Event(NamedTuple):
    """A message of the file; those of a time keep the order of robots and of what happened in a tick."""

    time: int  # ms
    robot: int
    order: int
    channel: str
    content: dict[str, Any]


def write_mcap(folder: str | Path, out: str | Path) -> tuple[str, list[str]]:
    """Write the logs of a folder as an MCAP file with a channel for each robot and each kind of event.

    Returns what was written, and what the logs lack.

    Messages are JSON with a schema, in the order of time. Raises InputError for logs that cannot be read, two of one
    robot, a brain that is not known, a file that cannot be written, and if the library mcap is missing.
    """
    try:
        from mcap.writer import Writer
    except ImportError:
        raise InputError("MCAP files need the package mcap: pip install 'swarmcensus[ros]'") from None

    recording = read_recording(Path(folder))
    firsts = [member.log.states[0] for member in recording.members]
    origin = min([first.now for first in firsts if first.now], default=0)
    with atomic_write(out) as temporary, temporary.open("wb") as file:
        writer = Writer(file)
        writer.start(library="swarmcensus")
        messages = _write(writer, _events(recording, origin))
        if recording.about:
            texts = {key: x if isinstance(x, str) else json.dumps(x) for key, x in recording.about.items()}
            writer.add_metadata("swarm", texts)
        writer.finish()
    robots, ticks = len(firsts), sum(len(member.log.ticks) for member in recording.members)
    written = f"{counted(robots, 'robot')}, {counted(ticks, 'tick')}, {counted(messages, 'message')}"
    return written, gaps_in(recording)


def _events(recording: Recording, origin: int) -> Iterator[tuple[str, Event]]:
    """All events and their topics in the order of time; the truth is one at the beginning and one at the end."""
    truth = [] if recording.fill_ratio is None else [{"fill_ratio": recording.fill_ratio}]
    now = None
    for event in heapq.merge(*(_events_of(member, origin) for member in recording.members)):
        for content in truth if now is None else ():
            yield TRUTH, Event(event.time, -1, 0, "fill_ratio", content)
        now = event.time
        yield f"/robot_{event.robot}/{event.channel}", event
    for content in truth if now is not None else ():
        yield TRUTH, Event(now or 0, -1, 0, "fill_ratio", content)


def _events_of(member: LoggedRobot, origin: int) -> Iterator[Event]:
    """What happened to a robot."""
    order, boot, times = 0, 0, LogTimes(origin)
    names = list(member.brain.message)
    try:
        reader = replica_of(member.brain, member.log.states[0]).messages
    except Unfit:
        reader = None
    for block in member.log.blocks:
        now = times.of(block)
        if isinstance(block, State):
            boot = block.boot
        elif isinstance(block, Tick) and now is not None:
            for channel, content in _contents(block, reader, names):
                yield Event(now, member.number, order, channel, {**content, "tick": block.tick, "boot": boot})
                order += 1


def _contents(tick: Tick, reader: Messages | None, names: Iterable[str]) -> Iterator[tuple[str, dict[str, Any]]]:
    """What happened in a tick, by channels."""

    def message(code: bytes) -> dict[str, Any]:
        numbers = reader.read(code) if reader else None
        return {"numbers": dict(zip(names, numbers or (), strict=False)), "code": code.hex()}

    if tick.looks:
        yield "reading", {"blacks": tick.blacks, "looks": tick.looks}
    if tick.said is not None:
        yield "said", message(tick.said)
    for one in tick.heard:
        yield (
            "heard",
            {"sender": one.sender, "sender_boot": one.boot, "sender_tick": one.tick, **message(one.code)},
        )
    yield "estimate", {"estimate": tick.estimate if math.isfinite(tick.estimate) else None}


def _write(writer: Any, events: Iterable[tuple[str, Event]]) -> int:
    """Write all messages and return how many."""
    schemas, channels, count = {}, dict[str, int](), 0
    for name, fields in CHANNELS.items():
        schema = {"type": "object", "title": f"swarmcensus.{name}", "properties": fields}
        schemas[name] = writer.register_schema(f"swarmcensus.{name}", "jsonschema", json.dumps(schema).encode())
    for topic, event in events:
        if topic not in channels:
            channels[topic] = writer.register_channel(topic, "json", schemas[event.channel])
        at = min(max(event.time * NANO, 0), LATEST)
        data = json.dumps(event.content, separators=(",", ":")).encode()
        writer.add_message(channels[topic], log_time=at, data=data, publish_time=at, sequence=count & 0xFFFFFFFF)
        count += 1
    return count
