"""Logs of a folder of robots as MCAP: what another library reads in the file is what the logs hold."""

import json
import sys

import pytest

from swarmcensus.robots.logs.clocks import LogTimes
from swarmcensus.robots.logs.logs import Tick, read_log
from swarmcensus.robots.logs.mcap_files import write_mcap
from tests.support.boards import Clock
from tests.support.logged import live, made

NOW = 1_700_000_000_000


@pytest.fixture
def folder(tmp_path):
    """Three robots, and what they logged in 20 ticks."""
    folder, clock = tmp_path / "day", Clock()
    folder.mkdir()
    live([made(folder, number, clock, now=NOW) for number in (3, 0, 7)], clock, 20)
    about = {"format": 1, "fill_ratio": 0.55, "title": "a day", "links": [[0, 1]]}
    (folder / "swarm.json").write_text(json.dumps(about))
    return folder


def read(path):
    """Schemas by topic, messages by topic, and metadata of a file."""
    reader = pytest.importorskip("mcap.reader", reason="pip install 'swarmcensus[ros]'")
    with path.open("rb") as file:
        opened = reader.make_reader(file, validate_crcs=True)
        schemas, messages = {}, {}
        for schema, channel, message in opened.iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            schemas[channel.topic] = json.loads(schema.data)
            messages.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))
        return schemas, messages, {record.name: record.metadata for record in opened.iter_metadata()}


def exported(folder, tmp_path):
    pytest.importorskip("mcap", reason="pip install 'swarmcensus[ros]'")
    written = write_mcap(folder, tmp_path / "day.mcap")
    return written, *read(tmp_path / "day.mcap")


def test_each_robot_has_its_channels(folder, tmp_path):
    written, schemas, messages, metadata = exported(folder, tmp_path)
    kinds = ("estimate", "reading", "said", "heard")
    assert set(messages) == {f"/robot_{n}/{kind}" for n in (0, 3, 7) for kind in kinds} | {"/swarm/fill_ratio"}
    assert written == (f"3 robots, 60 ticks, {sum(map(len, messages.values()))} messages", [])
    validator = pytest.importorskip("jsonschema")
    for topic, sent in messages.items():
        for _, content in sent:
            validator.validate(content, schemas[topic] | {"additionalProperties": False})
    assert [content["fill_ratio"] for _, content in messages["/swarm/fill_ratio"]] == [0.55, 0.55]
    assert metadata["swarm"] == {"format": "1", "fill_ratio": "0.55", "title": "a day", "links": "[[0, 1]]"}


def test_what_is_in_the_channels_is_what_is_in_the_log(folder, tmp_path):
    _, _, messages, _ = exported(folder, tmp_path)
    ticks = read_log(folder / "robot-3.log").ticks
    times = [(NOW + 100 * k) * 10**6 for k in range(1, 21)]
    estimates = messages["/robot_3/estimate"]
    assert [content["estimate"] for _, content in estimates] == [tick.estimate for tick in ticks]
    assert [time for time, _ in estimates] == times
    assert [content["blacks"] for _, content in messages["/robot_3/reading"]] == [tick.blacks for tick in ticks]
    assert [bytes.fromhex(c["code"]) for _, c in messages["/robot_3/said"]] == [tick.said for tick in ticks]
    heard = [(one.sender, one.tick, one.code.hex()) for tick in ticks for one in tick.heard]
    assert heard
    assert [(c["sender"], c["sender_tick"], c["code"]) for _, c in messages["/robot_3/heard"]] == heard


def times_of(log):
    times = LogTimes()
    found = [(times.of(block), block) for block in read_log(log).blocks]
    return [now for now, block in found if now is not None and isinstance(block, Tick)]


def test_a_clock_that_begins_again_goes_on(tmp_path):
    clock = Clock(2**30 - 250)
    live([made(tmp_path, 1, clock, now=NOW)], clock, 6)
    assert [tick.clock for tick in read_log(tmp_path / "robot-1.log").ticks][2] == 50
    assert times_of(tmp_path / "robot-1.log") == [NOW + 100 * k for k in range(1, 7)]


