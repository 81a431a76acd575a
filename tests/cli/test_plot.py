"""`plot`, `replay` and `infer` on the command line: options that mean nothing, checks in their order, what is said."""

import json
import os
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import numba
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.simulation import inferring
from swarmcensus.summaries import replaying
from tests.support.small import study_of


@pytest.mark.long
def test_a_setting_that_where_leaves_out(small_file, here, refused):
    out = ["plot", small_file, "--kind", "curves", "--where", 'topology == "ring"', "--setting"]
    assert "setting 0 is not one of those that --where 'topology == \"ring\"' selects" in refused(*out, 0)
    assert "--setting 99: these results hold setting" in refused(*out, 99)
    data = sc.load(small_file)
    ring = int(data["setting"].values[data["topology"].values == "ring"][0])
    assert main([*map(str, out), str(ring), "--trial", "3", "--out", "x.svg"]) == 0
    assert f"small, setting {ring}, trial 3: minimalistic, ring, N = " in (here / "x.svg").read_text()


@pytest.mark.parametrize(("options", "said"), [
    ("replay --setting 0 --trial 0 --out x.txt", "ends in .csv or .nc"),
    ("replay --setting 0 --trial 0 --recording file/rec", "cannot write file/rec"),
    ("plot --kind curves --out file/x.svg", "cannot write file/x.svg"),
    ("infer --accuracy 0.8 --plot file/x.png", "cannot write file/x.png"),
])  # fmt: skip
def test_cheap_checks_come_first(options, said, small_file, here, refused, monkeypatch):
    def run(*_, **__):
        raise AssertionError("run again")

    monkeypatch.setattr(replaying, "replay", run)
    monkeypatch.setattr(inferring, "infer", run)
    (here / "file").touch()
    (here / "obs.csv").write_text("1,1\n0,1\n")
    command, *words = options.split()
    assert said in refused(command, "obs.csv" if command == "infer" else small_file, *words)


def test_a_recording_that_cannot_be_leaves_nothing(here, refused):
    sc.run(study_of(robots=4, rounds=5, trials=1, link_success=0.5), jobs=1, out="lossy.nc")
    one = ["replay", "lossy.nc", "--setting", 0, "--trial", 0, "--out", "t.csv", "--recording", "r"]
    assert "a recording holds no lost messages" in refused(*one)


def test_compilation_is_announced(small_file, here, accepted, monkeypatch):
    def compiles(*arguments: object) -> xr.Dataset:
        numba.njit(lambda x: x)(1)
        return replay(*arguments)

    replay, command = replaying.replay, ["replay", str(small_file), "--setting", "0", "--trial", "0"]
    assert main(command) == 0  # compiles, or finds it on disk
    assert "compiling" not in accepted(*command).err
    monkeypatch.setattr(replaying, "replay", compiles)
    assert accepted(*command).err == "compiling what replay needs for minimalistic, once on this machine\n"


def test_settings_of_matplotlib_that_would_break_figures(small_file, here):
    settings = {"text.usetex": True, "savefig.bbox": "tight", "figure.constrained_layout.use": True}
    command = ["plot", str(small_file), "--kind", "heatmap", "--where", 'topology == "ring" and robots == 5', "--out"]
    with mpl.rc_context(settings):
        assert main([*command, "drawn.png"]) == 0
    assert main([*command, "plain.png"]) == 0
    assert (here / "plain.png").read_bytes() == (here / "drawn.png").read_bytes()


def test_settings_that_matplotlib_cannot_read_are_one_sentence(small_file, here):
    (here / "matplotlibrc").write_bytes(b"font.size: 9 # \xe9")
    command = [sys.executable, "-m", "swarmcensus", "plot", str(small_file), "--quiet", "--out", "x.png"]
    done = subprocess.run(command, env=os.environ | {"MPLBACKEND": "no such"}, capture_output=True, text=True)
    assert done.returncode == 2
    assert "matplotlib cannot read its settings, matplotlibrc" in done.stderr
    assert done.stderr.count("\n") == 1


