"""The study file: what it means, and what is said of a wrong one."""

import pytest

import swarmcensus as sc
from tests.support.small import SMALL

CONTEXT = "studies/x.toml: "


def test_a_grid_is_every_combination():
    study = sc.Study.parse(SMALL)
    settings = study.settings()
    assert len(settings) == len(set(settings)) == 4 * 2 * 2 * 2
    assert (study.name, study.seed, study.trials) == ("small", 7, 4)
    assert study.checkpoints == [10, 60]


def test_defaults():
    study = sc.Study(trials=3, swarm={"robots": 5, "accuracy": 0.7}, world={"topology": "ring", "fill_ratio": 0.5})
    setting = study.settings()[0]
    assert (setting.brain.name, setting.rounds, setting.observations_per_round) == ("minimalistic", 1000, 10)
    assert (study.measure.delta, study.measure.bins, study.measure.local) == (0.01, 10, False)
    assert study.checkpoints == [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]


def test_text_gives_the_same_study_again():
    study = sc.Study(
        trials=3,
        swarm={"robots": [5, 9], "accuracy": [0.7, "U(0.5,0.9)", {"black": 0.9, "white": 0.6}]},
        world={"topology": ["ring", {"name": "pair", "edges": [[0, 1]]}], "fill_ratio": 0.5},
        measure={"local": True},
    )
    again = sc.Study.parse(study.text)
    assert again.settings() == study.settings()
    assert again.measure == study.measure


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("robots ", "robot "), "unknown key swarm.robot: did you mean 'robots'"),
        (("world =", "wrld ="), "unknown key wrld: did you mean 'world'"),
        (("[5, 12]", "[]"), "swarm.robots = []"),
        (("[0.675,", "[1.2,"), "swarm.accuracy[0] = 1.2"),
        (('"ring"', '"rng"'), 'world.topology[1] = "rng"'),
        (("= 60,", "= -60,"), "schedule.rounds = -60"),
        (("trials = 4", ""), "trials is missing"),
        (("[10, 60]", "[10, 61]"), "measure.checkpoints = 61"),
        (("swarm = {", 'swarm = {brain = "nobody", '), 'swarm.brain = "nobody"'),
        (('"ring"', '{name = "far", edges = [[0, 11]]}'), "edge (0, 11) of topology 'far' leads to a robot"),
        (('"ring"', '"full"'), "two entries of world.topology have one name"),
        (("trials = 4", "trials = ["), "not TOML"),
    ],
)
def test_what_is_wrong_is_named(change, said):
    assert change[0] in SMALL
    with pytest.raises(sc.InputError) as caught:
        sc.Study.parse(SMALL.replace(*change, 1), where="studies/x.toml")
    assert str(caught.value).startswith(CONTEXT + said)


def test_blind_sensors_are_warned_of():
    with pytest.warns(UserWarning, match="carries no information"):
        sc.Study.parse(SMALL.replace("0.675", "0.5"))


def test_unreadable_files(tmp_path):
    with pytest.raises(sc.InputError, match="there is no such file"):
        sc.Study.load(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\x00")
    with pytest.raises(sc.InputError, match="cannot be read"):
        sc.Study.load(tmp_path / "bytes.toml")
