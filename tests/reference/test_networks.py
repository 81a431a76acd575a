"""Small swarms on fixed networks against the reference, and batches of trials against their curves."""

import math
from dataclasses import replace

import numpy as np
import pytest

from swarmcensus import brains
from swarmcensus.simulation import trials
from swarmcensus.simulation.trials import Metrics, record_readings, run_batch
from swarmcensus.studies import addresses
from tests.reference import rounds as reference
from tests.support.small import FAULTS, GO, SEED, failing, heard_in, settings_of
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
        "brain": ["commons", "legacy"],
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
