"""Readings and messages that ROS 2 has recorded in a bag, for `infer`. A bag is read whole, or refused."""

import contextlib
import re
import sqlite3
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from swarmcensus.simulation import Readings, readings_of
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option, wrong_option
from swarmcensus.support.read_table import frame_table, in_order

STORAGES = (".mcap", ".db3")
PACKED = ".zstd"
ZSTD = bytes.fromhex("28b52ffd")  # how compressed data begins, and no message of ROS 2
CDR = "cdr"  # how ROS 2 encodes messages
ROBOT = "{robot}"
NUMBERS = (*(f"{sign}nt{bits}" for sign in ("I", "UI") for bits in (8, 16, 32, 64)),)
READINGS = ("Bool", *NUMBERS, "Float32", "Float64")
MESSAGES = (*NUMBERS, *(f"{name}MultiArray" for name in NUMBERS), "String")
MOST_STEPS = 10_000_000
NANO = 10**9


class Event(NamedTuple):
    """A message of a bag."""

    time: int  # ns
    topic: str
    robot: str  # the name in the topic
    value: Any


def is_bag(path: Path) -> bool:
    """Whether a path is a folder with a bag, or a file of one."""
    return path.is_dir() or path.suffix in (*STORAGES, PACKED)


def read_bag(
    path: str | Path, readings: str, messages: str | None, period: float
) -> tuple[Readings, np.ndarray | None]:
    """Readings of a bag of rosbag2, and its messages (message, 3) as step, sender, receiver.

    path: its folder, or one file of it. readings, messages: topics, in which {robot} stands for a robot's name.
    period: seconds of a step; a step begins half a period before its time, counted from the first event. Events are
    put into steps as rows of a table are.

    Raises InputError for what is no bag, a bag that is cut, damaged or does not hold the messages that it counts,
    topics that are not there or of other types, values that are none, too many steps, and if the library rosbags is
    missing.
    """
    path = Path(path)
    templates = {"readings": readings} if messages is None else {"readings": readings, "messages": messages}
    for name, template in templates.items():
        if template.count(ROBOT) != 1:
            raise wrong_option(name, template, f"should name a robot once as {ROBOT}, as /robot_{ROBOT}/floor")
    if not 1e-9 <= period < 1e9:
        raise wrong_option("period", period, "should be the seconds of a step, above 0")
    events = _events(path, templates)
    if not events["readings"]:
        raise ResultsError.of(path, f"no readings on the topics of {option('readings', readings)}")
    read = _readings(path, events, period)
    if messages is None:
        return read, None
    heard, notes = _messages(path, events, read)
    return read._replace(notes=[*notes, *read.notes]), heard


def _events(path: Path, templates: Mapping[str, str]) -> dict[str, list[Event]]:
    """All events on the topics of templates, by the templates' names. Raises InputError."""
    try:
        from rosbags.rosbag2 import Reader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError("bags need the package rosbags: pip install 'swarmcensus[ros]'") from None

    files = _files(path)
    store = get_typestore(Stores.LATEST)  # std_msgs are the same in all
    found: dict[str, list[Event]] = {name: [] for name in templates}
    try:
        for file in files:
            (_check_database if ".db3" in file.suffixes else _check_mcap)(file)
        with Reader(path) as reader:
            robots = {name: _topics(path, reader.connections, name, one) for name, one in templates.items()}
            wanted = [one for one in reader.connections if any(one.topic in topics for topics in robots.values())]
            read: Counter[str] = Counter()
            for one, time, data in reader.messages(wanted):
                if data.startswith(ZSTD):
                    raise ResultsError.of(path, "its messages are compressed: name the folder with its metadata.yaml")
                if not isinstance(time, int):
                    raise TypeError(f"{one.topic} has a time that is no number")
                value = store.deserialize_cdr(data, one.msgtype).data  # type: ignore[attr-defined]
                read[one.topic] += 1
                for name, topics in robots.items():
                    if one.topic in topics:
                        found[name].append(Event(time, one.topic, topics[one.topic], value))
            parts = getattr(reader.storage, "storages", [reader.storage])  # files; of a file it is the only one
            there = Counter[str]()
            for one in (one for part in parts for one in part.connections):
                there[one.topic] += one.msgcount
            listed = {topic: about.msgcount for topic, about in reader.topics.items()}
            _check_counts(reader.message_count, listed, dict(there) | {one.topic: read[one.topic] for one in wanted})
    except InputError:
        raise
    except Exception as error:  # a damaged bag raises anything
        mend = "sqlite3 FILE .recover" if ".db3" in files[0].suffixes else "mcap recover FILE"
        why = " ".join(str(error).split()) or type(error).__name__
        mend += f", then ros2 bag reindex {path}," if path.is_dir() else ""
        raise ResultsError.of(path, f"cannot be read whole ({why}): {mend} mends a damaged or unindexed bag") from error
    return found


