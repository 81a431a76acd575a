"""Lives lived again from robots' logs: to the bit, under another brain, and after all that can happen to a log."""

import random
import shutil
import struct
from binascii import crc32
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.clocks import Clock
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive
from swarmcensus.robots.logs.logs import Heard, Tick, block_at
from swarmcensus.robots.logs.other_brain import relive_with
from swarmcensus.robots.logs.traces import as_logged, as_trace, ends_of
from swarmcensus.runtime.log import ENDING, MAGIC, OPENING, STATE, TICK, block
from tests.support.lockstep import Swarm
from tests.support.long import in_two_sizes
from tests.support.relived import SEED, estimates_of, logged, setting_of, told, trace_of
from tests.support.trials import difference, record_trial

pytestmark = pytest.mark.interpreted


def recorded(folder, brain="commons", **given):
    """Logs of a swarm that lived to its end: its study, and what its robots showed."""
    study, _, swarm = logged(folder, brain, **given)
    swarm.run()
    return study, swarm.close()


def lived(folder):
    """The recording of a folder, and its lives."""
    recording = read_recording(folder)
    return recording, [relive(member) for member in recording.members]


def killed(folder, brain="commons", damages=(), now=True, waits=0, **given):
    """A swarm in which robot 1 is killed after tick 23, and is back at tick 31; robot 2 at once after tick 12."""
    _, _, swarm = logged(folder, brain, more={"saves": 5, "now": now, "waits": waits}, **given)
    swarm.run(12)
    swarm.kill(2)
    for name in damages:
        (folder / name).write_bytes(b"damaged")
    swarm.start(2)
    swarm.run(11)
    swarm.kill(1)
    swarm.run(7)
    swarm.start(1)
    swarm.run()
    return swarm.close()


OTHERS = [
    ("commons", "minimalistic", "float32", "double"),
    ("minimalistic", "commons", "ratio16", "double"),
    ("commons", "sure", "float16", "single"),
    ("voter", "voter", "float16", "double"),
    ("sure", "commons", "ratio8", "double"),
    ("commons", "voter", "float32", "single"),
]


@pytest.mark.parametrize(("brain", "other", "message", "precision"), OTHERS)
def test_logs_are_lived_again_to_the_bit_and_by_another_brain_as_its_simulation(
    tmp_path, brain, other, message, precision
):
    formats = {"message": message, "precision": precision}
    study, shown = recorded(tmp_path / "day", brain, **formats)
    told(tmp_path / "day", study)
    recording, lives = lived(tmp_path / "day")
    for life in lives:
        assert life.to_the_bit, life.breaks
        assert (life.ticks, life.relived, life.lost) == (40, 40, [])
    for one in (brain, other):
        expected = record_trial(setting_of(one, **formats)[1], SEED, 0)[1]
        result = relive_with(recording, brains.load(one))
        assert (estimates_of(recording, result, 40) == expected).all()
        assert one != brain or ((expected == shown).all() and not result.unknown)


@pytest.mark.parametrize(("now", "waits"), [(True, 370), (False, 0)])
def test_robots_that_start_again_resume_what_they_had_saved(tmp_path, now, waits):
    """Robots of a swarm wait for a common beginning; one that starts again does not."""
    shown = killed(tmp_path / "day", now=now, waits=waits)
    recording, lives = lived(tmp_path / "day")
    assert all(life.to_the_bit and not life.lost for life in lives)
    starts = [[s.tick for s in member.log.states if s.starts] for member in recording.members]
    assert starts[1:3] == [[0, 20], [0, 10]]
    clock = Clock(recording.members)
    trace = as_trace(recording, as_logged(recording, lives), clock)["estimate"].values
    if now:  # the rounds are those of the world
        assert len(trace) == 41
        times = {clock.time(0, at) for at in range(len(recording.members[0].log.blocks))}
        assert times == set(range(41))  # a robot that never started again has its own ticks
        assert np.isnan(trace[24:30, 1]).all()
        there = ~np.isnan(shown)
        assert (trace[there] == shown[there]).all()
    else:
        assert (trace[31:34, 1] == shown[38:41, 1]).all()
    same = relive_with(recording, recording.brain, clock=clock)
    assert not same.unknown
    assert difference(trace_of(recording, same), trace_of(recording, as_logged(recording, lives))) is None


