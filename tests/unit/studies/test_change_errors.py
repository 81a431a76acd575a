"""Changes and drifts that cannot be: each is named in one sentence, through the command line."""

from pathlib import Path

import pytest

import swarmcensus as sc
from tests.support.small import changing

RING = '[world]\ntopology = "ring"\nfill_ratio = {fill}\n[schedule]\nrounds = [50, 100]\n'
MOVING = '[world]\ntopology = "moving"\ndensity = 8\nfill_ratio = {fill}\n[schedule]\nticks = 100\n'


@pytest.fixture
def said(refused):
    """What the command line says of a study: a function of its world, fill ratio and swarm."""

    def said(world, fill="0.3", swarm="accuracy = 0.8"):
        Path("s.toml").write_text(f"trials = 1\n[swarm]\nrobots = 4\n{swarm}\n{world.replace('{fill}', fill)}")
        return refused("run", "s.toml")

    return said


@pytest.mark.parametrize(
    ("fill", "due"),
    [
        ("{from = 0.9, to = 0.1, at = 100}", "at = 100 should be before the last round, 100"),
        ("{from = 0.9, to = 0.1, at = 20, until = 19}", "world.fill_ratio.until = 19 comes before at = 20"),
        ("{from = 0.9, to = 0.9, at = 20}", "from and to are both 0.9"),
        ("{from = 0.9, to = 0.1, at = 1}", "at should be a whole number from 2"),
        ("{from = 0.9, to = 0.1, at = 20, til = 30}", "unknown key til: did you mean 'until'?"),
        ("{from = 0.9, at = 20}", "to is missing"),
        ('{from = 0.9, to = 0.1, at = "5 min"}', "the rounds of fixed networks have no"),
        ("[0.5, {from = 0.9, to = 2, at = 20}]", "world.fill_ratio[1] = "),
    ],
)
def test_what_is_wrong_of_a_change_is_named(fill, due, said):
    assert due in said(RING, fill)


@pytest.mark.parametrize(
    ("accuracy", "due"),
    [
        ("{start = 0.6, drift = -0.01, least = 0.6}", "start = 0.6 should lie above least = 0.6"),
        ('{start = "U(0.5, 0.9)", drift = -0.01, least = 0.6}', "start = U(0.5,0.9) should lie above least = 0.6"),
        ("{start = 0.9, drift = 0}", "drift = 0 is no drift"),
        ("{start = 0.9, drift = -0.1, most = 1}", "most means nothing if the drift is below 0"),
        ("{start = 0.9}", "drift is missing"),
        ("{start = 0.9, drift = -0.1, lest = 0.5}", "did you mean 'least'?"),
        ("{black = {start = 0.9, drift = -0.1}, white = 0.8}", "black and white cannot drift"),
        ("{black = 0.9, grey = 0.8}", "an accuracy table has the keys black and white, or start and drift"),
    ],
)
def test_what_is_wrong_of_a_drift_is_named(accuracy, due, said):
    found = said(RING, swarm=f"accuracy = {accuracy}")
    assert due in found
    assert f"swarm.accuracy = {accuracy}"[:25] in found


def test_beliefs_do_not_drift_and_cases_are_checked(said):
    belief = "accuracy = 0.8\nassumed_accuracy = {start = 0.8, drift = -0.1}"
    assert "swarm.assumed_accuracy = " in said(RING, swarm=belief)
    case = RING + "[[case]]\nfill_ratio = {from = 0.9, to = 0.1, at = 200}\n"
    assert "case[0].fill_ratio = " in said(case)


@pytest.mark.parametrize(
    ("when", "due"),
    [
        ('at = "0.1 s"', 'at = "0.1 s": that is 1 ticks of 0.1 s: should be a whole number from 2, such as "0.2 s"'),
        ('at = "1 h"', 'at = "1 h" (36,000 ticks) should be before the last round, 100'),
        ('at = 2, until = "0 s"', 'until = "0 s": that is 0 ticks of 0.1 s'),
        ('at = "2 s", until = "1 s"', 'until = "1 s" (10 ticks) comes before at = "2 s" (20 ticks)'),
    ],
)
def test_times_are_shown_as_the_file_has_them(when, due, said):
    found = said(MOVING, "{from = 0.9, to = 0.1, " + when + "}")
    assert due in found
    assert "36000}" not in found


def test_times_count_ticks(tmp_path):
    change = {"from": 0.9, "to": 0.1, "at": "2 s", "until": "0.1 min"}
    (setting,) = changing(change, world={"topology": "moving", "density": 8}).settings()
    assert str(setting.change) == "0.9 to 0.1 at 20 until 60"
    made = sc.Study.parse(changing(change, world={"topology": "moving", "density": 8}).text)
    assert made.settings() == [setting]
    cased = changing(0.3, world={"topology": "moving", "density": 8}, case=[{"fill_ratio": change}])
    assert str(cased.settings()[1].change) == "0.9 to 0.1 at 20 until 60"
