"""interval: how sure robots are over trials; tests/reference compares what is measured of it."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus.brains.packing import Numbers
from swarmcensus.checks import suite
from swarmcensus.checks.contract_checks import PROMISES
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import Metrics, run_batch
from swarmcensus.support.errors import InputError
from tests.support.second import MEANS, SAYS, WALD, brain, fixed, moving
from tests.support.small import GO, SEED, study_of

ALONE = {"name": "nobody", "edges": []}


@pytest.mark.long(but=["7-0.9-1.0"])
@pytest.mark.parametrize(("looks", "f", "z"), [(20, 0.55, 1.96), (7, 0.9, 1.0)])
def test_coverage_and_width_of_lone_robots(looks, f, z):
    """Readings are binomial, and so the coverage and width exactly known: error rate 0.1 % of each of the two tests."""
    b, rounds, robots = 0.8, 3, 2000
    used = brain(WALD).with_parameters({"z": z})
    (setting,) = fixed(used, robots=robots, rounds=rounds, looks=looks, accuracy=b, fill_ratio=f, topology=ALONE)
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
def test_interval_that_fails_in_a_replay_is_reported(world, here, refused):
    timid = "def interval(me):\n    half = 0.1 / me.t\n    return max(0.0, 0.5 - half), min(1.0, 0.5 + half)\n"
    Path("timid.py").write_text(f"{MEANS}\n\n{timid}")
    study = study_of("timid.py", robots=3, trials=1, measure={"checkpoints": [3]}, **world)
    assert sc.run(study, jobs=1, out="timid.nc")["coverage"].notnull().all()
    said = refused("replay", "timid.nc", "--setting", "0", "--trial", "0")
    assert f"brain 'timid.py' fails in trial 0 of {study.settings()[0]}: ZeroDivisionError: division by zero" in said


# ---- answers that are refused: of `interval` before anything runs, by the suite and where robots are asked; estimates
@pytest.mark.parametrize(("given", "shown"), [
    ({"low": 0.75, "high": 0.25}, r"\(0.75, 0.25\)"),
    ({"low": -0.5, "high": 0.25}, r"\(-0.5, 0.25\)"),
    ({"low": 0.5, "high": 1.5}, r"\(0.5, 1.5\)"),
    ({"low": 0.5, "big": 1e200}, r"\(nan, 1\)"),
], ids=["the wrong way round", "below 0", "above 1", "no number"])  # fmt: skip
def test_what_is_no_interval_is_refused(given, shown):
    used = brain(SAYS).with_parameters(given | {"since": 3.0})
    right = r"two numbers, 0 <= low <= high <= 1, are right, or \(0.0, 1.0\) if nothing is known"
    said = f"brain 'brain.py' fails in trial 1 of .*, after {{}}: interval gives {shown}: {right}$"
    (setting,) = fixed(used)
    with pytest.raises(InputError, match=said.format("round 3")):
        run_batch(setting, SEED, 1, 1, Metrics(0.01, 10, (2, 3, 8)), GO)
    run_batch(setting, SEED, 1, 1, Metrics(0.01, 10, (2,)), GO)  # nobody asks
    with pytest.raises(InputError, match=said.format("tick 25")):
        run_ride([moving(used)], SEED, 1, Metrics(0.01, 10, (2, 25)), GO)
    fault = suite.fault_of(PROMISES["tells an interval within [0, 1], the low end first"], used)
    assert fault
    assert "interval (line 29) gives (" in fault
    assert right.replace("\\", "") in fault


ADDS = MEANS.replace("MEMORY", 'PARAMETERS = {"add": 0.0, "big": 0.0}\nMEMORY', 1).replace(
    "return me.n / me.t if me.t > 0.0 else 0.5",
    "return 0.5 + me.add + me.big * me.big - me.big * me.big if me.t >= 3.0 else 0.5",
)


@pytest.mark.interpreted
@pytest.mark.parametrize(("given", "shown"), [
    ({"add": 1.0}, "1.5"), ({"add": -5.5}, "-5"), ({"big": 1e200}, "nan"), ({"add": 1e-5 + 0.5}, "1.00001"),
], ids=str)  # fmt: skip
def test_estimate_outside_0_to_1_fails_its_trial(given, shown):
    used = brain(ADDS).with_parameters(given)
    said = rf"^brain 'brain.py' fails in trial 1 of .*: robot {{}}: estimate gives {shown}: a number in \[0, 1\] is"
    metrics = Metrics(0.01, 10, (2,))
    for one in (used, *([] if "big" in given else [used.with_numbers(Numbers("single"))])):
        with pytest.raises(InputError, match=said.format("0, after round 3")):
            run_batch(fixed(one)[0], SEED, 1, 2, metrics, GO)
    with pytest.raises(InputError, match=said.format("0, after observation 3")):
        run_batch(fixed(used)[0], SEED, 1, 1, metrics, GO, True)
    with pytest.raises(InputError, match=said.format(r"\d, after tick \d+")):
        run_ride([moving(used)], SEED, 1, metrics, GO)
    steers = brain(ADDS + "\n\ndef steer(me):\n    return 0.1, 0.0\n").with_parameters(given)
    with pytest.raises(InputError, match="estimate gives"):
        run_ride([moving(steers)], SEED, 1, metrics, GO)
    run_batch(fixed(brain(ADDS).with_parameters({"add": 0.5 + 1e-9}))[0], SEED, 1, 1, metrics, GO)  # rounding
    liars = [{"robots": 2, "honest": False, "brain": used}]
    assert run_batch(fixed(brain(MEANS, "means.py"), liars)[0], SEED, 1, 1, metrics, GO)


@pytest.mark.interpreted
def test_a_replay_shows_a_wrong_estimate_and_warns_of_it():
    used = brain(ADDS).with_parameters({"add": 1.0})
    with pytest.warns(UserWarning, match=r"robot 0, after round 3: estimate gives 1.5: a number in \[0, 1\] is right"):
        trace = sc.infer(np.ones((4, 2)), None, 0.8, 1, used)
    assert trace["estimate"].values[:, 0].tolist() == [0.5, 0.5, 0.5, 1.5, 1.5]
