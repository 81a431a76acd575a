"""`plot`, `replay` and `infer` on the command line: options that mean nothing, checks in their order, what is said."""

import os
import subprocess
import sys

import matplotlib as mpl
import numba
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.simulation import inferring
from swarmcensus.summaries import replaying

LOSSY = """
trials = 1
swarm = {robots = 4, accuracy = 0.8}
world = {topology = "ring", fill_ratio = 0.55, link_success = 0.5}
schedule = {rounds = 5}
"""


@pytest.mark.long
def test_a_setting_that_where_leaves_out(small_file, here, refused):
    out = ["plot", small_file, "--kind", "curves", "--where", 'topology == "ring"', "--setting"]
    assert "setting 0 is not one of those that --where 'topology == \"ring\"' selects" in refused(*out, 0)
    assert "--setting 99: these results hold setting" in refused(*out, 99)
    data = sc.load(small_file)
    ring = int(data["setting"].values[data["topology"].values == "ring"][0])
    assert main([*map(str, out), str(ring), "--trial", "3", "--out", "x.svg"]) == 0
    assert f"small, setting {ring}, trial 3: minimalistic, ring, N = " in (here / "x.svg").read_text()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("replay --setting 0 --trial 0 --out x.txt", "ends in .csv or .nc"),
        ("replay --setting 0 --trial 0 --recording file/rec", "cannot write file/rec"),
        ("plot --kind curves --out file/x.svg", "cannot write file/x.svg"),
        ("infer --accuracy 0.8 --plot file/x.png", "cannot write file/x.png"),
    ],
)
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
    (here / "lossy.toml").write_text(LOSSY)
    assert main(["run", "lossy.toml"]) == 0
    one = ["replay", "lossy.nc", "--setting", 0, "--trial", 0, "--out", "t.csv", "--recording", "r"]
    assert "a recording holds no lost messages" in refused(*one)


def test_compilation_is_announced(small_file, here, capsys, monkeypatch):
    def compiles(*arguments: object) -> xr.Dataset:
        numba.njit(lambda x: x)(1)
        return replay(*arguments)

    replay, command = replaying.replay, ["replay", str(small_file), "--setting", "0", "--trial", "0"]
    assert main(command) == 0  # compiles, or finds it on disk
    capsys.readouterr()
    assert main(command) == 0
    assert "compiling" not in capsys.readouterr().err
    monkeypatch.setattr(replaying, "replay", compiles)
    assert main(command) == 0
    assert capsys.readouterr().err == "compiling what replay needs for minimalistic, once on this machine\n"


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
