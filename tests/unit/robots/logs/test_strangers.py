"""Logs that are not of a folder's recording are named, and a log that is only cut, full or absent is not."""

import json
import shutil

import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.strangers import strangers_of
from tests.support.lockstep import BEGUN
from tests.support.relived import logged, told

pytestmark = pytest.mark.interpreted
DAY = 86_400_000


def recorded(folder, boot=0, **more):
    """Logs of a swarm of five on a ring that lived to its end, and its study."""
    study, _, swarm = logged(folder, more=more)
    if boot:
        for robot in swarm.robots:
            robot.log.close()
            (folder / f"robot-{robot.number}.log").unlink()
            robot.boot = boot
            robot.record(robot.log)
    swarm.run()
    swarm.close()
    return study


def lose(log, live):
    """Let robots live so that nothing of it comes into a log."""
    log.hold = 10**6
    live()
    log.held.clear()
    log.hold = 0


def strangers(folder):
    return strangers_of(read_recording(folder))


def verdict(folder, capsys):
    """The exit code of `relive`, and what it says."""
    capsys.readouterr()
    return main(["relive", str(folder)]), capsys.readouterr().out


def test_a_log_of_another_recording_is_named(tmp_path, capsys):
    recorded(tmp_path / "day")
    assert verdict(tmp_path / "day", capsys)[0] == 0
    recorded(tmp_path / "other", trial=1)
    shutil.copy(tmp_path / "other" / "robot-2.log", tmp_path / "day")
    code, said = verdict(tmp_path / "day", capsys)
    assert code == 1
    assert "5 of 5 robots lived again to the bit" in said
    assert said.count("of this recording") == 1
    assert "robot 2 is not of this recording: its log and 2 others contradict each other" in said


def test_a_log_of_other_boots_is_named(tmp_path, capsys):
    """None of its messages can be in the others' logs, nor theirs in its own."""
    recorded(tmp_path / "day")
    recorded(tmp_path / "other", boot=7)
    shutil.copy(tmp_path / "other" / "robot-2.log", tmp_path / "day")
    code, said = verdict(tmp_path / "day", capsys)
    assert code == 1
    assert said.count("of this recording") == 1
    assert "robot 2 is not of this recording: of " in said
    assert "no sender's log has any" in said


@pytest.mark.parametrize(
    ("times", "names"),
    [
        ({"started": BEGUN, "ended": BEGUN + 4000}, 0),
        ({"started": BEGUN + 30_000, "ended": None}, 0),
        ({"started": BEGUN + DAY, "ended": None}, 5),
        ({"started": BEGUN - DAY, "ended": BEGUN - DAY + 4000}, 5),
    ],
)
def test_times_are_those_of_the_swarm(tmp_path, capsys, times, names):
    study = recorded(tmp_path / "day")
    told(tmp_path / "day", study, **times)
    code, said = verdict(tmp_path / "day", capsys)
    assert (code, said.count("is not of this recording: it started on 2023-11-14 22:13:20 UTC")) == (names > 0, names)


def test_numbers_are_those_of_the_swarm(tmp_path, capsys):
    study = recorded(tmp_path / "day")
    told(tmp_path / "day", study, robots=[{"number": k, "log": f"robot-{k}.log"} for k in range(4)])
    code, said = verdict(tmp_path / "day", capsys)
    assert code == 1
    assert "robot 4 is not of this recording: swarm.json has no robot of this number" in said
    told(tmp_path / "day", study, robots=[{"number": 4 - k, "log": f"robot-{k}.log"} for k in range(5)])
    code, said = verdict(tmp_path / "day", capsys)
    assert code == 1
    assert "robot 0 is not of this recording: robot-0.log is the log of robot 4 in swarm.json" in said


@pytest.mark.parametrize(("ended", "names"), [(BEGUN - 1500, 0), (BEGUN - 5000, 5)])
def test_clocks_of_one_machine_are_the_same(tmp_path, ended, names):
    """The swarm.json of a run that ended seconds before, where `swarm` ran both."""
    robots = [{"number": k, "log": f"robot-{k}.log", "runs_on": "cpython"} for k in range(5)]
    told(tmp_path / "day", recorded(tmp_path / "day"), robots=robots, started=BEGUN - 9000, ended=ended)
    assert len(strangers(tmp_path / "day")) == names


def test_sensors_are_those_of_the_swarm(tmp_path):
    robots = [{"number": k, "log": f"robot-{k}.log", "b": 0.8, "w": 0.8 + 0.1 * (k == 3)} for k in range(5)]
    told(tmp_path / "day", recorded(tmp_path / "day"), robots=robots)
    assert strangers(tmp_path / "day") == [((3,), "its log has w = 0.8, and swarm.json 0.9")]


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        ({"robots": [{"number": "1", "log": "robot-1.log"}]}, "number = '1': should be a whole number"),
        ({"started": "yesterday"}, "started = 'yesterday': should be a number"),
        ({"ended": [1]}, "ended = [1]: should be a number"),
        ({"started": float("inf")}, "started = inf: should be a number"),
    ],
)
def test_wrong_values_of_swarm_json_are_refused(tmp_path, refused, wrong, expected):
    told(tmp_path / "day", recorded(tmp_path / "day"), **wrong)
    assert f"swarm.json: {expected}" in refused("relive", tmp_path / "day")


