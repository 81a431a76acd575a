"""`plot`, `replay` and `infer` on the command line: options that mean nothing, checks in their order, what is said."""

import os
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import numba
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.figures import panels, scenes
from swarmcensus.results import replaying
from swarmcensus.runs import progress
from swarmcensus.simulation import inferring

LOSSY = """
trials = 1
[swarm]
robots = 4
accuracy = 0.8
[world]
topology = "ring"
fill_ratio = 0.55
link_success = 0.5
[schedule]
rounds = 5
"""
MOVING = LOSSY.replace('"ring"', '["ring", "moving"]\ndensity = 1').replace("rounds", "ticks = 9\nrounds")


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def complaint(capsys, *command):
    """What a command that must fail says, in one line."""
    assert main(list(map(str, command))) == 2
    *before, error = capsys.readouterr().err.splitlines()
    assert all(line.startswith("compiling") for line in before)
    return error


@pytest.mark.parametrize("kind", ["scatter", "decisions", "heatmap", "beliefs"])
@pytest.mark.parametrize("option", [["--setting", "0"], ["--trial", "0"], ["--brain-file", "mine.py"]])
def test_one_trial_means_nothing_to_pictures_of_all(kind, option, small_file, here, capsys):
    said = complaint(capsys, "plot", small_file, "--kind", kind, *option)
    assert f"{option[0]} goes with --kind arena or curves or film, not with {kind}" in said
    assert not list(here.iterdir())


@pytest.mark.long
def test_curves_of_a_brain_file_that_is_given(here):
    Path("mine.py").write_text(brains.load("minimalistic").source)
    study = sc.Study(
        trials=1, swarm={"brain": "mine.py", "robots": 3, "accuracy": 0.8},
        world={"topology": "ring", "fill_ratio": 0.5}, schedule={"rounds": 5},
    )  # fmt: skip
    sc.run(study, jobs=1, out="mine.nc", progress=False)
    assert main(["plot", "mine.nc", "--kind", "curves", "--brain-file", "mine.py", "--out", "curves.png"]) == 0
    assert Path("curves.png").is_file()


@pytest.mark.long
def test_a_setting_that_where_leaves_out(small_file, here, capsys):
    out = ["plot", small_file, "--kind", "curves", "--where", 'topology == "ring"', "--setting"]
    assert "setting 0 is not one of those that --where 'topology == \"ring\"' selects" in complaint(capsys, *out, 0)
    assert "setting 99: these results hold setting" in complaint(capsys, *out, 99)
    ring = int(sc.load(small_file)["setting"].values[sc.load(small_file)["topology"].values == "ring"][0])
    assert main(["plot", str(small_file), *map(str, out[2:]), str(ring), "--trial", "3", "--out", "x.svg"]) == 0
    assert f"small, setting {ring}, trial 3: minimalistic, ring, N = " in (here / "x.svg").read_text()


def test_advice_for_too_many_panels_is_a_shell_s(small_file, here, capsys, monkeypatch):
    monkeypatch.setattr(panels, "MOST_PANELS", 4)
    said = complaint(capsys, "plot", small_file, "--kind", "decisions")
    assert "16: select some of the settings, as --where '" in said
    assert "isel" not in said
    assert main(["plot", str(small_file), "--kind", "decisions", "--where", said.split("'")[1], "--out", "x.png"]) == 0
    said = complaint(capsys, "plot", small_file, "--kind", "heatmap")
    assert "isel" not in said
    assert main(["plot", str(small_file), "--kind", "heatmap", "--where", said.split("'")[1], "--out", "y.png"]) == 0


def test_cheap_checks_come_first(small_file, here, capsys, monkeypatch):
    def replay(*_, **__):
        raise AssertionError("run again")

    monkeypatch.setattr(replaying, "replay", replay)
    one = ["replay", small_file, "--setting", 0, "--trial", 0]
    (here / "file").touch()
    assert "written as .csv or .nc" in complaint(capsys, *one, "--out", "x.txt")
    assert "figures are written as" in complaint(capsys, *one, "--plot", "x.bmp")
    assert "cannot write file/x.png" in complaint(capsys, *one, "--plot", "file/x.png")
    assert "cannot write file/rec" in complaint(capsys, *one, "--recording", "file/rec")
    assert "figures are written as" in complaint(capsys, "plot", small_file, "--kind", "curves", "--out", "x.bmp")
    assert "cannot write file/x.svg" in complaint(capsys, "plot", small_file, "--kind", "curves", "--out", "file/x.svg")
    (here / "obs.csv").write_text("1,1\n0,1\n")
    monkeypatch.setattr(inferring, "infer", replay)
    seen = ["infer", "obs.csv", "--accuracy", "0.8"]
    assert "cannot write file/x.png" in complaint(capsys, *seen, "--plot", "file/x.png")
    assert {p.name for p in here.iterdir()} == {"file", "obs.csv"}


