"""Robots in the real ARGoS 3 live again to the bit, and the same, in whichever folder it is started."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive_all
from tests.support.places import DATA

PROGRAM = shutil.which("argos3")
ROBOTS, TICKS = 20, 300
STUDY = f"""
trials = 1
seed = 7
[swarm]
robots = {ROBOTS}
accuracy = {{black = 0.9, white = 0.8}}
[world]
topology = "moving"
density = 1
fill_ratio = 0.55
[schedule]
ticks = {TICKS}
"""
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not (PROGRAM and shutil.which("cmake")), reason="needs argos3 of ARGoS 3, and cmake"),
]


@pytest.mark.parametrize("brain", ["commons", "leaver", pytest.param(str(DATA / "whole.py"), id="whole")])
def test_from_any_folder(brain, tmp_path):
    prefix, folder, name = Path(str(PROGRAM)).resolve().parents[1], tmp_path / "robots", Path(brain).stem
    (tmp_path / "study.toml").write_text(STUDY)
    words = ["--target", "argos", "--study", str(tmp_path / "study.toml")]
    assert main(["deploy", brain, str(folder), *words]) == 0
    for step in (["-B", "build", f"-DARGOS={prefix}"], ["--build", "build"]):
        subprocess.run(["cmake", *step], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    experiment, days = folder / f"{name}.argos", (folder / "day", tmp_path / "elsewhere" / "day")
    experiment.write_text(experiment.read_text().replace('logs=""', 'logs="day"'))
    places = {key: str(prefix / "lib" / "argos3") for key in ("LD_LIBRARY_PATH", "ARGOS_PLUGIN_PATH")}
    for day, given in zip(days, (experiment.name, f"../robots/{experiment.name}"), strict=True):
        day.parent.mkdir(exist_ok=True)
        subprocess.run([str(PROGRAM), "-c", given], cwd=day.parent, env=os.environ | places, check=True)
        lives = relive_all(read_recording(day))
        found = [(life.relived, life.ticks, life.breaks, life.lost) for life in lives]
        assert found == [(TICKS, TICKS, [], [])] * ROBOTS
    for log in days[0].glob("*.log"):
        assert log.read_bytes() == (days[1] / log.name).read_bytes()
