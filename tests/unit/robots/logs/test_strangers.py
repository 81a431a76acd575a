"""Logs that are not of a folder's recording are named, and a log that is only cut or absent is not."""

import json

import pytest

from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.logs import block_at
from tests.support.lockstep import BEGUN
from tests.support.relived import recorded, told

pytestmark = pytest.mark.interpreted
DAY = 86_400_000
ROBOTS = [{"number": k, "log": f"robot-{k}.log", "b": 0.8, "w": 0.8} for k in range(5)]
AWAY = "all 5 robots: not of this recording: it started on 2023-11-14T22:13:20 UTC, and the swarm "


@pytest.fixture
def day(tmp_path):
    """Logs of a swarm of five on a ring that lived to its end, and what writes its swarm.json."""
    study, _ = recorded(tmp_path / "day", more={"saves": 4})
    return tmp_path / "day", lambda **more: told(tmp_path / "day", study, **{"robots": ROBOTS} | more)


def verdict(folder, capsys):
    """The exit code of `relive`, and what it says."""
    capsys.readouterr()
    return main(["relive", str(folder)]), capsys.readouterr().out


@pytest.mark.parametrize(("more", "says"), [
    ({"started": BEGUN, "ended": BEGUN + 4000}, ""),
    ({"started": BEGUN + 30_000, "ended": None}, "the recording was not finished"),
    ({"started": BEGUN + DAY, "ended": None}, AWAY + "on 2023-11-15"),
    ({"started": BEGUN - DAY, "ended": BEGUN - DAY + 4000}, AWAY + "ended on 2023-11-13"),
    ({"robots": ROBOTS[:4]}, "robot 4: not of this recording: swarm.json has no log as that of robot 4"),
    ({"robots": [{"number": 4 - k, "log": f"robot-{k}.log"} for k in range(5)]},
     "robot 0: not of this recording: swarm.json has robot-4.log as that of robot 0"),
    ({"robots": [*ROBOTS[:4], ROBOTS[4] | {"w": 0.9}]},
     "robot 4: not of this recording: its log has w = 0.8, and swarm.json 0.9"),
])  # fmt: skip
def test_numbers_times_and_sensors_are_those_of_the_swarm(day, capsys, more, says):
    folder, tell = day
    tell(**more)
    code, said = verdict(folder, capsys)
    assert code == bool(says)
    assert says in said
    assert ("not of this recording" in said) == ("not of" in says)


def test_another_brains_file_is_named_once_and_only_where_states_differ(day, capsys):
    folder, tell = day
    tell()
    source = brains.load("commons").source
    (folder / "brain.py").write_text(source + "\n# changed\n")
    code, said = verdict(folder, capsys)
    assert code == 0  # a comment changes nothing
    assert "all 5 robots: the hash of its brain's file begins with" in said
    for text in (source.replace("0.5", "0.4"), brains.load("voter").source):
        (folder / "brain.py").write_text(text)
        code, said = verdict(folder, capsys)
        assert code == 1
        assert said.count("all 5 robots: not of this recording: the hash of its brain's file begins with") == 1
        assert "differs" not in said
    main(["relive", str(folder), "--json"])
    robots = json.loads(capsys.readouterr().out)["robots"]
    assert [robot["breaks"][0]["field"] for robot in robots] == ["the number of its parameters"] * 5


@pytest.mark.parametrize(("wrong", "expected"), [
    ({"robots": [{"number": "1", "log": "robot-1.log"}]}, 'robots[0].number = "1": should be a whole number'),
    ({"started": "yesterday"}, 'started = "yesterday": should be a valid number'),
    ({"ended": [1]}, "ended = [1]: should be a valid number"),
    ({"started": float("inf")}, "started = inf: should be less than"),
    ({"brain": {"file": "../brain.py"}}, 'brain.file = "../brain.py"'),
    ({"brain": {"file": "/etc/passwd"}}, 'brain.file = "/etc/passwd"'),
    ({"brain": {"file": "b\0.py"}}, "should be the name of a file in the folder"),
    ({"brain": {"file": "brain.py", "parameters": [1]}}, "brain.parameters = [1]: should be a table"),
])  # fmt: skip
def test_wrong_values_of_swarm_json_are_refused(day, refused, wrong, expected):
    folder, tell = day
    tell(**wrong)
    said = refused("relive", folder)
    assert "swarm.json: " in said
    assert expected in said


