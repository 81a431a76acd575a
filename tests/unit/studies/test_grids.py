"""Grids of settings: the full one and each case's, and arenas by their side."""

import re

import pytest

import swarmcensus as sc
from swarmcensus.studies import addresses, read_value, short_key, to_text
from swarmcensus.studies.coordinates import coordinates_of
from swarmcensus.support.formatting import counted
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body

BASE = {"trials": 1, "swarm": {"robots": [10, 20], "accuracy": 0.7},
        "world": {"topology": "ring", "fill_ratio": 0.5}, "schedule": {"rounds": 50}}  # fmt: skip
MOVING = BASE | {"world": {"topology": "moving", "fill_ratio": 0.5}, "schedule": {"ticks": 50}}


def study(base=BASE, **changes):
    return sc.Study(**{k: base.get(k, {}) | v if isinstance(v, dict) else v for k, v in (base | changes).items()})


def refused(base=BASE, **changes):
    with pytest.raises(sc.InputError) as caught:
        study(base, **changes)
    return str(caught.value)


# ---- cases
def test_each_case_adds_a_grid_of_its_own():
    made = study(case=[{"robots": [100, 200], "rounds": 500}, {"topology": ["full", "line"], "brain": "legacy"}])
    assert [(s.brain.name, str(s.topology), s.robots, s.rounds) for s in made.settings()] == [
        ("minimalistic", "ring", 10, 50), ("minimalistic", "ring", 20, 50),
        ("minimalistic", "ring", 100, 500), ("minimalistic", "ring", 200, 500),
        ("legacy", "full", 10, 50), ("legacy", "full", 20, 50), ("legacy", "line", 10, 50), ("legacy", "line", 20, 50),
    ]  # fmt: skip
    assert (made.checkpoints[-1], [b.name for b in made.brains]) == (500, ["minimalistic", "legacy"])
    assert [t.name for t in made.topologies] == ["ring", "full", "line"]
    assert sc.Study.parse(made.text).settings() == made.settings()
    again = study(case=[{"robots": [20, 30]}, {"robots": [30, 40]}])
    assert [s.robots for s in again.settings()] == [10, 20, 30, 40]  # each once


def test_a_case_may_move_where_the_rest_stands():
    made = study(case=[{"topology": "moving", "side": 3.0, "ticks": "10 s", "floor": "half"}])
    moving = [s for s in made.settings() if s.body]
    assert [(s.robots, s.rounds, s.side, str(s.floor)) for s in moving] == [(n, 100, 3.0, "half") for n in (10, 20)]
    # what the base says of fixed networks is left out there, and the other way round
    back = study(MOVING, world={"density": 1.0, "floor": "half"}, case=[{"topology": "ring", "rounds": 9}])
    assert [(s.density, s.floor, s.rounds) for s in back.settings()[2:]] == [(None, None, 9)] * 2
    # a case's density stands in place of the base's side
    other = study(MOVING, world={"side": 3.0}, case=[{"density": 2.0}])
    assert [s.density for s in other.settings()[2:]] == [2.0, 2.0]


@pytest.mark.parametrize(("case", "said"), [
    ([{"robots": 5}, {"robotz": 5}], "unknown key case[1].robotz: did you mean 'robots'?"),
    ([{"body": {}}], "unknown key case[0].body"),
    ([{"robots": [10, 20]}], "case[0] adds no setting"),
    ([{"robots": 5}, {"robots": 5}], "case[1] adds no setting"),
    ([{"robots": [5, 5]}], "a value is twice in a list"),
    ([{"ticks": 5}], "case[0].ticks"),
    ([{"topology": "moving", "side": 1, "rounds": 5}], "case[0].rounds"),
    ([{"topology": "moving"}], "case[0]: world.density is missing"),
    ([{"accuracy": [0.7, 1.5]}], "case[0].accuracy[1] = 1.5"),
    ([{"topology": {"name": "far", "edges": [[0, 19]]}}], "edge (0, 19) of topology 'far' leads to a robot"),
    ([{"topology": {"name": "x", "edges": [[0, 1]]}}, {"topology": {"name": "x", "edges": [[0, 2]]}}],
     "two topologies of world.topology and of cases have one name: x"),
    ({"robots": 5}, "case = {robots = 5}"),
    ([{"accuracy": [k / 999 for k in range(999)], "fill_ratio": [k / 999 for k in range(999)]}], "its lists span"),
    ([{"robots": 2**31 - 1}], "values to keep"),
])  # fmt: skip
def test_what_is_wrong_with_a_case_is_named(case, said):
    assert said in refused(case=case)


def test_checks_hold_for_every_grid():
    faults = [{"at": 1, "robots": 8, "stop": "talking"}]
    assert "faults[0].robots = 8: there are 5 robots" in refused(faults=faults, case=[{"robots": 5}])
    case = [{"topology": "moving", "side": 3, "ticks": 9}]
    assert "measure.local = true" in refused(measure={"local": True}, case=case)
    assert study(measure={"checkpoints": 90}, case=[{"rounds": 90}]).checkpoints == [90]
    assert "comes after the last round, 90" in refused(measure={"checkpoints": 91}, case=[{"rounds": 90}])
    with pytest.warns(UserWarning, match="carries no information"):
        study(case=[{"accuracy": 0.5}])


