"""The arena with robots that always say 0: what its page says of few and many liars, on few trials."""

import pytest

import swarmcensus as sc
from tests.support.places import ROOT

STUDY = ROOT / "studies" / "rivals" / "strobel-2020.toml"
TRIALS = 6


@pytest.fixture(scope="module")
def results():
    """Some numbers of liars: trials are as in the whole study, whatever other settings there are."""
    study = sc.Study.load(STUDY)
    assert len(study.settings()) == 20
    return ran({"[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]": "[0, 2, 5]"}, TRIALS)


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
