"""Rules that add trials until an interval is narrow enough."""

import re

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.runs.running import run
from swarmcensus.studies.precision import Until, look_level
from swarmcensus.support import intervals
from swarmcensus.support.errors import InputError

WORLD = {"topology": ["ring", "full"], "fill_ratio": [0.55]}
MORE = {"schedule": {"rounds": 50}, "measure": {"checkpoints": [10, 20, 50]}}


def study(rule):
    trials = {"until": rule, "at_least": 8, "at_most": 200}
    return sc.Study(trials=trials, seed=5, swarm={"robots": 10, "accuracy": [0.7, 0.95]}, world=WORLD, **MORE)


def needed(data):
    return (data["convergence_round"].values[:, :, 0] >= 0).sum(axis=1)


@pytest.mark.parametrize(("rule", "variable"), [
    ("convergence_error median +- 0.003", "convergence_error"), ("convergence_round mean ± 2", "convergence_round"),
    ("final_estimate mean +- 4e-3", "final_estimate"), ("correct@20 mean +- 0.03", "correct"),
])  # fmt: skip
def test_each_setting_gets_what_it_needs(rule, variable):
    asked = study(rule)
    data = sc.run(asked, jobs=2)
    stages = list(asked.until.stages())
    width = float(rule.split()[-1])
    assert set(needed(data)) <= set(stages)
    assert len(set(needed(data))) > 1
    for k, trials in enumerate(needed(data)):
        values = data[variable].values[k]
        values = values[1, :, np.newaxis] if variable == "correct" else values
        for stage in [s for s in stages if s <= trials]:
            seen = (values[:stage].astype(float), rule.split()[1], variable == "correct", look_level(stage))
            _, low, high = intervals.estimate(*seen)
            # it stops at the first look at which the interval is narrow enough, and at no other
            assert ((high - low) / 2 <= width) == (stage == trials and trials < stages[-1]) or stage == stages[-1]
        assert data["half_width"].values[k] == pytest.approx((high - low) / 2, rel=1e-12)
        assert data["half_width"].values[k] <= width or trials == 200


def test_the_trials_are_those_of_a_plain_study():
    data = sc.run(study("convergence_error median +- 0.004"), jobs=2)
    plain = sc.run(study("convergence_error median +- 0.004").with_(trials=data.sizes["trial"]), jobs=2)
    for k, trials in enumerate(needed(data)):
        assert np.array_equal(data["final_estimate"].values[k, :trials], plain["final_estimate"].values[k, :trials])


def test_it_does_not_depend_on_threads_or_on_being_cut_off(tmp_path, monkeypatch):
    monkeypatch.setattr("swarmcensus.runs.pools.BUNDLE_SECONDS", 0.001)
    asked = study("convergence_error median +- 0.003")
    one, two = sc.run(asked, jobs=1), sc.run(asked, jobs=2)

    def stop(progress):
        if progress.total < 100 and progress.done == progress.total:
            raise KeyboardInterrupt

    with pytest.raises(sc.Interrupted):
        run(asked, 2, stop, out=tmp_path / "a.nc")
    found = []
    three = run(asked, 2, out=tmp_path / "a.nc", say=found.append)
    assert "found" in found[0]
    for other in (two, three):
        assert one.drop_attrs().identical(other.drop_attrs())
    assert one.attrs["trials_total"] == one.attrs["trials_done"] == needed(one).sum()


def test_a_smaller_width_goes_on_from_the_larger(tmp_path):
    wide = run(study("convergence_error median +- 0.004"), 2, out=tmp_path / "a.nc")
    narrow = run(study("convergence_error median +- 0.002"), 2, out=tmp_path / "a.nc")
    assert (needed(narrow) >= needed(wide)).all()
    assert narrow.drop_attrs().identical(sc.run(study("convergence_error median +- 0.002"), jobs=2).drop_attrs())


def test_thirty_equal_trials_do_not_say_that_all_are_equal():
    """The interval of 30 trials that are all right, or all alike, has a width: up to one in ten may be otherwise."""
    right = Until(until="correct@10 mean +- 0.02")
    assert right.half_width(np.ones((30, 1))) > 0.05
    assert right.holds(right.half_width(np.ones((200, 1))))
    for rule in ("convergence_round median +- 0.01", "convergence_error mean +- 0.01"):
        alike = Until(until=rule)
        for value in (0.0, 0.1, 17.0):
            assert alike.half_width(np.full((30, 20), value)) > 0.05
    wide, missing = Until(until="final_estimate mean +- 1e9"), np.ones((8, 1))
    missing[3] = np.nan
    assert not wide.holds(wide.half_width(missing))


def test_a_look_errs_the_less_often_the_fewer_trials_it_is_at():
    levels = [look_level(trials) for trials in (6, 10, 30, 100, 1000)]
    assert levels == sorted(levels, reverse=True)
    assert levels[2:] == pytest.approx([0.97, 0.958, 0.951], abs=5e-4)  # as docs/comparing.md says
    values = np.random.default_rng(3).normal(size=(30, 4))
    _, low, high = intervals.estimate(values, "mean")
    assert Until(until="final_estimate mean +- 1").half_width(values) > (high - low) / 2


@pytest.mark.parametrize(("trials", "said"), [
    ({"until": "speed median +- 1"}, "should be such as"),
    ({"until": "correct mean +- 0.1"}, "should be such as"),
    ({"until": "convergence_error@10 mean +- 0.1"}, "should be such as"),
    ({"until": "convergence_error mean +- 0"}, "should be such as"),
    ({"until": "correct@11 mean +- 0.1"}, "11 is no checkpoint"),
    ({"until": "final_estimate mean +- 1", "at_least": 3}, "trials.at_least = 3"),
    ({"until": "final_estimate mean +- 1", "at_least": 30, "at_most": 20}, "at_most = 20 is less than"),
    ({"until": "final_estimate mean +- 1", "at_last": 30}, "did you mean 'at_least'"),
    ({"at_least": 30}, "trials.until is missing"),
])  # fmt: skip
def test_bad_rules(trials, said):
    with pytest.raises(InputError, match=re.escape(said)):
        sc.Study(trials=trials, swarm={"robots": 3, "accuracy": 0.7}, world=WORLD, **MORE)


def test_the_report_lists_what_each_setting_needed(here, accepted):
    (here / "s.toml").write_text(study("convergence_error median +- 0.003").text)
    shown = accepted("run", "s.toml").out
    rows = {words[0]: words[-2] for line in shown.splitlines() if (words := line.split())}
    assert [int(rows[str(k)]) for k in range(4)] == needed(sc.load("s.nc")).tolist()
    assert "4 settings of up to 200 trials" in shown


def test_checkpoint_of_a_rule_is_recorded_and_reached():
    def checkpoints(k, rounds):
        trials, swarm = {"until": f"correct@{k} mean +- 0.2"}, {"robots": 3, "accuracy": 0.7}
        return sc.Study(trials=trials, swarm=swarm, world=WORLD, schedule={"rounds": rounds}).checkpoints

    assert 17 in checkpoints(17, 50)
    with pytest.raises(InputError, match=r"correct@40 .*: that comes after the last round of settings of 20 rounds"):
        checkpoints(40, [20, 40])