@pytest.mark.parametrize("begun", [(NOW, NOW + 90_000), (0, 0)], ids=["with times", "without"])
def test_a_boot_begins_at_its_own_time_or_after_the_one_before(tmp_path, begun):
    for boot, now in enumerate(begun):
        clock = Clock(777)
        live([made(tmp_path, 1, clock, now=now, boot=boot)], clock, 3)
    starts = begun if begun[0] else (0, 300)
    assert times_of(tmp_path / "robot-1.log") == [now + 100 * k for now in starts for k in (1, 2, 3)]


def test_robots_without_a_time_begin_with_the_others_and_messages_are_in_order(folder, tmp_path):
    clock = Clock()
    live([made(folder, 9, clock)], clock, 2)
    _, _, messages, _ = exported(folder, tmp_path)
    assert messages["/robot_9/estimate"][0][0] == (NOW + 100) * 10**6
    from mcap.stream_reader import StreamReader

    with (tmp_path / "day.mcap").open("rb") as file:
        times = [record.log_time for record in StreamReader(file).records if type(record).__name__ == "Message"]
    assert (times, len(set(times))) == (sorted(times), 20)


def test_a_cut_log_is_written_as_far_as_it_is_whole(folder, here, accepted):
    pytest.importorskip("mcap", reason="pip install 'swarmcensus[ros]'")
    log = folder / "robot-3.log"
    log.write_bytes(log.read_bytes()[:-5])
    ticks = read_log(log).ticks
    lost = "day: robot 3, boot 0: ticks 20 on are not in the log: the file is cut or damaged: "
    assert lost in accepted("export", "day").err
    assert len(read(here / "day.mcap")[1]["/robot_3/estimate"]) == len(ticks) == 19


@pytest.mark.parametrize(("arguments", "expected"), [
    (["day", "--out", "x.txt"], "--out x.txt"),
    (["day", "--where", "robots == 3"], "--where is for results files"),
    (["day", "--out", "day/robot-0.log"], "--out day/robot-0.log: what this writes ends in .mcap"),
    (["small.nc", "--out", "x.xls"], "--out x.xls: what this writes ends in .csv or .parquet"),
    (["empty"], "empty: it holds no log: should be a folder with files such as robot-0.log"),
    (["twice"], "two logs are of robot 0: each robot has one"),
    (["foreign"], "should be a robot's log"),
    (["mixed"], "of robot 0 and of robot 3"),
    (["torn"], "swarm.json: cannot be read as JSON"),
])  # fmt: skip
def test_wrong_input_is_one_sentence(folder, tmp_path, small_file, refused, arguments, expected):
    pytest.importorskip("mcap", reason="pip install 'swarmcensus[ros]'")
    log = (folder / "robot-0.log").read_bytes()
    files = {
        "twice/a.log": log, "twice/b.log": log, "torn/a.log": log, "torn/swarm.json": b"{",
        "foreign/a.log": b"hello" * 9, "mixed/a.log": log + (folder / "robot-3.log").read_bytes(),
    }  # fmt: skip
    for name, data in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(data)
    (tmp_path / "empty").mkdir()
    (tmp_path / "small.nc").write_bytes(small_file.read_bytes())
    assert expected in refused("export", *arguments)


@pytest.mark.parametrize(("library", "words"), [
    ("mcap.writer", ["export", "day"]),
    ("rosbags.rosbag2", ["infer", "day", *["--readings", "/{robot}", "--period", "1"]]),
])  # fmt: skip
def test_a_missing_library_says_what_to_install(library, words, folder, monkeypatch, refused):
    monkeypatch.setitem(sys.modules, library, None)
    more = ["--accuracy", "0.8"] * (words[0] == "infer")
    assert "pip install 'swarmcensus[ros]'" in refused(*words, *more)
