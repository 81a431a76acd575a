"""Bags of ROS 2: `infer` of a bag is, to the bit, `infer` of the same data as CSV files."""

import random
import shutil

import numpy as np
import pytest
import xarray as xr

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.bags import read_bag
from swarmcensus.summaries.recordings import write_rows
from swarmcensus.support.errors import InputError

pytest.importorskip("rosbags", reason="pip install 'swarmcensus[ros]'")

START, PERIOD = 1_700_000_000_123_456_789, 100_000_000  # ns
TOPICS = ["--readings", "/robot_{robot}/floor", "--messages", "/robot_{robot}/heard", "--period", "0.1"]
ROBOTS, STEPS = 4, 40


@pytest.fixture(scope="module")
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
    for k, receiver in np.ndindex(STEPS, ROBOTS):
        senders = messages[(messages[:, 0] == k) & (messages[:, 2] == receiver), 1]
        said = ", ".join(map(str, senders)) if heard == "String" else senders
        if len(senders):
            events.append((START + k * PERIOD + 1000, f"/robot_{receiver}/heard", heard, said))
    return events


def inferred(here, what, *options):
    words = [here / what, *options, "--accuracy", 0.8, "--out", here / "t.nc", "--plot", here / "t.svg"]
    assert main(["infer", *map(str, words)]) == 0
    with xr.open_dataset(here / "t.nc") as trace:
        return trace.load()


@pytest.fixture(scope="module")
def csv(data, tmp_path_factory):
    """A folder with the data as tables."""
    here = tmp_path_factory.mktemp("csv")
    write_rows(here / "o.csv", [f"robot {k}" for k in range(ROBOTS)], data[0])
    write_rows(here / "l.csv", ["step", "sender", "receiver"], data[1])
    write_rows(here / "ij.csv", ["i", "j"], np.array([[0, 1], [1, 2], [2, 3]]))
    return here


@pytest.fixture(scope="module")
def from_csv(csv):
    return inferred(csv, "o.csv", "--links", csv / "l.csv")


