"""interval: how sure robots are, what of it is measured at checkpoints, and what is refused."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.simulation.trials import Metrics, run_batch
from tests.support.second import MEANS, WALD, brain, fixed
from tests.support.small import GO, SEED, changing

ALONE = {"name": "nobody", "edges": []}
TWO = ("coverage", "interval_width")


STUDY = """
name   = "sure"
seed   = 7
trials = 8
[swarm]
brain    = ["minimalistic", {file = "wald.py", z = [1.0, 1.96]}]
robots   = [3, 5]
accuracy = 0.9
[world]
topology   = ["ring", "moving"]
density    = 5
fill_ratio = 0.55
[schedule]
rounds = 12
ticks  = 30
[measure]
checkpoints = [5, 12, 30]
"""


def told(source, **tables):
    """The results of a study on a line of three robots that look once a round."""
    given = {
        "trials": 2, "seed": SEED, "swarm": {"brain": source, "robots": 3, "accuracy": 0.7},
        "schedule": {"rounds": 6, "observations_per_round": 1},
        "world": {"topology": "line", "fill_ratio": 0.8}, "measure": {"checkpoints": [2, 5, 6]},
    }  # fmt: skip
    return sc.run(sc.Study(**given | tables), jobs=1)


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("wald.py").write_text(WALD)
    Path("s.toml").write_text(STUDY)
    return tmp_path


@pytest.mark.interpreted
def test_by_hand():
    """Each robot says other numbers, by its name and its readings; the truth is 0.8, and ends belong to intervals."""
    lines = {
        2: [(0.1, 0.9), (0.8, 1.0), (0.2, 0.8)],
        5: [(0.1, 0.7), (0.81, 1.0), (0.75, 0.85)],
        6: [(0.0, 0.1), (0.8, 0.8), (0.9, 1.0)],
    }
    says = [
        f"    if me.t == {t}.0 and me.name == {i}.0:\n        return {low}, {high}\n"
        for t, row in lines.items()
        for i, (low, high) in enumerate(row)
    ]
    data = told(brain(f"{MEANS}\n\ndef interval(me):\n{''.join(says)}    return 0.0, 1.0\n"))
    assert data["coverage"].dims == data["interval_width"].dims == ("setting", "checkpoint", "trial")
    for trial in (0, 1):
        assert data["coverage"].values[0, :, trial].tolist() == [1.0, 1 / 3, 1 / 3]
        assert data["interval_width"].values[0, :, trial] == pytest.approx([1.6 / 3, 0.89 / 3, 0.2 / 3])


@pytest.mark.long(but=["7-0.9-1.0"])
@pytest.mark.parametrize(("looks", "f", "z"), [(20, 0.55, 1.96), (7, 0.9, 1.0)])
def test_coverage_and_width_of_lone_robots(looks, f, z):
    """Readings are binomial, and so the coverage and width exactly known: error rate 0.1 % of each of the two tests."""
    b, rounds, robots = 0.8, 3, 2000
    used = brain(WALD).with_parameters({"z": z})
    (setting,) = fixed(
        used, robots=robots, rounds=rounds, looks=looks, accuracy=b, fill_ratio=f, topology=ALONE
    )  # fmt: skip
    batch = run_batch(setting, SEED, 0, 5, Metrics(0.01, 10, (1, rounds)), GO)
    for c, made in enumerate((looks, looks * rounds)):
        ends = []
        for n in range(made + 1):
            me = used.robot(b, b)
            used.functions.observe(me, float(n), float(made))
            ends.append(used.functions.interval(me))
        low, high = np.array(ends).T
        law = stats.binom.pmf(np.arange(made + 1), made, b * f + (1 - b) * (1 - f))
        due = law @ ((low <= f) & (f <= high))
        found = batch.intervals[0, c]
        assert stats.binomtest(round(found.sum() * robots), found.size * robots, due).pvalue > 0.001
        width = law @ (high - low)
        spread = math.sqrt(law @ (high - low - width) ** 2 / (5 * robots))
        assert abs(batch.intervals[1, c].mean() - width) < stats.norm.isf(0.0005) * spread


WORLDS = {
    "a ring that changes": changing(world={"topology": "ring"}),
    "moving": changing(world={"topology": "moving", "density": 5}),
    "moving, on its own floor": changing(0.6, world={"topology": "moving", "density": 5, "body": {"tile": 0.2}}),
}


@pytest.mark.long(only=["moving-nominal-True", "moving-floor-False"])
@pytest.mark.parametrize(
    ("world", "truth", "steers"),
    [
        ("a ring that changes", "nominal", False),
        ("moving", "nominal", True),
        ("moving", "floor", False),
        pytest.param("moving, on its own floor", "floor", True, marks=pytest.mark.interpreted),
    ],
)
def test_held_against_the_truth_of_the_moment(world, truth, steers, here):
    """What replays show after the checkpoints' rounds, held against what they say that the truth was then."""
    Path("brain.py").write_text(WALD + "\n\ndef steer(me):\n    return 0.1, 0.3\n" * steers)
    looked = [1, 30, 50, 100]
    swarm = {"brain": "brain.py", "robots": 8, "accuracy": 0.9}
    study = WORLDS[world].with_(swarm=swarm, measure={"checkpoints": looked, "truth": truth})
    data = sc.run(study, jobs=1)
    held = []
    for trial in range(3):
        trace = sc.replay(data, 0, trial, brain_file="brain.py")
        low, high = (trace[name].values[looked] for name in ("interval_low", "interval_high"))
        due = study.settings()[0].fill_ratios(looked)
        if truth == "floor":
            own = trace["true_fill_ratio"].values[looked] if world == "moving" else trace.attrs["true_fill_ratio"]
            assert (own != due).any()
            due = np.broadcast_to(own, due.shape)
        held.append((low <= due[:, np.newaxis]) & (due[:, np.newaxis] <= high))
        assert data["coverage"].values[0, :, trial].tolist() == held[-1].mean(axis=1).tolist()
        assert data["interval_width"].values[0, :, trial] == pytest.approx((high - low).mean(axis=1), rel=1e-12)
    assert 0.0 < np.mean(held) < 1.0


