"""Bags of ROS 2: `infer` of a bag is, to the bit, `infer` of the same data as CSV files."""

import contextlib
import sqlite3

import numpy as np
import pytest
import xarray as xr

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.bags import is_bag, read_bag
from swarmcensus.summaries.recordings import write_rows
from swarmcensus.support.errors import InputError

pytest.importorskip("rosbags", reason="pip install 'swarmcensus[ros]'")

START, PERIOD = 1_700_000_000_123_456_789, 100_000_000  # ns
TOPICS = ["--readings", "/robot_{robot}/floor", "--messages", "/robot_{robot}/heard", "--period", "0.1"]
ROBOTS, STEPS = 4, 40


@pytest.fixture
def data():
    """Readings with gaps (step, robot), and messages as step, sender, receiver."""
    chance = np.random.default_rng(1)
    readings = (chance.random((STEPS, ROBOTS)) < 0.4).astype(float)
    readings[chance.random((STEPS, ROBOTS)) < 0.2] = np.nan
    readings[0] = 1.0
    pairs = [(i, j) for i in range(ROBOTS) for j in range(ROBOTS) if i != j]
    messages = [(k, *pairs[n]) for k in range(STEPS) for n in sorted(chance.choice(len(pairs), 3, replace=False))]
    return readings, np.array(messages)


def write(path, events, storage="SQLITE3", compressed=None):
    """Write a bag of events: time in ns, topic, type and value."""
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    writer = Writer(path, version=9, storage_plugin=StoragePlugin[storage])
    if compressed:
        writer.set_compression(CompressionMode[compressed], CompressionFormat.ZSTD)
    connections = {}
    with writer:
        for time, topic, kind, value in sorted(events, key=lambda event: event[0]):
            name = f"std_msgs/msg/{kind}"
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=store)
            types = store.types
            if kind.endswith("MultiArray"):
                layout = types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
                message = types[name](layout=layout, data=np.array(value, kind.removesuffix("MultiArray").lower()))
            else:
                message = types[name](data=value)
            writer.write(connections[topic], time, store.serialize_cdr(message, name))


def events_of(data, kind="Bool", heard="Int32MultiArray", jitter=0):
    """The events of data: readings a little early or late, and messages, all senders of a step at once."""
    readings, messages = data
    chance = np.random.default_rng(2)
    make = {"Bool": bool, "UInt8": int, "Int32": int, "Float32": float}[kind]
    events = []
    for (k, robot), value in np.ndenumerate(readings):
        if value == value:
            late = int(chance.integers(-jitter, jitter + 1)) if k else 0
            events.append((START + k * PERIOD + late, f"/robot_{robot}/floor", kind, make(value)))
    for k in range(STEPS):
        for receiver in range(ROBOTS):
            senders = messages[(messages[:, 0] == k) & (messages[:, 2] == receiver), 1]
            said = ", ".join(map(str, senders)) if heard == "String" else senders
            if len(senders):
                events.append((START + k * PERIOD + 1000, f"/robot_{receiver}/heard", heard, said))
    return events


def inferred(*arguments):
    assert main(["infer", *map(str, arguments), "--accuracy", "0.8", "--out", "t.nc", "--plot", "t.svg"]) == 0
    with xr.open_dataset("t.nc") as trace:
        return trace.load()


