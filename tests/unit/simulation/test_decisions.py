"""decide and done: what robots decide and when, what all agree on, and who has seen enough."""

from types import SimpleNamespace

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.analysis.comparing import cells
from swarmcensus.checks import suite
from swarmcensus.checks.contract_checks import PROMISES
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.swarming import right_option
from swarmcensus.simulation.trials import Metrics, run_batch
from swarmcensus.support.errors import InputError
from tests.support.places import EXAMPLE
from tests.support.second import MEANS, brain, changed, fixed, moving
from tests.support.small import GO, SEED, study_of
from tests.support.trials import record_trial

SPRT = brains.load(EXAMPLE / "sprt.py")
MEASURE = Metrics(0.01, 10, ())
DECIDES = MEANS + "\n\ndef decide(me):\n    return CHOICE\n"
OPTIONS = ("MEMORY =", "OPTIONS = 4\nMEMORY =")
ENDS = MEANS + "\n\ndef done(me):\n    return me.t >= 3.0\n"


def told(source, **world):
    """What a study on a line of robots that look once a round has in its results, of trial 0."""
    study = study_of(
        brain(source), robots=3, accuracy=0.7, rounds=6, looks=1, trials=2,
        **{"topology": "line", "fill_ratio": 0.8} | world,
    )  # fmt: skip
    return sc.run(study, jobs=1).isel(setting=0, trial=0)


@pytest.mark.parametrize("options", [2, 3, 7, 10, 100])
def test_the_right_option_is_the_bin_of_the_truth(options):
    """Bins are closed below, and the last one above; between white and black there is none at 0.5."""
    for k in range(options):
        low = k / options
        assert right_option(np.nextafter((k + 1) / options, 0.0), options) == k
        assert np.isnan(right_option(low, options)) if (options, k) == (2, 1) else right_option(low, options) == k
    assert right_option(1.0, options) == options - 1


@pytest.mark.interpreted
def test_what_nobody_decides_is_not_in_the_results():
    assert "decision" not in told(MEANS)
    assert "done_round" not in told(MEANS)
    only = told(ENDS)
    assert "consensus" not in only
    assert "done_estimate" in only


@pytest.mark.long
@pytest.mark.parametrize("wrong", [0.01, 0.05])
def test_error_rate_of_the_sequential_test(wrong):
    """600 robots alone: Wald's bound on the share of wrong decisions, and four standard errors; error rate 0.01 %."""
    lonely = {"name": "nobody", "edges": []}
    (setting,) = fixed(
        SPRT.with_parameters({"wrong": wrong, "margin": 0.1}), robots=600, rounds=400, accuracy=0.8, looks=5,
        fill_ratio=0.6, topology=lonely,
    )  # fmt: skip
    verdicts = run_batch(setting, SEED, 0, 1, MEASURE, GO).verdicts[0]
    decided = verdicts[:, 0]
    assert (decided >= 0).mean() > 0.99
    assert (decided == 0).mean() < wrong + 4 * np.sqrt(wrong / 600)
    assert (verdicts[:, 3] == verdicts[:, 1]).all()
    assert (decided == 0).any() or wrong < 0.02


WRONG = {
    "me.t * 0 + 2": "2", "me.t * 0 - 2": "-2", "0.5 + 0 * me.t": "0.5", "me.t * 1e300 * 1e300": "inf",
    "math.inf - math.inf * me.t": "nan",
}  # fmt: skip


@pytest.mark.interpreted
@pytest.mark.parametrize("choice", WRONG)
def test_what_is_no_option_is_refused(choice):
    source = changed(("MEMORY =", "import math\n\nMEMORY ="), source=DECIDES.replace("CHOICE", choice))
    said = rf"brain 'brain.py' fails in trial 1 of .*: decide gives {WRONG[choice]}: -1 \(undecided\) or an opt"
    (setting,) = fixed(brain(source))
    with pytest.raises(InputError, match=said):
        run_batch(setting, SEED, 1, 1, MEASURE, GO)
    with pytest.raises(InputError, match=said):
        run_ride([moving(brain(source))], SEED, 1, MEASURE, GO)
    fault = suite.fault_of(PROMISES["decides for an option, or not yet"], brain(source))
    assert fault
    assert f"gives {float(WRONG[choice]):g}" in fault or f"gives {WRONG[choice]}" in fault


@pytest.mark.filterwarnings("error")
def test_an_infinite_interval_has_no_width():
    """Of an agreement that never comes: nothing is subtracted from infinity, and the others have their digits."""
    measure = SimpleNamespace(share=False, unit="rounds")
    values, low, high = np.array([np.inf, 50.0]), np.array([np.inf, 40.0]), np.array([np.inf, 60.0])
    told = cells.numbers((values, low, high), np.array([5, 5]), measure)
    assert told[0][0] == "never"
    assert told[1] == ("50", "[40, 60]")


@pytest.mark.long
def test_nobody_is_asked_to_decide_before_the_first_round():
    """A brain that divides by what it has seen need not ask whether it has seen anything."""
    source = MEANS + "\n\ndef decide(me):\n    return 1 if me.n / me.t > 0.5 else 0\n"
    assert (told(source + "\n\ndef done(me):\n    return me.t > 3.0\n")["decision_round"] == 1).all()
    (setting,) = fixed(brain(source))
    fields, _, _ = record_trial(setting, SEED, 0)
    assert (fields["decided"][0] == -1).all()
    assert (fields["decided"][1:] >= 0).all()
    readings = np.ones((3, 2))
    for compiled in (True, False):
        trace = sc.infer(readings, None, 0.8, 1, brain(source), compiled=compiled)
        assert trace["decided"].values.tolist() == [[-1, -1], *[[1, 1]] * 3]
