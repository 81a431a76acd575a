"""Readings and messages that ROS 2 has recorded in a bag, for `infer`."""

import contextlib
import io
import itertools
import re
import sqlite3
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option, wrong_option

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
MOST_LACKING = 2**32  # bytes of a cut file that are made up; more is a damaged number
NANO = 10**9
# of an MCAP chunk's record: bytes before its records if they are not compressed, and where the name's length stands
CHUNK_HEAD, COMPRESSION, COMPRESSION_END = 49, 37, 41


class Raw(NamedTuple):
    """A message as it is in a bag."""

    topic: str
    kind: str  # such as std_msgs/msg/Bool
    time: int  # ns
    data: bytes


class Recorded(NamedTuple):
    """What `infer` takes, and what there is to tell of the bag."""

    readings: np.ndarray  # (step, robot) of 0, 1 and NaN
    messages: np.ndarray | None  # (message, 3): step, sender, receiver
    names: list[str]  # of the robots, as {robot} stands for them
    notes: list[str]


class _Found:
    """What is in a bag's files."""

    def __init__(self) -> None:
        self.raw: list[Raw] = []
        self.topics: dict[str, str] = {}  # all of them, and their types
        self.encodings: dict[str, str] = {}  # of their messages
        self.whole = True  # whether all that the files should hold was read


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


def is_bag(path: Path) -> bool:
    """Whether a path is a folder with a bag, or a file of one."""
    return path.is_dir() or path.name.lower().endswith((*STORAGES, *COMPRESSED))


def read_bag(path: str | Path, readings: str, messages: str | None, period: float) -> Recorded:
    """Read a bag of rosbag2, whole or as much of it as is readable.

    path: its folder, or one file of it. readings, messages: topics, in which {robot} stands for a robot's name.
    period: seconds of a step; a step begins half a period before its time, counted from the first event. Of several
    readings of a robot in a step the last one counts. Robots are numbered by their names, whole numbers first.

    Raises InputError for what is no bag, topics that are not there or of other types, values that are none, too many
    steps, and if the library rosbags is missing.
    """
    path = Path(path)
    for name, template in (("readings", readings), ("messages", messages)):
        if template is not None and template.count(ROBOT) != 1:
            raise wrong_option(name, template, f"should name a robot once as {ROBOT}, as /robot_{ROBOT}/floor")
    if not 1e-9 <= period < 1e9:
        raise wrong_option("period", period, "should be the seconds of a step, above 0")
    found, notes = _raw(path, [_pattern(template) for template in (readings, messages) if template is not None])
    wanted: dict[str, tuple[Callable[[_Events, Raw, str, Any], None], str]] = {}
    _choose(path, found, readings, "readings", READINGS, _reading, wanted, notes)
    if messages is not None:
        _choose(path, found, messages, "messages", MESSAGES, _heard, wanted, notes)
    events = _decoded(found.raw, wanted)
    if events.compressed:
        why = "they are compressed one by one, and metadata.yaml, which says so, is missing"
        notes.append(f"{path}: {counted(events.compressed, 'message')} could not be decoded: {why}")
    if events.undecoded:
        notes.append(f"{path}: {counted(events.undecoded, 'message')} could not be decoded")
    if not events.seen:
        known = "".join(f"; {note.removeprefix(f'{path}: ')}" for note in notes)
        raise ResultsError.of(path, f"no readings on the topics of {option('readings', readings)}{known}")
    if messages is not None:
        own = {messages.partition(ROBOT)[0].strip("/"), messages.partition(ROBOT)[0].rpartition("/")[2]}
        events.heard = [(event[0], _short(event[1], own), *event[2:]) for event in events.heard]
    return _steps(path, events, messages is not None, round(period * NANO), notes)


