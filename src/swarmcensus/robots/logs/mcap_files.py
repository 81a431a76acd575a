"""Logs of a folder of robots as one MCAP file, which Foxglove and other tools of robotics open."""

import heapq
import json
import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from swarmcensus import brains
from swarmcensus.brains import FORMATS, Numbers, Precision
from swarmcensus.robots.logs.folders import OWN, about_of, logs_in, without_logs
from swarmcensus.robots.logs.log_times import LogTimes
from swarmcensus.robots.logs.logs import Gap, State, Tick, blocks_of
from swarmcensus.runtime.runtime import Messages
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.plugins import digest, read_source
from swarmcensus.translation import messages_of

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
}
TRUTH = "/swarm/fill_ratio"


class Written(NamedTuple):
    """What went into a file."""

    robots: int
    ticks: int
    messages: int
    lost: int  # bytes of logs that are cut or damaged


class Event(NamedTuple):
    """A message of the file; those of a time keep the order of robots and of what happened in a tick."""

    time: int  # ms
    robot: int
    order: int
    channel: str
    content: dict[str, Any]


class _Source:
    """One log: its first state, what its messages mean, and what was read of it so far."""

    def __init__(self, path: Path) -> None:
        self.path = path
        first = next((block for block in blocks_of(path) if isinstance(block, State)), None)
        if first is None:
            raise ResultsError.of(path, "should be a robot's log, which begins with what the robot is")
        self.first = first
        self.precision: Precision = "single" if first.single else "double"
        self.message: Any = FORMATS[first.form] if 0 < first.form < len(FORMATS) else ""
        self.brain: brains.Brain | None = None
        self.names: list[str] = []
        self.reader: Messages | None = None
        self.ticks = self.lost = 0
        self.boots: set[int] = set()

    def know(self, brain: brains.Brain | None) -> None:
        """From now on tell the numbers of messages, if this is the robot's brain and the format is known."""
        if brain is None or not self.message:
            return
        self.brain = brain
        reader = messages_of(brain.with_numbers(Numbers(self.precision, self.message, self.first.feedback)))
        if reader.body == self.first.code_bytes:
            self.names, self.reader = list(brain.message), reader

    def events(self, origin: int) -> Iterator[Event]:
        """What happened, in order."""
        order = 0
        number, boot = self.first.number, self.first.boot
        times = LogTimes(max(origin, 0))
        for block in blocks_of(self.path):
            now = times.of(block)
            if isinstance(block, Gap):
                self.lost += block.length
            if now is None or isinstance(block, Gap):
                continue
            if isinstance(block, State):
                if block.number != number:
                    raise ResultsError.of(
                        self.path, f"the log is of robot {number} and of robot {block.number}: of one is right"
                    )
                boot = block.boot
                self.boots.add(boot)
                continue
            self.ticks += 1
            for name, content in self._contents(block):
                yield Event(now, number, order, name, {**content, "tick": block.tick, "boot": boot})
                order += 1

    def _contents(self, tick: Tick) -> Iterator[tuple[str, dict[str, Any]]]:
        if tick.looks:
            yield "reading", {"blacks": tick.blacks, "looks": tick.looks}
        if tick.said is not None:
            yield "said", self._message(tick.said)
        for one in tick.heard:
            origin = {"sender": one.sender, "sender_boot": one.boot, "sender_tick": one.tick}
            yield "heard", origin | self._message(one.code)
        yield "estimate", {"estimate": tick.estimate if math.isfinite(tick.estimate) else None}

    def _message(self, code: bytes) -> dict[str, Any]:
        numbers = self.reader.read(code) if self.reader else None
        return {"numbers": dict(zip(self.names, numbers or (), strict=False)), "code": code.hex()}

    def about(self) -> dict[str, Any]:
        """What the robot is, for a metadata record."""
        first = self.first
        return {
            "number": first.number, "log": self.path.name, "b": first.b, "w": first.w, "period_ms": first.period,
            "brain": self.brain.name if self.brain else "", "brain_sha256": first.brain.hex(),
            "message": self.message, "precision": self.precision,
            "boots": len(self.boots), "ticks": self.ticks, "bytes_lost": self.lost,
            "times": "since 1970" if first.now else "counted from the first tick",
        }  # fmt: skip


