"""Studies of every kind give the same bits, however they are run: one table of studies, and one test a way.

What a run records of random studies is tested in tests/unit/simulation/test_recorded.py.
"""

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
from swarmcensus.simulation import trials, walking
from tests.support.results import same
from tests.support.second import ADDS, ALL, STEER, TALKS

pytestmark = pytest.mark.usefixtures("untraced_processes")

RING = {"topology": "ring", "fill_ratio": 0.55}
MOVING = {"topology": "moving", "density": 3, "fill_ratio": 0.55, "body": {"message_delay": 2}}
MIXED = ["U(0.525, 0.975)", {"black": 0.9, "white": 0.7}]
BEYOND = ["commons", {"file": "sure", "within": 0.2}, "swift", "steadfast", "tracking", "self-taught"]
OPTIONAL = ["all.py", "steers.py", {"file": "all.py", "enough": 2}]
LIARS = [{"robots": [0, 0.4], "brain": "talks.py", "accuracy": 0.9, "honest": False}]
STOPS = [{"at": 20, "robots": 1, "stop": ["moving", "talking"]}]
SMALL_WORLD = {"name": "small-world", "rewired": 0.5, "label": "a small world"}
SLOW = {"from": 0.85, "to": 0.25, "at": 11, "until": 21}
ON_FLOOR = {"measure": {"truth": "floor"}}
SLOWER = [{"robots": [0, 2], "brain": "talks.py", "speed": 0.05}]
STUDIES = {  # swarm, world, all else; of 6 robots, 6 trials and 30 rounds unless they say otherwise
    "networks": (
        {"brain": ["minimalistic", "legacy"], "robots": [1, 2, 9], "accuracy": [0.6, 1.0]},
        {"topology": ["full", "ring", "line", "scale-free"], "fill_ratio": [0.0, 0.55], "link_success": [1.0, 0.5]},
        {"schedule": {"rounds": 12, "observations_per_round": [1, 37]}, "measure": {"local": True}},
    ),
    "moving": ({"brain": ["minimalistic", "leaver"], "accuracy": [0.6, "N(0.7, 0.1)"]}, MOVING, {"faults": STOPS}),
    "late and changing": (
        {"accuracy": [0.9, {"start": "U(0.8, 0.9)", "drift": -0.002, "least": 0.6}]},
        RING | {"fill_ratio": [SLOW, 0.3], "message_delay": [0, 1, 4]},
        {"measure": {"estimates": True, "checkpoints": [1, 20, 30], "metrics": ["mean-error", "recovery-time"]}},
    ),
    "floors": ({}, MOVING | {"floor": ["tiles", {"clusters": 0.2}, "half", {"benchmark": "star"}]}, ON_FLOOR),
    "adversaries": (
        {"brain": "steadfast", "robots": [5, 8, 11]},
        RING | {"topology": ["ring", "full"]},
        {"members": [{"robots": [0, 2], "brain": ["shouter", "jammer"]}]},
    ),
    "beyond": ({"brain": BEYOND, "accuracy": MIXED}, RING | {"topology": ["full", "ring"], "link_success": 0.6}, {}),
    "beyond, moving": ({"brain": BEYOND, "accuracy": MIXED}, MOVING, {"faults": STOPS}),
    "optional": (
        {"brain": OPTIONAL[:2], "robots": [5, 8], "accuracy": [0.7, "U(0.525, 0.975)"]},
        RING | {"topology": ["ring", "full", "scale-free"], "link_success": [1.0, 0.6]},
        {"schedule": {"rounds": 12}, "measure": {"local": True}, "members": LIARS},
    ),
    "sums": (
        {"brain": {"file": "adds.py", "weight": [0.3, 0.9]}, "robots": [5, 8]},
        RING | {"topology": ["full", "scale-free", SMALL_WORLD, "random-geometric"], "link_success": [1.0, 0.6]},
        {"schedule": {"rounds": 12}, "members": [{"robots": [0, 0.4], "accuracy": 0.9, "honest": False}]},
    ),
    "optional, moving": ({"brain": OPTIONAL}, MOVING, {"members": SLOWER, "faults": STOPS}),
}
QUICK = ["networks", "moving"]  # brains that other tests compile too
LOCAL = [name for name, (_, _, more) in STUDIES.items() if more.get("measure", {}).get("local")]
IN_CPYTHON = """
import sys, swarmcensus
for name in sys.argv[1:]:
    swarmcensus.save(swarmcensus.run(swarmcensus.Study.load(name), jobs=1), name.replace(".toml", "-slow.nc"))
"""


def study(name, trials=6, **changes):
    swarm, world, more = STUDIES[name]
    members = [{"honest": False} | one if one.get("brain") != "talks.py" else one for one in more.get("members", [])]
    more = more | ({"members": members} if members else {})
    moves = world["topology"] == "moving"
    length = {"ticks": 60} if moves else {"rounds": 30, "observations_per_round": 3}
    tables = {"schedule": length, "name": name.replace(", ", "-"), "seed": 7} | more | changes
    return sc.Study(trials=trials, **{"swarm": {"robots": 6, "accuracy": 0.8} | swarm, "world": world} | tables)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studies")
    for name, source in {"all": ALL, "adds": ADDS, "steers": ALL + STEER, "talks": TALKS}.items():
        (folder / f"{name}.py").write_text(source)
    return folder


@pytest.fixture(autouse=True)
def here(folder, monkeypatch):
    monkeypatch.chdir(folder)