def _raw(path: Path, patterns: list[re.Pattern[str]]) -> tuple[_Found, list[str]]:
    """What files hold on topics of these patterns, and what there is to tell of them. Raises InputError."""
    try:
        from rosbags.rosbag2 import Reader, ReaderError
    except ImportError:
        raise InputError("bags need the package rosbags: pip install 'swarmcensus[ros]'") from None

    if not path.exists():
        raise ResultsError.of(path, "there is no such bag")
    found = _Found()
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    try:
        if any(_lacking(file) for file in files if file.suffix.lower() == ".db3"):
            raise EOFError  # SQLite takes zeros for the last bytes
        _read(Reader(path), found, patterns)
    except Exception as error:  # a damaged bag raises anything
        why = str(error) if isinstance(error, ReaderError) else ""
    else:
        return found, []
    packed = [file.name for file in files if file.name.lower().endswith(COMPRESSED)]
    notes = [f"{path}: {name} is compressed and cannot be unpacked here: zstd -d {name} does it" for name in packed]
    files = [file for file in files if file.suffix.lower() in STORAGES]
    if not files and packed:
        raise ResultsError.of(path, notes[0].removeprefix(f"{path}: "))
    if not files:
        raise ResultsError.of(path, "no bag of rosbag2, which has files that end in .mcap or .db3")
    found = _Found()
    for file in files:
        _salvage(file, found, patterns)
    if not found.topics:
        raise ResultsError.of(path, "no message of it could be read")
    read = f"{counted(len(found.raw), 'message')} could be read"
    if not found.whole:
        notes.append(f"{path}: the bag is cut or damaged: {read}")
    elif path.is_dir() and not (path / "metadata.yaml").exists():
        notes.append(f"{path}: metadata.yaml is missing, and its files are whole: {read}")
    elif path.is_dir() and why:
        notes.append(f"{path}: its files are whole: {read}, although rosbags says {why!r}")
    return found, notes


def _read(reader: Any, found: _Found, patterns: list[re.Pattern[str]]) -> None:
    """Add the messages that a reader of rosbags reads. Raises anything."""
    with reader:
        found.topics.update({c.topic: c.msgtype for c in reader.connections})
        found.encodings.update({c.topic: c.ext.serialization_format for c in reader.connections})
        wanted = [c for c in reader.connections if any(p.fullmatch(c.topic) for p in patterns)]
        for connection, time, data in reader.messages(wanted) if wanted else ():
            found.raw.append(Raw(connection.topic, connection.msgtype, time, data))


def _salvage(file: Path, found: _Found, patterns: list[re.Pattern[str]]) -> None:
    """Add what is readable of one file."""
    try:
        for one in _records(file, found) if file.suffix.lower() == ".mcap" else _rows(file, found):
            if any(pattern.fullmatch(one.topic) for pattern in patterns):
                found.raw.append(one)
    except Exception:  # here the damage begins
        found.whole = False


def _lacking(file: Path) -> int:
    """The bytes that an SQLite file is shorter than its head says."""
    with file.open("rb") as stream:
        head = stream.read(32)
    pages, size = int.from_bytes(head[28:32], "big"), int.from_bytes(head[16:18], "big")
    return max(0, pages * size - file.stat().st_size)


def _rows(file: Path, found: _Found) -> Iterator[Raw]:
    """The messages of an SQLite file, from both ends up to the damage. Raises anything."""
    content, lacking = bytearray(file.read_bytes()), _lacking(file)
    content[18:20] = 1, 1  # no second file is asked for newer rows
    if not lacking or lacking >= MOST_LACKING:
        yield from _rows_of(content, found)
        return
    found.whole = False
    real = set(_rows_of(content + b"\xff" * lacking, _Found()))
    for one in _rows_of(content + bytes(lacking), found):  # SQLite opens no file that is shorter than it should be
        if one in real:  # it has none of the bytes that are made up
            yield one


def _rows_of(content: bytes | bytearray, found: _Found) -> Iterator[Raw]:
    """The messages of the content of an SQLite file. Raises anything before the first of them."""
    with contextlib.closing(sqlite3.connect(":memory:")) as base:
        base.deserialize(bytes(content))
        kinds = {}
        for key, topic, kind, encoding in base.execute("SELECT id, name, type, serialization_format FROM topics"):
            if isinstance(topic, str) and isinstance(kind, str):
                kinds[key] = topic, kind
                found.topics[topic], found.encodings[topic] = kind, str(encoding)
            else:
                found.whole = False
        last = 0
        for order in ("ASC", "DESC"):
            limit = "id > ?" if order == "DESC" else "id >= ?"
            wanted = f"SELECT id, topic_id, timestamp, data FROM messages WHERE {limit} ORDER BY id {order}"
            try:
                for key, topic, time, data in base.execute(wanted, [last]):
                    last = key if order == "ASC" else last
                    if topic in kinds:
                        yield Raw(*kinds[topic], time, data)
            except sqlite3.DatabaseError:
                found.whole = False


