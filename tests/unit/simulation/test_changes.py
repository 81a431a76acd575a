"""Floors that change and sensors that drift while robots look: what a study says, and what a run makes of it."""

from dataclasses import replace

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.analysis.explaining import wrong_beliefs
from swarmcensus.engine.changes import accuracy_in, fill_ratio_in
from swarmcensus.simulation import sampling, walking
from swarmcensus.studies import addresses
from swarmcensus.summaries.selecting import where
from swarmcensus.worlds.changes import Change, along, read_change
from tests.reference import rounds as reference
from tests.support.small import SEED, SLOW, SWITCH, called, changing, moving_of, settings_of
from tests.support.trials import record_ride

# ---- what it is


def test_a_course_is_what_the_docs_say():
    """From `at` on it moves by equal steps, and in round `until` it has arrived; a switch is one step."""
    slow = along(Change(0.8, 0.2, 4, 6).course, np.arange(1, 9))
    assert slow == pytest.approx([0.8, 0.8, 0.8, 0.6, 0.4, 0.2, 0.2, 0.2], abs=1e-15)
    assert along(Change(0.8, 0.2, 4).course, np.arange(1, 7)).tolist() == [0.8] * 3 + [0.2] * 3
    assert along(Change(0.8, 0.2, 4, 4).course, np.arange(1, 7)).tolist() == [0.8] * 3 + [0.2] * 3


@pytest.mark.parametrize("change", [Change(0.1, 0.7, 5), Change(0.9, 0.3, 3, 17), Change(1 / 3, 0.7, 2, 1000)])
def test_engine_dataset_and_reference_agree_on_it_to_the_bit(change):
    (setting,) = settings_of(rounds=30)
    setting = replace(setting, change=change)
    rounds = np.arange(1, 31)
    found = along(change.course, rounds).tolist()
    assert found == [called(fill_ratio_in)(change.course, k) for k in rounds]
    assert found == [reference.fill_ratio_in(setting, int(k)) for k in rounds]
    assert read_change(str(change)) == change


@pytest.mark.parametrize(("drift", "bound"), [(-0.03, {"least": 0.6}), (0.02, {"most": 0.85}), (-0.03, {}), (0.05, {})])
def test_accuracies_drift_to_their_bound_and_stay(drift, bound):
    accuracy = {"start": "U(0.7, 0.8)", "drift": drift, **bound}
    (setting,) = settings_of(accuracy=accuracy)
    b, w, assumed_b, assumed_w = sampling.accuracies(setting, SEED, 0, 2)
    assert (b == w).all()
    assert (b == assumed_b).all()  # who knows its sensor knows how it began
    assert (w == assumed_w).all()
    (plain,) = settings_of(accuracy="U(0.7, 0.8)")
    assert (b == sampling.accuracies(plain, SEED, 0, 2)[0]).all()
    moves = sampling.drifts(setting, SEED, 0, 2, b)
    in_round = called(accuracy_in)
    end = bound.get("least", 0.5) if drift < 0 else bound.get("most", 1.0)
    for k in range(1, 30):
        for i in range(5):
            due = max(b[1, i] + drift * (k - 1), end) if drift < 0 else min(b[1, i] + drift * (k - 1), end)
            assert in_round(b[1], moves[1], i, k) == due == reference.accuracy_in(setting, 0, b[1, i], k)


def test_who_starts_beyond_the_bound_stays_there():
    """Of a normal spread only the mean is held against the bound."""
    (setting,) = settings_of(robots=60, accuracy={"start": "N(0.7, 0.2)", "drift": -0.01, "least": 0.65})
    b = sampling.accuracies(setting, SEED, 0, 1)[0][0]
    moves = sampling.drifts(setting, SEED, 0, 1, b[np.newaxis])[0]
    below = np.flatnonzero(b < 0.65)
    assert 5 < below.size < 55
    ends = np.array([called(accuracy_in)(b, moves, i, 1000) for i in range(60)])
    assert (ends == np.where(b < 0.65, b, 0.65)).all()