def _files(path: Path) -> list[Path]:
    """The files of a bag. Raises InputError."""
    if not path.exists():
        raise ResultsError.of(path, "there is no such bag")
    if not path.is_dir():
        if path.suffix == PACKED:
            raise ResultsError.of(path, f"is compressed: name its folder, or unpack it with zstd -d {path}")
        return [path]
    files = sorted(file for file in path.iterdir() if {*file.suffixes} & {*STORAGES} and is_bag(file))
    if not files:
        raise ResultsError.of(path, "no bag of rosbag2, which has files that end in .mcap or .db3")
    metadata = path / "metadata.yaml"
    if not metadata.is_file():
        raise ResultsError.of(path, f"metadata.yaml is missing: ros2 bag reindex {path} writes it")
    listed = metadata.read_text(encoding="utf-8", errors="replace")
    if more := [file.name for file in files if file.name not in listed]:
        raise ResultsError.of(path, f"metadata.yaml lacks {', '.join(more)}: move it away, or ros2 bag reindex {path}")
    return files


def _check_database(file: Path) -> None:
    """Raise an exception for an SQLite file that is cut or damaged: SQLite takes zeros for the last bytes."""
    if file.suffix == PACKED:
        return
    with file.open("rb") as stream:
        head = stream.read(32)
    if int.from_bytes(head[28:32], "big") * int.from_bytes(head[16:18], "big") > file.stat().st_size:
        raise EOFError("its end is missing")
    rest = file.with_name(f"{file.name}-wal")
    if rest.is_file() and rest.stat().st_size:
        raise EOFError(f"its last messages are in {rest.name}")
    with contextlib.closing(sqlite3.connect(f"{file.resolve().as_uri()}?immutable=1", uri=True)) as base:
        [(said,), *_] = base.execute("PRAGMA quick_check(1)")
    if said != "ok":
        raise ValueError(said)


def _check_mcap(file: Path) -> None:
    """Raise an exception for an MCAP file that is cut, or has another checksum than its content."""
    from mcap.stream_reader import StreamReader

    if file.suffix != PACKED:
        with file.open("rb") as stream:
            for _ in StreamReader(stream, emit_chunks=True, validate_crcs=True).records:
                pass


def _check_counts(total: int, counts: Mapping[str, int], there: Mapping[str, int]) -> None:
    """Raise ValueError if other messages are there, or were read, than metadata.yaml or the file's index counts."""
    for topic in sorted(counts.keys() | there.keys()):
        if (found := there.get(topic, 0)) != (listed := counts.get(topic, 0)):
            raise ValueError(f"{topic} has {found:,} messages, and {listed:,} were counted as recorded")
    if total != sum(counts.values()):
        raise ValueError(f"its topics have {sum(counts.values()):,} messages, and {total:,} were counted as recorded")


