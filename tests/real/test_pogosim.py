"""Pogobots in the real pogosim live again to the bit, and their program builds for the robots.

Where no package has Apache Arrow, pogosim builds with the headers and the library inside the wheel of pyarrow.
"""

import os
import subprocess

import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive_all
from tests.support.places import DATA

WHY = "needs POGOSIM, where it is installed, and LIBRARIES if make cannot link"
SIMULATOR = pytest.mark.skipif("POGOSIM" not in os.environ, reason=WHY)
WHY = "needs SDK and SOURCES, where the Makefile says what they are"
BOARD = pytest.mark.skipif(not {"SDK", "SOURCES"} <= set(os.environ), reason=WHY)


def made(tmp_path, brain, goal):
    """The folder of a brain after `make`."""
    robot = tmp_path / "robot"
    asked = ["--target", "pogobot", "--accuracy", ".9", "--message", "ratio16"]
    assert main(["deploy", str(brain), str(robot), *asked]) == 0
    subprocess.run(["make", goal], cwd=robot, check=True)
    return robot


@SIMULATOR
@pytest.mark.parametrize("brain", ["commons", "sure", pytest.param(DATA / "whole.py", id="whole")])
def test_twenty_robots_live_again_to_the_bit(tmp_path, brain):
    recording = read_recording(made(tmp_path, brain, "run") / "logs")
    lives = relive_all(recording)
    assert len(lives) == 20
    assert all(life.relived == life.ticks > 1990 and not (life.breaks or life.lost) for life in lives)
    if brain == "commons":
        estimates = [member.log.ticks[-1].estimate for member in recording.members]
        assert sum(estimates) / 20 == pytest.approx(0.56, abs=0.05)  # the floor of simulation.yaml


@BOARD
@pytest.mark.parametrize("brain", ["commons", pytest.param(DATA / "whole.py", id="whole")])
def test_the_program_fits_the_robots(tmp_path, brain):
    assert 0 < (made(tmp_path, brain, "bin") / "firmware.bin").stat().st_size < 64 * 1024