def test_results_of_cases_are_run_kept_and_replayed(here):
    (here / "net.csv").write_text("u,v\n0,1\n1,2\n")
    case = {"brain": "legacy", "topology": {"file": "net.csv", "directed": True}, "robots": 4, "rounds": 6}
    made = study(trials=2, swarm={"robots": 3}, schedule={"rounds": 4}, case=[case])
    sc.save(sc.run(made, jobs=1), here / "r.nc")
    (here / "net.csv").unlink()
    kept = sc.load(here / "r.nc")
    assert kept["brain"].values.tolist() == ["minimalistic", "legacy"]
    assert (kept["edges_net"].attrs["directed"], sc.replay(kept, 1, 1).sizes["round"]) == (1, 7)
    assert not sc.verify(kept, sample=1.0, jobs=1).differences


# ---- side
def test_a_side_is_a_density_for_each_number_of_robots():
    made = study(MOVING, world={"side": [2.0, 3.7]}, swarm={"robots": [7, 25]})
    for setting, side in zip(made.settings(), [2.0, 3.7] * 2, strict=True):
        assert arena.side(setting.robots, setting.density, Body()) == pytest.approx(side, rel=1e-12)
        assert coordinates_of(setting)["side"] == side
    [equal] = study(MOVING, world={"density": made.settings()[3].density}, swarm={"robots": 25}).settings()
    assert addresses.fingerprint(equal, 1) == addresses.fingerprint(made.settings()[3], 1)


@pytest.mark.parametrize("robots", [1, 5, 25, 333])
def test_the_sizes_that_messages_name_are_taken(robots):
    for key, wrong in (("side", 0.01), ("density", 1000)):
        swarm = {"robots": robots}
        said = refused(MOVING, world={key: wrong}, swarm=swarm)
        assert f"world.{key} = {float(wrong)}: the arena cannot hold {counted(robots, 'robot')}" in said
        study(MOVING, world={key: float(said.removesuffix(" m").split()[-1])}, swarm=swarm)


def test_one_of_density_and_side_is_wanted():
    assert "world.density is missing" in refused(MOVING)
    assert "world.density and world.side both say" in refused(MOVING, world={"side": 3, "density": 1})
    assert 'world.side is of robots that move: it goes with topology = "moving"' in refused(world={"side": 3})
    assert "tiles wide" in refused(MOVING, world={"side": 1e9}, swarm={"robots": 1})