@pytest.mark.long
def test_what_is_shown(here, capsys):
    study = sc.Study.load("s.toml")
    data = sc.run(study, jobs=1)
    sc.save(data, "r.nc")
    table = sc.summary(data)
    row, k = table.iloc[-1], -1
    assert row["coverage"] == pytest.approx(data["coverage"].values[k, -1].mean())
    assert row["interval_width"] == pytest.approx(np.median(data["interval_width"].values[k, -1]))
    assert row["coverage_low"] < row["coverage"] < row["coverage_high"] <= 1.0
    assert np.isnan(table["coverage"].values[(table["brain"] == "minimalistic").values]).all()
    capsys.readouterr()
    assert main(["show", "r.nc", "--sort", "coverage", "--where", "topology == 'ring'"]) == 0
    shown = capsys.readouterr().out
    lines = shown.splitlines()
    assert re.search(r"coverage %\s+\[95 %\]", lines[2])
    ours = (data["brain"] == "wald.py").values & (data["topology"] == "ring").values
    for k in np.flatnonzero(ours):
        assert f" {100 * data['coverage'].values[k, 1].mean():.1f}  [" in shown
    assert "coverage: robots whose interval holds f, interval width: their mean (median over trials)" in shown
    assert main(["show", "r.nc", "--json"]) == 0
    one = json.loads(capsys.readouterr().out)["settings"][-1]
    assert one["coverage"]["mean"] == row["coverage"]
    assert one["interval_width"]["median"] == row["interval_width"]
    assert main(["compare", "r.nc", "--metric", "interval_width"]) == 0
    assert "wald.py z=1 is best" in capsys.readouterr().out
    assert main(["compare", "r.nc", "--metric", "coverage"]) == 2
    plain = sc.run(study.with_(swarm={"brain": "minimalistic", "robots": 3, "accuracy": 0.9}), jobs=1)
    assert not {*TWO} & {*plain, *sc.summary(plain)}


def test_wrong_stops_use_the_done_estimate(here):
    """A robot is done where its interval is narrow; how many are then wrong by more than half of it, a trace knows."""
    half, f = 0.15, 0.8
    schedule = {"rounds": 90, "observations_per_round": 1}
    used = {"file": "wald.py", "enough": 2 * half}
    data = told(used, swarm={"brain": used, "robots": 30, "accuracy": 0.9}, schedule=schedule, measure={})
    wrong = (np.abs(data["done_estimate"] - f) > half).values[0]
    for trial in range(2):
        trace = sc.replay(data, 0, trial, brain_file="wald.py")
        width = (trace["interval_high"] - trace["interval_low"]).values
        ends = (width < 2 * half).argmax(axis=0)
        then = trace["estimate"].values[ends, np.arange(30)]
        assert (data["done_round"].values[0, trial] == ends).all()
        assert wrong[trial].tolist() == (np.abs(then - f) > half).tolist()
    assert 0 < wrong.sum() < 60


@pytest.mark.long(only=["ring"])
@pytest.mark.parametrize("world", [{"topology": "ring"}, {"topology": "moving", "density": 5}], ids=["ring", "moving"])
def test_interval_that_fails_in_a_replay_is_reported(world, here, capsys):
    """A replay asks before the first observation too, where no run does."""
    timid = "def interval(me):\n    half = 0.1 / me.t\n    return max(0.0, 0.5 - half), min(1.0, 0.5 + half)\n"
    Path("timid.py").write_text(f"{MEANS}\n\n{timid}")
    study = sc.Study(
        trials=1, swarm={"brain": "timid.py", "robots": 3, "accuracy": 0.7}, world=world | {"fill_ratio": 0.8},
        schedule={"ticks" if "density" in world else "rounds": 3}, measure={"checkpoints": [3]},
    )  # fmt: skip
    assert sc.run(study, jobs=1, out="timid.nc")["coverage"].notnull().all()
    assert main(["replay", "timid.nc", "--setting", "0", "--trial", "0"]) == 2
    said = capsys.readouterr().err
    assert f"brain 'timid.py' fails in trial 0 of {study.settings()[0]}: ZeroDivisionError: division by zero" in said
