"""Results put together, and results run again."""

import json

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.engine import compiler
from swarmcensus.runs.resuming import hold_output
from swarmcensus.support.errors import InputError

TABLES = {
    "name": "parts", "seed": 3, "trials": 4, "swarm": {"robots": [4, 6], "accuracy": ["U(0.6, 0.9)"]},
    "world": {"topology": ["ring", "full"], "fill_ratio": [0.55]}, "schedule": {"rounds": 40},
    "measure": {"checkpoints": [10, 40]},
}  # fmt: skip


def study(**changes):
    tables = {k: dict(v) if isinstance(v, dict) else v for k, v in TABLES.items()}
    for key, value in changes.items():
        table, _, name = key.partition("_in_")
        if name:
            tables[name][table] = value
        else:
            tables[key] = value
    return sc.Study(**tables)


def ran(**changes):
    return sc.run(study(**changes), jobs=2)


def test_settings_and_trials_that_differ():
    one = ran(robots_in_swarm=4, trials=6)
    two = ran(robots_in_swarm=6, topology_in_world="ring")
    three = ran(robots_in_swarm=[6, 4], topology_in_world=["full", "ring"])
    merged = sc.merge([one, two, three])
    assert merged.sizes == {"setting": 4, "trial": 6, "robot": 6, "checkpoint": 2}
    assert merged.attrs["trials_done"] == 6 + 6 + 4 + 4
    assert (merged.attrs["title"], len(json.loads(merged.attrs["merged"]))) == ("parts", 3)
    for source in (one, two, three):
        for k, mark in enumerate(source["fingerprint"].values):
            (row,) = np.flatnonzero(merged["fingerprint"].values == mark)
            trials, robots = source.sizes["trial"], int(source["robots"].values[k])
            for name in ("convergence_round", "convergence_error", "final_estimate"):
                found = merged[name].values[row, :trials, :robots]
                assert np.array_equal(found, source[name].values[k, :, :robots])
            for name in ("topology", "robots", "accuracy", "fill_ratio"):
                assert merged[name].values[row] == source[name].values[k]
    for k, robots in enumerate(merged["robots"].values):
        last = sc.replay(merged, k, 3)["estimate"].values[-1]
        assert np.array_equal(last, merged["final_estimate"].values[k, 3, :robots])


def test_overlaps_that_disagree_are_refused():
    one, two = ran(), ran()
    two["convergence_error"].values[2, 1, 0] += 1e-16 + np.spacing(two["convergence_error"].values[2, 1, 0])
    with pytest.raises(InputError, match=r"1 disagree: setting 2 of results 2, trial 1: convergence_error is 0"):
        sc.merge([one, two])


def test_results_that_cannot_go_together():
    for changes, said in (({"seed": 4}, "seed is 4 and 3"), ({"bins_in_measure": 5}, "bins is 5 and 10")):
        with pytest.raises(InputError, match=said):
            sc.merge([ran(), ran(**changes)])


def test_two_brains_of_one_name_are_refused(here, monkeypatch):
    shipped, compile_brain, results = study().swarm.brain[0], compiler.compile_brain, []
    monkeypatch.setattr(compiler, "compile_brain", lambda _, *how, **more: compile_brain(shipped, *how, **more))
    for text in (shipped.source, shipped.source + "\n# another\n"):
        (here / "mine.py").write_text(text)
        results.append(ran(brain_in_swarm="mine.py", robots_in_swarm=5, topology_in_world="ring"))
    with pytest.raises(InputError, match=r"two different brains 'mine\.py'"):
        sc.merge(results)


def test_a_sample_is_run_again(small_file, accepted):
    said = accepted("verify", small_file, "--sample", "0.1", "--seed", "5").out
    assert "13 of 128 trials run again (--seed 5): the same to the last bit" in said
    found = sc.verify(small_file, 0.001, seed=1)
    assert (found.checked, found.stored, found.differences) == (1, 128, [])