def write_mcap(folder: str | Path, out: str | Path) -> Written:
    """Write the logs of a folder as an MCAP file with a channel for each robot and each kind of event.

    Messages are JSON with a schema. They are written in the order of time, in memory that does not grow with the logs.
    Raises InputError for logs that cannot be read, two of one robot, a file that cannot be written, and if the library
    mcap is missing.
    """
    try:
        from mcap.writer import Writer
    except ImportError:
        raise InputError("MCAP files need the package mcap: pip install 'swarmcensus[ros]'") from None

    folder = Path(folder)
    swarm = about_of(folder)
    sources = [_Source(path) for path in logs_in(folder)]
    if not sources:
        raise without_logs(folder)
    by_number: dict[int, _Source] = {}
    for source in sources:
        other = by_number.setdefault(source.first.number, source)
        if other is not source:
            raise ResultsError.of(source.path, f"is of robot {source.first.number}, as {other.path.name} is: one each")
    known = _brains(folder, swarm.get("brain", {}), {source.first.brain for source in sources})
    for source in sources:
        source.know(known.get(source.first.brain))
    origin = min([source.first.now for source in sources if source.first.now], default=0)
    with atomic_write(out) as temporary, temporary.open("wb") as file:
        writer = Writer(file)
        writer.start(library="swarmcensus")
        messages = _write(writer, [source.events(origin) for source in sources], swarm.get("fill_ratio"))
        if swarm:
            writer.add_metadata("swarm", _texts(swarm))
        for source in sources:
            writer.add_metadata(f"robot_{source.first.number}", _texts(source.about()))
        writer.finish()
    return Written(len(sources), sum(s.ticks for s in sources), messages, sum(s.lost for s in sources))


def _write(writer: Any, streams: list[Iterator[Event]], truth: Any) -> int:
    """Write all messages and return how many; the truth is one at the beginning and one at the end."""
    channels: dict[tuple[int, str], int] = {}
    schemas = {name: _schema(writer, name, fields) for name, fields in CHANNELS.items()}
    send = partial(_send, writer)
    count, now, fill_ratio = 0, None, None
    if isinstance(truth, int | float):
        schema = _schema(writer, "fill_ratio", {"fill_ratio": NUMBER})
        fill_ratio = writer.register_channel(TRUTH, "json", schema)
    for event in heapq.merge(*streams):
        if now is None and fill_ratio is not None:
            send(fill_ratio, event.time, count, {"fill_ratio": truth})
        now = event.time
        key = event.robot, event.channel
        if key not in channels:
            topic = f"/robot_{event.robot}/{event.channel}"
            channels[key] = writer.register_channel(topic, "json", schemas[event.channel])
        send(channels[key], event.time, count, event.content)
        count += 1
    if now is not None and fill_ratio is not None:
        send(fill_ratio, now, count, {"fill_ratio": truth})
        return count + 2
    return count


def _send(writer: Any, channel: int, time: int, sequence: int, content: dict[str, Any]) -> None:
    at = min(max(time * NANO, 0), LATEST)
    data = json.dumps(content, separators=(",", ":")).encode()
    writer.add_message(channel, log_time=at, data=data, publish_time=at, sequence=sequence & 0xFFFFFFFF)


def _schema(writer: Any, name: str, fields: dict[str, Any]) -> int:
    schema = {"type": "object", "title": f"swarmcensus.{name}", "properties": fields}
    return int(writer.register_schema(f"swarmcensus.{name}", "jsonschema", json.dumps(schema).encode()))


def _texts(about: dict[str, Any]) -> dict[str, str]:
    """The values of a metadata record, which holds texts only."""
    return {key: value if isinstance(value, str) else json.dumps(value) for key, value in about.items()}


def _brains(folder: Path, about: dict[str, Any], named: set[bytes]) -> dict[bytes, brains.Brain]:
    """The brains that logs name, of those in the folder and the shipped ones. None of them is run.

    `about` is what swarm.json says of the swarm's brain: its name, which is not that of its file.
    """
    known: dict[bytes, brains.Brain] = {}
    names = {str(about.get("file", OWN)): str(about["name"])} if about.get("name") else {}
    own = [path for path in sorted(folder.iterdir()) if path.suffix.lower() == ".py"]
    for path in [*map(brains.find, brains.shipped()), *own]:
        source = read_source("brain", path)
        if (mark := bytes.fromhex(digest(source))[:8]) in named:
            name = names.get(path.name) or (known[mark].name if mark in known else path.stem)
            known[mark] = brains.unloaded(name, source)
    return known