def _records(file: Path, found: _Found) -> Iterator[Raw]:
    """The messages of an MCAP file in their order, without its index, which a cut file lacks. Raises anything."""
    from mcap.records import Channel, Message, Schema, Statistics

    schemas: dict[int, str] = {}
    channels: dict[int, str] = {}
    count = 0
    for record in _whole_records(file, found):
        if isinstance(record, Schema):
            schemas[record.id] = record.name
        elif isinstance(record, Channel):
            channels[record.id] = record.topic
            found.topics[record.topic] = schemas.get(record.schema_id, "")
            found.encodings[record.topic] = record.message_encoding
        elif isinstance(record, Statistics):  # chunks need not have checksums
            found.whole = found.whole and count == record.message_count
        elif isinstance(record, Message) and record.channel_id in channels:
            count += 1
            topic = channels[record.channel_id]
            yield Raw(topic, found.topics[topic], record.log_time, record.data)


def _whole_records(file: Path, found: _Found) -> Iterator[Any]:
    """All whole records, also of a chunk that is cut, unless it is compressed. Raises anything."""
    from mcap.opcode import Opcode
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader, breakup_chunk

    size = file.stat().st_size
    with file.open("rb") as stream:
        at = 0
        try:
            for record in StreamReader(stream, emit_chunks=True, record_size_limit=size).records:
                at = stream.tell()
                if not isinstance(record, Chunk):
                    yield record
                    continue
                try:
                    yield from breakup_chunk(record, validate_crc=True)
                except Exception:  # a damaged chunk; the next ones may be whole
                    found.whole = False
        except Exception:
            found.whole = False
            stream.seek(at)
            head = stream.read(CHUNK_HEAD)
            if head[:1] == bytes([Opcode.CHUNK]) and not any(head[COMPRESSION:COMPRESSION_END]):
                yield from StreamReader(io.BytesIO(stream.read()), skip_magic=True, record_size_limit=size).records


def _choose(
    path: Path,
    found: _Found,
    template: str,
    name: str,
    kinds: Iterable[str],
    add: Callable[[_Events, Raw, str, Any], None],
    wanted: dict[str, tuple[Callable[[_Events, Raw, str, Any], None], str]],
    notes: list[str],
) -> None:
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
        notes.append(f"{path}: {which}")
    for topic, robot in meant.items():
        if topic in foreign:
            continue
        package, _, kind = topics[topic].rpartition("/")
        if package != "std_msgs/msg" or kind not in kinds:
            raise ResultsError.of(
                path, f"{topic} is of {topics[topic]}: {option(name)} should be of std_msgs, {', '.join(kinds)}"
            )
        wanted[topic] = add, robot


def _pattern(template: str) -> re.Pattern[str]:
    """What matches the topics of a template, with the robot's name as a group."""
    before, _, after = template.partition(ROBOT)
    return re.compile(f"{re.escape(before)}([^/]+){re.escape(after)}")


def _decoded(raw: list[Raw], wanted: dict[str, tuple[Callable[[_Events, Raw, str, Any], None], str]]) -> _Events:
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
            value: Any = store.deserialize_cdr(one.data, one.kind)
        except Exception:  # rosbags raises anything for bytes that do not fit
            events.undecoded += 1
            continue
        add, robot = wanted[one.topic]
        add(events, one, robot, value.data)
    return events


def _reading(events: _Events, raw: Raw, robot: str, value: Any) -> None:
    if value == value and value not in (0, 1):
        found = f"{raw.topic}: a reading of {value:g}: should be 0 (white), 1 (black) or NaN (none)"
        raise ResultsError(found, key=raw.topic, value=value)
    events.seen.append((raw.time, robot, float(value), raw.topic))


def _heard(events: _Events, raw: Raw, robot: str, value: Any) -> None:
    if isinstance(value, str):
        senders = [name for name in re.split(r"[\s,;]+", value) if name]
    else:
        senders = [str(int(sender)) for sender in np.atleast_1d(value)]
    events.heard += [(raw.time, sender, robot, raw.topic) for sender in senders]