def test_a_change_is_named(small_results, tmp_path, capsys):
    data = small_results.copy(deep=True)
    values = data["convergence_error"].values
    values[9, 2, 3] = np.nextafter(values[9, 2, 3], 2)
    sc.save(data, tmp_path / "changed.nc")
    assert main(["verify", str(tmp_path / "changed.nc"), "--all"]) == 1
    said = capsys.readouterr().out
    assert f"setting 9, trial 2: convergence_error is {values[9, 2, 3].item()!r} in the file and " in said
    assert "128 of 128 trials run again: 1 differ" in said


@pytest.mark.parametrize("sample", ["0", "-1", "2", "nan"])
def test_bad_samples(sample, small_file, refused):
    right = "should be a number" if sample == "nan" else "should be a share above 0"
    assert f"--sample {sample}: {right}" in refused("verify", small_file, "--sample", sample)


@pytest.mark.long
def test_an_output_is_not_thrown_away(here, refused):
    for name, changes in (("a", {"robots_in_swarm": 6}), ("b", {"robots_in_swarm": 4}), ("c", {"trials": 5})):
        sc.save(ran(topology_in_world="ring", **changes), f"{name}.nc")
    assert main(["merge", "a.nc", "--out", "m.nc"]) == 0
    (here / "n.nc").write_text("my notes")
    for name in ("m.nc", "n.nc"):
        says = f"{name} is there: write elsewhere with --out, or replace it with --fresh"
        assert says in refused("merge", "a.nc", "b.nc", "--out", name)
    with hold_output(here / "m.nc", study(), [], [], False, print):
        assert "another run" in refused("merge", "c.nc", "--out", "m.nc")
    assert main(["merge", "a.nc", "b.nc", "--out", "m.nc", "--fresh"]) == 0
    assert sc.load("m.nc").attrs["trials_done"] == 8
    assert sorted(p.name for p in here.iterdir()) == ["a.nc", "b.nc", "c.nc", "m.nc", "n.nc"]


def test_time_is_counted_once_where_results_overlap():
    one, two = ran(robots_in_swarm=4), ran(robots_in_swarm=6)
    one.attrs["wall_seconds"], two.attrs["wall_seconds"] = 10.0, 20.0
    both = sc.merge([one, two])
    assert both.attrs["wall_seconds"] == sc.merge([both, one, two]).attrs["wall_seconds"] == 30.0
    assert sc.merge([one, both]).attrs["wall_seconds"] == 25.0  # by trials: those of `both` took 3.75 each


def test_totals_of_what_is_merged():
    rule = {"until": "convergence_error median +- 0.02", "at_least": 6, "at_most": 40}
    one, two = ran(trials=rule, robots_in_swarm=4), ran(robots_in_swarm=6, trials=3)
    merged = sc.merge([one, two])
    assert merged.attrs["trials_total"] == merged.attrs["trials_done"] == one.attrs["trials_done"] + 6
    assert not sc.verify(merged, 1.0).labels


def test_what_only_some_of_merged_results_have_is_verified():
    more = {"checkpoints": [10, 40], "estimates": True, "metrics": ["mean-error"]}
    early = ran(robots_in_swarm=4, checkpoints_in_measure=[5, 20])
    merged = sc.merge([ran(), early, ran(robots_in_swarm=6, local_in_measure=True, trials=2), ran(measure=more)])
    found = sc.verify(merged, 1.0, jobs=2)
    assert (found.differences, found.labels) == ([], [])
    for name in ("correct", "local_convergence_step", "estimates", "mean_error"):
        changed = merged.copy(deep=True)
        place = tuple(np.argwhere(np.isfinite(changed[name].values) & (changed[name].values != -1))[-1])
        changed[name].values[place] += 1
        (difference,) = sc.verify(changed, 1.0, jobs=2).differences
        assert (difference.setting, difference.variable) == (place[0], name)
