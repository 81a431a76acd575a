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
    "name": "parts",
    "seed": 3,
    "trials": 4,
    "swarm": {"robots": [4, 6], "accuracy": ["U(0.6, 0.9)"]},
    "world": {"topology": ["ring", "full"], "fill_ratio": [0.55]},
    "schedule": {"rounds": 40},
    "measure": {"checkpoints": [10, 40]},
}
NUMBERS = ("convergence_round", "convergence_error", "final_estimate", "correct")


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
    assert merged.attrs["title"] == "parts"
    assert len(json.loads(merged.attrs["merged"])) == 3
    for source in (one, two, three):
        for k, mark in enumerate(source["fingerprint"].values):
            (row,) = np.flatnonzero(merged["fingerprint"].values == mark)
            trials, robots = source.sizes["trial"], int(source["robots"].values[k])
            for name in NUMBERS[:3]:
                found = merged[name].values[row, :trials, :robots]
                assert np.array_equal(found, source[name].values[k, :, :robots])
            for name in ("topology", "robots", "accuracy", "fill_ratio"):
                assert merged[name].values[row] == source[name].values[k]


def test_checkpoints_are_joined():
    merged = sc.merge([ran(robots_in_swarm=4), ran(robots_in_swarm=6, checkpoints_in_measure=[20, 40])])
    assert merged["checkpoint"].values.tolist() == [10, 20, 40]
    assert np.isnan(merged["correct"].values[:2, 1]).all()
    assert np.isfinite(merged["correct"].values[:2, [0, 2]]).all()
    assert np.isfinite(merged["correct"].values[2:, 1:]).all()


@pytest.mark.long
def test_merged_results_are_results(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, changes in (("a", {"robots_in_swarm": 6}), ("b", {"topology_in_world": ["line"]})):
        sc.save(ran(**changes), f"{name}.nc")
    assert main(["merge", "a.nc", "b.nc", "--out", "c.nc"]) == 0
    assert "c.nc: 4 settings, 16 of 16 trials" in capsys.readouterr().out
    merged = sc.load("c.nc")
    for k in range(4):
        trace = sc.replay(merged, k, 2)  # itself checks that the last round is what was stored
        assert trace.attrs["fill_ratio"] == 0.55
    assert main(["verify", "c.nc", "--all"]) == 0
    assert "16 of 16 trials run again: the same to the last bit" in capsys.readouterr().out
    assert main(["plot", "c.nc"]) == 0
    assert main(["export", "c.nc"]) == 0
    assert main(["merge", "c.nc", "a.nc", "--out", "d.nc"]) == 0
    assert sc.load("d.nc").drop_attrs().identical(merged.drop_attrs())
    whole = study(robots_in_swarm=[4, 6], topology_in_world=["ring", "full", "line"])
    (tmp_path / "whole.toml").write_text(whole.text)
    assert main(["run", "whole.toml", "--out", "c.nc"]) == 0
    assert sc.load("c.nc").drop_attrs().identical(sc.run(whole, jobs=2).drop_attrs())


def test_robots_that_move_and_images_merge(tmp_path):
    moving = {
        "trials": 2,
        "swarm": {"robots": 5, "accuracy": [0.7]},
        "world": {"topology": "moving", "density": 1, "fill_ratio": 0.55, "floor": ["tiles", {"clusters": 0.3}]},
        "schedule": {"ticks": 50},
    }
    one = sc.run(sc.Study(seed=3, **moving), jobs=2)
    moving["world"]["floor"] = ["half"]
    merged = sc.merge([one, sc.run(sc.Study(seed=3, **moving), jobs=2)])
    assert merged["floor"].values.tolist() == ["tiles", "clusters(0.3)", "half"]
    assert np.isfinite(merged["true_fill_ratio"].values).all()
    assert not sc.verify(merged, 1.0).differences


def test_overlaps_that_disagree_are_refused():
    one, two = ran(), ran()
    two["convergence_error"].values[2, 1, 0] += 1e-16 + np.spacing(two["convergence_error"].values[2, 1, 0])
    with pytest.raises(InputError, match=r"1 disagree: setting 2 of results 2, trial 1: convergence_error is 0"):
        sc.merge([one, two])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"seed": 4}, "seed is 4 and 3"),
        ({"delta_in_measure": 0.02}, "delta is 0.02 and 0.01"),
        ({"bins_in_measure": 5}, "bins is 5 and 10"),
    ],
)
def test_results_that_cannot_go_together(changes, said):
    with pytest.raises(InputError, match=said):
        sc.merge([ran(), ran(**changes)])