def _topics(path: Path, connections: Sequence[Any], name: str, template: str) -> dict[str, str]:
    """The topics that a template means, and their robots. Raises InputError if there are none, or others."""
    before, _, after = template.partition(ROBOT)
    pattern = re.compile(f"{re.escape(before)}([^/]+){re.escape(after)}")
    meant = {one.topic: one for one in connections if pattern.fullmatch(one.topic)}
    if not meant:
        there = ", ".join(sorted(f"{one.topic} ({one.msgtype})" for one in connections)[:20]) or "none"
        raise ResultsError.of(path, f"no topic matches {option(name, template)}: there are {there}")
    kinds = READINGS if name == "readings" else MESSAGES
    for topic, one in meant.items():
        if one.ext.serialization_format != CDR:
            raise ResultsError.of(path, f"{topic} is encoded as {one.ext.serialization_format!r}: should be {CDR}")
        package, _, kind = one.msgtype.rpartition("/")
        if package != "std_msgs/msg" or kind not in kinds:
            raise ResultsError.of(
                path, f"{topic} is of {one.msgtype}: {option(name)} should be of std_msgs, {', '.join(kinds)}"
            )
    return {topic: pattern.fullmatch(topic)[1] for topic in meant}  # type: ignore[index]


def _readings(path: Path, events: Mapping[str, list[Event]], period: float) -> Readings:
    """Events put into steps, which begin with the first event and end with the last, whether read or heard."""
    import pandas as pd

    for event in events["readings"]:
        if event.value == event.value and event.value not in (0, 1):
            found = f"{event.topic}: a reading of {event.value:g}: should be 0 (white), 1 (black) or NaN (none)"
            raise ResultsError(found, key=event.topic, value=event.value)
    first, last = _ends(events)
    if last.time - first.time > MOST_STEPS * period * NANO:
        ends = " to ".join(f"{one.topic} at {one.time / NANO:.1f} s" for one in (first, last))
        steps = f"{(last.time - first.time) / NANO / period:,.0f} steps of {option('period', period)}"
        raise ResultsError.of(path, f"{ends} are {steps}: {MOST_STEPS:,} at most")
    rows = [((one.time - first.time) / NANO, one.robot, float(one.value)) for one in events["readings"]]
    rows += [((one.time - first.time) / NANO, events["readings"][0].robot, np.nan) for one in (first, last)]
    frame = pd.DataFrame(rows, columns=["time", "robot", "reading"])
    return readings_of(frame_table(frame, str(path)), period=period)


def _ends(events: Mapping[str, list[Event]]) -> tuple[Event, Event]:
    """The first event and the last."""
    every = [event for of_template in events.values() for event in of_template]
    return min(every, key=lambda event: event.time), max(every, key=lambda event: event.time)


def _messages(path: Path, events: Mapping[str, list[Event]], read: Readings) -> tuple[np.ndarray, list[str]]:
    """Rows of step, sender and receiver, and notes on what is left out: messages of and to robots without readings."""
    rows, own, others, first = [], 0, Counter[str](), _ends(events)[0].time
    for event in events["messages"]:
        receiver = read.names.get(event.robot)
        for name in _senders(event.value):
            sender = read.names.get(name)
            if sender is None or receiver is None:
                others[name if sender is None else event.robot] += 1
            elif sender == receiver:  # some radios hear themselves
                own += 1
            else:
                rows.append((int((event.time - first) / NANO / (read.period or 1.0) + 0.5), sender, receiver))
    if others and not rows and not own:
        said = f"messages name {next(iter(others))}, of which there are no readings, as of all that are heard"
        raise ResultsError.of(path, f"{said}: robots are {', '.join(read.names)}")
    notes = []
    if others:
        left_out = f"{counted(others.total(), 'message')} of or to robots without readings"
        notes.append(f"{left_out} are left out: {', '.join(sorted(others, key=in_order))}")
    if own:
        notes.append(f"{counted(own, 'message')} that a robot heard from itself are left out")
    return np.array(rows, np.int64).reshape(-1, 3), notes


def _senders(value: Any) -> Iterator[str]:
    """The names in a message, as {robot} stands for them."""
    if isinstance(value, str):
        yield from filter(None, re.split(r"[\s,;]+", value))
    else:
        yield from (str(int(sender)) for sender in np.atleast_1d(value))
