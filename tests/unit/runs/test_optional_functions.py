"""Studies of brains that use the contract's second edition: the same bits, however they are run."""

import os
import subprocess
import sys
from pathlib import Path

import distributed
import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.results import shards
from swarmcensus.runs.running import run
from swarmcensus.simulation import sampling
from tests.support.long import in_two_sizes
from tests.support.second import ADDS, ALL, STEER, TALKS

pytestmark = pytest.mark.usefixtures("untraced_processes")

FIXED = """
name   = "second"
seed   = 7
trials = 4

[swarm]
brain    = [{file = "all.py", step = [0.05, 0.2], weights = [[0.2, 0.3, 0.5], [0.5, 0.1, 0.4]]}, "steers.py"]
robots   = [5, 8]
accuracy = [0.7, "U(0.525, 0.975)"]

[[members]]
robots   = [0, 0.4]
brain    = "talks.py"
accuracy = 0.9
honest   = false

[world]
topology     = ["ring", "full", "scale-free"]
fill_ratio   = 0.55
link_success = [1.0, 0.6]

[schedule]
rounds = 12

[measure]
local = true
"""
MOVING = """
name   = "second, moving"
seed   = 8
trials = 6

[swarm]
brain    = ["all.py", "steers.py", {file = "all.py", enough = 2}]
robots   = 6
accuracy = 0.8

[[members]]
robots = [0, 2]
brain  = "talks.py"
speed  = 0.05

[world]
topology   = "moving"
density    = 3
fill_ratio = 0.55
body       = {message_delay = 2}

[schedule]
ticks = 60

[[faults]]
at     = 20
robots = 1
stop   = ["moving", "talking"]
"""
SUMS = (
    FIXED.replace("all.py", "adds.py")
    .replace(", step = [0.05, 0.2]", ", weight = [0.3, 0.9]")
    .replace(", weights = [[0.2, 0.3, 0.5], [0.5, 0.1, 0.4]]", "")
    .replace(', "steers.py"', "")
    .replace('[[members]]\nrobots   = [0, 0.4]\nbrain    = "talks.py"\n', "[[members]]\nrobots   = [0, 0.4]\n")
)
TEXTS = {"fixed": FIXED, "sums": SUMS, "moving": MOVING}
IN_CPYTHON = """
import sys, swarmcensus
for name in sys.argv[1:]:
    swarmcensus.save(swarmcensus.run(swarmcensus.Study.load(name), jobs=1), name.replace(".toml", "-slow.nc"))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("second")
    sources = {"all": ALL, "adds": ADDS, "steers": ALL + STEER, "talks": TALKS}
    for name, source in sources.items():
        (folder / f"{name}.py").write_text(source)
    for name, text in TEXTS.items():
        (folder / f"{name}.toml").write_text(text)
    return folder


@pytest.fixture
def here(folder, monkeypatch):
    monkeypatch.chdir(folder)
    return folder


class Known(dict):
    """What two threads make of each study that is asked for."""

    def __init__(self, folder):
        self.folder = folder

    def __missing__(self, name):
        self[name] = sc.run(load(self.folder, name), jobs=2)
        return self[name]


@pytest.fixture(scope="module")
def known(folder):
    return Known(folder)


def load(folder, name):
    return sc.Study.load(folder / f"{name}.toml")


def same(one, other):
    """Equal to the last bit, but for what says when and by whom it was run."""
    return one.drop_attrs(deep=False).identical(other.drop_attrs(deep=False))


@pytest.mark.long
def test_they_do_what_they_are_to_try(known):
    """Some robots are silent, some decide, some are done, some swarms agree, some hear more than they say."""
    for data in map(known.__getitem__, TEXTS):
        assert len(np.unique(data["messages_sent"])) > 6
        assert (data["decision_round"] < np.inf).any()
        assert (data["consensus"] >= 0).any()
        assert (data["consensus"] == -1).any()
        assert 0 < float(np.isfinite(data["done_round"]).mean()) < 1


@pytest.mark.long(only=["fixed"])
@pytest.mark.parametrize("name", TEXTS)
def test_with_one_thread_and_bundles_of_another_size(here, known, name, monkeypatch):
    monkeypatch.setattr("swarmcensus.runs.pools.BUNDLE_SECONDS", 0.0005)
    assert same(sc.run(load(here, name), jobs=1), known[name])


@pytest.mark.parametrize("name", ["fixed", "sums"])
def test_where_few_rounds_are_kept_at_a_time(here, known, name, monkeypatch):
    """Rounds run again for their curves are not counted or judged again."""
    monkeypatch.setattr("swarmcensus.simulation.trials.segment_length", lambda *_: 5)
    assert same(sc.run(load(here, name), jobs=1), known[name])


@pytest.mark.long
@pytest.mark.parametrize("name", TEXTS)
def test_after_a_cut(here, known, name, monkeypatch):
    monkeypatch.setattr("swarmcensus.runs.pools.BUNDLE_SECONDS", 0.001)
    monkeypatch.setattr(shards, "AT_LEAST", 0.0)
    monkeypatch.setattr(shards, "OF_ELAPSED", 0.0)
    out, half = f"{name}-cut.nc", known[name].attrs["trials_total"] // 3

    def stop(progress):
        if progress.done >= half:
            raise KeyboardInterrupt

    with pytest.raises(sc.Interrupted):
        run(load(here, name), 1, stop, out=out)
    begun = []
    again = run(load(here, name), 1, lambda progress: begun.append(progress.done), out=out)
    assert half <= begun[0] < known[name].attrs["trials_total"]
    assert same(again, known[name])
    assert same(sc.load(out), known[name])


@pytest.mark.long
@pytest.mark.parametrize("name", TEXTS)
def test_verified_and_merged(here, known, name):
    sc.save(known[name], f"{name}.nc")
    found = sc.verify(f"{name}.nc", 0.3, jobs=1)
    assert found.checked > 0
    assert not found.differences
    assert not found.labels
    few = load(here, name).with_(trials=2)
    merged = sc.merge([sc.run(few, jobs=2), known[name]])
    for variable in known[name].data_vars:
        assert merged[variable].identical(known[name][variable]) or variable == "fingerprint"


@pytest.mark.long(but_every=3)
@in_two_sizes("step", 12, 5)
@pytest.mark.parametrize("name", TEXTS)
def test_replayed(here, known, name, step):
    """The trace's last round is the dataset's, of the robots that count; who lies is in the trace too."""
    data = known[name]
    for k in range(0, data.sizes["setting"], step):
        trace = sc.replay(data, k, 2)
        setting = load(here, name).settings()[k]
        honest = np.array(
            [m == 0 or setting.members[m - 1].honest for m in sampling.groups(setting, data.attrs["seed"], 2, 1)[0]]
        )
        n = int(honest.sum())
        last = trace.isel({trace["estimate"].dims[0]: -1})
        assert (data["final_estimate"].values[k, 2, :n] == last["estimate"].values[honest]).all()
        assert (data["decision"].values[k, 2, :n] == last["decided"].values[honest]).all()
        ever = trace["is_done"].values[1:, honest].any(axis=0)
        assert (np.isfinite(data["done_round"].values[k, 2, :n]) == ever).all()


@pytest.mark.long
def test_without_numba(here, known):
    """A study of few settings: the last bit of what CPython computes is that of machine code."""
    less = {
        "trials = 4": "trials = 1", "trials = 6": "trials = 1", "[5, 8]": "5", "rounds = 12": "rounds = 6",
        '[0.7, "U(0.525, 0.975)"]': '"U(0.525, 0.975)"', "ticks = 60": "ticks = 22",
        "message_delay = 2": "message_delay = 2, tile = 0.05",
    }  # fmt: skip
    small = TEXTS
    for old, new in less.items():
        small = {name: text.replace(old, new) for name, text in small.items()}
    for name, text in small.items():
        Path(f"{name}-small.toml").write_text(text)
    names = [f"{name}-small.toml" for name in small]
    subprocess.run(
        [sys.executable, "-W", "ignore", "-c", IN_CPYTHON, *names],
        check=True,
        timeout=500,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )
    for name in names:
        assert same(sc.load(name.replace(".toml", "-slow.nc")), sc.run(sc.Study.load(name), jobs=2))


def test_local_estimates_are_those_of_whatever_else_a_study_runs(here, known):
    """Settings that differ in their network alone share them: they are the same in a study that has but one."""
    for network in ("full", "scale-free"):
        one = sc.run(sc.Study.parse(FIXED.replace('["ring", "full", "scale-free"]', f'"{network}"')), jobs=2)
        alike = known["fixed"].sel(setting=known["fixed"]["topology"] == network)
        for name in ("local_convergence_step", "local_convergence_error", "final_estimate"):
            assert (one[name].values == alike[name].values)[~np.isnan(one[name].values)].all()


@pytest.mark.long
def test_on_a_cluster(here, known):
    cluster = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0", silence_logs="CRITICAL"
    )
    with cluster:
        for name in TEXTS:
            out = f"{name}-far.nc"
            assert main(["run", f"{name}.toml", "--scheduler", cluster.scheduler_address, "--out", out]) == 0
            assert same(sc.load(out), known[name])
