"""Kept estimates: what they are."""

import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc

FIXED = {"seed": 3, "trials": 3, "swarm": {"robots": [4, 9], "accuracy": [0.7, 0.95]},
         "world": {"topology": ["full", "ring"], "fill_ratio": 0.55},
         "schedule": {"rounds": [20, 40], "observations_per_round": 5}}  # fmt: skip
MOVING = {"seed": 3, "trials": 2, "swarm": {"robots": [5, 8], "accuracy": 0.9},
          "world": {"topology": "moving", "density": 4, "fill_ratio": 0.55, "floor": ["tiles", "half"]},
          "schedule": {"ticks": 60}}  # fmt: skip


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
