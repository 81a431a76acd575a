"""Readings and messages that ROS 2 has recorded in a bag, for `infer`."""

import contextlib
import itertools
import re
import sqlite3
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from swarmcensus.simulation import Readings, readings_of
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option, wrong_option
from swarmcensus.support.read_table import frame_table, in_order

STORAGES = (".mcap", ".db3")
COMPRESSED = tuple(f"{suffix}.zstd" for suffix in STORAGES)
ZSTD = bytes.fromhex("28b52ffd")  # how compressed data begins, and no message of ROS 2
CDR = "cdr"  # how ROS 2 encodes messages
ROBOT = "{robot}"
NUMBERS = (*(f"{sign}nt{bits}" for sign in ("I", "UI") for bits in (8, 16, 32, 64)),)
READINGS = ("Bool", *NUMBERS, "Float32", "Float64")
MESSAGES = (*NUMBERS, *(f"{name}MultiArray" for name in NUMBERS), "String")
MOST_STEPS = 10_000_000
PAUSE = 100  # times as long as any other gap between events: what lies beyond has another clock
NANO = 10**9


class Raw(NamedTuple):
    """A message as it is in a bag."""

    topic: str
    kind: str  # such as std_msgs/msg/Bool
    time: int  # ns
    data: bytes


class _BagContent(NamedTuple):
    """What is in a bag."""

    raw: list[Raw]
    topics: dict[str, str]  # all of them, and their types
    encodings: dict[str, str]  # of their messages


class _Events:
    """What was decoded so far: of each event its time, its robots and its value."""

    def __init__(self) -> None:
        self.seen: list[tuple[int, str, float, str]] = []  # time, robot, reading, topic
        self.heard: list[tuple[int, str, str, str]] = []  # time, sender, receiver, topic
        self.undecoded = self.compressed = 0

    @property
    def stamps(self) -> list[tuple[int, str]]:
        """The times and topics of all events, the earliest first."""
        return sorted((event[0], event[-1]) for events in (self.seen, self.heard) for event in events)


Wanted = dict[str, tuple[str, str]]  # by topic: "readings" or "messages", and the robot


def is_bag(path: Path) -> bool:
    """Whether a path is a folder with a bag, or a file of one."""
    return path.is_dir() or path.name.lower().endswith((*STORAGES, *COMPRESSED))


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
    for name, template in (("readings", readings), ("messages", messages)):
        if template is not None and template.count(ROBOT) != 1:
            raise wrong_option(name, template, f"should name a robot once as {ROBOT}, as /robot_{ROBOT}/floor")
    if not 1e-9 <= period < 1e9:
        raise wrong_option("period", period, "should be the seconds of a step, above 0")
    notes: list[str] = []
    found = _raw(path, [_pattern(template) for template in (readings, messages) if template is not None])
    wanted: Wanted = {}
    _choose(path, found, readings, "readings", wanted, notes)
    if messages is not None:
        _choose(path, found, messages, "messages", wanted, notes)
    events = _decoded(found.raw, wanted)
    if events.compressed:
        why = "they are compressed one by one, and metadata.yaml, which says so, is missing"
        notes.append(f"{counted(events.compressed, 'message')} could not be decoded: {why}")
    if events.undecoded:
        notes.append(f"{counted(events.undecoded, 'message')} could not be decoded")
    if not events.seen:
        known = "".join(f"; {note}" for note in notes)
        raise ResultsError.of(path, f"no readings on the topics of {option('readings', readings)}{known}")
    read = _readings(path, events, period, notes)
    heard = None
    if messages is not None:
        own = {messages.partition(ROBOT)[0].strip("/"), messages.partition(ROBOT)[0].rpartition("/")[2]}
        events.heard = [(event[0], _short(event[1], own), *event[2:]) for event in events.heard]
        heard = _messages(path, events, read, notes)
    return read._replace(notes=[*notes, *read.notes]), heard


