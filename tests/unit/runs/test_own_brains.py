"""Studies of the brains that go beyond the paper's: the same bits, however they are run, and in CPython."""

import functools
import os
import subprocess
import sys

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.results import shards
from swarmcensus.runs.running import run
from tests.support.long import in_two_sizes

pytestmark = pytest.mark.usefixtures("untraced_processes")

BRAINS = ["commons", {"file": "sure", "within": 0.2}, "swift", "steadfast", "tracking", "self-taught"]
WORLDS = {
    "fixed": {
        "world": {"topology": ["full", "ring"], "fill_ratio": 0.55, "link_success": [1.0, 0.6]},
        "schedule": {"rounds": 30, "observations_per_round": 5},
        "measure": {"checkpoints": [10, 30]},
    },
    "moving": {
        "world": {"topology": "moving", "density": 3, "fill_ratio": 0.55, "body": {"message_delay": 2}},
        "schedule": {"ticks": 40},
        "measure": {"checkpoints": [10, 40]},
        "faults": [{"at": 20, "robots": 1, "stop": ["moving", "talking"]}],
    },
}
IN_CPYTHON = """
import sys, swarmcensus
for name in sys.argv[1:]:
    swarmcensus.save(swarmcensus.run(swarmcensus.Study.load(name), jobs=1), name.replace(".toml", "-slow.nc"))
"""


def study(name, trials=10, brains=None):
    swarm = {"brain": BRAINS[:brains], "robots": 6, "accuracy": ["U(0.525, 0.975)", {"black": 0.9, "white": 0.7}]}
    return sc.Study(name=name, seed=11, trials=trials, swarm=swarm, **WORLDS[name])


def same(one, other):
    """Equal to the last bit, but for what says when and by whom it was run."""
    return one.drop_attrs(deep=False).identical(other.drop_attrs(deep=False))


@functools.cache
def known(name, brains=None):
    """What two threads make of a study of the first few brains."""
    return sc.run(study(name, brains=brains), jobs=2)


@pytest.mark.long
@pytest.mark.parametrize("name", WORLDS)
def test_with_one_thread_after_a_cut_and_verified(name, monkeypatch, tmp_path):
    monkeypatch.setattr("swarmcensus.runs.pools.BUNDLE_SECONDS", 0.0001)  # ten bundles: four are out at once
    monkeypatch.setattr(shards, "AT_LEAST", 0.0)
    monkeypatch.setattr(shards, "OF_ELAPSED", 0.0)
    out, half = tmp_path / f"{name}.nc", known(name).attrs["trials_total"] // 3

    def stop(progress):
        if progress.done >= half:
            raise KeyboardInterrupt

    with pytest.raises(sc.Interrupted):
        run(study(name), 1, stop, out=out)
    begun = []
    again = run(study(name), 1, lambda progress: begun.append(progress.done), out=out)
    assert half <= begun[0] < known(name).attrs["trials_total"]
    assert same(again, known(name))
    found = sc.verify(out, 0.2, jobs=1)
    assert found.checked > 0
    assert not found.differences
    assert not found.labels


@in_two_sizes(("brains", "step"), (1, 1), (None, 1))
@pytest.mark.parametrize("name", WORLDS)
def test_replayed(name, brains, step):
    """The trace's last round is the dataset's, and its memory has as many numbers as the brain."""
    data = known(name, brains)
    for k in range(0, data.sizes["setting"], step):
        trace = sc.replay(data, k, 2)
        last = trace.isel({trace["estimate"].dims[0]: -1})
        assert (data["final_estimate"].values[k, 2] == last["estimate"].values).all()


@pytest.mark.long
def test_without_numba(tmp_path, untraced_processes):
    """Of few trials: the last bit of what CPython computes is that of machine code."""
    for name in WORLDS:
        (tmp_path / f"{name}.toml").write_text(study(name, trials=1).text)
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    names = [f"{name}.toml" for name in WORLDS]
    subprocess.run([sys.executable, "-c", IN_CPYTHON, *names], cwd=tmp_path, env=environment, check=True, timeout=600)
    for name in WORLDS:
        slow, fast = sc.load(tmp_path / f"{name}-slow.nc"), sc.run(study(name, trials=1))
        for variable in fast.data_vars:
            np.testing.assert_array_equal(slow[variable].values, fast[variable].values, err_msg=f"{name} {variable}")
