"""Brains that steer: who gets what it wants, and that a run, its replay and CPython all tell the same life."""

import re

import numba
import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.checks import contract_checks, suite as conformance
from swarmcensus.engine.return_values import chosen
from swarmcensus.simulation import rides, sampling
from swarmcensus.summaries.replaying import recording
from swarmcensus.worlds.bodies import Body
from tests.support.steering import WANTS, steered_in

STUDY = """
seed = 3
trials = 2
swarm = {brain = "steered.py", robots = 8, accuracy = 0.7, assumed_accuracy = [WANTS]}
world = {topology = "moving", density = [1, 6], floor = {clusters = 0.3}, fill_ratio = 0.55, body = {message_delay = 0}}
schedule = {ticks = 150}
measure = {checkpoints = [10, 150]}
"""
STEP = Body().speed * Body().tick
TURN = 2 * Body().turn_speed * Body().tick / Body().wheel_distance


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return steered_in(tmp_path_factory.mktemp("brains"))


def study_of(folder, *wants, **changes):
    text = STUDY.replace("WANTS", ", ".join(f"{{black = 0.8, white = {WANTS[name]}}}" for name in wants))
    for key, value in changes.items():
        text, found = re.subn(rf"\b{key} = (\[[^]]*\]|[^,}}\n]+)", f"{key} = {value}", text, count=1)
        assert found, key
    return sc.Study.parse(text, context={"base": folder})


def traces(folder, *wants, trials=2, **changes):
    results = sc.run(study_of(folder, *wants, trials=trials, **changes))
    brain = folder / "steered.py"
    settings = results["setting"].values.tolist()
    return [sc.replay(results, k, trial, brain, links=True) for k in settings for trial in range(trials)]


def turns_of(trace):
    """The change of heading in each tick, radians, the shorter way round."""
    return np.angle(np.exp(1j * np.diff(trace["heading"].values, axis=0)))


def steps_of(trace):
    return np.hypot(*np.moveaxis(np.diff(trace["position"].values, axis=0), 2, 0))


@pytest.fixture(scope="module")
def steered(folder):
    study = study_of(folder, "ABSURD", "STRAIGHT", "SEEN")
    return study, sc.run(study, jobs=2)


def test_inference_lives_what_a_replay_shows(folder, steered):
    study, results = steered
    brain = folder / "steered.py"
    for k, setting in enumerate(study.settings()):
        trace = sc.replay(results, k, 1, brain)
        readings, messages = recording(results, k, 1, brain)
        *_, assumed_b, assumed_w = sampling.accuracies(setting, study.seed, 1, 1)
        assumed = {"black": assumed_b[0, 0], "white": assumed_w[0, 0]}
        again = sc.infer(readings, messages, assumed, 1, setting.brain, compiled=False)
        for name in ("estimate", *setting.brain.memory):
            assert (again[name].values == trace[name].values).all(), name


def test_large_arenas_are_lived_in_the_same_way(steered, monkeypatch):
    study, results = steered
    monkeypatch.setattr(rides, "MOST_TILES", 0)
    assert sc.run(study).equals(results)


def test_wheels_have_limits(folder):
    for trace in traces(folder, "ABSURD", robots=1, density=1):
        load = steps_of(trace) / STEP + np.abs(turns_of(trace)) / TURN
        assert 1 - 1e-3 < load.max() <= 1 + 1e-9  # what is too much is slowed, not refused, and keeps its proportions
        share = 1 / (1 + TURN / STEP)  # of the wheels' speed that goes into the turn: as many radians as metres
        wanted = turns_of(trace)[np.abs(turns_of(trace)) < 1.01 * share * TURN] / (share * TURN)
        assert (wanted.min(), wanted.max()) == pytest.approx((-1, 1))


def test_steering_walks_alone_and_leaves_other_settings_alone(folder, steered):
    study, results = steered
    k = [k for k, s in enumerate(study.settings()) if s.density == 6.0]
    begins = [sc.replay(results, n, 0, folder / "steered.py")["position"].values for n in k]
    for other in begins[1:]:
        assert (begins[0][:2] == other[:2]).all()
        assert (begins[0][-1] != other[-1]).any()
    alone = sc.run(study_of(folder, "SEEN", density=6))
    assert (alone["final_estimate"].values[0] == results["final_estimate"].values[k[-1]]).all()


def test_a_command_that_is_no_number_ends_the_run_with_a_message(folder, monkeypatch):
    for _ in range(2):
        said = r"brain 'steered.py' fails in trial 0.*robot 0, after tick 1: steer gives \(nan, 0\): two finite numbers"
        with pytest.raises(sc.InputError, match=said):
            sc.run(study_of(folder, "BROKEN", density=1))
        with pytest.raises(sc.InputError, match=r"ZeroDivisionError.* at .*steered.py, line \d+: return 0.1 / "):
            sc.run(study_of(folder, "DIVIDES", density=1))
        monkeypatch.setattr(rides, "MOST_TILES", 0)


@pytest.mark.long(but_every=3)
@pytest.mark.parametrize(("steer", "said"), [
    ("me.x = 0.0\n    return None", "changes me.x from 0.5 to 0.0: it may only read"),
    ("return 1e308 * 10.0, 0.0", "gives (inf, 0.0), neither two"),
    ("return 0.1, 0.0, 0.0", "gives (0.1, 0.0, 0.0), neither two"),
    ("return True, 0.0", "gives (True, 0.0), neither two finite"),
])  # fmt: skip
def test_what_is_wrong_with_steer_is_named(steer, said, tmp_path, untraced):
    (tmp_path / "bad.py").write_text(f"{brains.load('minimalistic').source}\n\ndef steer(me):\n    {steer}\n")
    found = conformance.examine(brains.load(tmp_path / "bad.py"), contract_checks.PROMISES)
    [fault] = {c.fault for c in found} - {None, "the same as above"}
    assert said in fault


@pytest.mark.parametrize("command", [None, (0.1, -0.2), (1, 0), (0.1, 2)])
def test_a_command_is_read(command):
    assert numba.njit(lambda: chosen(command))() == chosen(command) == ((0, 0, 0) if command is None else (1, *command))


@pytest.mark.parametrize("command", [(0.1, 0.0, 0.0), (0.1,), (True, 0.1), ("a", "b"), 0.1, "left"])
def test_what_is_no_command_is_not_compiled(command):
    with pytest.raises(TypeError, match=r"steer gives .*, neither two numbers, a speed and a turn, nor None"):
        numba.njit(lambda: chosen(command))()