def _raw(path: Path, patterns: list[re.Pattern[str]]) -> _BagContent:
    """What a bag holds on topics of these patterns, all of it. Raises InputError."""
    try:
        from rosbags.rosbag2 import Reader
    except ImportError:
        raise InputError("bags need the package rosbags: pip install 'swarmcensus[ros]'") from None

    if not path.exists():
        raise ResultsError.of(path, "there is no such bag")
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    files = [file for file in files if file.name.lower().endswith((*STORAGES, *COMPRESSED))]
    if not files:
        raise ResultsError.of(path, "no bag of rosbag2, which has files that end in .mcap or .db3")
    packed = next((file.name for file in files if file.name.lower().endswith(COMPRESSED)), "")
    if path.is_dir() and not (path / "metadata.yaml").exists():
        raise ResultsError.of(path, f"metadata.yaml is missing: ros2 bag reindex {path} writes it")
    if packed and not path.is_dir():
        raise ResultsError.of(path, f"{packed} is compressed: name its folder, or unpack it with zstd -d {packed}")
    if path.is_file() and path.suffix not in STORAGES:
        raise ResultsError.of(
            path, f"rosbags knows files by their endings: rename it to {path.stem}{path.suffix.lower()}"
        )
    found, counts = _BagContent([], {}, {}), Counter[str]()
    try:
        for file in files:
            if file.suffix.lower() == ".db3":
                _check_database(file)
        with Reader(path) as reader:
            for one in reader.connections:
                found.topics[one.topic], found.encodings[one.topic] = one.msgtype, one.ext.serialization_format  # type: ignore[union-attr]
            wanted = [one for one in reader.connections if any(p.fullmatch(one.topic) for p in patterns)]
            for one in wanted:
                counts[one.topic] += one.msgcount
            for one, time, data in reader.messages(wanted) if wanted else ():
                found.raw.append(Raw(one.topic, one.msgtype, time, data))
        read = Counter(one.topic for one in found.raw)
        if topic := next((topic for topic in counts if counts[topic] != read[topic]), None):
            raise ValueError(f"{topic} has {read[topic]:,} messages, and {counts[topic]:,} were counted as recorded")
    except Exception as error:  # a damaged bag raises anything
        mend = "sqlite3 FILE .recover" if ".db3" in files[0].name.lower() else "mcap recover FILE"
        why = " ".join(str(error).split()) or type(error).__name__
        mend += f", then ros2 bag reindex {path}," if path.is_dir() else ""
        raise ResultsError.of(path, f"cannot be read whole ({why}): {mend} mends a damaged or unindexed bag") from error
    listed = (path / "metadata.yaml").read_text(encoding="utf-8", errors="replace") if path.is_dir() else path.name
    if more := [one.name for one in files if not re.search(rf"(?<![\w.-]){re.escape(one.name)}(?!\w)", listed)]:
        raise ResultsError.of(path, f"metadata.yaml lacks {', '.join(more)}: move it away, or ros2 bag reindex {path}")
    return found


def _check_database(file: Path) -> None:
    """Raise an exception for an SQLite file that is cut or damaged: SQLite takes zeros for the last bytes."""
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


def _choose(path: Path, found: _BagContent, template: str, name: str, wanted: Wanted, notes: list[str]) -> None:
    """Add the topics that a template means to those that are wanted, and note those that cannot be decoded."""
    pattern, topics = _pattern(template), found.topics
    meant = {topic: match[1] for topic in topics if (match := pattern.fullmatch(topic))}
    if not meant:
        there = ", ".join(f"{topic} ({kind})" for topic, kind in sorted(topics.items())[:20]) or "none"
        raise ResultsError.of(path, f"no topic matches {option(name, template)}: there are {there}")
    foreign = [topic for topic in meant if found.encodings[topic] != CDR]
    if foreign:
        encoding = found.encodings[foreign[0]] or "something unknown"
        which = f"{foreign[0]} is encoded as {encoding}, not as {CDR}: it is left out"
        if len(foreign) > 1:
            which = f"{len(foreign):,} topics such as {foreign[0]} are not encoded as {CDR} but as {encoding}: left out"
        notes.append(which)
    kinds = READINGS if name == "readings" else MESSAGES
    for topic, robot in meant.items():
        if topic in foreign:
            continue
        package, _, kind = topics[topic].rpartition("/")
        if package != "std_msgs/msg" or kind not in kinds:
            raise ResultsError.of(
                path, f"{topic} is of {topics[topic]}: {option(name)} should be of std_msgs, {', '.join(kinds)}"
            )
        wanted[topic] = name, robot


def _pattern(template: str) -> re.Pattern[str]:
    """What matches the topics of a template, with the robot's name as a group."""
    before, _, after = template.partition(ROBOT)
    return re.compile(f"{re.escape(before)}([^/]+){re.escape(after)}")


def _decoded(raw: list[Raw], wanted: Wanted) -> _Events:
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.LATEST)  # std_msgs are the same in all
    events = _Events()
    for one in raw:
        if one.topic not in wanted:
            continue
        try:
            if not isinstance(one.time, int) or not isinstance(one.data, bytes):  # of a damaged row
                raise TypeError
            if one.data.startswith(ZSTD):
                events.compressed += 1
                continue
            value: Any = store.deserialize_cdr(one.data, one.kind).data  # type: ignore[attr-defined]
        except Exception:  # rosbags raises anything for bytes that do not fit
            events.undecoded += 1
            continue
        name, robot = wanted[one.topic]
        if name == "messages" and isinstance(value, str):
            senders = [sender for sender in re.split(r"[\s,;]+", value) if sender]
            events.heard += [(one.time, sender, robot, one.topic) for sender in senders]
        elif name == "messages":
            events.heard += [(one.time, str(int(sender)), robot, one.topic) for sender in np.atleast_1d(value)]
        elif value == value and value not in (0, 1):
            found = f"{one.topic}: a reading of {value:g}: should be 0 (white), 1 (black) or NaN (none)"
            raise ResultsError(found, key=one.topic, value=value)
        else:
            events.seen.append((one.time, robot, float(value), one.topic))
    return events


