"""Fill ratios that each trial draws: how, for whom, and that all else refers to what was drawn."""

import json

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus.analysis import compare
from swarmcensus.simulation import Stepped
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import Metrics, record_estimates, run_batch
from swarmcensus.studies import addresses
from swarmcensus.summaries import measures, remeasure, replay
from tests.support.small import GO, SEED, moving_of, settings_of, study_of

DRAWN = "U(0.3, 0.7)"
MEASURE = Metrics(0.02, 10, (2, 8), estimates=True)


def drawn_of(setting, trials):
    return np.array([addresses.in_trial(setting, SEED, trial).fill_ratio for trial in range(trials)])


@pytest.mark.parametrize(("spread", "law"), [(DRAWN, stats.uniform(0.3, 0.4)), ("N(0.5, 0.05)", stats.norm(0.5, 0.05))])
def test_trials_draw_from_the_spread(spread, law):
    (setting,) = settings_of(fill_ratio=spread)
    assert setting.fill_ratio == 0.5
    assert settings_of(fill_ratio="U(0.2, 0.4)")[0].fill_ratio == 0.3
    drawn = drawn_of(setting, 1000)
    assert stats.kstest(drawn, law.cdf).pvalue > 1e-3  # fails for one seed in a thousand
    assert abs(stats.pearsonr(drawn[:-1], drawn[1:])[0]) < 3.3 / 1000**0.5  # the same


def test_settings_that_differ_in_other_things_draw_the_same():
    first, *others = settings_of(brain=["commons", "minimalistic"], topology=["ring", "full"], fill_ratio=DRAWN)
    others += [*settings_of(robots=7, accuracy=0.9, rounds=3, fill_ratio=DRAWN), moving_of(fill_ratio=DRAWN)]
    assert all((drawn_of(first, 5) == drawn_of(other, 5)).all() for other in others)
    (apart,) = settings_of(fill_ratio="U(0.3, 0.71)")
    (fixed,) = settings_of(fill_ratio=0.5)
    shared = [addresses.streams(one, SEED)["readings"] for one in (first, others[0], apart, fixed)]
    assert shared[0] == shared[1]
    assert shared[2] not in shared[:2]
    assert shared[3] not in shared[:3]
    assert not np.isclose((drawn_of(first, 5) - 0.3) / 0.4, (drawn_of(apart, 5) - 0.3) / 0.41).any()


def same_batches(one, two):
    for name in ("convergence", "error", "final", "correct", "agreement", "fill_ratio", "kept"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name), err_msg=name)


@pytest.mark.parametrize("more", [{}, {"members": [{"robots": 2, "accuracy": 0.5}]}, {"brain": "commons"}])
def test_a_trial_is_that_of_a_setting_with_the_number_that_it_drew(more):
    (setting,) = settings_of(fill_ratio=DRAWN, **more)
    batch = run_batch(setting, SEED, 2, 3, MEASURE, GO)
    for k, trial in enumerate((2, 3, 4)):
        own = addresses.in_trial(setting, SEED, trial)
        (plain,) = settings_of(fill_ratio=own.fill_ratio, **more)
        assert own == plain
        alone = run_batch(plain, SEED, trial, 1, MEASURE, GO)
        assert batch.final[k].tolist() == alone.final[0].tolist()
        assert batch.error[k].tolist() == alone.error[0].tolist()
        assert batch.correct[:, k].tolist() == alone.correct[:, 0].tolist()
        assert record_estimates(setting, SEED, trial)[-1].tolist() == alone.final[0].tolist()
        live = Stepped(setting, SEED, trial)
        assert live.setting == plain
        assert live.at(0).estimates[-1].tolist() == alone.final[0].tolist()


