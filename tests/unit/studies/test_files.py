"""Study files and tables: grids, defaults, keys that mean nothing, and values however they are given."""

import os
import re
import time

import numpy as np
import pandas as pd
import pytest

import swarmcensus as sc
from swarmcensus.studies import study as studies
from swarmcensus.support.errors import LONGEST
from swarmcensus.support.plugins import MOST_SOURCE
from tests.support.small import BOTH, MOVING, RING, SMALL, study_of


def test_a_grid_is_every_combination():
    study = sc.Study.parse(SMALL)
    assert len(study.settings()) == len(set(study.settings())) == 4 * 2 * 2 * 2
    assert (study.name, study.seed, study.trials) == ("small", 7, 4)
    assert study.checkpoints == [10, 60]


def test_defaults():
    study = sc.Study(trials=3, swarm={"robots": 5, "accuracy": 0.7}, world={"topology": "ring", "fill_ratio": 0.5})
    setting = study.settings()[0]
    assert (setting.brain.name, setting.rounds, setting.observations_per_round) == ("minimalistic", 1000, 10)
    assert (study.measure.delta, study.measure.bins, study.measure.local) == (0.01, 10, False)
    assert study.checkpoints == [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]


def test_text_gives_the_same_study_again():
    accuracies = [0.7, "U(0.5,0.9)", {"black": 0.9, "white": 0.6}]
    networks = ["ring", {"name": "pair", "edges": [[0, 1]]}]
    study = study_of(robots=[5, 9], accuracy=accuracies, measure={"local": True}, topology=networks)
    again = sc.Study.parse(study.text)
    assert again.settings() == study.settings()
    assert again.measure == study.measure


@pytest.mark.parametrize(("change", "said"), [
    (("robots ", "robot "),
     "unknown key swarm.robot: did you mean 'robots'? known here: brain, robots, accuracy, assumed_accuracy, "
     "precision; 1 more error: swarm.robots is missing"),
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
    (("trials = 4", "trials = 4\ntrials = 5"), "not TOML: a key is given twice (at line"),
])  # fmt: skip
def test_what_is_wrong_is_named(change, said):
    assert change[0] in SMALL
    with pytest.raises(sc.InputError, match=rf"\Astudies/x\.toml: {re.escape(said)}"):
        sc.Study.parse(SMALL.replace(*change, 1), where="studies/x.toml")


def test_blind_sensors_are_warned_of():
    with pytest.warns(UserWarning, match="carries no information"):
        sc.Study.parse(SMALL.replace("0.675", "0.5"))