@pytest.mark.parametrize(
    ("storage", "kind", "heard", "compressed"),
    [
        ("SQLITE3", "Bool", "Int32MultiArray", None),
        ("SQLITE3", "UInt8", "String", "MESSAGE"),
        ("MCAP", "Float32", "UInt16MultiArray", None),
        ("MCAP", "Int32", "String", "FILE"),
    ],
)
def test_a_bag_infers_what_its_csv_files_do(data, here, storage, kind, heard, compressed):
    write(here / "bag", events_of(data, kind, heard, jitter=PERIOD // 3), storage, compressed)
    write_rows("o.csv", [f"robot {k}" for k in range(ROBOTS)], data[0])
    write_rows("l.csv", ["step", "sender", "receiver"], data[1])
    from_csv = inferred("o.csv", "--links", "l.csv")
    from_bag = inferred("bag", *TOPICS)
    xr.testing.assert_identical(from_csv, from_bag)
    assert from_csv["estimate"].values[-1].std() > 0


def test_links_of_a_file_go_with_readings_of_a_bag(data, here):
    write(here / "bag", events_of(data))
    write_rows("o.csv", [f"robot {k}" for k in range(ROBOTS)], data[0])
    write_rows("l.csv", ["i", "j"], np.array([[0, 1], [1, 2], [2, 3]]))
    from_bag = inferred("bag", *TOPICS[:2], *TOPICS[4:], "--links", "l.csv")
    xr.testing.assert_identical(from_bag, inferred("o.csv", "--links", "l.csv"))


def test_robots_keep_their_names_in_their_order(tmp_path):
    events = [(START, f"/{name}/floor", "Bool", name != "b") for name in ("b", "a", "12", "9")]
    events += [(START, "/b/heard", "String", "12 a")]
    write(tmp_path / "bag", events)
    read, heard = read_bag(tmp_path / "bag", "/{robot}/floor", "/{robot}/heard", 0.1)
    assert read.labels == ["9", "12", "a", "b"]
    assert read.values.tolist() == [[1, 1, 1, 0]]
    assert heard.tolist() == [[0, 1, 3], [0, 2, 3]]


def test_the_last_reading_of_a_step_counts_and_is_sent(tmp_path):
    values = [True, False, True, True, False]
    times = [0, 20, 100, 110, 120]  # ms
    events = [(START + t * 10**6, "/robot_0/floor", "Bool", v) for t, v in zip(times, values, strict=True)]
    events += [(START + 5 * 10**6, "/robot_0/heard", "Int32MultiArray", [0])]
    write(tmp_path / "bag", events)
    read, heard = read_bag(tmp_path / "bag", "/robot_{robot}/floor", "/robot_{robot}/heard", 0.1)
    assert read.values.tolist() == [[0], [0]]
    assert "1 message that a robot heard from itself" in read.notes[0]
    assert read.notes[1].startswith("3 readings left out: the last one")
    assert heard.shape == (0, 3)


def long_bag(path, storage):
    events = [(START + k * PERIOD, f"/robot_{r}/floor", "Bool", (k + r) % 3 == 0) for k in range(9000) for r in (0, 1)]
    write(path, events, storage)
    [file] = [p for p in path.iterdir() if p.suffix in (".mcap", ".db3")]
    return file, [k % 3 == 0 for k in range(9000)]


@pytest.mark.parametrize("storage", ["MCAP", "SQLITE3"])
@pytest.mark.parametrize("damage", ["metadata", "cut", "flip", "lost", "added"])
def test_a_damaged_bag_is_refused_with_what_mends_it(tmp_path, refused, storage, damage):
    bag = tmp_path / "bag"
    file, _ = long_bag(bag, storage)
    content = bytearray(file.read_bytes())
    metadata = bag / "metadata.yaml"
    if damage == "metadata":
        metadata.unlink()
    elif damage == "cut":
        file.write_bytes(content[: len(content) * 2 // 3])
    elif damage == "flip":
        middle = len(content) // 2
        content[middle : middle + 64] = bytes(range(64))
        file.write_bytes(content)
    else:  # the recorder counted other messages than there are
        counted = "9001" if damage == "lost" else "8999"
        metadata.write_text(metadata.read_text().replace("message_count: 9000", f"message_count: {counted}", 1))
    said = refused("infer", bag, "--readings", FLOOR, "--period", "0.1", "--accuracy", "0.8")
    assert f"ros2 bag reindex {bag}" in said
    if damage != "metadata":
        assert f"{bag}: cannot be read whole" in said
        assert ("sqlite3 FILE .recover" if storage == "SQLITE3" else "mcap recover FILE") in said
    if damage in ("lost", "added"):
        assert f"/robot_0/floor has 9,000 messages, and {int(counted):,} were counted" in said


@pytest.mark.parametrize("early", [1, 3])
def test_events_before_the_recorder_knew_the_time_are_left_out(tmp_path, early):
    events = [(k, f"/robot_{k % 2}/floor", "Bool", True) for k in [0] * early]
    events += [(START + k * PERIOD, f"/robot_{k % 2}/floor", "Bool", False) for k in range(4)]
    events += [(0, "/robot_0/heard", "Int32", 1), (START, "/robot_1/heard", "Int32", 0)]
    write(tmp_path / "bag", events)
    read, heard = read_bag(tmp_path / "bag", FLOOR, "/robot_{robot}/heard", 0.1)
    assert read.values.shape == (4, 2)
    assert np.nansum(read.values) == 0
    assert heard.tolist() == [[0, 0, 1]]
    assert f"{early + 1} events at time 0 left out" in read.notes[0]


@pytest.mark.parametrize("steps", [(0, 10, 11), (0, 20, 40, 60), (0, 80, 81, 82)])
def test_a_simulated_time_may_begin_at_0(tmp_path, steps):
    write(tmp_path / "bag", [(k * PERIOD, "/robot_0/floor", "Bool", True) for k in steps])
    read, _ = read_bag(tmp_path / "bag", FLOOR, None, 0.1)
    assert (len(read.values), len(read.notes)) == (steps[-1] + 1, 1)


@pytest.mark.parametrize("seconds", [86_400, 10**7])
def test_an_event_of_another_time_is_named(tmp_path, seconds):
    events = [(START + k * PERIOD, "/robot_0/floor", "Bool", True) for k in range(20)]
    write(tmp_path / "bag", [*events, (START + seconds * 10**9, "/robot_0/heard", "Int32", 0)])
    time = START / 10**9 + seconds
    named = f"1 event, such as that of /robot_0/heard at {time:.1f} s, {seconds - 2:,} s after the others"
    if seconds > 10**6:
        with pytest.raises(InputError, match=f"10,000,000 at most; {named}"):
            read_bag(tmp_path / "bag", FLOOR, "/robot_{robot}/heard", 0.1)
    else:
        read, _ = read_bag(tmp_path / "bag", FLOOR, "/robot_{robot}/heard", 0.1)
        assert read.notes[0] == named


def test_a_cut_database_is_refused(tmp_path):
    """Also where a page is cut in its middle, only the last bytes are missing, or rows wait in a second file."""
    events = [(START + k * PERIOD, f"/robot_{r}/floor", "Bool", k % 3 == 0) for k in range(120) for r in (0, 1)]
    write(tmp_path / "bag", events, "SQLITE3")
    [file] = (tmp_path / "bag").glob("*.db3")
    content = file.read_bytes()
    for cut in (*range(1, 60, 7), *range(900, len(content), 900)):
        file.write_bytes(content[:-cut])
        with pytest.raises(InputError, match="cannot be read whole"):
            read_bag(tmp_path / "bag", FLOOR, None, 0.1)
    file.write_bytes(content)
    file.with_name(f"{file.name}-wal").write_bytes(b"rows")
    with pytest.raises(InputError, match="its last messages are in"):
        read_bag(file, FLOOR, None, 0.1)


def test_a_robot_that_is_only_heard_costs_its_messages_alone(tmp_path):
    events = [(START, f"/robot_{k}/floor", "Bool", True) for k in range(2)]
    events += [(START, "/robot_0/heard", "String", "1 7 base"), (START, "/robot_9/heard", "String", "0")]
    write(tmp_path / "bag", events)
    read, heard = read_bag(tmp_path / "bag", FLOOR, "/robot_{robot}/heard", 0.1)
    assert heard.tolist() == [[0, 1, 0]]
    assert read.notes[0].endswith("3 messages of or to robots without readings are left out: 7, 9, base")


@pytest.mark.parametrize("topic", ["/robot_{robot}/", "/{robot}/"])
def test_a_number_names_a_robot_whatever_its_zeros(tmp_path, topic):
    names = ["robot_01", "robot_02", "robot_10"]
    events = [(START, f"/{name}/floor", "Bool", True) for name in names]
    events += [
        (START, "/robot_01/heard", "Int32MultiArray", [2, 10]),
        (START, "/robot_10/heard", "Int32MultiArray", [1]),
    ]
    write(tmp_path / "bag", events)
    _read, heard = read_bag(tmp_path / "bag", f"{topic}floor", f"{topic}heard", 0.1)
    assert heard.tolist() == [[0, 1, 0], [0, 2, 0], [0, 0, 2]]


def test_a_number_that_two_robots_have_names_neither(tmp_path):
    events = [(START, f"/{name}/floor", "Bool", True) for name in ("a1", "b1", "b2")]
    events += [(START, "/b2/heard", "String", "1 b01")]
    write(tmp_path / "bag", events)
    read, heard = read_bag(tmp_path / "bag", "/{robot}/floor", "/{robot}/heard", 0.1)
    assert heard.tolist() == [[0, 1, 2]]
    assert read.notes[0].endswith("1 message of or to robots without readings are left out: 1")


@pytest.mark.parametrize("name", ["robot_1", "/robot_1", "robot_01", "/swarm/robot_1", "1", "01"])
def test_messages_may_name_a_robot_as_its_topic_does(tmp_path, name):
    events = [(START, f"/swarm/robot_{k}/floor", "Bool", True) for k in range(2)]
    write(tmp_path / "bag", [*events, (START, "/swarm/robot_0/heard", "String", name)])
    _read, heard = read_bag(tmp_path / "bag", "/swarm/robot_{robot}/floor", "/swarm/robot_{robot}/heard", 0.1)
    assert heard.tolist() == [[0, 1, 0]]


def test_messages_compressed_one_by_one_need_the_metadata(tmp_path):
    write(tmp_path / "bag", [(START, "/robot_0/floor", "Bool", True)], "SQLITE3", "MESSAGE")
    [file] = (tmp_path / "bag").glob("*.db3")
    with pytest.raises(
        InputError, match="1 message could not be decoded: they are compressed one by one, and metadata"
    ):
        read_bag(file, FLOOR, None, 0.1)


def test_a_chunk_says_itself_that_it_is_compressed(tmp_path):
    write(tmp_path / "bag", [(START, "/robot_0/floor", "Bool", True)], "MCAP", "STORAGE")
    [file] = (tmp_path / "bag").glob("*.mcap")
    assert read_bag(file, FLOOR, None, 0.1)[0].values.tolist() == [[1]]


def test_a_file_compressed_as_a_whole_is_named(tmp_path):
    write(tmp_path / "bag", [(START, "/robot_0/floor", "Bool", True)], "SQLITE3", "FILE")
    [file] = (tmp_path / "bag").glob("*.db3.zstd")
    with pytest.raises(InputError, match=r"is compressed: name its folder, or unpack it with zstd -d bag.*zstd"):
        read_bag(file, FLOOR, None, 0.1)
    assert is_bag(file)


def test_a_topic_that_is_not_cdr_is_named(tmp_path):
    from mcap.writer import Writer

    with (tmp_path / "bag.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema("std_msgs/msg/Bool", "ros2msg", b"bool data")
        for k, (encoding, data) in enumerate([("json", b'{"data": true}'), ("cdr", b"\0\1\0\0\1")]):
            channel = writer.register_channel(f"/robot_{k}/floor", encoding, schema)
            writer.add_message(channel, START, data, START)
        writer.finish()
    read, _ = read_bag(tmp_path / "bag.mcap", FLOOR, None, 0.1)
    assert read.values.tolist() == [[1]]
    said = "/robot_0/floor is encoded as json, not as cdr: it is left out"
    assert read.notes[0] == said
    with pytest.raises(InputError, match=r"no readings on the topics of .*; /robot_0/floor is encoded as json"):
        read_bag(tmp_path / "bag.mcap", "/{robot}_0/floor", None, 0.1)


def test_a_missing_file_of_a_bag_is_named(tmp_path):
    file, _ = long_bag(tmp_path / "bag", "MCAP")
    text = (tmp_path / "bag" / "metadata.yaml").read_text()
    (tmp_path / "bag" / "metadata.yaml").write_text(text.replace(f"- {file.name}", f"- {file.name}\n  - bag_1.mcap", 1))
    with pytest.raises(InputError, match=r"cannot be read whole .*bag_1\.mcap"):
        read_bag(tmp_path / "bag", FLOOR, None, 0.1)


def test_a_file_that_is_not_of_the_bag_is_named(tmp_path):
    file, _ = long_bag(tmp_path / "bag", "MCAP")
    file.with_name("more_1.mcap").write_bytes(file.read_bytes())
    with pytest.raises(InputError, match=r"metadata\.yaml lacks more_1\.mcap: move it away, or ros2 bag reindex"):
        read_bag(tmp_path / "bag", FLOOR, None, 0.1)
    assert read_bag(file, FLOOR, None, 0.1)[0].notes == []  # one file of it was asked for


def test_what_cannot_be_decoded_is_left_out(tmp_path):
    """Rows of other types, as damage leaves them."""
    file, _ = long_bag(tmp_path / "bag", "SQLITE3")
    with contextlib.closing(sqlite3.connect(file)) as base, base:
        base.execute("UPDATE messages SET timestamp = x'00' WHERE id = 3")
        base.execute("UPDATE messages SET data = 5 WHERE id = 4")
        base.execute("UPDATE messages SET data = x'00' WHERE id = 5")
    read, _ = read_bag(tmp_path / "bag", FLOOR, None, 0.1)
    assert read.notes[0] == "3 messages could not be decoded"
    assert np.isnan(read.values).sum() == 3


def test_no_reading_is_nan(tmp_path):
    write(tmp_path / "bag", [(START + k * PERIOD, "/r0/f", "Float32", v) for k, v in enumerate([1.0, np.nan, 0.0])])
    readings = read_bag(tmp_path / "bag", "/r{robot}/f", None, 0.1)[0].values
    np.testing.assert_array_equal(readings, [[1], [np.nan], [0]])


FLOOR = "/robot_{robot}/floor"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["bag"], "bag: a bag needs --readings and --period"),
        (["bag", "--readings", FLOOR], "bag: a bag needs --period"),
        (["bag", "--readings", "/robot_0/floor", "--period", "1"], "should name a robot once as {robot}"),
        (
            ["bag", "--readings", "/r{robot}/x", "--period", "1"],
            "there are /picture_0 (std_msgs/msg/String), /robot_0/",
        ),
        (["bag", "--readings", FLOOR, "--period", "nan"], "--period nan"),
        (["bag", "--readings", FLOOR, "--period", "1e-8"], "steps of --period 1e-08: 10,000,000 at most"),
        (
            ["bag", "--readings", "/picture_{robot}", "--period", "1"],
            "/picture_0 is of std_msgs/msg/String: --readings",
        ),
        (["bag", "--readings", "/robot_{robot}/grey", "--period", "1"], "/robot_0/grey: a reading of 7: should be 0"),
        (["bag", *TOPICS[:2], *TOPICS[4:], "--messages", "/robot_{robot}/far"], "/robot_0/far names 9, of which"),
        (["bag", *TOPICS[:2], *TOPICS[4:], "--messages", FLOOR], "/robot_0/floor is of std_msgs/msg/Bool: --messages"),
        (["bag", *TOPICS, "--links", "l.csv"], "--links l.csv and --messages /robot_{robot}/heard: one of them"),
        (["empty", *TOPICS], "empty: no bag of rosbag2"),
        (["text.db3", *TOPICS], "text.db3"),
        (["text.mcap", *TOPICS], "text.mcap"),
        (["o.csv", "--period", "1"], "--period"),
    ],
)
def test_wrong_input_is_one_sentence(tmp_path, refused, arguments, expected):
    events = [(START + k * 10**9, "/robot_0/floor", "Bool", True) for k in range(2)]
    events += [(START, "/robot_0/grey", "UInt8", 7), (START, "/robot_0/far", "Int32MultiArray", [9])]
    events += [(START, "/robot_0/heard", "Int32", 0), (START, "/picture_0", "String", "a cat")]
    write(tmp_path / "bag", events)
    (tmp_path / "empty").mkdir()
    for name in ("text.db3", "text.mcap"):
        (tmp_path / name).write_text("hello")
    (tmp_path / "o.csv").write_text("1\n")
    assert expected in refused("infer", *arguments, "--accuracy", "0.8")
