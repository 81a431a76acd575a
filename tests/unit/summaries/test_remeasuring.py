"""Kept estimates: what they are, and other bins asked of them instead of a new run."""

import json

import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus.cli.commands import main

FIXED = {
    "seed": 3,
    "trials": 3,
    "swarm": {"robots": [4, 9], "accuracy": [0.7, 0.95]},
    "world": {"topology": ["full", "ring"], "fill_ratio": 0.55},
    "schedule": {"rounds": [20, 40], "observations_per_round": 5},
}
MOVING = {
    "seed": 3,
    "trials": 2,
    "swarm": {"robots": [5, 8], "accuracy": 0.9},
    "world": {"topology": "moving", "density": 4, "fill_ratio": 0.55, "floor": ["tiles", "half"]},
    "schedule": {"ticks": 60},
}


def measured(tables, **measure):
    return sc.run(sc.Study(**tables, measure=measure), jobs=2)


@pytest.fixture(scope="module", params=[FIXED, MOVING], ids=["network", "moving"])
def tables(request):
    return request.param


@pytest.fixture(scope="module")
def kept(tables):
    return measured(tables, estimates=True, checkpoints=list(range(1, 61 if tables is MOVING else 41)))


def test_estimates_are_those_of_the_curves(kept):
    for setting in kept["setting"].values:
        trace = sc.replay(kept, int(setting), 1)
        one = kept["estimates"].sel(setting=setting, trial=1).values
        rounds, robots = trace.sizes["round"] - 1, trace.sizes["robot"]
        assert np.array_equal(one[:rounds, :robots], trace["estimate"].values[1:])
        assert np.isnan(one[rounds:]).all()
        assert np.isnan(one[:, robots:]).all()


def test_to_keep_estimates_changes_no_other_number(tables, kept):
    plain = measured(tables, checkpoints=kept["checkpoint"].values.tolist())
    xr.testing.assert_identical(plain.drop_attrs(deep=False), kept.drop_vars("estimates").drop_attrs(deep=False))


@pytest.mark.parametrize("truth", ["nominal", "floor"])
def test_remeasuring_equals_a_run(tables, kept, truth):
    if truth == "floor" and tables is FIXED:
        pytest.skip("fixed networks have no floor")
    measure = {"checkpoints": kept["checkpoint"].values.tolist(), "truth": truth}
    if truth == "floor":
        kept = measured(tables, estimates=True, **measure)
    asked = sc.remeasure(kept, bins=7)
    run = measured(tables, bins=7, **measure)
    assert np.array_equal(asked["correct"], run["correct"], equal_nan=True)
    assert asked.attrs["bins"] == 7
    assert kept.attrs["bins"] == 10, "the results asked of stay as they are"


def test_trials_that_are_missing_stay_missing(kept):
    cut = kept.copy(deep=True)
    if "true_fill_ratio" in cut:
        cut.attrs["truth"] = "floor"  # each trial has its own
    whole = sc.remeasure(cut, bins=3)
    names = ["correct", "convergence_round", "convergence_error"]
    for name in ["estimates", "final_estimate", *names]:
        cut[name].loc[{"trial": 0}] = np.nan
    asked = sc.remeasure(cut, bins=3)
    for name in names:
        assert np.isnan(asked[name].sel(trial=0)).all()
        later = {"trial": slice(1, None)}
        np.testing.assert_array_equal(asked[name].isel(later), whole[name].isel(later))


@pytest.mark.long
def test_repeated_requests_are_reported(here, accepted):
    kept = measured(FIXED | {"trials": 8}, estimates=True, checkpoints=[1, 2, 5, 20, 40])
    sc.save(kept, "kept.nc")

    def shown(*options):
        return accepted("show", "kept.nc", *options).out

    assert shown("--bins", "10") == shown()
    assert "bins 3, recomputed" in shown("--bins", "3")
    assert json.loads(shown("--json", "--bins", "3"))["asked_anew"] == ["bins"]
    sc.save(sc.remeasure(kept, bins=3), "asked.nc")
    assert main(["export", "kept.nc", "--bins", "3"]) == main(["export", "asked.nc"]) == 0
    assert (here / "kept.csv").read_bytes() == (here / "asked.csv").read_bytes()


@pytest.mark.parametrize("asked", [{"bins": 0}, {"bins": 2.5}])
def test_what_cannot_be_asked_is_refused(kept, asked):
    [(key, value)] = asked.items()
    with pytest.raises(sc.InputError, match=f"{key} = {value}"):
        sc.remeasure(kept, **asked)


def test_results_without_estimates_say_how_to_get_them(small_results):
    with pytest.raises(sc.InputError, match=r"estimates = true under \[measure\]"):
        sc.remeasure(small_results, bins=5)
