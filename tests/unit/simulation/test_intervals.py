"""interval: how sure robots are over trials; tests/reference compares what is measured of it."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.simulation.trials import Metrics, run_batch
from tests.support.second import MEANS, WALD, brain, fixed
from tests.support.small import GO, SEED, study_of

ALONE = {"name": "nobody", "edges": []}


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


@pytest.mark.long(only=["ring"])
@pytest.mark.parametrize("world", [{"rounds": 3}, {"ticks": 3, "density": 1}], ids=["ring", "moving"])
def test_interval_that_fails_in_a_replay_is_reported(world, here, capsys):
    timid = "def interval(me):\n    half = 0.1 / me.t\n    return max(0.0, 0.5 - half), min(1.0, 0.5 + half)\n"
    Path("timid.py").write_text(f"{MEANS}\n\n{timid}")
    study = study_of("timid.py", robots=3, trials=1, measure={"checkpoints": [3]}, **world)
    assert sc.run(study, jobs=1, out="timid.nc")["coverage"].notnull().all()
    assert main(["replay", "timid.nc", "--setting", "0", "--trial", "0"]) == 2
    said = capsys.readouterr().err
    assert f"brain 'timid.py' fails in trial 0 of {study.settings()[0]}: ZeroDivisionError: division by zero" in said
