"""Times with a unit, wherever a study counts ticks; changes and drifts that cannot be."""

import re
from pathlib import Path

import pytest
from PIL import Image

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.studies import addresses
from swarmcensus.support.times import parse_time
from tests.support.small import changing

STUDY = {"trials": 1, "swarm": {"robots": 5, "accuracy": 0.7},
         "world": {"topology": "moving", "side": 3, "fill_ratio": 0.5}}  # fmt: skip


def study(world={}, **tables):  # noqa: B006
    return sc.Study(**STUDY | {"world": STUDY["world"] | world} | tables)


@pytest.mark.parametrize(("text", "tick", "ticks"), [
    ("17 min", 0.1, 10_200), ("90 s", 0.1, 900), ("1 h", 0.1, 36_000), ("0.3 s", 0.1, 3), ("1.5min", 0.25, 360),
    (" 2e1 s ", 0.7, None), ("21 s", 0.7, 30), ("7 s", 1 / 3, 21), ("100000.05 s", 0.1, None),
])  # fmt: skip
def test_times_are_whole_numbers_of_ticks(text, tick, ticks):
    if ticks is None:
        with pytest.raises(ValueError, match="should be a whole number, such as"):
            parse_time(text).ticks(tick)
    else:
        assert parse_time(text).ticks(tick) == ticks


def test_every_key_that_counts_ticks_takes_times():
    made = study(
        schedule={"ticks": ["17 min", 300, "2 min"]}, measure={"checkpoints": ["1 min", 7]},
        faults=[{"at": "5 s", "robots": 1, "stop": "talking"}], case=[{"ticks": "1 h", "robots": 3}],
        world={"body": {"message_delay": "0.4 s"}},
    )  # fmt: skip
    assert [s.rounds for s in made.settings()] == [10_200, 300, 1200, 36_000]
    assert made.checkpoints == [7, 600]
    assert [(f.at, s.body.message_delay) for s in made.settings() for f in s.faults] == [(50, 4)] * 4
    again = sc.Study.parse(made.text)
    assert '"17 min"' in made.text
    marks = [[addresses.fingerprint(s, 1) for s in one.settings()] for one in (again, made)]
    assert marks[0] == marks[1]
    slow = study(schedule={"ticks": "17 min"}, world={"body": {"tick": 0.5, "message_delay": "0 s"}})
    assert [(s.rounds, s.body.message_delay) for s in slow.settings()] == [(2040, 0)]


@pytest.mark.parametrize(("tables", "said"), [
    ({"schedule": {"ticks": "1.25 s"}},
     'schedule.ticks = "1.25 s": that is 12.5 ticks of 0.1 s: should be a whole number, such as "1.2 s" (12) or '
     '"1.3 s" (13)'),
    ({"schedule": {"ticks": ["1 s", "0 s"]}}, 'such as "0.1 s" (1)'),
    ({"schedule": {"ticks": "1e999 h"}}, "2,147,483,647 at the most"),
    ({"schedule": {"ticks": "5 m"}}, "(s, min or h)"),
    ({"schedule": {"ticks": ["1 s", 10]}}, "a value is twice in a list"),
    ({"case": [{"ticks": "0.25 s"}]}, 'case[0].ticks = "0.25 s"'),
    ({"faults": [{"at": "0.25 s", "robots": 1, "stop": "moving"}]}, 'faults[0].at = "0.25 s"'),
    ({"measure": {"checkpoints": "0.25 s"}}, 'measure.checkpoints = "0.25 s"'),
    ({"world": {"body": {"message_delay": "0.25 s"}}}, 'world.body.message_delay = "0.25 s"'),
    ({"world": {"body": {"message_delay": "9 h"}}}, "less than or equal to 1,000"),
])  # fmt: skip
def test_what_is_wrong_is_named(tables, said):
    with pytest.raises(sc.InputError, match=re.escape(said)):
        study(**tables)


def test_rounds_have_no_clock():
    both = {"topology": ["ring", "moving"]}
    for tables, key in (
        ({"faults": [{"at": "5 s", "robots": 1, "stop": "talking"}]}, r"faults\[0\].at"),
        ({"measure": {"checkpoints": [3, "5 s"]}}, "measure.checkpoints"),
    ):
        with pytest.raises(sc.InputError, match=f'{key} = "5 s": the rounds of fixed networks have no clock'):
            study(both, **tables)
    assert {s.rounds for s in study(both, schedule={"ticks": "1 s"}).settings()} == {1000, 10}
    with pytest.raises(sc.InputError, match="should be a whole number"):
        study(both, schedule={"rounds": "5 s"})


@pytest.mark.long
def test_commands_take_times(here, refused, accepted):
    made = study({"body": {"tick": 0.5}}, schedule={"ticks": 20}, measure={"checkpoints": [12, 20]})
    sc.save(sc.run(made), "m.nc")

    def shown(*command):
        return accepted("show", "m.nc", *command).out

    assert shown("--checkpoint", "0.1 min") == shown("--checkpoint", "12") != shown()
    plot = ["plot", "m.nc", "--kind"]
    for name, tick in (("a.png", "4 s"), ("b.png", "8")):
        assert main([*plot, "arena", "--tick", tick, "--out", name]) == 0
    assert (here / "a.png").read_bytes() == (here / "b.png").read_bytes()
    size = ["--width", "4", "--height", "5", "--dpi", "50"]
    film = accepted(*plot, "film", *size, "--first", "2 s", "--last", "4 s", "--every", "1", "--out", "f.gif")
    assert film.out == "f.gif: 5 frames\nf.gif.caption.txt\n"
    with Image.open("f.gif") as picture:
        assert picture.size == (200, 250)
    assert "that is 10.6 ticks of 0.5 s" in refused("show", "m.nc", "--checkpoint", "5.3 s")
    assert "--tick 7200: this trial has ticks 0 to 20" in refused(*plot, "arena", "--tick", "1 h")