def _readings(path: Path, events: _Events, period: float, notes: list[str]) -> Readings:
    """Events put into steps, which begin with the first event and end with the last, whether read or heard."""
    import pandas as pd

    strays = _strays(events, round(period * NANO), notes)
    stamps = events.stamps
    first, last = stamps[0][0], stamps[-1][0]
    steps = (last - first) / NANO / period
    if steps > MOST_STEPS:
        ending = f": {MOST_STEPS:,} at most{strays and f'; {strays}'}"
        raise ResultsError.of(
            path, f"{(last - first) / NANO:,.0f} s are {steps:,.0f} steps of {option('period', period)}{ending}"
        )
    notes += [strays] if strays else []
    rows = [((time - first) / NANO, robot, value) for time, robot, value, _ in events.seen]
    rows += [((time - first) / NANO, events.seen[0][1], np.nan) for time in (first, last)]
    frame = pd.DataFrame(rows, columns=["time", "robot", "reading"])
    return readings_of(frame_table(frame, str(path)), period=period)


def _strays(events: _Events, period: int, notes: list[str]) -> str:
    """What is said of events of another clock; empty without them.

    Those at time 0 are left out: a recorder has no time before its first clock.
    """
    stamps = events.stamps
    gaps = [later - sooner for (sooner, _), (later, _) in itertools.pairwise(stamps)]
    *_, second, longest = sorted([0, 0, *gaps])
    if longest <= PAUSE * max(period, second):
        return ""
    at = gaps.index(longest) + 1
    if stamps[at - 1][0] <= 0:
        events.seen = [event for event in events.seen if event[0] > 0]
        events.heard = [event for event in events.heard if event[0] > 0]
        notes.append(f"{counted(at, 'event')} at time 0 left out, {longest / NANO:,.0f} s before the others")
        return _strays(events, period, notes)
    is_late = 2 * at >= len(stamps)
    count, (time, topic) = (len(stamps) - at, stamps[at]) if is_late else (at, stamps[at - 1])
    where = f"{longest / NANO:,.0f} s {'after' if is_late else 'before'} the others"
    return f"{counted(count, 'event')}, such as that of {topic} at {time / NANO:.1f} s, {where}"


def _messages(path: Path, events: _Events, read: Readings, notes: list[str]) -> np.ndarray:
    """Rows of step, sender and receiver; messages of and to robots without readings are left out."""
    rows, own, others, index, first = [], 0, Counter[str](), read.names, events.stamps[0][0]
    known = {name: _robot_number(name, index) for _, sender, receiver, _ in events.heard for name in (sender, receiver)}
    for time, sender, receiver, _ in events.heard:
        here, there = known[sender], known[receiver]
        if here is None or there is None:
            others[sender if here is None else receiver] += 1
        elif here == there:  # some radios hear themselves
            own += 1
        else:
            rows.append((int((time - first) / NANO / (read.period or 1.0) + 0.5), here, there))
    if others and not rows and not own:
        topic, name = next((topic, n) for _, *pair, topic in events.heard for n in pair if known[n] is None)
        said = f"{topic} names {name}, of which there are no readings, as of all that are heard: robots are"
        raise ResultsError.of(path, f"{said} {', '.join(index)}")
    if others:
        left_out = f"{counted(sum(others.values()), 'message')} of or to robots without readings"
        notes.append(f"{left_out} are left out: {', '.join(sorted(others, key=in_order))}")
    if own:
        notes.append(f"{counted(own, 'message')} that a robot heard from itself are left out")
    return np.array(rows, np.int64).reshape(-1, 3)


def _short(name: str, own: set[str]) -> str:
    """A robot's name as {robot} stands for it, where a message gives more of its topic."""
    name = name.strip("/")
    return next((name.removeprefix(one) for one in own if one and name.startswith(one) and name != one), name)


def _robot_number(name: str, index: Mapping[str, int]) -> int | None:
    """The robot that a message names: by its name, the same with other zeros, or its number; None if not just one."""
    words, number = _parts(name)
    for fits in (
        [one for one in index if one == name],
        [one for one in index if _parts(one) == (words, number)],
        [one for one in index if _parts(one)[1] == number and not words],
    ):
        if len(fits) == 1:
            return index[fits[0]]
    return None


def _parts(name: str) -> tuple[str, int | None]:
    """A name in two parts: what is before its number, and the number at its end."""
    match = re.fullmatch(r"(.*?)(?<![0-9])([0-9]+)", name)
    return (match[1], int(match[2])) if match else (name, None)
