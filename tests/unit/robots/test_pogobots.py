"""`swarmcensus deploy --target pogobot`: one program for robots and for pogosim, for which a header stands in here."""

import shutil
import subprocess

import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive
from tests.support.places import DATA, ROOT

NEEDED = ["--target", "pogobot", "--accuracy", "{black = 0.9, white = 0.85}"]
HOST = pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
STRICT = f"gcc -std=gnu11 -Wall -Wextra -Werror -ffp-contract=off -I{ROOT / 'tests' / 'support' / 'pogobot'}"


@HOST
def test_a_run_in_a_simulator_is_lived_again_to_the_bit(tmp_path):
    """Messages come several times and count once; each robot draws its own numbers, even from equal seeds."""
    robot = tmp_path / "robot"
    assert main(["deploy", str(DATA / "whole.py"), str(robot), *NEEDED, "--message", "ratio16"]) == 0
    subprocess.run([*STRICT.split(), "main.c", "-lm", "-o", "robot"], cwd=robot, check=True)
    subprocess.run([*STRICT.split(), "-DREAL_ROBOT", "-fsyntax-only", "main.c"], cwd=robot, check=True)
    (robot / "logs").mkdir()
    (robot / "logs" / "robot-1.log").touch()  # of another run
    subprocess.run(["make", "run"], cwd=robot, check=True)
    members = read_recording(robot / "logs").members
    assert [member.number for member in members] == [1000, 1001, 1002, 1003]
    for member in members:
        life, ticks = relive(member), member.log.ticks
        assert life.relived == life.ticks >= 58
        assert (life.breaks, life.lost) == ([], [])
        assert sum(tick.looks for tick in ticks) == 12  # until it is done
        heard = [(message.sender, message.tick) for tick in ticks for message in tick.heard]
        assert len(set(heard)) == len(heard) > 30
        assert 0 < sum(tick.said is None for tick in ticks) < 58
    assert len({member.log.ticks[0].draws for member in members}) == 4
    assert len({member.log.states[0].boot for member in members}) > 1


def test_the_settings_are_what_was_asked(tmp_path):
    robot = tmp_path / "robot"
    assert main(["deploy", "sure", str(robot), *NEEDED, "--hz", "20"]) == 0
    settings = (robot / "settings.h").read_text()
    assert all(f"#define {line}  //" in settings for line in ("B 0.9f", "W 0.85f", "HZ 20", "LOOPS 2", "ENDS 1"))
    assert "time_step: 0.01 " in (robot / "simulation.yaml").read_text()