def test_two_brains_of_one_name_are_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shipped, compile_brain, results = study().swarm.brain[0], compiler.compile_brain, []
    monkeypatch.setattr(
        compiler, "compile_brain", lambda _, *how, **more: compile_brain(shipped, *how, **more)
    )  # the same
    for text in (shipped.source, shipped.source + "\n# another\n"):
        (tmp_path / "mine.py").write_text(text)
        results.append(ran(brain_in_swarm="mine.py", robots_in_swarm=5, topology_in_world="ring"))
    with pytest.raises(InputError, match=r"two different brains 'mine\.py'"):
        sc.merge(results)


def test_a_sample_is_run_again(small_file, tmp_path, capsys):
    assert main(["verify", str(small_file), "--sample", "0.1", "--seed", "5"]) == 0
    assert "13 of 128 trials run again (--seed 5): the same to the last bit" in capsys.readouterr().out
    found = sc.verify(small_file, 0.001, seed=1)
    assert (found.checked, found.stored, found.differences) == (1, 128, [])


@pytest.mark.long(but_every=2)
@pytest.mark.parametrize("name", NUMBERS)
def test_any_change_is_found(name, small_results, tmp_path, capsys):
    data = small_results.copy(deep=True)
    place = (9, 1, 2) if name == "correct" else (9, 2, 3)
    trial = 2
    values = data[name].values
    values[place] = values[place] + 1 if name == "convergence_round" else np.nextafter(values[place], 2)
    sc.save(data, tmp_path / "changed.nc")
    assert main(["verify", str(tmp_path / "changed.nc"), "--all"]) == 1
    said = capsys.readouterr().out
    value = int(values[place]) if name == "convergence_round" else values[place].item()
    assert f"setting 9, trial {trial}: {name} is {value!r} in the file and " in said
    assert "128 of 128 trials run again: 1 differ" in said


def test_local_estimates_are_verified():
    data = ran(local_in_measure=True)
    assert not sc.verify(data, 1.0).differences
    data["local_convergence_step"].values[1, 3, 0] += 1
    (found,) = sc.verify(data, 1.0).differences
    assert (found.setting, found.trial, found.variable) == (1, 3, "local_convergence_step")


def test_a_rule_is_verified():
    data = ran(trials={"until": "convergence_error median +- 0.01", "at_least": 6, "at_most": 20})
    found = sc.verify(data, 1.0)
    assert not found.differences
    assert found.stored == data.attrs["trials_done"]


@pytest.mark.long
def test_brains_of_ones_own_are_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    source = study().swarm.brain[0].source
    (tmp_path / "mine.py").write_text(source)
    sc.save(ran(brain_in_swarm="mine.py"), "a.nc")
    (tmp_path / "mine.py").write_text("raise SystemExit('was run')")
    assert main(["verify", "a.nc", "--all"]) == 2
    assert "are run only if they lie below" in capsys.readouterr().err
    (tmp_path / "copy.py").write_text(source)
    assert main(["verify", "a.nc", "--all", "--brain-file", "copy.py"]) == 0
    (tmp_path / "copy.py").write_text(source + "\n# other\n")
    assert main(["verify", "a.nc", "--all", "--brain-file", "copy.py"]) == 2
    assert "not the source that these results were made with" in capsys.readouterr().err


@pytest.mark.parametrize("sample", ["0", "-1", "2", "nan"])
def test_bad_samples(sample, small_file, capsys):
    assert main(["verify", str(small_file), "--sample", sample]) == 2
    assert f"swarmcensus: --sample {sample}: should be a share above 0" in capsys.readouterr().err


def test_metrics_of_only_some_merged_results():
    results = [
        ran(),
        ran(robots_in_swarm=4, checkpoints_in_measure=[5, 20]),
        ran(robots_in_swarm=6, local_in_measure=True, trials=2),
    ]
    merged = sc.merge(results)
    assert sc.verify(merged, 1.0, jobs=2).differences == []
    for name, where in (("correct", (0, 1, 3)), ("local_convergence_step", (1, 1, 0))):
        changed = merged.copy(deep=True)
        assert changed[name].values[where] not in (-1.0, np.nan)
        changed[name].values[where] += 1
        (found,) = sc.verify(changed, 1.0, jobs=2).differences
        assert (found.setting, found.variable) == (where[0], name)


