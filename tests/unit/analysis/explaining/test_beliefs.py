"""What wrong beliefs cost: the closed form against the likelihood and the simulation, and the figure of both."""

import re

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import swarmcensus as sc
from swarmcensus.analysis.explaining.wrong_beliefs import EQ_4, costs
from swarmcensus.support.errors import InputError
from swarmcensus.theory import asymptote

STUDY = """
seed = 5
trials = 12
[swarm]
robots = 20
accuracy = [0.675, {black = 0.9, white = 0.7}]
assumed_accuracy = [{error = -0.05}, {error = 0}, {error = 0.05}, {error = "N(0, 0.05)"}]
[world]
topology = ["ring", "moving"]
density = 10
fill_ratio = [0.55, 0.95]
[schedule]
rounds = 400
ticks = 2000
"""


# ---- the closed form


@pytest.mark.parametrize("seed", range(5))
def test_asymptote_maximises_the_expected_likelihood(seed):
    rng = np.random.default_rng(seed)
    for _ in range(40):
        b, w, assumed_b, assumed_w, f = rng.uniform(0.02, 0.98, 5)
        if abs(assumed_b + assumed_w - 1) < 0.02:
            continue
        p = b * f + (1 - w) * (1 - f)

        def loss(x, p=p, b=assumed_b, w=assumed_w):
            black = b * x + (1 - w) * (1 - x)
            return -(p * np.log(black) + (1 - p) * np.log(1 - black))

        found = minimize_scalar(loss, bounds=(0, 1), method="bounded", options={"xatol": 1e-9}).x
        assert asymptote(b, w, assumed_b, assumed_w, f) == pytest.approx(found, abs=1e-4)


def test_asymptote_of_expected_readings():
    """A hundred readings, of which the very share that is expected says black, in the brain itself."""
    cases = [(0.8, 0.6, 0.7, 0.75, 0.5), (0.7, 0.7, 0.6, 0.6, 0.9), (0.9, 0.9, 0.3, 0.3, 0.4)]
    for b, w, assumed_b, assumed_w, f in cases:
        black = round(100 * (b * f + (1 - w) * (1 - f)))
        readings = (np.arange(100) < black).astype(float)[:, np.newaxis]
        for brain in sorted(EQ_4):
            assumed = {"black": assumed_b, "white": assumed_w}
            trace = sc.infer(readings, None, assumed, brain=brain, observations_per_round=100)
            predicted = float(asymptote(b, w, assumed_b, assumed_w, f))
            assert trace["estimate"].values[-1, 0] == pytest.approx(predicted, abs=1e-12)


# ---- the simulation


@pytest.mark.long(but=["full"])
@pytest.mark.parametrize("topology", ["full", '"moving"\ndensity = 10'])
def test_swarms_go_where_the_closed_form_says(topology):
    """The mean final estimate, within 4.5 standard errors over trials: 12 settings fail together once in 10^4.

    Only where nothing is cut is the estimate's mean its limit. The estimator's own bias is of the order of
    1 / observations and is allowed for by 5e-4.
    """
    world = topology if "\n" in topology else f'"{topology}"'
    text = STUDY.replace('["ring", "moving"]\ndensity = 10', world).replace("trials = 12", "trials = 40")
    text = text.replace("rounds = 400\n" if "moving" in topology else "ticks = 2000\n", "")
    text = text.replace('{error = 0}, {error = 0.05}, {error = "N(0, 0.05)"}', "{error = 0}, {error = 0.05}")
    data = sc.run(sc.Study.parse(text.replace("0.95]", "0.4]")), jobs=2)
    sides = {"0.675": (0.675, 0.675), "black=0.9 white=0.7": (0.9, 0.7)}
    for k, cost in enumerate(costs(data)):
        b, w = sides[cost.accuracy]
        goes_to = asymptote(b, w, b + cost.error, w + cost.error, cost.fill_ratio)
        final = data["final_estimate"].values[k].mean(axis=1)
        assert abs(final.mean() - goes_to) < 4.5 * final.std(ddof=1) / np.sqrt(len(final)) + 5e-4
        assert cost.predicted == pytest.approx(abs(goes_to - cost.fill_ratio), abs=1e-12)


def test_assumed_accuracies_are_clipped_to_0_and_1():
    text = STUDY.replace('"moving"', '"full"').replace("density = 10", "").replace("trials = 12", "trials = 1")
    text = text.replace("ticks = 2000\n", "")
    accuracy = "accuracy = [0.675, {black = 0.9, white = 0.7}]"
    assumed = re.search(r"assumed_accuracy = .*", text)[0]
    assert accuracy in text

    def told(accuracies, beliefs_):
        changed = text.replace(accuracy, f"accuracy = {accuracies}").replace(assumed, f"assumed_accuracy = {beliefs_}")
        return costs(sc.run(sc.Study.parse(changed)))

    assert {c.error for c in told("0.7", "[0.6, 0.7, {black = 0.8, white = 0.8}]")} == {-0.1, 0.0, 0.1}
    for cost in told("{black = 0.9, white = 0.7}", "{error = 0.2}"):
        f = cost.fill_ratio
        assert cost.predicted == pytest.approx(abs(float(asymptote(0.9, 0.7, 1.0, 0.9, f)) - f))
        assert np.isnan(cost.low)  # of one trial
    mixed = told('"U(0.6, 0.8)"', '[{error = 0.05}, "U(0.6, 0.8)", 0.7]')
    assert [c.error for c in mixed] == [0.05, 0.05, None, None, None, None] * 2
    assert all(np.isnan(c.predicted) for c in mixed)
    with pytest.raises(InputError, match=r"0.8 is off from the accuracy black=0.9 white=0.7 by -0.1 for black and 0.1"):
        told("{black = 0.9, white = 0.7}", "0.8")