@pytest.mark.parametrize(("storage", "kind", "heard", "compressed"), [
    ("SQLITE3", "Bool", "Int32MultiArray", None), ("SQLITE3", "UInt8", "String", "MESSAGE"),
    ("MCAP", "Float32", "UInt16MultiArray", "STORAGE"), ("MCAP", "Int32", "String", "FILE"),
])  # fmt: skip
def test_a_bag_infers_what_its_csv_files_do(data, from_csv, tmp_path, storage, kind, heard, compressed):
    write(tmp_path / "bag", events_of(data, kind, heard, jitter=PERIOD // 3), storage, compressed)
    xr.testing.assert_identical(from_csv, inferred(tmp_path, "bag", *TOPICS))
    assert from_csv["estimate"].values[-1].std() > 0


def test_links_of_a_file_go_with_readings_of_a_bag(data, csv, tmp_path):
    write(tmp_path / "bag", events_of(data))
    from_bag = inferred(tmp_path, "bag", *TOPICS[:2], *TOPICS[4:], "--links", csv / "ij.csv")
    xr.testing.assert_identical(from_bag, inferred(csv, "o.csv", "--links", csv / "ij.csv"))


def test_the_last_reading_of_a_step_counts_and_is_sent(tmp_path):
    values = {0: True, 20: False, 100: True, 110: True, 120: False}  # by ms
    events = [(START + ms * 10**6, "/robot_0/floor", "Bool", value) for ms, value in values.items()]
    write(tmp_path / "bag", [*events, (START + 5 * 10**6, "/robot_0/heard", "Int32MultiArray", [0])])
    read, heard = read_bag(tmp_path / "bag", "/robot_{robot}/floor", "/robot_{robot}/heard", 0.1)
    assert read.values.tolist() == [[0], [0]]
    assert "1 message that a robot heard from itself" in read.notes[0]
    assert read.notes[1].startswith("3 readings left out: the last one")
    assert heard.shape == (0, 3)


@pytest.mark.parametrize(("names", "templates", "hearer", "says", "heard", "note"), [
    (("b", "a", "12", "9"), "/{robot}", "b", "12 a", [(1, 3), (2, 3)], ""),
    ((0, 1), "/robot_{robot}", 0, "1 7 base", [(1, 0)], "2 messages of or to robots without readings"),
    (("robot_01", "robot_10"), "/{robot}", "robot_10", "robot_01 1", [(0, 1)], "are left out: 1"),
])  # fmt: skip
def test_messages_name_robots_as_topics_do(tmp_path, names, templates, hearer, says, heard, note):
    place = templates if isinstance(names[0], int) else "/{robot}"
    events = [(START, place.format(robot=name) + "/floor", "Bool", name != "b") for name in names]
    write(tmp_path / "bag", [*events, (START, place.format(robot=hearer) + "/heard", "String", says)])
    read, messages = read_bag(tmp_path / "bag", f"{templates}/floor", f"{templates}/heard", 0.1)
    assert [tuple(row) for row in messages] == [(0, *pair) for pair in heard]
    assert note in "".join(read.notes)
    if names[0] == "b":
        assert (read.labels, read.values.tolist()) == (["9", "12", "a", "b"], [[1, 1, 1, 0]])


def test_no_reading_is_nan_and_time_may_begin_at_0(tmp_path):
    write(tmp_path / "bag", [(k * PERIOD, "/r0/f", "Float32", v) for k, v in [(0, 1.0), (1, np.nan), (8, 0.0)]])
    readings = read_bag(tmp_path / "bag", "/r{robot}/f", None, 0.1)[0].values
    np.testing.assert_array_equal(readings, [[1], *[[np.nan]] * 7, [0]])


# ---- a bag is read whole, or refused
def short_bag(path, storage="MCAP", compressed=None):
    """The file of a bag of two robots, which read 300 times."""
    events = [(START + k * PERIOD, f"/robot_{r}/floor", "Bool", (k + r) % 3 == 0) for k in range(300) for r in (0, 1)]
    write(path, events, storage, compressed)
    [file] = [one for one in path.iterdir() if {".mcap", ".db3"} & {*one.suffixes}]
    return file


def checked_file(path, encoding="cdr"):
    """A file with a checksum of each chunk, as `ros2 bag record` writes it; rosbags writes none."""
    from mcap.writer import Writer

    with path.open("wb") as file:
        writer = Writer(file, chunk_size=2000)
        writer.start(profile="ros2")
        schema = writer.register_schema("std_msgs/msg/Bool", "ros2msg", b"bool data")
        channels = [writer.register_channel(f"/robot_{k}/floor", encoding, schema) for k in (0, 1)]
        for time in range(START, START + 300 * PERIOD, PERIOD):
            for channel in channels:
                writer.add_message(channel, time, bytes([0, 1, 0, 0, (time // PERIOD + channel) % 3 == 0]), time)
        writer.finish()
    return path


@pytest.mark.parametrize("kind", ["SQLITE3", "MCAP", "checked"])
def test_no_bag_that_is_cut_or_damaged_is_believed(tmp_path, kind):
    """Any exception but InputError fails, and so do other readings, or fewer."""
    file = checked_file(tmp_path / "a.mcap") if kind == "checked" else short_bag(tmp_path / "bag", kind)
    whole, chance, refusals = file.read_bytes(), random.Random(7), 0
    right = read_bag(file, FLOOR, None, 0.1)[0].values
    for number in range(40):
        data, at = bytearray(whole), chance.randrange(len(whole))
        if number % 2:
            del data[at:]
        elif kind == "checked":
            data[at] ^= 1 << chance.randrange(8)
        else:  # a sector of a disk; without checksums nobody can tell a single bit
            at -= at % 512
            data[at : at + 512] = bytes(len(data[at : at + 512]))
        file.write_bytes(data)
        try:
            read = read_bag(file if kind == "checked" else file.parent, FLOOR, None, 0.1)[0].values
        except InputError:
            refusals += 1
        else:  # what was hit was no message
            np.testing.assert_array_equal(read, right)
    assert refusals > 25


COUNTED = "(/robot_0/floor has 300 messages, and {} were counted as recorded): "


@pytest.mark.parametrize("storage", ["MCAP", "SQLITE3"])
@pytest.mark.parametrize(("damage", "says"), [
    ("cut", "): "),
    (("message_count: 300", "message_count: 301"), COUNTED.format(301)),
    (("message_count: 300", "message_count: 299"), COUNTED.format(299)),
    (("\n  message_count: 600", "\n  message_count: 900"), "(its topics have 600 messages, and 900 were counted"),
    (("name: /robot_1/floor", "name: /floor"), "(/floor has 0 messages, and 300 were counted as recorded): "),
    (("name: /robot_1/floor", "name: /robot_0/floor"), "(/robot_0/floor has 300 messages, and 600 were counted"),
    (("relative_file_paths:", "relative_file_paths:\n  - more"), "/bag/more"),
    (("relative_file_paths:\n  - bag", "relative_file_paths:\n  - more"), "metadata.yaml lacks bag.{ending}: move"),
    ("no metadata", "metadata.yaml is missing"),
])  # fmt: skip
def test_a_damaged_bag_is_refused_with_what_mends_it(tmp_path, refused, storage, damage, says):
    bag, mend = tmp_path / "bag", "sqlite3 FILE .recover" if storage == "SQLITE3" else "mcap recover FILE"
    file, metadata = short_bag(bag, storage), bag / "metadata.yaml"
    if damage == "cut":
        file.write_bytes(file.read_bytes()[: file.stat().st_size * 2 // 3])
    elif damage == "no metadata":
        metadata.unlink()
    else:
        metadata.write_text(metadata.read_text().replace(f"path: {file.name}", "").replace(*damage, 1))
    said = refused("infer", bag, "--readings", FLOOR, "--period", "0.1", "--accuracy", "0.8")
    assert says.format(ending=file.suffix[1:]) in said
    assert f"ros2 bag reindex {bag}" in said
    assert (f"{bag}: cannot be read whole (" in said and mend in said) or "metadata.yaml " in says


FLOOR = "/robot_{robot}/floor"


@pytest.mark.parametrize(("arguments", "expected"), [
    (["bag"], "bag: a bag needs --readings and --period"),
    (["bag", "--readings", FLOOR], "bag: a bag needs --period"),
    (["bag", "--readings", "/robot_0/floor", "--period", "1"], "should name a robot once as {robot}"),
    (["bag", "--readings", "/r{robot}", "--period", "1"], "there are /picture_0 (std_msgs/msg/String), /robot_0/"),
    (["bag", "--readings", FLOOR, "--period", "nan"], "--period nan"),
    (["bag", "--readings", FLOOR, "--period", "1e-8"], "steps of --period 1e-08: 10,000,000 at most"),
    (["bag", "--readings", "/picture_{robot}", "--period", "1"], "picture_0 is of std_msgs/msg/String: --readings"),
    (["bag", "--readings", "/robot_{robot}/grey", "--period", "1"], "/robot_0/grey: a reading of 7: should be 0"),
    (["bag", *TOPICS[:2], *TOPICS[4:], "--messages", "/robot_{robot}/far"], "messages name 9, of which"),
    (["bag", *TOPICS[:2], *TOPICS[4:], "--messages", FLOOR], "/robot_0/floor is of std_msgs/msg/Bool: --messages"),
    (["bag", *TOPICS, "--links", "l.csv"], "--links l.csv and --messages /robot_{robot}/heard: one of them"),
    (["empty", *TOPICS], "empty: no bag of rosbag2"),
    (["text.db3", *TOPICS], "text.db3"),
    (["text.mcap", *TOPICS], "text.mcap"),
    (["o.csv", "--period", "1"], "--period"),
    (["one.db3", "--readings", FLOOR, "--period", "1"], "one.db3: its messages are compressed: name the folder"),
    (["all.db3.zstd", *TOPICS], "all.db3.zstd: is compressed: name its folder, or unpack it with zstd -d"),
    (["json.mcap", "--readings", FLOOR, "--period", "1"], "/robot_0/floor is encoded as 'json': should be cdr"),
    (["rows.db3", "--readings", FLOOR, "--period", "1"], "read whole (its last messages are in"),
])  # fmt: skip
def test_wrong_input_is_one_sentence(wrong, tmp_path, refused, arguments, expected):
    shutil.copytree(wrong, tmp_path, dirs_exist_ok=True)
    assert expected in refused("infer", *arguments, "--accuracy", "0.8")


@pytest.fixture(scope="module")
def wrong(tmp_path_factory):
    """A folder of bags, and of what is none."""
    here = tmp_path_factory.mktemp("bags")
    events = [(START + k * 10**9, "/robot_0/floor", "Bool", True) for k in range(2)]
    events += [(START, "/robot_0/grey", "UInt8", 7), (START, "/robot_0/far", "Int32MultiArray", [9])]
    events += [(START, "/robot_0/heard", "Int32", 0), (START, "/picture_0", "String", "a cat")]
    write(here / "bag", events)
    (here / "empty").mkdir()
    for name in ("text.db3", "text.mcap"):
        (here / name).write_text("hello")
    (here / "o.csv").write_text("1\n")
    short_bag(here / "one", "SQLITE3", "MESSAGE").rename(here / "one.db3")
    short_bag(here / "all", "SQLITE3", "FILE").rename(here / "all.db3.zstd")
    short_bag(here / "rows", "SQLITE3").rename(here / "rows.db3")
    (here / "rows.db3-wal").write_bytes(b"rows")
    checked_file(here / "json.mcap", "json")
    return here