def test_one_forged_message_is_named(tmp_path, capsys):
    _, _, swarm = logged(tmp_path / "day")
    swarm.run(20)
    forged = bytearray(swarm.bodies[1].sent)
    forged[4] += 1  # the next tick
    forged[6] ^= 1
    swarm.bodies[0].waiting.append(bytes(forged))
    swarm.robots[0]._hear()
    swarm.run()
    swarm.close()
    capsys.readouterr()
    assert main(["relive", str(tmp_path / "day"), "--json"]) == 1
    [one] = json.loads(capsys.readouterr().out)["strangers"]
    assert one["robots"] == [0, 1]
    assert one["reason"].startswith(
        "robot 0 heard in tick 21 a message of robot 1, tick 21, that the log of robot 1 has"
    )


def test_logs_that_are_cut_or_absent_are_of_the_recording(tmp_path):
    study = recorded(tmp_path / "day")
    told(tmp_path / "day", study, robots=[{"number": k, "log": f"robot-{k}.log"} for k in range(5)])
    path = tmp_path / "day" / "robot-2.log"
    data = path.read_bytes()
    for kept in (len(data) // 2, len(data) // 9):
        path.write_bytes(data[:kept])
        assert strangers(tmp_path / "day") == []
    path.unlink()
    assert strangers(tmp_path / "day") == []


def test_robots_that_start_again_are_of_the_recording(tmp_path):
    """Their ticks begin again at a saved memory, after ticks that are in no log."""
    _, _, swarm = logged(tmp_path / "day", more={"saves": 5})
    swarm.robots[1].log.hold = 400
    swarm.run(18)
    swarm.robots[1].log.held.clear()
    for number in (1, 2):
        swarm.kill(number)
        swarm.start(number)
    swarm.run()
    swarm.close()
    assert strangers(tmp_path / "day") == []


@pytest.mark.parametrize("loses", [False, True])
def test_ticks_whose_low_bytes_come_again_contradict_nothing(tmp_path, loses):
    """With `loses`, only another lap has the bytes of three ticks of robot 1."""
    _, _, swarm = logged(tmp_path / "day", robots=2, rounds=60, topology="full")
    swarm.run(9)
    if loses:
        lose(swarm.robots[1].log, lambda: swarm.run(3))
    for robot in swarm.robots:
        robot.ticks += 65_536 - 15
        robot.log.state(robot, False)
    swarm.run()
    swarm.close()
    assert strangers(tmp_path / "day") == []


def test_ticks_of_which_only_another_life_is_in_the_log_contradict_nothing(tmp_path):
    """Robot 1 loses the end of its log, and its boot count with its memory."""
    _, _, swarm = logged(tmp_path / "day", robots=3, rounds=60, topology="full")
    swarm.run(9)
    lose(swarm.robots[1].log, lambda: swarm.run(5))
    swarm.kill(1)
    swarm.start(1)
    swarm.run()
    swarm.close()
    assert strangers(tmp_path / "day") == []


@pytest.mark.parametrize("others", ["lose all", "are full"])
def test_a_robot_that_hears_only_what_no_log_has_is_of_the_recording(tmp_path, others):
    _, _, swarm = logged(tmp_path / "day", robots=3, rounds=40, topology="full")
    swarm.kill(0)
    (tmp_path / "day" / "robot-0.log").unlink()
    if others == "lose all":
        for robot in swarm.robots[1:]:
            robot.log.hold = 10**6
    swarm.run(10)
    for robot in swarm.robots[1:]:
        robot.log.most = robot.log.size
    swarm.start(0)
    swarm.run()
    for robot in swarm.robots[1:]:
        robot.log.held.clear()
    swarm.close()
    assert len(read_recording(tmp_path / "day").members[0].log.ticks) == 30
    assert strangers(tmp_path / "day") == []


def test_names_in_upper_case_are_logs_and_others_are_named(tmp_path, capsys):
    study = recorded(tmp_path / "day")
    told(tmp_path / "day", study)
    for number in range(3):
        (tmp_path / "day" / f"robot-{number}.log").rename(tmp_path / "day" / f"ROBOT-{number}.LOG")
    code, said = verdict(tmp_path / "day", capsys)
    assert (code, "5 of 5 robots lived again to the bit" in said) == (0, True)
    (tmp_path / "day" / "ROBOT-1.LOG").rename(tmp_path / "day" / "ROBOT-1.BAK")
    with pytest.warns(UserWarning, match=r"left out, as logs of robots end in \.log: ROBOT-1\.BAK"):
        assert len(read_recording(tmp_path / "day").members) == 4
