"""Small swarms on fixed networks against the reference, and batches of trials against their curves."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.engine import compiler
from swarmcensus.simulation import metrics, trials
from swarmcensus.simulation.trials import Metrics, record_readings, run_batch
from swarmcensus.studies import addresses
from tests.reference import rounds as reference
from tests.support.lives import local_curves
from tests.support.small import FAULTS, GO, SEED, failing, heard_in, moving_of, settings_of
from tests.support.trials import record_trial

CASES = [
    {"robots": [1, 2, 5], "topology": ["full", "ring", "line", "scale-free"]},
    {"robots": 6, "topology": "full", "brain": ["minimalistic", "legacy"], "link_success": [1.0, 0.5], "rounds": 5},
    {"robots": 6, "topology": ["full", "scale-free"], "accuracy": "U(0.5, 0.9)", "faults": FAULTS, "looks": 3},
    {"robots": [3, 6], "topology": ["full", "ring"], "link_success": 0.4, "faults": FAULTS[:2], "brain": "legacy"},
    {"robots": 5, "topology": {"name": "odd", "edges": [[0, 3], [3, 1], [4, 0]]}, "link_success": [0.7, 1.0]},
    {
        "robots": 4,
        "topology": {"name": "one way", "edges": [[0, 3], [3, 1], [1, 3], [2, 0]], "directed": True},
        "link_success": [0.7, 1.0],
    },
    {"robots": 4, "accuracy": {"black": "N(0.8, 0.1)", "white": 0.6}, "assumed_accuracy": {"error": "U(-0.2, 0.1)"}},
    {"robots": 260, "rounds": 2, "accuracy": "U(0.6, 0.8)", "looks": 17},
    {
        "robots": 5,
        "topology": ["ring", "full"],
        "looks": 3,
        "fill_ratio": {"from": 0.9, "to": 0.2, "at": 3, "until": 6},
        "accuracy": {"start": "U(0.7, 0.9)", "drift": -0.02, "least": 0.6},
    },
    {
        "robots": 6,
        "topology": ["ring", "full"],
        "brain": ["commons", "swift", "voter"],
        "looks": 3,
        "rounds": 9,
        "message_delay": [1, 4],
    },
    {"robots": 258, "topology": "line", "rounds": 3, "faults": [FAULTS[0] | {"robots": 0.5}], "link_success": 0.9},
]


@pytest.mark.parametrize("case", CASES, ids=range(len(CASES)))
def test_fixed_networks_against_the_reference(case):
    """Bit for bit, but to rounding where everyone hears everyone: sums are added in another order there."""
    for setting in settings_of(**case):
        for trial in (0, 2):
            history, estimates, blacks = record_trial(setting, SEED, trial)
            states = reference.fixed(setting, SEED, trial, failing(setting, trial), heard_in(setting, trial), blacks)
            if setting.topology.name == "full":
                assert estimates == pytest.approx(np.array(states.estimates), abs=1e-12)
            else:
                assert (estimates == np.array(states.estimates)).all()
            for name in setting.brain.memory:
                assert history[name][-1] == pytest.approx([getattr(me, name) for me in states.states], rel=1e-9)


@pytest.mark.parametrize("looks", [1, 3, 17])
def test_rounds_are_sums_of_single_readings(looks):
    (setting,) = settings_of(robots=3, looks=looks, rounds=3, accuracy="U(0.6, 0.9)")
    for trial in (0, 2):
        blacks = record_trial(setting, SEED, trial)[2]
        readings = record_readings(setting, SEED, trial)
        key, left = addresses.readings_key(setting, SEED, "order"), blacks.copy()
        for step, row in enumerate(readings):
            tick, to_come = 1 + step // looks, looks - step % looks
            for i in range(3):
                u = reference.unit(reference.robots_word(key, trial, step + 1, i))
                assert row[i] == (u < left[tick, i] / to_come)
                left[tick, i] -= row[i]
        assert (left[1:] == 0).all()


def test_swarms_of_more_than_a_block_are_measured_like_others():
    """A block is 256 robots."""
    (setting,) = settings_of(robots=259, rounds=2, looks=2, topology="line")
    batch = run_batch(setting, SEED, 0, 1, Metrics(0.03, 7, (1, 2), estimates=True), GO)
    curves = record_trial(setting, SEED, 0)[1]
    assert (batch.kept[:, 0] == curves[1:]).all()
    assert (batch.final[0] == curves[-1]).all()
    assert (batch.convergence[0] == metrics.convergence(curves, 0.03)).all()
    alone = run_batch(setting, SEED, 0, 1, Metrics(0.03, 7, ()), GO, local=True)
    assert (alone.final[0] == local_curves(setting, 0)[-1]).all()


def test_estimates_are_kept_where_they_are_asked_for_alone():
    (setting,) = settings_of(rounds=2)
    assert run_batch(setting, SEED, 0, 1, Metrics(0.01, 10, (2,)), GO).kept is None


@pytest.mark.parametrize("topology", ["line", "full"])
def test_losses_one_way_say_nothing_of_the_other_way(topology):
    """Two robots, 600 rounds: directions, rounds and trials are uncorrelated, within 4 standard errors."""
    source = brains.load("minimalistic").source
    source = source.replace("SUMS = ", "NOTHING = ").replace("        me.heard = 0.0\n", "")  # counts what it hears
    (setting,) = settings_of(robots=2, rounds=300, topology=topology, link_success=0.5)
    setting = replace(setting, brain=brains.parse(source, "counting", setting.brain.path))
    heard = [np.diff(record_trial(setting, SEED, trial)[0]["heard"], axis=0) for trial in (0, 1)]
    assert set(np.unique(heard)) == {0.0, 1.0}
    one, other = np.concatenate(heard).T
    pairs = [(one, other), (one[1:], one[:-1]), (one[1:], other[:-1]), (heard[0].ravel(), heard[1].ravel())]
    for x, y in pairs:
        assert abs(np.corrcoef(x, y)[0, 1]) < 4 / math.sqrt(len(x))


def failing_engine(error, *, only="kernel"):

    def fail(*_):
        raise error

    def compile_world(name="world"):
        return SimpleNamespace(simulate=fail, live=fail) if name == only else compiler.compile_world(name)

    return SimpleNamespace(**{**vars(compiler), "compile_world": compile_world})


def test_a_brain_that_fails_is_named_with_its_trials(monkeypatch):
    (setting,) = settings_of()
    monkeypatch.setattr(trials, "compiler", failing_engine(ZeroDivisionError("division by zero\nand more")))
    for first, count, which in ((3, 1, "trial 3"), (4, 3, "trials 4 to 6")):
        with pytest.raises(sc.InputError) as caught:
            run_batch(setting, SEED, first, count, Metrics(0.01, 10, (2,)), GO)
        assert str(caught.value) == (
            f"brain 'minimalistic' fails in {which} of {setting}: ZeroDivisionError: division by zero"
        )
    monkeypatch.setattr(trials, "compiler", failing_engine(RuntimeError()))
    with pytest.raises(sc.InputError, match=r"fails in trial 0 of .*: RuntimeError: $"):
        run_batch(setting, SEED, 0, 1, Metrics(0.01, 10, (2,)), GO)


def test_length_of_segments():
    """Few robots' estimates are all kept; of many, what is kept grows with the square root of the rounds."""
    assert trials.segment_length(10, 50, 96, 1) == 50
    assert trials.segment_length(100_000, 5000, 96, 1) == 244  # the root of 5000 96 / 8
    assert trials.segment_length(100_000, 5000, 96, 10) == 250
    assert trials.segment_length(10**6, 10**9, 8, 7) % 7 == 0
    assert trials.segment_length(10**9, 50, 8, 1) == 7
    assert trials.segment_length(10**6, 120, 8, 1) == 100  # of a crowd, a hundred
    assert trials.segment_length(10**5, 120, 8, 1) == 100
    assert trials.segment_length(10**10, 1, 8, 1) == 1