def _steps(path: Path, events: _Events, talks: bool, period: int, notes: list[str]) -> Recorded:
    """Events put into steps."""
    strays = _strays(path, events, period, notes)
    names = sorted({robot for _, robot, *_ in events.seen}, key=_by_number)
    index = {name: k for k, name in enumerate(names)}
    stamps = events.stamps
    first, last = stamps[0][0], stamps[-1][0]
    steps = _step(last, first, period) + 1
    if steps > MOST_STEPS:
        raise ResultsError.of(
            path,
            f"{(last - first) / NANO:,.0f} s are {steps:,} steps of {option('period', period / NANO)}: "
            f"{MOST_STEPS:,} at most{strays and f'; {strays}'}",
        )
    if strays:
        notes.append(f"{path}: {strays}")
    readings = np.full((steps, len(names)), np.nan)
    taken: Counter[tuple[int, int]] = Counter()
    for time, robot, value, _ in sorted(events.seen, key=lambda event: event[0]):
        if value == value:
            place = _step(time, first, period), index[robot]
            readings[place] = value
            taken[place] += 1
    if extra := sum(taken.values()) - len(taken):
        notes.append(
            f"{path}: of several readings in a step the last one counts: {extra:,} of {sum(taken.values()):,} are left "
            f"out, which a shorter {option('period')} would keep"
        )
    if names != [str(k) for k in range(len(names))]:
        notes.append(f"{path}: robots 0 to {len(names) - 1} are {', '.join(names)}")
    return Recorded(readings, _messages(path, events, index, first, period, notes) if talks else None, names, notes)


def _strays(path: Path, events: _Events, period: int, notes: list[str]) -> str:
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
        notes.append(f"{path}: {counted(at, 'event')} at time 0 left out, {longest / NANO:,.0f} s before the others")
        return _strays(path, events, period, notes)
    is_late = 2 * at >= len(stamps)
    count, (time, topic) = (len(stamps) - at, stamps[at]) if is_late else (at, stamps[at - 1])
    where = f"{longest / NANO:,.0f} s {'after' if is_late else 'before'} the others"
    return f"{counted(count, 'event')}, such as that of {topic} at {time / NANO:.1f} s, {where}"


def _messages(
    path: Path, events: _Events, index: dict[str, int], first: int, period: int, notes: list[str]
) -> np.ndarray:
    """Rows of step, sender and receiver; messages of and to robots without readings are left out."""
    rows, own, others = [], 0, Counter[str]()
    known = {name: _known(name, index) for _, sender, receiver, _ in events.heard for name in (sender, receiver)}
    for time, sender, receiver, _ in events.heard:
        here, there = known[sender], known[receiver]
        if here is None or there is None:
            others[sender if here is None else receiver] += 1
        elif here == there:  # some radios hear themselves
            own += 1
        else:
            rows.append((_step(time, first, period), here, there))
    if others and not rows and not own:
        topic, name = next((topic, n) for _, *pair, topic in events.heard for n in pair if known[n] is None)
        said = f"{topic} names {name}, of which there are no readings, as of all that are heard: robots are"
        raise ResultsError.of(path, f"{said} {', '.join(index)}")
    if others:
        left_out = f"{counted(sum(others.values()), 'message')} of or to robots without readings"
        notes.append(f"{path}: {left_out} are left out: {', '.join(sorted(others, key=_by_number))}")
    if own:
        notes.append(f"{path}: {counted(own, 'message')} that a robot heard from itself are left out")
    return np.array(rows, np.int64).reshape(-1, 3)


def _short(name: str, own: set[str]) -> str:
    """A robot's name as {robot} stands for it, where a message gives more of its topic."""
    name = name.strip("/")
    return next((name.removeprefix(one) for one in own if one and name.startswith(one) and name != one), name)


def _known(name: str, index: dict[str, int]) -> int | None:
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
    match = re.fullmatch(r"(.*?)([0-9]+)", name)
    return (match[1], int(match[2])) if match else (name, None)


def _step(time: int, first: int, period: int) -> int:
    return (time - first + period // 2) // period


def _by_number(name: str) -> tuple[int, int, str]:
    return (0, int(name), name) if name.isdecimal() and name.isascii() else (1, 0, name)