@pytest.mark.parametrize("whole", [False, True], ids=["in a block", "between blocks"])
def test_a_log_that_is_cut_is_of_the_recording_and_its_loss_is_named(day, capsys, whole):
    """Between two blocks the count in swarm.json tells it, or other logs; a log that is absent is left out."""
    folder, tell = day
    tell(result={"ticks": [40, 39, 40, 0]})  # of a robot that was killed less may be known
    assert "not in the log" not in verdict(folder, capsys)[1]
    path = folder / "robot-2.log"
    data, at = path.read_bytes(), 0
    while at < len(data) // 2:
        at = block_at(data, at)[-1]
    path.write_bytes(data[: at if whole else at - 9])
    last = read_recording(folder).members[2].log.ticks[-1].tick
    why = f"it has {last} of 40 lived ticks" if whole else "the file is cut or damaged: "
    assert f"robot 2, boot 0: ticks {last + 1} on are not in the log: {why}" in verdict(folder, capsys)[1]
    tell()  # no counts
    code, said = verdict(folder, capsys)
    why = "another robot heard it in its tick " if whole else "the file is cut or damaged: "
    assert (code, said.count("not in the log: ")) == (1, 1)
    assert f"robot 2, boot 0: ticks {last + 1} on are not in the log: {why}" in said
    path.unlink()
    code, said = verdict(folder, capsys)
    assert (code, "not of this recording" in said) == (1, False)


APART = {"name": "pair", "edges": [[2, 3]]}


@pytest.mark.parametrize(("topology", "more", "kept", "says"), [
    ("ring", {}, 30, "ticks 31 on are not in the log: another robot heard it in its tick 60"),
    (APART, {}, 30, "ticks 31 on are not in the log: it ends 30 ticks before the last log"),
    (APART, {"now": False}, 30, ""),  # it may have begun later
    ("ring", {}, 57, ""),
    ("ring", {"first": 65_500}, 30, "ticks 65531 on are not in the log: another robot heard it in its tick 65,560"),
])  # fmt: skip
def test_a_log_without_its_end_is_named_by_others(tmp_path, capsys, topology, more, kept, says):
    """No count is known; robot 1 was cut between two blocks, or stopped for itself."""
    folder = tmp_path / "day"
    recorded(folder, robots=4, rounds=60, topology=topology, more=more)
    path = folder / "robot-1.log"
    data, end = path.read_bytes(), 0
    for _ in range(kept + 1):  # the first block is the start
        end = block_at(data, end)[-1]
    path.write_bytes(data[:end])
    code, said = verdict(folder, capsys)
    assert (code, f"robot 1, boot 0: {says}" in said) == (bool(says), bool(says))
    assert said.count("not in the log") == bool(says)


def test_plot_and_watch_say_what_relive_says(day, here, accepted):
    folder, tell = day
    tell(rounds=50, robots=[*ROBOTS, {"number": 5, "log": "robot-5.log"}])
    log = folder / "robot-2.log"
    log.write_bytes(log.read_bytes()[:-9])
    gaps = (
        "robot-5.log: No such file",
        "not finished: its logs end at tick 40",
        "boot 0: ticks 41 on are not in the log",
    )
    said = accepted("plot", folder, "--kind", "curves", "--out", "c.png")
    assert all(gap in said.err for gap in gaps)
    assert all(gap in " ".join((here / "c.png.caption.txt").read_text().split()) for gap in gaps)
    said = accepted("watch", folder, "--out", "c.html")
    assert all(gap in said.out + said.err for gap in gaps)