@pytest.mark.long
def test_an_output_is_not_thrown_away(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, changes in (("a", {"robots_in_swarm": 6}), ("b", {"robots_in_swarm": 4}), ("c", {"trials": 5})):
        sc.save(ran(topology_in_world="ring", **changes), f"{name}.nc")
    assert main(["merge", "a.nc", "--out", "m.nc"]) == 0
    assert main(["merge", "a.nc", "b.nc", "--out", "m.nc"]) == 0  # holds all that was there
    assert sc.load("m.nc").attrs["trials_done"] == 8
    before = (tmp_path / "m.nc").read_bytes()
    assert main(["merge", "a.nc", "--out", "m.nc"]) == 2
    assert "m.nc is there, with 4 trials that are not in what is merged" in capsys.readouterr().err
    (tmp_path / "n.nc").write_text("my notes")
    assert main(["merge", "a.nc", "--out", "n.nc"]) == 2
    assert "it is in the way" in capsys.readouterr().err
    assert (tmp_path / "m.nc").read_bytes() == before
    assert (tmp_path / "n.nc").read_text() == "my notes"
    with hold_output(tmp_path / "m.nc", study(), [], [], False, print):
        assert main(["merge", "c.nc", "--out", "m.nc"]) == 2
    assert "another run" in capsys.readouterr().err
    assert main(["merge", "a.nc", "--out", "m.nc", "--fresh"]) == 0
    assert sc.load("m.nc").attrs["trials_done"] == 4
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.nc", "b.nc", "c.nc", "m.nc", "n.nc"]


def test_time_is_counted_once_where_results_overlap():
    one, two = ran(robots_in_swarm=4), ran(robots_in_swarm=6)
    one.attrs["wall_seconds"], two.attrs["wall_seconds"] = 10.0, 20.0
    both = sc.merge([one, two])
    assert both.attrs["wall_seconds"] == 30.0
    assert sc.merge([both, one, two]).attrs["wall_seconds"] == 30.0
    assert sc.merge([one, both]).attrs["wall_seconds"] == 25.0  # by trials: those of `both` took 3.75 each


def test_totals_of_what_is_merged():
    rule = {"until": "convergence_error median +- 0.02", "at_least": 6, "at_most": 40}
    one, two = ran(trials=rule, robots_in_swarm=4), ran(robots_in_swarm=6, trials=3)
    merged = sc.merge([one, two])
    assert merged.attrs["trials_total"] == merged.attrs["trials_done"] == one.attrs["trials_done"] + 6
    assert not sc.verify(merged, 1.0).labels


def test_studies_with_members_and_without_go_together():
    """What one of them does not speak of is empty there, and all of its robots are honest."""
    swarm = {"robots": 6, "accuracy": 0.8}
    told = {"trials": 2, "swarm": swarm, "world": {"topology": "ring", "fill_ratio": 0.3}, "schedule": {"rounds": 10}}
    plain = sc.run(sc.Study(**told))
    mixed = sc.run(sc.Study(**told, members=[{"robots": 2, "accuracy": 0.6, "honest": False}]))
    for parts in ([plain, mixed], [mixed, plain]):
        both = sc.merge(parts)
        assert sorted(zip(both["members"].values, both["honest"].values, strict=True)) == [
            ("", 6), ("2 accuracy 0.6, not honest", 4)
        ]  # fmt: skip
        for k, one in enumerate(parts):
            found = both["final_estimate"].values[k, :, : one.sizes["robot"]]
            assert (found == one["final_estimate"].values[0]).all()


def test_metrics_of_the_second_study_are_verified():
    """Both hold the same settings and trials: of these all that either measured is run again."""
    more = {"checkpoints": [10, 40], "estimates": True, "metrics": ["mean-error"]}
    merged = sc.merge([ran(), ran(measure=more)])
    found = sc.verify(merged, 1.0)
    assert (found.differences, found.labels) == ([], [])
    for name in ("estimates", "mean_error"):
        changed = merged.copy(deep=True)
        place = tuple(np.argwhere(np.isfinite(changed[name].values))[-1])
        changed[name].values[place] = 0.125
        (difference,) = sc.verify(changed, 1.0).differences
        assert (difference.variable, difference.stored) == (name, 0.125)