def test_a_stopped_robot_has_no_numbers_in_between(tmp_path):
    """Its process misses ticks, and its count of them lags behind the clock."""
    _, _, swarm = logged(tmp_path / "day", more={"saves": 5})
    swarm.run(12)
    stopped, swarm.robots[1] = swarm.robots[1], None
    swarm.run(8)
    swarm.robots[1] = stopped
    swarm.kill(3)
    swarm.start(3)
    swarm.run()
    shown = swarm.close()
    recording, lives = lived(tmp_path / "day")
    trace = as_trace(recording, as_logged(recording, lives), Clock(recording.members))["estimate"].values
    assert np.isnan(trace[13:21, 1]).all()
    np.testing.assert_array_equal(trace, shown)


def test_late_start_is_known(tmp_path):
    _, _, swarm = logged(tmp_path / "day", robots=3, rounds=20)
    swarm.kill(2)
    (tmp_path / "day" / "robot-2.log").unlink()
    swarm.run(10)
    swarm.start(2)
    swarm.run(10)
    swarm.close()
    clock = Clock(read_recording(tmp_path / "day").members)
    assert [clock.time(robot, 0) for robot in range(3)] == [0, 0, 10]
    assert {clock.last(robot) for robot in range(3)} == {20}


@pytest.mark.parametrize("other", ["minimalistic", "voter"])
def test_another_brain_goes_on_with_what_it_would_have_saved(tmp_path, other):
    killed(tmp_path / "day", damages=["memory-2"])
    told(tmp_path / "day", setting_of()[0])
    expected = killed(tmp_path / "other", other, damages=["memory-2"])
    recording = read_recording(tmp_path / "day")
    result = relive_with(recording, brains.load(other))
    assert [state.tick for state in recording.members[2].log.states if state.starts] == [0, 0]  # it was damaged
    clock = Clock(recording.members)
    found = as_trace(recording, result, clock)["estimate"].values
    if other == "voter":  # the luck of another boot is another one
        expected, found = expected[:13], found[:13]
    there = ~np.isnan(expected)
    assert (found[there] == expected[there]).all()
    assert result.counts["missing"] == result.counts["lost"] == 0


def test_replay_of_a_cut_log(tmp_path):
    _, shown = recorded(tmp_path / "day")
    path = tmp_path / "day" / "robot-1.log"
    path.write_bytes(path.read_bytes()[:-300])
    recording, lives = lived(tmp_path / "day")
    assert all(life.to_the_bit for life in lives)
    kept = lives[1].ticks
    (lost,) = lives[1].lost
    assert kept < 40
    assert (lost.after, lost.before) == (kept, None)
    assert lost.reason.startswith("the file is cut or damaged: ")
    same = relive_with(recording, recording.brain)
    found = estimates_of(recording, same, 40)
    assert same.counts["missing"] > 0
    assert (found[: kept + 1] == shown[: kept + 1]).all()
    assert (found[kept + 1 :, [0, 2]] != shown[kept + 1 :, [0, 2]]).any()  # the neighbours of robot 1


@pytest.mark.parametrize(
    ("lost", "resumes", "expected"),
    [
        (1, 10, "tick 10 is not in the log"),
        (3, 10, "ticks 10 to 12 are not in the log"),
        (3, 2, "ticks 1 to 2 are not in the log"),
    ],
)
def test_ticks_after_a_loss_are_unknown_and_not_different(tmp_path, capsys, lost, resumes, expected):
    """Robot 1 loses ticks; in the last case the start of a life whose saved memory comes next."""
    _, _, swarm = logged(tmp_path / "day")
    swarm.run(9)
    robot = swarm.robots[1]
    robot.log.hold = 10**6
    swarm.run(lost)
    robot.log.held.clear()
    robot.log.hold = 0
    if resumes < 10:
        robot.ticks = resumes
        robot.log.state(robot, False)
    swarm.run()
    swarm.close()
    unknown = 31 - lost if resumes == 10 else 0
    assert main(["relive", str(tmp_path / "day")]) == 1
    said = capsys.readouterr().out
    assert (f"{unknown} ticks not lived again: the memory before is not known" in said) == (unknown > 0)
    assert f"robot 1, boot 0: {expected}" in said
    assert said.count("not in the log") == 1


