"""Logs and swarm.json that somebody has made up: a verdict or one sentence, without much memory."""

import json
import shutil
import struct
from pathlib import Path

import pytest

from swarmcensus.cli.commands import main
from swarmcensus.robots.logs.logs import Gap, read_log
from swarmcensus.runtime.log import ENDING, MAGIC, OPENING, STATE, TICK, block
from tests.support.relived import logged, told

pytestmark = pytest.mark.interpreted
TOO_LATE = block(TICK, struct.pack(OPENING, 100_000_000, 5, 0, 0, 0, 0) + struct.pack(ENDING, 0.5, 7))


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs") / "day"
    study, _, swarm = logged(folder, "commons")
    swarm.run()
    swarm.close()
    told(folder, study)
    return folder


@pytest.fixture
def copied(recording, tmp_path):
    return Path(shutil.copytree(recording, tmp_path / "day"))


@pytest.mark.parametrize(
    "added",
    [TOO_LATE, block(STATE, b""), block(STATE, MAGIC + bytes(63)), block(9, b"?")],
    ids=["late", "empty", "version", "kind"],
)
@pytest.mark.parametrize("command", ["relive", "relive --brain minimalistic --trace t.nc", "export --format mcap"])
def test_no_block_ends_without_a_sentence(added, command, copied, here, capsys):
    path = copied / "robot-1.log"
    path.write_bytes(path.read_bytes() + added)
    words = command.split()
    assert main([words[0], str(copied), *words[1:]]) in (0, 1, 2)
    assert "internal error" not in capsys.readouterr().err


def test_ticks_before_the_first_state_are_lost(copied):
    path = copied / "robot-1.log"
    whole = read_log(path)
    path.write_bytes(block(9, b"?") + TOO_LATE + path.read_bytes())
    log = read_log(path)
    assert log.blocks[1:] == whole.blocks
    assert isinstance(log.blocks[0], Gap)


@pytest.mark.parametrize(
    ("brain", "says"),
    [
        ({"file": "../brain.py"}, "brain.file = '../brain.py'"),
        ({"file": "/etc/passwd"}, "brain.file = '/etc/passwd'"),
        ({"file": "b\0.py"}, "should be the name of a file in the folder"),
        ({"file": "brain.py", "parameters": [1]}, "brain should be a table"),
    ],
)
def test_a_folder_reads_nothing_outside(brain, says, copied, refused):
    path = copied / "swarm.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"brain": brain}))
    assert says in refused("relive", copied)