def test_a_recording_that_cannot_be_leaves_nothing(here, capsys):
    (here / "lossy.toml").write_text(LOSSY)
    assert main(["run", "lossy.toml"]) == 0
    capsys.readouterr()
    files = set(here.iterdir())
    one = ["replay", "lossy.nc", "--setting", 0, "--trial", 0, "--out", "t.csv", "--plot", "t.png", "--recording", "r"]
    assert "a recording holds no lost messages" in complaint(capsys, *one)
    assert set(here.iterdir()) == files


@pytest.mark.long
def test_faults_of_film_options_come_first(here, capsys, monkeypatch):
    (here / "m.toml").write_text(MOVING)
    assert main(["run", "m.toml"]) == 0
    capsys.readouterr()

    def scene_of(*_, **__):
        raise AssertionError("run again")

    monkeypatch.setattr(scenes, "scene_of", scene_of)
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    film = ["plot", "m.nc", "--kind", "film"]
    for options, said in (
        (["--setting", 0], "setting 0 is a fixed network"),
        (["--setting", 9], "setting 9: these results hold"),
        (["--trial", 1], "trial 1: these results hold"),
        (["--brain-file", "none.py"], "neither a shipped brain"),
        (["--last", 10], "tick 10: this trial has ticks 0 to 9"),
        (["--first", 5, "--last", 4], "no tick from 5 to 4"),
        (["--robot", 4], "robot 4: the robots are numbered 0 to 3"),
        (["--fps", 500], "at most 240 frames a second"),
        ([], "pip install 'imageio-ffmpeg"),
    ):
        told = complaint(capsys, *film, *options)
        assert said in told
        assert ("pip install" in told) == (not options)
    arena = ["plot", "m.nc", "--kind", "arena", "--tick", 10]
    assert "tick 10: this trial has ticks 0 to 9" in complaint(capsys, *arena)


def test_compiling_is_told_once_and_only_where_it_happens(caplog):
    caplog.set_level("INFO", "swarmcensus")

    @numba.njit
    def twice(x):
        return inside(x)

    @numba.njit
    def inside(x):
        return 2 * x

    with progress.log_compilation("mine.py"):
        assert twice(1) == 2
    assert caplog.messages == ["compiling what replay needs for mine.py, once on this machine"]
    with progress.log_compilation("mine.py"):
        assert twice(1) == 2
    assert twice(1.0) == 2.0
    assert len(caplog.messages) == 1


@pytest.mark.long(but_every=3)
@pytest.mark.parametrize(
    ("command", "where"),
    [
        (["plot", "FILE", "--kind", "curves", "--out", "x.png"], (replaying, "estimates")),
        (["replay", "FILE", "--setting", "0", "--trial", "0"], (replaying, "replay")),
        (["infer", "obs.csv", "--accuracy", "0.8"], (inferring, "infer")),
    ],
)
def test_who_waits_for_the_compiler_knows_it(command, where, small_file, here, capsys, monkeypatch):
    (here / "obs.csv").write_text("1,1\n0,1\n")
    true = getattr(*where)

    def compiles(*arguments: object) -> xr.Dataset:
        numba.njit(lambda x: x)(1)
        return true(*arguments)

    command = [str(small_file) if word == "FILE" else word for word in command]
    assert main(command) == 0  # compiles, or finds it on disk
    capsys.readouterr()
    assert main(command) == 0
    assert "compiling" not in capsys.readouterr().err
    monkeypatch.setattr(*where, compiles)
    assert main(command) == 0
    what = "recorded data" if command[0] == "infer" else "replay"
    assert capsys.readouterr().err == f"compiling what {what} needs for minimalistic, once on this machine\n"


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"text.usetex": True, "savefig.bbox": "tight", "figure.constrained_layout.use": True}, ""),
        ({"path.effects": "nonsense"}, "matplotlib cannot draw with these settings"),
    ],
)
def test_settings_of_matplotlib_that_would_break_figures(settings, says, small_file, here, capsys):
    """As a person's matplotlibrc has them; LaTeX is not there, or does not know names with underscores."""
    command = ["plot", str(small_file), "--kind", "heatmap", "--where", 'topology == "ring" and robots == 5', "--out"]
    plain, drawn = ([*command, name] for name in ("plain.png", "drawn.png"))
    with mpl.rc_context(settings):
        assert main(drawn) == (2 if says else 0)
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == bool(says)
    if not says:
        assert main(plain) == 0
        assert (here / "plain.png").read_bytes() == (here / "drawn.png").read_bytes()
    else:
        assert not list(here.iterdir())


def test_settings_that_matplotlib_cannot_read_are_one_sentence(small_file, here):
    (here / "matplotlibrc").write_bytes(b"font.size: 9 # \xe9")
    command = [sys.executable, "-m", "swarmcensus", "plot", str(small_file), "--quiet", "--out", "x.png"]
    done = subprocess.run(command, env=os.environ | {"MPLBACKEND": "no such"}, capture_output=True, text=True)
    assert done.returncode == 2
    assert "matplotlib cannot read its settings, matplotlibrc" in done.stderr
    assert done.stderr.count("\n") == 1