def test_a_sensor_that_lies_to_the_log_is_found(tmp_path):
    recorded(tmp_path / "day", more={"saves": 8, "lies": lambda robot, tick: (robot, tick) == (2, 19)})
    _, lives = lived(tmp_path / "day")
    assert all(life.to_the_bit for life in lives if life.number != 2)
    [first] = lives[2].breaks
    assert (first.boot, first.tick) == (0, 19)
    assert first.field == "message.s"
    assert lives[2].relived == 40 - 6  # it starts again from the state after tick 24


def test_readings_that_were_not_made_are_counted(tmp_path):
    """Of a robot that was done, where the other brain is not."""
    own = tmp_path / "ends.py"
    own.write_text(brains.load("commons").source + "\n\ndef done(me):\n    return me.v > 4.0\n")
    recorded(tmp_path / "day", str(own))
    recording, lives = lived(tmp_path / "day")
    assert all(life.to_the_bit for life in lives)
    without = sum(not tick.looks for member in recording.members for tick in member.log.ticks)
    assert relive_with(recording, brains.load("minimalistic")).counts["unread"] == without > 0


@pytest.mark.parametrize(("first", "boot"), [(65_520, 0), (131_060, 255), (0, 300)])
def test_ticks_and_boots_wrap_in_messages(tmp_path, first, boot):
    _, setting = setting_of()
    folder = tmp_path / "day"
    swarm = Swarm(folder, setting, SEED, first=first)
    for path in folder.glob("*.log"):
        path.unlink()
    for robot in swarm.robots:
        robot.log.close()
        robot.boot = boot
        robot.record(robot.log)
    swarm.run()
    shown = swarm.close()
    (folder / "brain.py").write_text(setting.brain.source)
    recording, lives = lived(folder)
    assert all(life.to_the_bit for life in lives)
    same = relive_with(recording, recording.brain)
    assert not same.counts["missing"]
    assert ends_of(recording, same).tolist() == shown[-1].tolist()


@pytest.mark.parametrize("brain", ["commons", "voter"])  # a voter says one of two things
def test_a_message_is_of_the_nearest_tick_with_its_low_bytes(tmp_path, brain):
    """After 65,536 ticks the low bytes are the same again."""
    given = {"robots": 2, "rounds": 60, "topology": "full"}
    _, _, swarm = logged(tmp_path / "day", brain, more={"now": False}, **given)
    swarm.run(20)
    for robot in swarm.robots:  # as if 65,536 ticks less some had passed, in which nothing was written
        robot.ticks += 65_536 - 15
        robot.log.state(robot, False)
    swarm.run()
    swarm.close()
    recording, lives = lived(tmp_path / "day")
    assert all(life.to_the_bit for life in lives)
    same, was = relive_with(recording, recording.brain), as_logged(recording, lives)
    assert +same.counts == {"lost": 2 * (65_536 - 15)}
    assert difference(trace_of(recording, same), trace_of(recording, was)) is None


def test_the_other_brain_speaks_where_the_first_was_silent(tmp_path):
    recorded(tmp_path / "day", "voter")
    recording = read_recording(tmp_path / "day")
    result = relive_with(recording, brains.load("commons"))
    silent = sum(tick.said is None for member in recording.members for tick in member.log.ticks)
    assert result.counts["unheard"] == silent > 0
    back = relive_with(recording, brains.load("voter"))
    assert not +back.counts