# ---- a study's keys mean the same in every command, and wrong ones are refused in the same sentence
STUDY = """trials = 40
swarm = {robots = 6, accuracy = 0.8, brain = "commons"}
world = {topology = "ring", fill_ratio = 0.55, message = "float32"}
schedule = {rounds = 20, observations_per_round = 1}
wanted = {error = 0.2}
groups = {all = "robots > 0"}
"""
COMMANDS = {
    "run": "run s.toml", "plan": "plan s.toml", "watch": "watch s.toml --no-browser",
    "swarm": "swarm s.toml --out logs", "tune": "tune p.toml --parameter z=2:3 --budget 13",
    "deploy": "deploy commons out --target argos --study s.toml", "infer": "infer o.csv --study s.toml",
    "leaderboard": "leaderboard --study s.toml",
}  # fmt: skip
WRONG = {  # what is asked, and what is said of it
    "fil_ratio=0.3": "unknown key fil_ratio: did you mean 'fill_ratio'?",
    "robots=0": "swarm.robots = 0: should be greater than or equal to 1",
    "accuracy=1.5": "swarm.accuracy = 1.5: ",
    "accuracy={black=0.8}": "swarm.accuracy = {black = 0.8}: ",
    "topology=rnig": "did you mean 'ring'?",
    "fill_ratio=[0.5": "[0.5: not a value of TOML",
    "message_delay=3": "message_delay may be world.message_delay or world.body.message_delay: say which",
    "density=2": "world.density",
    'members=[{robots=2, brain="nobody"}]': "members[0].brain",
    'faults=[{at=5, robots=1, stop="singing"}]': "faults[0].stop",
    'topology={name="ring", label="moving"}': "this label is the name of another topology or floor",
    "wanted={eror=0.1}": "unknown key wanted.eror: did you mean 'error'?",
    "link_success=nan": "world.link_success = nan: ",
}


@pytest.fixture
def files(here):
    (here / "s.toml").write_text(STUDY)
    (here / "p.toml").write_text(STUDY.replace('"commons"', '{file = "steadfast", z = 2.5}'))
    (here / "o.csv").write_text("1,0,1\n0,0,1\n")


@pytest.mark.parametrize("value", WRONG)
@pytest.mark.parametrize("command", COMMANDS)
def test_wrong_keys_and_values_are_refused_alike(command, value, files, refused):
    assert WRONG[value] in refused(*COMMANDS[command].split(), "--set", value)


def test_a_group_that_selects_nothing_is_refused_before_anything_runs(files, refused):
    said = refused("leaderboard", "--study", "s.toml", "--set", "groups.x='nosuch == 3'", "--out", "board")
    assert "groups.x = 'nosuch == 3': no coordinate 'nosuch'" in said


@pytest.mark.interpreted
def test_merged_studies_that_want_different_things_say_so(files, accepted, refused):
    for name, values in (("a", ["error=0.1"]), ("b", ["right=10", "robots=7"])):
        words = [word for value in (*values, "trials=2") for word in ("--set", value)]
        assert main(["run", "s.toml", *words, "--out", f"{name}.nc", "-q"]) == 0
    accepted("merge", "a.nc", "b.nc", "--out", "c.nc")
    assert "the studies want different things (error = 0.1; right = 10)" in accepted("show", "c.nc").out
    words = ("compare", "c.nc", "--factor", "robots", "--metric", "reached")
    assert "merged studies want different things" in refused(*words)


@pytest.mark.interpreted
def test_infer_takes_brain_accuracy_and_rounds_from_a_study(files, accepted):
    words = ["infer", "o.csv", "--json", "--out", "t.csv", "--plot", "t.svg"]
    of_study = json.loads(accepted(*words, "--study", "s.toml", "--set", "accuracy={black=0.9, white=0.7}").out)["rows"]
    plain = ["--accuracy", "{black=0.9, white=0.7}", "--brain", "commons", "--observations-per-round", "1"]
    assert json.loads(accepted(*words, *plain).out)["rows"] == of_study


def test_deploy_takes_other_values_of_a_study(files, capsys):
    moving = ["--set", "topology=moving", "--set", "density=1", "--set", "schedule={ticks=99}"]
    assert main([*COMMANDS["deploy"].split(), *moving, "--set", "robots=7", "--set", "message=float16"]) == 0
    assert 'quantity="7"' in Path("out", "commons.argos").read_text()