@pytest.fixture(scope="module")
def known(folder):
    """What two threads make of each study that is asked for."""

    class Known(dict):
        def __missing__(self, name):
            self[name] = sc.run(study(name), jobs=2)
            return self[name]

    return Known()


every = pytest.mark.parametrize("name", STUDIES)


@pytest.mark.long
def test_the_studies_do_what_they_are_to_try(known):
    """Some robots are silent, some decide, some are done, some swarms agree."""
    for name in ("optional", "sums", "optional, moving"):
        data = known[name]
        assert len(np.unique(data["messages_sent"])) > 6
        assert (data["decision_round"] < np.inf).any()
        assert {*np.unique(data["consensus"] >= 0)} == {*np.unique(data["consensus"] == -1)} == {False, True}
        assert 0 < float(np.isfinite(data["done_round"]).mean()) < 1


@pytest.mark.long(but=QUICK)
@every
def test_in_one_thread_and_bundles_of_another_size(known, name, monkeypatch):
    monkeypatch.setattr("swarmcensus.runs.pools.BUNDLE_SECONDS", 0.0005)
    assert same(sc.run(study(name), jobs=1), known[name])


@pytest.mark.long(but=QUICK)
@every
def test_where_few_rounds_are_kept_at_a_time(known, name, monkeypatch):
    """Rounds that are run again for their curves are not counted or judged again."""
    monkeypatch.setattr(trials, "segment_length", lambda _, rounds, __, looks, *___: min(rounds, 5 * looks))
    monkeypatch.setattr(walking, "CHUNK_BYTES", 6 * 41 * 7)
    assert same(sc.run(study(name), jobs=1), known[name])


@pytest.mark.long
@every
def test_after_a_cut(known, name, monkeypatch):
    """And what is written then is verified, and merged with fewer trials of the same."""
    monkeypatch.setattr("swarmcensus.runs.pools.BUNDLE_SECONDS", 0.0001)
    monkeypatch.setattr(shards, "AT_LEAST", 0.0)
    monkeypatch.setattr(shards, "OF_ELAPSED", 0.0)
    out, half = f"{name}-cut.nc", known[name].attrs["trials_total"] // 3

    def stop(progress):
        if progress.done >= half:
            raise KeyboardInterrupt

    with pytest.raises(sc.Interrupted):
        run(study(name), 1, stop, out=out)
    begun = []
    again = run(study(name), 1, lambda progress: begun.append(progress.done), out=out)
    assert half <= begun[0] < known[name].attrs["trials_total"]
    assert same(again, known[name])
    found = sc.verify(out, 0.3, jobs=1)
    assert found.checked > 0
    assert found.differences == found.labels == []
    merged = sc.merge([sc.run(study(name, trials=2), jobs=2), sc.load(out)])
    for variable in known[name].data_vars:
        assert merged[variable].identical(known[name][variable]) or variable == "fingerprint"


@pytest.mark.long(but=QUICK)
@every
def test_in_shares(known, name):
    assert same(sc.merge([sc.run(study(name), jobs=1, share=(k, 3)) for k in (1, 2, 3)]), known[name])


@pytest.mark.long
def test_on_a_cluster(known):
    where = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0", "silence_logs": "CRITICAL"}
    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, **where)
    with cluster:
        for name in STUDIES:
            Path("far.toml").write_text(study(name).text)
            assert main(["run", "far.toml", "--cluster", cluster.scheduler_address, "--out", f"{name}-far.nc"]) == 0
            assert same(sc.load(f"{name}-far.nc"), known[name])


@pytest.mark.long
@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled")
@every
def test_in_cpython(name):
    """The last bit of what CPython computes is that of machine code; of one trial of few rounds."""
    moves = STUDIES[name][1]["topology"] == "moving"
    less = {"schedule": {"ticks": 22}} if moves else {"schedule": {"rounds": 6, "observations_per_round": [1, 31]}}
    less |= {"measure": {k: v for k, v in STUDIES[name][2].get("measure", {}).items() if k != "checkpoints"}}
    if name == "late and changing":
        less["schedule"] = {"rounds": 30}
    small = study(name, trials=1, **less).with_(swarm={"accuracy": 0.8} | STUDIES[name][0] | {"robots": 4})
    if name == "networks":
        small = small.with_(world=STUDIES[name][1] | {"fill_ratio": 0.55})
    file = Path(f"{name.replace(', ', '-')}.toml")
    file.write_text(small.text)
    command = [sys.executable, "-W", "ignore", "-c", IN_CPYTHON, str(file)]
    subprocess.run(command, check=True, timeout=500, env=os.environ | {"NUMBA_DISABLE_JIT": "1"})
    assert same(sc.load(f"{file.stem}-slow.nc"), sc.run(sc.Study.load(file), jobs=2))


@pytest.mark.parametrize("name", LOCAL[:1])
def test_local_estimates_do_not_depend_on_other_settings(known, name):
    """Settings that differ in their network alone share them: they are the same in a study that has but one."""
    swarm, world, more = STUDIES[name]
    for network in world["topology"][::2]:
        tables = {"schedule": more["schedule"], "measure": more["measure"], "name": name, "seed": 7}
        one = sc.run(sc.Study(trials=6, swarm=swarm, world=world | {"topology": network}, **tables), jobs=2)
        alike = known[name].sel(setting=known[name]["topology"] == network)
        for variable in ("local_convergence_step", "local_convergence_error", "final_estimate"):
            assert np.array_equal(one[variable].values, alike[variable].values, equal_nan=True)