def test_forged_names_are_counted(tmp_path):
    _, _, swarm = logged(tmp_path / "day")
    swarm.run(20)
    forged = bytearray(swarm.bodies[1].sent[-1])
    forged[4:6] = struct.pack("<H", 21)  # the next tick
    forged[6] ^= 1
    swarm.bodies[0].waiting.append(bytes(forged))
    swarm.robots[0]._hear()
    swarm.run()
    swarm.close()
    recording, lives = lived(tmp_path / "day")
    assert all(life.to_the_bit for life in lives)
    assert +relive_with(recording, recording.brain).counts == {"missing": 1}


def test_logs_that_contradict_each_other_come_to_an_end(tmp_path):
    """Each of two robots heard a message that the other said only after it."""
    recorded(tmp_path / "day", robots=2, rounds=9, topology="full")
    recording = read_recording(tmp_path / "day")
    changed = []
    for member, other in zip(recording.members, recording.members[::-1], strict=True):
        late = other.log.ticks[6]
        early = [late.said and Heard(other.number, 0, 7, late.said)]
        blocks = [
            b._replace(heard=tuple(early)) if isinstance(b, Tick) and b.tick == 3 else b for b in member.log.blocks
        ]
        changed.append(replace(member, log=replace(member.log, blocks=tuple(blocks))))
    result = relive_with(replace(recording, members=tuple(changed)), brains.load("minimalistic"))
    assert result.counts["missing"] >= 1
    assert {len(blocks) for blocks in result.lived.values()} == {10}


@in_two_sizes("count", 16, 80)
@pytest.mark.parametrize("forged", [False, True])
def test_no_log_that_is_cut_or_damaged_is_believed(tmp_path, capsys, forged, count):
    """Each is refused, or what is missing is said; where somebody made the checksum right, nothing is raised."""
    study, _ = recorded(tmp_path / "day", "voter", robots=3, rounds=12, more={"saves": 4})
    told(tmp_path / "day", study, result={"ticks": [12] * 3})
    path = tmp_path / "day" / "robot-1.log"
    data, chance, doubts = path.read_bytes(), random.Random(5), 0
    for number in range(count):
        changed, at = bytearray(data), chance.randrange(len(data))
        changed[at : at + 1 + 63 * (number % 2)] = chance.randbytes(len(data[at : at + 1 + 63 * (number % 2)]))
        if forged:
            changed = bytearray(data)
            changed[at] ^= 1 << chance.randrange(8)
            end = block_at(data, begins_before(data, at))[2] - 2
            changed[end : end + 2] = struct.pack("<H", crc32(changed[begins_before(data, at) : end]) & 0xFFFF)
        elif chance.random() < 0.5:
            changed = changed[:at]
        path.write_bytes(changed)
        code = main(["relive", str(tmp_path / "day"), "--brain", "commons"])
        said = capsys.readouterr()
        assert "internal error" not in said.err
        assert code in (0, 1, 2)
        doubts += any(words in said.out + said.err for words in ("not in the log", "left out: ", "differs at tick"))
        assert forged or changed == data or doubts == number + 1, said
    assert doubts > 0.3 * count


def begins_before(data, at):
    """Where the block of a log begins that holds a byte."""
    begin = 0
    while (end := block_at(data, begin)[2]) <= at:
        begin = end
    return begin


# ---- logs and swarm.json that somebody has made up


TOO_LATE = block(TICK, struct.pack(OPENING, 100_000_000, 5, 0, 0, 0, 0) + struct.pack(ENDING, 0.5, 7))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs") / "day"
    told(folder, recorded(folder)[0])
    return folder


@pytest.fixture
def copied(whole, tmp_path):
    return Path(shutil.copytree(whole, tmp_path / "day"))


@pytest.mark.parametrize(
    "added",
    [TOO_LATE, block(STATE, b""), block(STATE, MAGIC + bytes(63)), block(9, b"?")],
    ids=["late", "empty", "version", "kind"],
)
@pytest.mark.parametrize("command", ["relive", "relive --brain minimalistic --trace t.nc", "export"])
def test_no_block_ends_without_a_sentence(added, command, copied, here, capsys):
    path = copied / "robot-1.log"
    path.write_bytes(path.read_bytes() + added)
    words = command.split()
    assert main([words[0], str(copied), *words[1:]]) in (0, 1, 2)
    assert "internal error" not in capsys.readouterr().err