# ---- values in place of those of a study's keys: which key is meant, how values are read, and what is refused
TEXT = """
trials = 2
swarm = {robots = 5, accuracy = 0.7}
world = {topology = "moving", fill_ratio = 0.5, density = 1}
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "moving.toml"
    path.write_text(TEXT, encoding="utf-8")
    return path


@pytest.mark.parametrize(("values", "same"), [
    ({"robots": [3, 4], "world.density": 2}, TEXT.replace("= 5", "= [3, 4]").replace("= 1", "= 2")),
    ({"side": 3.0}, TEXT.replace("density = 1", "side = 3.0")),
    ({"speed": 0.1}, TEXT.replace("= 1}", "= 1, body = {speed = 0.1}}")),
    ({"body.speed": 0.1, "world.body.tile": 0.02}, TEXT.replace("= 1}", "= 1, body = {speed = 0.1, tile = 0.02}}")),
    ({"seed": 3, "name": "mine"}, "name = 'mine'\nseed = 3" + TEXT),
    ({"members": [{"robots": 1, "speed": 0.0}]}, TEXT + "[[members]]\nrobots = 1\nspeed = 0.0"),
    ({"brain": "census", "brain.z": 2, "swarm.brain.lone": 3},
     TEXT.replace("robots", "brain = {file = 'census', z = 2, lone = 3}, robots")),
    ({"swarm": {"robots": 2, "accuracy": 0.9}}, TEXT.replace("= 5", "= 2").replace("= 0.7", "= 0.9")),
])  # fmt: skip
def test_a_value_is_that_of_a_changed_file(file, values, same):
    read, wanted = sc.Study.load(file, values), sc.Study.parse(same)
    assert read.settings() == wanted.settings()
    assert (read.seed, read.members) == (wanted.seed, wanted.members)
    assert sc.Study.parse(TEXT).with_(**values).settings() == wanted.settings()
    assert sc.Study.parse(read.text).settings() == wanted.settings()
    assert sc.Study.load(file).settings() == sc.Study.parse(TEXT).settings()


@pytest.mark.parametrize(("text", "value"), [
    ("2", 2), ("0.5", 0.5), ("[1, 2]", [1, 2]), ("{black = 0.8, white = 0.9}", {"black": 0.8, "white": 0.9}),
    ("true", True), ('"a b"', "a b"), ("ring", "ring"), ("U(0.6, 0.8)", "U(0.6, 0.8)"), ("17 min", "17 min"),
])  # fmt: skip
def test_values_are_those_of_a_file_and_words_need_no_quotation_marks(text, value):
    assert read_value(text) == read_value(to_text(value)) == value


@pytest.mark.parametrize("text", ["", " a", "2", "true", "[x", "{", "1979-05-27", '"', "a\nb"])
def test_a_text_that_would_be_read_as_another_value_has_quotation_marks(text):
    assert (to_text(text)[0], read_value(to_text(text))) == ('"', text)


def test_a_key_has_the_shortest_name_that_is_no_other_ones():
    taken = ("side", "tick")
    keys = {
        "world.density": "density", "side": "world.side", "body.tick": "body.tick", "world.body.speed": "speed",
        "world.message_delay": "world.message_delay", "seed": "seed", "swarm": "swarm", "swarm.brain.z": "brain.z",
    }  # fmt: skip
    assert {key: short_key(key, taken) for key in keys} == keys


OF_CASES = """
trials = {at_most = 40, until = "convergence_error median +- 0.01"}
labels = {census = "C"}
swarm = {robots = [6, 9], accuracy = ["U(0.6, 0.9)", {black = 0.9, white = 0.6}]}
schedule = {rounds = [60, 90], ticks = "1 min"}
measure = {checkpoints = [10, 60], local = false, bins = 5}
members = [{robots = [0.34, 1], accuracy = [0.6, 0.95]}]
case = [{side = 2.0, topology = "moving", brain = {file = "census", z = [2, 3]}}]
[world]
topology = ["ring", "moving"]
density = [1, 2]
fill_ratio = [0.5, 0.75]
body = {speed = 0.1}
message = ["double", "float16"]
"""


def test_a_setting_is_that_of_a_study_of_its_own():
    study = sc.Study.parse(OF_CASES)
    settings = study.settings()
    assert len(settings) > 100
    for setting in settings:
        alone = study.with_setting(setting, {})
        assert alone.settings() == [setting]
        assert addresses.fingerprint(alone.settings()[0], alone.seed) == addresses.fingerprint(setting, study.seed)
        assert (alone.trials, alone.measure.bins) == (40, 5)


@pytest.mark.parametrize(("number", "values", "says"), [
    (0, {"robots": 12}, "ring, N = 12, accuracy U(0.6,0.9), f = 0.5"),
    (0, {"topology": "moving"}, "moving, N = 6, D = 1, accuracy"),
    (0, {"topology": "moving", "side": 3}, "moving, N = 6, L = 3 m, accuracy"),
    (-1, {"topology": "line", "rounds": 7}, "line, N = 9"),
    (-1, {"robots": 12}, "N = 12, L = 2 m"),
    (-1, {"body.tick": 0.5}, "120 ticks"),
    (0, {"topology": "moving", "rounds": None, "ticks": 70}, "70 ticks"),
])  # fmt: skip
def test_values_of_one_setting_lead_to_another(number, values, says):
    study = sc.Study.parse(OF_CASES)
    [setting] = study.with_setting(study.settings()[number], values).settings()
    assert says in str(setting)


def test_what_means_nothing_in_another_world_is_refused_if_it_was_given():
    study = sc.Study.parse(TEXT)
    [setting] = study.settings()
    for values, says in (
        ({"topology": "ring", "density": 2}, "mine: world.density is of robots that move"),
        ({"topology": "rng"}, "mine: world.topology = \"rng\": did you mean 'ring'?"),
        ({"rounds": 3}, "mine: schedule.rounds is of fixed networks"),
        ({"world": 3}, "mine: world = 3: should be a table"),
    ):
        with pytest.raises(sc.InputError, match=rf"\A{re.escape(says)}"):
            study.with_setting(setting, values, where="mine")


@pytest.mark.parametrize(("word", "says"), [
    ("world.robots=3", "unknown key world.robots"),
    ("density=-1", "moving.toml with --set density=-1: world.density = -1: should be greater than 0"),
    ("rounds=3", "schedule.rounds is of fixed networks"),
    ("trials.until=x", "should be such as"),
    ("robots", "should be KEY=VALUE, such as density=2"),
    ("robots=3\ntrials=1", "not a value of TOML"),
    ("brain.z=2", "file is missing: a brain with parameters is a table such as"),
    ("accuracy.black=0.9", "is given whole, as accuracy = {black = ...}"),
])  # fmt: skip
def test_wrong_keys_and_values_are_refused_in_a_sentence(file, refused, word, says):
    for command in ("run", "tune"):
        assert says in refused(command, str(file), "--set", word, *["--parameter", "prior=1:2"] * (command == "tune"))


def test_a_key_is_given_once(file, refused):
    words = ("run", str(file), "--set", "robots=3", "--set", "robots=4")
    assert "--set robots: the name is given twice" in refused(*words)
