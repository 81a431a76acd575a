"""Logs that are not of a folder's recording are named, and a log that is only cut or absent is not."""

import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.foreign_logs import strangers_of
from swarmcensus.robots.logs.logs import _block
from tests.support.lockstep import BEGUN
from tests.support.relived import logged, told

pytestmark = pytest.mark.interpreted
DAY = 86_400_000


def recorded(folder):
    """Logs of a swarm of five on a ring that lived to its end, and its study."""
    study, _, swarm = logged(folder)
    swarm.run()
    swarm.close()
    return study


def strangers(folder):
    return strangers_of(read_recording(folder))


def verdict(folder, capsys):
    """The exit code of `relive`, and what it says."""
    capsys.readouterr()
    return main(["relive", str(folder)]), capsys.readouterr().out


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
    assert code == (names > 0)
    assert ("all 5 robots: not of this recording: it started on 2023-11-14 22:13:20 UTC" in said) == (names == 5)


def test_numbers_are_those_of_the_swarm(tmp_path, capsys):
    study = recorded(tmp_path / "day")
    told(tmp_path / "day", study, robots=[{"number": k, "log": f"robot-{k}.log"} for k in range(4)])
    code, said = verdict(tmp_path / "day", capsys)
    assert code == 1
    assert "robot 4: not of this recording: swarm.json has no robot of this number" in said
    told(tmp_path / "day", study, robots=[{"number": 4 - k, "log": f"robot-{k}.log"} for k in range(5)])
    code, said = verdict(tmp_path / "day", capsys)
    assert code == 1
    assert "robot 0: not of this recording: robot-0.log is the log of robot 4 in swarm.json" in said


@pytest.mark.parametrize(("ended", "names"), [(BEGUN - 1500, 0), (BEGUN - 5000, 5)])
def test_clocks_of_one_machine_are_the_same(tmp_path, ended, names):
    """The swarm.json of a run that ended seconds before, where `swarm` ran both."""
    robots = [{"number": k, "log": f"robot-{k}.log", "runs_on": "cpython"} for k in range(5)]
    told(tmp_path / "day", recorded(tmp_path / "day"), robots=robots, started=BEGUN - 9000, ended=ended)
    assert len(strangers(tmp_path / "day")) == names


def test_sensors_are_those_of_the_swarm(tmp_path):
    robots = [{"number": k, "log": f"robot-{k}.log", "b": 0.8, "w": 0.8 + 0.1 * (k == 3)} for k in range(5)]
    told(tmp_path / "day", recorded(tmp_path / "day"), robots=robots)
    assert strangers(tmp_path / "day") == [(3, "its log has w = 0.8, and swarm.json 0.9")]


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


def test_a_log_that_is_cut_between_two_blocks_is_named(tmp_path, capsys):
    study = recorded(tmp_path / "day")
    logs = [member.log for member in read_recording(tmp_path / "day").members]
    robots = [{"number": k, "log": f"robot-{k}.log", "runs_on": "cpython"} for k in range(5)]
    finals = [log.ticks[-1].estimate for log in logs[:4]] + [None]
    told(tmp_path / "day", study, robots=robots, result={"estimates": finals})
    assert "not in the log" not in verdict(tmp_path / "day", capsys)[1]
    path = tmp_path / "day" / "robot-2.log"
    data, at = path.read_bytes(), 0
    while at < len(data) // 2:
        at = _block(data, at)[-1]
    path.write_bytes(data[:at])
    last = read_recording(tmp_path / "day").members[2].log.blocks[-1].tick
    said = (
        f"robot 2, boot 0: ticks {last + 1} on are not in the log: the log ends before the last estimate, {finals[2]}"
    )
    assert said in verdict(tmp_path / "day", capsys)[1]


def test_names_in_upper_case_are_logs_and_others_are_named(tmp_path, capsys):
    study = recorded(tmp_path / "day")
    told(tmp_path / "day", study)
    right = read_recording(tmp_path / "day")
    for name in ("swarm.json", "brain.py"):
        (tmp_path / "day" / name).rename(tmp_path / "day" / name.upper())
    again = read_recording(tmp_path / "day")
    assert (again.fill_ratio, again.brain.label) == (0.6, right.brain.label)
    assert again.brain.path.name == "BRAIN.PY"
    for number in range(3):
        (tmp_path / "day" / f"robot-{number}.log").rename(tmp_path / "day" / f"ROBOT-{number}.LOG")
    code, said = verdict(tmp_path / "day", capsys)
    assert (code, "5 of 5 robots lived again to the bit" in said) == (0, True)
    (tmp_path / "day" / "ROBOT-1.LOG").rename(tmp_path / "day" / "ROBOT-1.BAK")
    with pytest.warns(UserWarning, match=r"left out, as logs of robots end in \.log: ROBOT-1\.BAK"):
        assert len(read_recording(tmp_path / "day").members) == 4
