"""Values in place of those of a study's keys: which key is meant, how values are read, and what is refused."""

import pytest

import swarmcensus as sc
from swarmcensus.studies import read_value

TEXT = """
trials = 2
[swarm]
robots = 5
accuracy = 0.7
[world]
topology = "moving"
fill_ratio = 0.5
density = 1
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
        ({"speed": 0.1}, TEXT + "body = {speed = 0.1}"),
        ({"body.speed": 0.1, "world.body.tile": 0.02}, TEXT + "body = {speed = 0.1, tile = 0.02}"),
        ({"seed": 3, "name": "mine"}, "name = 'mine'\nseed = 3" + TEXT),
        ({"members": [{"robots": 1, "speed": 0.0}]}, TEXT + "[[members]]\nrobots = 1\nspeed = 0.0"),
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