def test_robots_that_move_see_a_floor_of_what_was_drawn():
    setting = moving_of(robots=4, ticks=12, fill_ratio=DRAWN)
    plain = moving_of(robots=4, ticks=12, fill_ratio=addresses.in_trial(setting, SEED, 1).fill_ratio)
    (one,), (other,) = (run_ride([chosen], SEED, 1, MEASURE, GO) for chosen in (setting, plain))
    same_batches(one, other)
    assert one.true_fill_ratio == other.true_fill_ratio
    assert abs(float(one.true_fill_ratio[0]) - plain.fill_ratio) < 0.1


@pytest.fixture(scope="module")
def results():
    keys = {"rounds": 8, "trials": 12, "accuracy": 0.9, "measure": {"estimates": True, "bins": 4}}
    return sc.run(study_of(brain=["commons", "minimalistic"], fill_ratio=[DRAWN, 0.6], **keys), jobs=1)


def test_results_have_the_mean_as_a_coordinate_and_what_was_drawn(results):
    assert results["fill_ratio"].values.tolist() == [0.5, 0.6] * 2
    assert results["fill_ratio_spread"].values.tolist() == ["U(0.3,0.7)", ""] * 2
    drawn = results["drawn_fill_ratio"]
    assert drawn.dims == ("setting", "trial")
    assert (drawn[0] == drawn[2]).all()
    assert np.unique(drawn[0]).size == 12
    assert (drawn[1] == 0.6).all()
    assert sc.verify(results).labels == sc.verify(results).differences == []


def test_errors_and_decisions_refer_to_what_was_drawn(results):
    drawn, final = results["drawn_fill_ratio"].values[..., np.newaxis], results["final_estimate"].values
    np.testing.assert_array_equal(measures.sample(results, "final_error", np.arange(4)), np.abs(final - drawn))
    right = (np.floor(4 * final) == np.floor(4 * drawn)).mean(axis=2)
    np.testing.assert_array_equal(results["correct"].values[:, -1], right)
    assert sc.summary(results)["final_error"][0] == np.median(np.abs(final - drawn)[0])
    six = remeasure(results, bins=6)
    np.testing.assert_array_equal(six["correct"][:, -1], (np.floor(6 * final) == np.floor(6 * drawn)).mean(axis=2))


def test_replays_and_comparisons_know_what_was_drawn(results):
    trace = replay(results, 0, 3)
    assert trace.attrs["fill_ratio"] == results["drawn_fill_ratio"].values[0, 3]
    assert trace["estimate"].values[-1].tolist() == results["final_estimate"].values[0, 3].tolist()
    assert [*compare(results).grid.worlds[0]] == ["fill_ratio", "fill_ratio_spread"]
    assert compare(results, factor="fill_ratio_spread").contenders == [
        "fill_ratio_spread=U(0.3,0.7)", "f fixed",
    ]  # fmt: skip


def test_results_of_studies_with_and_without_merge(results):
    plain = sc.run(study_of(fill_ratio=0.5, rounds=8, trials=4, measure={"estimates": True, "bins": 4}), jobs=1)
    merged = sc.merge([results, plain])
    assert measures.truth(merged)[-1].tolist()[:4] == [0.5] * 4
    assert measures.truth(merged)[0].tolist() == results["drawn_fill_ratio"].values[0].tolist()
    assert sc.verify(merged, 1).labels == []
    assert json.loads(merged.attrs["merged"])


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("U(0.3", "a fill ratio is a number in [0, 1], or a shipped spread"),
        ("0.5", "a fill ratio is a number in [0, 1], or a shipped spread"),
        ("mine.py(1)", "a fill ratio is a number in [0, 1], or a shipped spread"),
        ("U(0.5, 1.5)", "a fill ratio is a number in [0, 1], or a shipped spread"),
        ({"spread": "U", "lo": [], "hi": 0.5}, "lo = []: should be a list of at least one"),
    ],
)
def test_wrong_spreads_are_refused(value, said):
    with pytest.raises(sc.InputError) as refused:
        study_of(fill_ratio=value)
    assert said in str(refused.value)
    assert "world.fill_ratio" in str(refused.value)
