"""Lives lived again from robots' logs: to the bit, and after all that can happen to a log."""

import random
import shutil
import struct
from binascii import crc32
from pathlib import Path

import numpy as np
import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.clocks import Clock
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive
from swarmcensus.robots.logs.logs import block_at
from swarmcensus.robots.logs.traces import as_trace
from swarmcensus.runtime.log import ENDING, MAGIC, OPENING, STATE, TICK, block
from tests.support.lockstep import Swarm
from tests.support.long import in_two_sizes
from tests.support.relived import SEED, estimates_of, logged, recorded, setting_of, told
from tests.support.trials import record_trial

pytestmark = pytest.mark.interpreted


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


@pytest.mark.parametrize(("brain", "message", "precision"), [
    ("commons", "float32", "double"), ("minimalistic", "ratio16", "double"), ("commons", "float16", "single"),
    ("voter", "float16", "double"), ("sure", "ratio8", "double"),
])  # fmt: skip
def test_logs_are_lived_again_to_the_bit_as_their_simulation(tmp_path, brain, message, precision):
    formats = {"message": message, "precision": precision}
    study, shown = recorded(tmp_path / "day", brain, **formats)
    told(tmp_path / "day", study)
    recording, lives = lived(tmp_path / "day")
    for life in lives:
        assert life.to_the_bit, life.breaks
        assert (life.ticks, life.relived, life.lost) == (40, 40, [])
    expected = record_trial(setting_of(brain, **formats)[1], SEED, 0)[1]
    assert (estimates_of(recording, lives, 40) == expected).all()
    assert (expected == shown).all()


@pytest.mark.parametrize(("now", "waits"), [(True, 370), (False, 0)])
def test_robots_that_start_again_resume_what_they_had_saved(tmp_path, now, waits):
    """Robots of a swarm wait for a common beginning; one that starts again does not."""
    shown = killed(tmp_path / "day", now=now, waits=waits)
    recording, lives = lived(tmp_path / "day")
    assert all(life.to_the_bit and not life.lost for life in lives)
    starts = [[s.tick for s in member.log.states if s.starts] for member in recording.members]
    assert starts[1:3] == [[0, 20], [0, 10]]
    clock = Clock(recording.members)
    trace = as_trace(recording, lives)["estimate"].values
    if now:  # the rounds are those of the world
        assert len(trace) == 41
        times = {clock.time(0, at) for at in range(len(recording.members[0].log.blocks))}
        assert times == set(range(41))  # a robot that never started again has its own ticks
        assert np.isnan(trace[24:30, 1]).all()
        there = ~np.isnan(shown)
        assert (trace[there] == shown[there]).all()
    else:
        assert (trace[31:34, 1] == shown[38:41, 1]).all()


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
    trace = as_trace(recording, lives)["estimate"].values
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
    found = estimates_of(recording, lives, 40)
    assert (found[: kept + 1] == shown[: kept + 1]).all()
    assert np.isnan(found[kept + 1 :, 1]).all()
    assert (found[kept + 1 :, [0, 2]] == shown[kept + 1 :, [0, 2]]).all()  # the neighbours of robot 1


@pytest.mark.parametrize(("lost", "resumes", "expected"), [
    (1, 10, "tick 10 is not in the log"), (3, 10, "ticks 10 to 12 are not in the log"),
    (3, 2, "ticks 1 to 2 are not in the log"),
])  # fmt: skip
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
    assert (first.boot, first.tick, first.field) == (0, 19, "message.s")
    assert lives[2].relived == 40 - 6  # it starts again from the state after tick 24


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
    assert (estimates_of(recording, lives, 40)[-1] == shown[-1]).all()


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
        code = main(["relive", str(tmp_path / "day")])
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


@pytest.mark.parametrize("added", [
    TOO_LATE, block(STATE, b""), block(STATE, MAGIC + bytes(63)), block(9, b"?")
], ids=["late", "empty", "version", "kind"])  # fmt: skip
@pytest.mark.parametrize("command", ["relive", "relive --trace t.nc", "export"])
def test_no_block_ends_without_a_sentence(added, command, copied, here, capsys):
    path = copied / "robot-1.log"
    path.write_bytes(path.read_bytes() + added)
    words = command.split()
    assert main([words[0], str(copied), *words[1:]]) in (0, 1, 2)
    assert "internal error" not in capsys.readouterr().err
