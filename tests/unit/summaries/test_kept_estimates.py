"""Kept estimates: what they are."""

import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc
from tests.support.small import study_of

FIXED = {"robots": [4, 9], "accuracy": [0.7, 0.95], "rounds": [20, 40], "looks": 5, "topology": ["full", "ring"]}
MOVING = {"robots": [5, 8], "accuracy": 0.9, "ticks": 60, "density": 4, "floor": ["tiles", "half"]}


def measured(given, **measure):
    return sc.run(study_of(**given, measure=measure), jobs=2)


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
