"""Values in place of those of a study's keys: which key is meant, how values are read, and what is refused."""

import pytest

import swarmcensus as sc
from swarmcensus.studies import addresses, read_value, short_key, to_text

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


@pytest.mark.parametrize(
    ("values", "same"),
    [
        ({"robots": [3, 4], "world.density": 2}, TEXT.replace("= 5", "= [3, 4]").replace("= 1", "= 2")),
        ({"side": 3.0}, TEXT.replace("density = 1", "side = 3.0")),
        ({"speed": 0.1}, TEXT.replace("= 1}", "= 1, body = {speed = 0.1}}")),
        ({"body.speed": 0.1, "world.body.tile": 0.02}, TEXT.replace("= 1}", "= 1, body = {speed = 0.1, tile = 0.02}}")),
        ({"seed": 3, "name": "mine"}, "name = 'mine'\nseed = 3" + TEXT),
        ({"members": [{"robots": 1, "speed": 0.0}]}, TEXT + "[[members]]\nrobots = 1\nspeed = 0.0"),
        (
            {"brain": "census", "brain.z": 2, "swarm.brain.lone": 3},
            TEXT.replace("robots", "brain = {file = 'census', z = 2, lone = 3}, robots"),
        ),
        ({"swarm": {"robots": 2, "accuracy": 0.9}}, TEXT.replace("= 5", "= 2").replace("= 0.7", "= 0.9")),
    ],
)
def test_a_value_is_that_of_a_changed_file(file, values, same):
    read, wanted = sc.Study.load(file, values), sc.Study.parse(same)
    assert read.settings() == wanted.settings()
    assert (read.seed, read.members) == (wanted.seed, wanted.members)
    assert sc.Study.parse(TEXT).with_(**values).settings() == wanted.settings()
    assert sc.Study.parse(read.text).settings() == wanted.settings()
    assert sc.Study.load(file).settings() == sc.Study.parse(TEXT).settings()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2", 2), ("0.5", 0.5), ("[1, 2]", [1, 2]), ("{black = 0.8, white = 0.9}", {"black": 0.8, "white": 0.9}),
        ("true", True), ('"a b"', "a b"), ("ring", "ring"), ("U(0.6, 0.8)", "U(0.6, 0.8)"), ("17 min", "17 min"),
    ],
)  # fmt: skip
def test_values_are_those_of_a_file_and_words_need_no_quotation_marks(text, value):
    assert read_value(text) == value
    assert read_value(to_text(value)) == value


@pytest.mark.parametrize("text", ["", " a", "2", "true", "[x", "{", "1979-05-27", '"', "a\nb"])
def test_a_text_that_would_be_read_as_another_value_has_quotation_marks(text):
    assert to_text(text)[0] == '"'
    assert read_value(to_text(text)) == text


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
[world]
topology = ["ring", "moving"]
density = [1, 2]
fill_ratio = [0.5, 0.75]
body = {speed = 0.1}
message = ["double", "float16"]
[[members]]
robots = [0.34, 1]
accuracy = [0.6, 0.95]
[[case]]
side = 2.0
topology = "moving"
brain = {file = "census", z = [2, 3]}
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


@pytest.mark.parametrize(
    ("number", "values", "says"),
    [
        (0, {"robots": 12}, "ring, N = 12, accuracy U(0.6,0.9), f = 0.5"),
        (0, {"topology": "moving"}, "moving, N = 6, D = 1, accuracy"),
        (0, {"topology": "moving", "side": 3}, "moving, N = 6, L = 3 m, accuracy"),
        (-1, {"topology": "line", "rounds": 7}, "line, N = 9"),
        (-1, {"robots": 12}, "N = 12, L = 2 m"),
        (-1, {"body.tick": 0.5}, "120 ticks"),
        (0, {"topology": "moving", "rounds": None, "ticks": 70}, "70 ticks"),
    ],
)
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
        with pytest.raises(sc.InputError) as told:
            study.with_setting(setting, values, where="mine")
        assert str(told.value).startswith(says)


@pytest.mark.parametrize(
    ("word", "says"),
    [
        ("robts=3", "unknown key robts: did you mean 'robots'?"),
        ("world.robots=3", "unknown key world.robots"),
        ("message_delay=3", "message_delay may be world.message_delay or world.body.message_delay: say which"),
        ("density=-1", "moving.toml with --set density=-1: world.density = -1: should be greater than 0"),
        ("rounds=3", "schedule.rounds is of fixed networks"),
        ("trials.until=x", "should be such as"),
        ("robots", "should be KEY=VALUE, such as density=2"),
        ("robots=[3", "[3: not a value of TOML"),
        ("robots=3\ntrials=1", "not a value of TOML"),
        ("brain.z=2", "file is missing: a brain with parameters is a table such as"),
        ("accuracy.black=0.9", "is given whole, as accuracy = {black = ...}"),
    ],
)
def test_wrong_keys_and_values_are_refused_in_a_sentence(file, refused, word, says):
    for command in ("run", "tune"):
        assert says in refused(command, str(file), "--set", word, *["--parameter", "prior=1:2"] * (command == "tune"))


def test_a_key_is_given_once(file, refused):
    assert "--set robots: the name is given twice" in refused(
        "run", str(file), "--set", "robots=3", "--set", "robots=4"
    )
