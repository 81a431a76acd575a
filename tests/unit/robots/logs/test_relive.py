"""Lives lived again from robots' logs: to the bit, under another brain, and after all that can happen to a log."""

import pytest

from swarmcensus import brains
from swarmcensus.robots.logs.folders import read_recording
from swarmcensus.robots.logs.lives import relive
from swarmcensus.robots.logs.others import under
from swarmcensus.simulation.trials import record_trial
from tests.support.relived import SEED, estimates_of, logged, setting_of, told

pytestmark = pytest.mark.interpreted


CASES = [
    ("commons", "float32", "double"),
    ("minimalistic", "ratio16", "double"),
    ("commons", "ratio8", "single"),
    ("voter", "float16", "double"),
    ("voter", "float32", "single"),
    ("sure", "float32", "double"),
]


@pytest.mark.parametrize(("brain", "message", "precision"), CASES)
def test_replay_of_logs_is_exact(tmp_path, brain, message, precision):
    _, setting, swarm = logged(tmp_path / "day", brain, message=message, precision=precision)
    swarm.run()
    shown = swarm.close()
    assert (shown == record_trial(setting, SEED, 0)[1]).all()
    recording = read_recording(tmp_path / "day")
    for member in recording.members:
        life = relive(member)
        assert life.to_the_bit, life.breaks
        assert (life.ticks, life.relived, life.lost) == (40, 40, [])
    same = under(recording, recording.brain)
    assert (estimates_of(recording, same, 40) == shown).all()
    assert not same.unknown


OTHERS = [
    ("commons", "minimalistic", "float32", "double"),
    ("minimalistic", "commons", "ratio16", "double"),
    ("commons", "sure", "float16", "single"),
    ("minimalistic", "voter", "float32", "double"),
    ("sure", "commons", "ratio8", "double"),
    ("commons", "voter", "float32", "single"),
]


@pytest.mark.parametrize(("brain", "other", "message", "precision"), OTHERS)
def test_another_brain_lives_the_day_as_its_simulation(tmp_path, brain, other, message, precision):
    study, _, swarm = logged(tmp_path / "day", brain, message=message, precision=precision)
    swarm.run()
    shown = swarm.close()
    told(tmp_path / "day", study)
    recording = read_recording(tmp_path / "day")
    result = under(recording, brains.load(other))
    expected = record_trial(setting_of(other, message=message, precision=precision)[1], SEED, 0)[1]
    found = estimates_of(recording, result, 40)
    assert (found == expected).all()
    assert (found != shown).any()