# ---- changes and drifts that cannot be: each is named in one sentence, through the command line
RING = '[world]\ntopology = "ring"\nfill_ratio = {fill}\n[schedule]\nrounds = [50, 100]\n'
FALLS = "{from = 0.9, to = 0.1, %s}"
MOVING = '[world]\ntopology = "moving"\ndensity = 8\nfill_ratio = {fill}\n[schedule]\nticks = 100\n'


@pytest.fixture
def said(refused):
    """What the command line says of a study: a function of its world, fill ratio and swarm."""

    def said(world, fill="0.3", swarm="accuracy = 0.8"):
        Path("s.toml").write_text(f"trials = 1\n[swarm]\nrobots = 4\n{swarm}\n{world.replace('{fill}', fill)}")
        return refused("run", "s.toml")

    return said


@pytest.mark.parametrize(("world", "fill", "due"), [
    (RING, "{from = 0.9, to = 0.1, at = 100}", "at = 100 should be before the last round, 100"),
    (RING, "{from = 0.9, to = 0.1, at = 20, until = 19}", "world.fill_ratio.until = 19 comes before at = 20"),
    (RING, "{from = 0.9, to = 0.9, at = 20}", "from and to are both 0.9"),
    (RING, "{from = 0.9, to = 0.1, at = 1}", "at should be a whole number from 2"),
    (RING, "{from = 0.9, to = 0.1, at = 20, til = 30}", "unknown key til: did you mean 'until'?"),
    (RING, "{from = 0.9, at = 20}", "to is missing"),
    (RING, '{from = 0.9, to = 0.1, at = "5 min"}', "the rounds of fixed networks have no"),
    (RING, "[0.5, {from = 0.9, to = 2, at = 20}]", "world.fill_ratio[1] = "),
    # times are shown as the file has them
    (MOVING, FALLS % 'at = "0.1 s"',
     'at = "0.1 s": that is 1 ticks of 0.1 s: should be a whole number from 2, such as "0.2 s"'),
    (MOVING, FALLS % 'at = "1 h"', 'at = "1 h" (36,000 ticks) should be before the last round, 100'),
    (MOVING, FALLS % 'at = 2, until = "0 s"', 'until = "0 s": that is 0 ticks of 0.1 s'),
    (MOVING, FALLS % 'at = "2 s", until = "1 s"', 'until = "1 s" (10 ticks) comes before at = "2 s" (20 ticks)'),
])  # fmt: skip
def test_what_is_wrong_of_a_change_is_named(world, fill, due, said):
    found = said(world, fill)
    assert due in found
    assert "36000}" not in found


@pytest.mark.parametrize(("accuracy", "due"), [
    ("{start = 0.6, drift = -0.01, least = 0.6}", "start = 0.6 should lie above least = 0.6"),
    ('{start = "U(0.5, 0.9)", drift = -0.01, least = 0.6}', "start = U(0.5,0.9) should lie above least = 0.6"),
    ("{start = 0.9, drift = 0}", "drift should be a number in [-1, 1] other than 0"),
    ("{start = 0.9, drift = -0.1, most = 1}", "unknown key most: "),
    ("{start = 0.9}", "drift is missing"),
    ("{start = 0.9, drift = -0.1, lest = 0.5}", "did you mean 'least'?"),
    ("{black = {start = 0.9, drift = -0.1}, white = 0.8}", "black and white cannot drift"),
    ("{black = 0.9, grey = 0.8}", "an accuracy table has the keys black and white, or start and drift"),
])  # fmt: skip
def test_what_is_wrong_of_a_drift_is_named(accuracy, due, said):
    found = said(RING, swarm=f"accuracy = {accuracy}")
    assert due in found
    assert f"swarm.accuracy = {accuracy}"[:25] in found


def test_beliefs_do_not_drift_and_cases_are_checked(said):
    belief = "accuracy = 0.8\nassumed_accuracy = {start = 0.8, drift = -0.1}"
    assert "swarm.assumed_accuracy = " in said(RING, swarm=belief)
    assert "case[0].fill_ratio = " in said(RING + "[[case]]\nfill_ratio = {from = 0.9, to = 0.1, at = 200}\n")


def test_times_count_ticks(tmp_path):
    change, world = {"from": 0.9, "to": 0.1, "at": "2 s", "until": "0.1 min"}, {"topology": "moving", "density": 8}
    made = changing(change, world=world)
    (setting,) = made.settings()
    assert str(setting.change) == "0.9 to 0.1 at 20 until 60"
    assert sc.Study.parse(made.text).settings() == [setting]
    cased = changing(0.3, world=world, case=[{"fill_ratio": change}])
    assert str(cased.settings()[1].change) == "0.9 to 0.1 at 20 until 60"