def test_batches_of_long_trials_keep_as_little_as_they_say(monkeypatch):
    """Memory for estimates is reckoned from robots, rounds, the size of a state, and the readings of a round."""
    asked = []
    monkeypatch.setattr(trials, "segment_length", lambda *sizes: asked.append(sizes) or 3)
    (setting,) = settings_of(robots=2, rounds=3, looks=4)
    size = compiler.array_layout(setting.brain).blank.nbytes
    for local, expected in ((False, (2, 3, size, 1)), (True, (2, 12, size, 4))):
        run_batch(setting, SEED, 0, 1, Metrics(0.01, 10, ()), GO, local)
        assert asked.pop() == expected


def test_costs_are_foretold_by_how_much_there_is_to_do():
    """In proportion to the rounds, robots, readings and messages: tasks are bundled and told out by it."""
    ring, full, scattered = settings_of(
        robots=1000, rounds=1000, topology=["ring", "full", {"name": "few", "edges": [[0, 1]]}]
    )
    nanoseconds = [trials.seconds(s) / 1e6 * 1e9 for s in (scattered, ring, full)]
    assert nanoseconds == pytest.approx([13, 19, 19], abs=0.1)
    one_by_one = replace(full.brain, contents=full.brain.contents._replace(sums=()))
    all_pairs = replace(full, link_success=0.5), replace(full, brain=one_by_one)
    assert [trials.seconds(s) for s in all_pairs] == pytest.approx([3.013] * 2, rel=0.01)
    assert trials.seconds(replace(ring, link_success=0.5)) == trials.seconds(ring)
    assert trials.seconds(replace(full, rounds=2000)) == pytest.approx(2 * trials.seconds(full), rel=0.01)
    assert trials.seconds(replace(full, observations_per_round=150)) == pytest.approx(0.039, rel=0.01)
    assert trials.seconds(replace(full, observations_per_round=150), local=True) == pytest.approx(2.25)
    moving = moving_of(robots=1000, ticks=500, density=10)
    assert (trials.seconds(moving), trials.walk_seconds(moving)) == pytest.approx((0.02, 0.2))