# ---- what it shares


@pytest.mark.parametrize("world", [{}, {"topology": "moving", "density": 8}], ids=["fixed", "moving"])
def test_until_it_changes_a_world_is_the_one_that_stays(world):
    """The same tiles, readings and messages; and after it none of the old floor's."""
    early, late = sc.run(changing(SWITCH, world=world)), sc.run(changing(0.85, world=world))
    one, other = (sc.replay(data, 0, 1)["estimate"].values for data in (early, late))
    assert (one[:31] == other[:31]).all()
    assert (one[-1] != other[-1]).all()
    drifts = sc.run(changing(0.85, {"start": 0.9, "drift": -0.001}, world))
    read = [sc.replay(data, 0, 1)[{True: "reading", False: "blacks"}[bool(world)]].values for data in (drifts, late)]
    assert np.array_equal(read[0][:2], read[1][:2], equal_nan=True)


def test_they_are_settings_of_their_own():
    made = changing([0.25, SWITCH, SLOW, SWITCH | {"from": 0.8}], [0.9, {"start": 0.9, "drift": -0.001}])
    settings = made.settings()
    assert len({addresses.fingerprint(s, 7) for s in settings}) == len(settings) == 8
    results = sc.run(made)
    assert (results["fill_ratio"] == 0.25).all()
    assert results["fill_ratio_change"].values[:4].tolist() == [
        "", "0.85 to 0.25 at 31", "0.85 to 0.25 at 31 until 71", "0.8 to 0.25 at 31"
    ]  # fmt: skip
    assert set(results["accuracy"].values) == {"0.9", "0.9 drift=-0.001 least=0.5"}
    assert (results["assumed_accuracy"] == "0.9").all()
    assert "fill_ratio_change" not in sc.run(changing(0.25))
    again = sc.Study.parse(made.text)
    assert again.settings() == settings
    for text, count in (("fill_ratio == 0.25", 8), ('fill_ratio_change == "0.85 to 0.25 at 31"', 2)):
        assert where(results, text).sizes["setting"] == count


def test_the_fill_ratio_of_a_setting_is_that_of_its_last_round():
    made = changing(SLOW, schedule={"rounds": [20, 40, 100]})
    assert [s.fill_ratio for s in made.settings()] == pytest.approx([0.85, 0.85 - 0.6 * 10 / 41, 0.25], abs=1e-15)


# ---- the same life, however it is lived


@pytest.mark.parametrize("change", [SWITCH, SLOW], ids=["switch", "drift"])
def test_walks_in_chunks_change_in_the_same_tick(change, monkeypatch):
    setting = moving_of(ticks=100, fill_ratio=change, accuracy={"start": 0.9, "drift": -0.004})
    whole = record_ride(setting, SEED, 1)
    monkeypatch.setattr(walking, "CHUNK_BYTES", 6 * 41 * 7)
    parts = record_ride(setting, SEED, 1)
    assert (whole.estimates == parts.estimates).all()
    assert np.array_equal(whole.readings, parts.readings, equal_nan=True)


# ---- what is asked and told later


def test_other_bins_are_not_asked_of_a_truth_that_changes():
    results = sc.run(changing([SLOW, 0.25], measure={"estimates": True, "checkpoints": [10, 30]}))
    with pytest.raises(sc.InputError, match="bins = 7"):
        sc.remeasure(results, bins=7)


def test_an_accuracy_is_read_from_the_text_of_a_dataset():
    """And no cost of a belief is predicted where the truth drifts."""
    told = {"start": "U(0.8, 0.9)", "drift": -0.001, "least": 0.6}
    made = changing(0.3, [0.9, told, {"start": 0.9, "drift": 0.002}])
    results = sc.run(made)
    for text, setting in zip(results["accuracy"].values, made.settings(), strict=True):
        assert wrong_beliefs.accuracy_of(text) == setting.accuracy
    assert [np.isnan(cost.predicted) for cost in wrong_beliefs.costs_of(results)] == [False, True, True]
