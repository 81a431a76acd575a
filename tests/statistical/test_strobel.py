"""The arena with robots that always say 0: what its page says of few and many liars, on few trials."""

import pytest

import swarmcensus as sc
from tests.support.places import ROOT

STUDY = ROOT / "studies" / "rivals" / "strobel-2020.toml"


@pytest.mark.interpreted
def test_the_study_is_the_published_experiment():
    """Liars say 0 of a colour that covers 0.75; 10,000 ticks of 1 s and 10 cm are 217 phases, three of them silent."""
    study = sc.Study.load(STUDY)
    for setting in study.settings():
        assert setting.fill_ratio == 0.75
        assert setting.rounds == 10_000
        body = setting.body
        assert (body.tick, body.speed, body.tile, body.radio_range) == (1, 0.1, 0.1, 0.5)
        assert (body.straight_mean, body.turn_most) == (40, 4)
        parameters = setting.brain.parameters
        assert setting.rounds // parameters["phase"] == 217
        assert parameters["silent"] == 3
        assert parameters["debiased"] == 0
    assert [adversary.name for adversary in study.adversaries] == ["always-white"]