def test_unreadable_files(tmp_path):
    with pytest.raises(sc.InputError, match="there is no such file"):
        sc.Study.load(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\x00")
    with pytest.raises(sc.InputError, match="cannot be read"):
        sc.Study.load(tmp_path / "bytes.toml")


# ---- keys that mean nothing are errors; values that mean something are taken however they are given
def study(world=RING, robots=5, **tables):
    return sc.Study(**{"trials": 1, "swarm": {"robots": robots, "accuracy": 0.7}, "world": world} | tables)


def fault(**changes):
    return [{"at": 1, "robots": 1, "stop": "talking"} | changes]


@pytest.mark.parametrize(("world", "tables", "said"), [
    (RING, {"schedule": {"ticks": 5}}, "schedule.ticks"),
    (RING | {"density": 1}, {}, "world.density"),
    (RING | {"body": {"radius": 0.1}}, {}, "world.body is of robots that move"),
    (RING, {"measure": {"truth": "floor"}}, 'measure.truth = "floor"'),
    (MOVING, {"schedule": {"rounds": 5}}, "schedule.rounds"),
    (MOVING, {"schedule": {"observations_per_round": 5}}, "schedule.observations_per_round"),
    (MOVING | {"body": {"message_delay": 40}}, {"schedule": {"ticks": 40}}, "no message is heard within 40 ticks"),
    (RING, {"faults": fault(at=1001)}, "faults[0].at = 1001"),
    (RING, {"faults": fault(robots=0.05)}, "faults[0].robots = 0.05"),
    # of a base that only cases use, and of which they use something else
    (RING | {"density": 1}, {"case": [{"topology": "moving", "density": 2}]}, "world.density"),
])  # fmt: skip
def test_what_means_nothing_is_an_error(world, tables, said):
    with pytest.raises(sc.InputError, match=re.escape(said)):
        study(world, **tables)


@pytest.mark.parametrize(("world", "tables"), [
    (BOTH | {"floor": "half", "body": {"radius": 0.05}},
     {"schedule": {"rounds": 5, "ticks": 9, "observations_per_round": 2}, "measure": {"truth": "floor"}}),
    (RING | {"density": None, "side": None, "floor": None}, {}),
    (RING | {"density": 1, "body": {}}, {"case": [{"topology": "moving", "ticks": 5}]}),
    (RING, {"faults": fault(at=1000, robots=1.0)}),
    (RING, {"schedule": {"rounds": [5, 10]}, "faults": fault(at=10)}),
])  # fmt: skip
def test_what_means_something_somewhere_is_taken(world, tables):
    made = study(world, **tables)
    assert sc.Study.parse(made.text).settings() == made.settings()


@pytest.mark.parametrize("robots", [
    range(3, 6), np.arange(3, 6), (3, 4, 5), pd.Series([3, 4, 5]), [np.int64(3), np.uint8(4), 5],
], ids=lambda v: type(v).__name__)  # fmt: skip
def test_whole_numbers_come_as_lists_of_any_kind(robots):
    made = study(robots=robots)
    assert [s.robots for s in made.settings()] == [3, 4, 5]
    assert sc.Study.parse(made.text).settings() == made.settings()


@pytest.mark.parametrize(("value", "shown"), [(np.float64(3.0), "3.0"), (3.0, "3.0"), (np.bool_(True), "true")])
def test_other_numbers_are_not_whole(value, shown):
    with pytest.raises(sc.InputError, match=f"schedule.rounds = {shown}: should be a whole number"):
        study(schedule={"rounds": value})


def test_numbers_of_numpy_are_numbers():
    made = study(
        MOVING | {"link_success": np.float32(0.5), "body": {"radius": np.float64(0.07)}}, trials=np.int64(2),
        seed=np.uint16(3), robots=np.int32(5), schedule={"ticks": np.arange(5, 8)},
        measure={"bins": np.int8(5), "checkpoints": np.array(5)}, faults=fault(at=np.int64(2), robots=np.float64(0.5)),
    )  # fmt: skip
    assert (made.trials, made.seed, made.measure.bins, made.checkpoints) == (2, 3, 5, [5])
    assert sc.Study.parse(made.text).settings() == made.settings()
    with pytest.raises(sc.InputError, match=r"world\.density = true"):
        study(MOVING | {"density": True})


def test_keys_of_fixed_networks_do_not_multiply_those_that_move():
    settings = study(BOTH | {"message_delay": [0, 2]}).settings()
    assert [(s.topology.name, s.delay) for s in settings] == [("ring", 0), ("ring", 2), ("moving", 0)]


# ---- small files that would take minutes or all memory are refused in a sentence
LONG = 50_000
STUDY = """trials = 2
swarm = {brain = BRAIN, robots = ROBOTS, accuracy = 0.8}
world = {topology = TOPOLOGY, fill_ratio = FILL}
"""
USUAL = {"BRAIN": '"minimalistic"', "ROBOTS": "5", "TOPOLOGY": '"ring"', "FILL": "0.5"}


def study_with(**values):
    text = STUDY
    for key, value in (USUAL | values).items():
        text = text.replace(key, value)
    return text


def shares(count):
    return f"[{', '.join(f'0.{k:06d}' for k in range(1, count))}]"


@pytest.mark.parametrize(("text", "said"), [
    ("a." * LONG + "a = 1", "x.toml: its keys, tables or lists are nested over 32 deep"),
    ("a = {" + "a.b.c." * 5 + "a.b={" + "a.b.c." * 5 + "a = 1}}", "nested over 32 deep"),
    ("a = " + "[" * LONG, "nested over 32 deep"),
    ("a = " + "{a=" * LONG, "nested over 32 deep"),
    ("a = " + "9" * LONG, "x.toml: a whole number has too many digits"),
    ("k" * LONG + " = 1", "x.toml: unknown key kkk"),
    (study_with(TOPOLOGY=f'"{"k" * LONG}"'), "x.toml: 'kkk"),
    (study_with(BRAIN=f'"{"k" * LONG}.py"'), "x.toml: 'kkk"),
    (study_with(FILL=shares(4000), BRAIN='["alone", "minimalistic"]', ROBOTS=str([*range(3, 50)])),
     "x.toml: its lists span 375,906 settings; 250,000 is the most"),
    (study_with(ROBOTS=str([*range(3, 60_000)])), "swarm.robots has 59,997 values; 10,000 is the most"),
    (study_with(BRAIN=str([f"b{k}" for k in range(85_000)])), "swarm.brain has 85,000 values; 10,000 is the most"),
    ("[[case]]\nrobots = 1\n" * 40_000, "case has 40,000 values; 10,000 is the most"),
    (study_with(ROBOTS=str([*range(990_000, 1_000_000)])), "10,000 settings of 1 trial make "),
    (study_with(BRAIN='"big.py"'), "big.py: cannot be read: it is over 125,000 bytes"),
    (study_with(BRAIN='"deep.py"'), "deep.py: its brackets or operators are nested too deep"),
    (study_with(BRAIN='"pipe.py"'), "pipe.py"),
])  # fmt: skip
def test_small_files_take_little(text, said, here, refused, monkeypatch):
    monkeypatch.setattr(studies, "all_settings", lambda *_: pytest.fail("the settings were listed"))
    (here / "x.toml").write_text(text)
    (here / "big.py").write_text("x = 1\n" * (MOST_SOURCE // 6 + 1))
    (here / "deep.py").write_text("x = " + "-" * 100_000 + "1\n")
    os.mkfifo(here / "pipe.py")
    begun = time.process_time()
    error = refused("run", "x.toml")
    assert time.process_time() - begun < 20.0
    assert said in error
    assert len(error) < LONGEST + 200


def test_what_is_not_a_file_is_not_read(here, refused):
    os.mkfifo(here / "pipe.toml")
    assert "pipe.toml: cannot be read: it is a device or a pipe, not a file" in refused("run", "pipe.toml")


def test_many_values_of_a_parameter_are_of_one_file(here):
    brains = ", ".join(f'{{file = "bayes-bots", prior = {k}}}' for k in range(1, 1500))
    begun = time.process_time()
    assert len(sc.Study.parse(study_with(BRAIN=f"[{brains}]"), context={"base": here}).brains) == 1
    assert time.process_time() - begun < 20.0
