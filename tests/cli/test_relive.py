"""The command `relive`: what it prints, writes and refuses."""

import json

import pytest
import xarray as xr

from swarmcensus.cli.commands import main
from tests.support.relived import SEED, logged, setting_of, told
from tests.support.trials import record_trial

pytestmark = pytest.mark.interpreted


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("days") / "day"
    study, _, swarm = logged(folder, robots=4, rounds=30)
    swarm.run()
    swarm.close()
    told(folder, study)
    return folder


def test_the_verdict_and_a_row_per_brain_are_printed(recording, accepted):
    assert "4 of 4 robots lived again to the bit, 120 of 120 ticks" in accepted("relive", recording).out
    [row] = json.loads(accepted("relive", recording, "--json").out)["rows"]
    assert (row["brain"], row["sent"], 0 < row["heard"] < 240) == ("commons", 120, True)
    ends = record_trial(setting_of(robots=4, rounds=30)[1], SEED, 0)[1][-1]
    assert row["mean_estimate"] == ends.mean()
    assert row["mean_error"] == abs(ends - 0.6).mean()


def test_what_differs_is_named_and_the_code_is_1(tmp_path, capsys):
    _, _, swarm = logged(tmp_path / "day", robots=3, rounds=20, more={"lies": lambda i, k: (i, k) == (1, 9)})
    swarm.run()
    swarm.close()
    assert main(["relive", str(tmp_path / "day")]) == 1
    said = capsys.readouterr().out
    assert "2 of 3 robots lived again to the bit, 48 of 60 ticks" in said
    assert "robot 1, boot 0: differs at tick 9 in message.s\n" in said


def test_traces_are_those_that_other_commands_take(recording, tmp_path, refused):
    trace = tmp_path / "trace.nc"
    assert main(["relive", str(recording), "--trace", str(trace)]) == 0
    expected = record_trial(setting_of(robots=4, rounds=30)[1], SEED, 0)[1]
    assert (xr.load_dataset(trace)["estimate"].values == expected).all()
    assert "not results: swarmcensus plot --kind curves draws what it was made from" in refused("show", trace)
    assert main(["relive", str(recording), "--trace", str(tmp_path / "t.csv")]) == 0
    rows = (tmp_path / "t.csv").read_text().splitlines()
    assert rows[0].startswith("round,robot,")
    assert len(rows) == 1 + 31 * 4


def test_a_folder_from_boards_needs_no_more_than_logs(recording, tmp_path, accepted):
    for path in recording.glob("*.log"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    said = accepted("relive", tmp_path).out
    assert "commons" in said  # the shipped brain with the hash in the logs
    assert "error" not in said
    assert "mean error" in accepted("relive", tmp_path, "--fill-ratio", 0.6).out


@pytest.mark.parametrize(("given", "says"), [
    ("nowhere", "nowhere: should be a folder of robots' logs"),
    ("EMPTY", "it holds no log"),
    ("DAY --fill-ratio 2", "--fill-ratio 2"),
    ("DAY --trace r.txt", "--trace r.txt: "),
    ("BLANK", "robot-0.log: the file is empty, and should be a robot's log"),
    ("BAD", "swarm.json: robots[0] = 3: should be a table"),
    ("AWAY", "should be the name of a file in the folder"),
])  # fmt: skip
def test_wrong_inputs_are_named_in_a_sentence(recording, here, refused, given, says):
    files = {
        "EMPTY/none": "", "BLANK/robot-0.log": "", "BAD/swarm.json": '{"format": 1, "robots": [3]}',
        "AWAY/swarm.json": '{"format": 1, "robots": [{"log": "../robot.log"}]}',
    }  # fmt: skip
    for name, text in files.items():
        (here / name).parent.mkdir()
        (here / name).write_text(text)
    assert says in refused("relive", *(recording if word == "DAY" else word for word in given.split()))


@pytest.mark.parametrize("command", ["relive", "export"])
def test_the_log_of_one_robot_is_not_taken_for_something_else(command, recording, refused):
    right = "is the log of one robot: relive, watch and export read the folder that it is in"
    assert right in refused(command, recording / "robot-0.log")


def test_logs_are_drawn_as_replays_are(recording, tmp_path, refused):
    out = tmp_path / "day.png"
    assert main(["plot", str(recording), "--kind", "curves", "--out", str(out)]) == 0
    assert out.is_file()
    for kind in ("arena", "film"):
        assert "robots' logs do not say where they were" in refused("plot", recording, "--kind", kind)
    assert "--kind scatter" in refused("plot", recording)
    assert "--setting" in refused("plot", recording, "--kind", "curves", "--setting", 1)
