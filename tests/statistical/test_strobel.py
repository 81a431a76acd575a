"""The arena with robots that always say 0: what its page says of few and many liars, on few trials."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.brains.library import TITLES
from swarmcensus.results import measures
from tests.support.places import ROOT

STUDY = ROOT / "studies" / "rivals" / "strobel-2020.toml"
TRIALS = 6


@pytest.fixture(scope="module")
def results():
    """Some numbers of liars: trials are as in the whole study, whatever other settings there are."""
    study = sc.Study.load(STUDY)
    assert len(study.settings()) == 20
    return ran({"[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]": "[0, 2, 5]"}, TRIALS)


@pytest.fixture(scope="module")
def few():
    """For a fiftieth of the time, in phases of a few ticks."""
    return ran({"[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]": "[0, 2]", "10000": "200", "[1000,": "[100,", "= 46": "= 6"}, 2)


def ran(changes, trials):
    text = STUDY.read_text(encoding="utf-8")
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    return sc.run(sc.Study.parse(text).with_(trials=trials))


@pytest.mark.interpreted
def test_the_study_is_the_published_experiment():
    """Liars say 0 of a colour that covers 0.75; 10,000 ticks of 1 s and 10 cm are 217 phases, three of them silent."""
    study = sc.Study.load(STUDY)
    for setting in study.settings():
        assert setting.fill_ratio == 0.75
        assert setting.rounds == 10_000
        body = setting.body
        assert (body.tick, body.speed, body.tile, body.radio_range) == (1, 0.1, 0.1, 0.5)
        parameters = setting.brain.parameters
        assert setting.rounds // parameters["phase"] == 217
        assert parameters["silent"] == 3
        assert parameters["debiased"] == 0
    assert [adversary.name for adversary in study.adversaries] == ["always-white"]


@pytest.mark.long
def test_two_liars_among_linear_consensus_and_w_msr(results):
    error = abs(results["final_estimate"] - results["true_fill_ratio"]).mean("robot")
    of = {
        (brain, liars): error.isel(setting=k).values
        for k, (brain, liars) in enumerate(zip(results["brain"].values, results["liars"].values, strict=True))
    }
    for brain in ("linear-consensus", "w-msr"):
        assert of[brain, 0].mean() < 0.03
        assert of[brain, 5].mean() > 0.1
    assert of["w-msr", 2].mean() < 0.03
    assert (of["linear-consensus", 2] > 2 * of["w-msr", 2]).sum() >= TRIALS - 1
    assert (of["linear-consensus", 5] > of["w-msr", 5]).sum() >= TRIALS - 1


@pytest.mark.long
@pytest.mark.interpreted
def test_figure_of_errors_by_number_of_liars(few):
    figure = sc.plot.lines(few, y="final_error", x="liars", color="brain", panels=["topology"], statistic="mean")
    (ax,) = figure.axes
    error = abs(few["final_estimate"] - few["true_fill_ratio"]).mean(["trial", "robot"]).values
    drawn = {line.get_label(): line.get_ydata() for line in ax.lines}
    assert len({*error.tolist()}) == 4
    for brain in ("linear-consensus", "w-msr"):
        dots = np.concatenate([np.ravel(y) for label, y in drawn.items() if label == TITLES[brain]])
        np.testing.assert_allclose(dots, error[few["brain"].values == brain], rtol=1e-12)


@pytest.mark.long
@pytest.mark.interpreted
def test_measures_by_trial(few):
    found = measures.with_measure(few, "final_error")
    with np.errstate(all="ignore"):
        median = found["final_error"].median("robot").transpose("setting", "trial").values
    np.testing.assert_allclose(median, measures.numbers(few, "final_error"), rtol=1e-12)
    assert found["final_error"].attrs["units"] == "1"
    sent = measures.with_measure(few, "bytes_sent")["bytes_sent"].mean("robot").transpose("setting", "trial").values
    np.testing.assert_allclose(sent, measures.numbers(few, "bytes_sent"), rtol=1e-12)
    for name in ("final_estimate", "decided", "nothing"):  # is there, lacks variables, is none
        assert measures.with_measure(few, name) is few
