"""Accuracies: their forms, their canonical text, their draws; and robots that fail."""

import itertools
import re
import tomllib

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.engine.constants import NEVER, PARTS, SENSING, TALKING
from swarmcensus.engine.failures import works
from swarmcensus.simulation import sampling
from swarmcensus.studies import addresses
from swarmcensus.worlds import distributions, sensors
from swarmcensus.worlds.faults import Fault, for_an_oracle, outages, stops


@pytest.mark.parametrize(("value", "text"), [
    (0.675, "0.675"), (1, "1.0"), ("0.5", "0.5"), ("U(0.525, 0.975)", "U(0.525,0.975)"),
    (" N ( 0.75 , 0.1 ) ", "N(0.75,0.1)"), ({"black": 0.9, "white": 0.6}, "black=0.9 white=0.6"),
    ({"black": "U(0.5,1)", "white": 1}, "black=U(0.5,1.0) white=1.0"),
])  # fmt: skip
def test_forms(value, text):
    accuracy = sensors.parse_accuracy(value)
    assert str(accuracy) == text
    assert sensors.parse_accuracy(accuracy) is accuracy
    assert sensors.parse_accuracy(accuracy.form) == accuracy


@pytest.mark.parametrize(("value", "text"), [(0.1, "error=0.1"), ("U(-1, 1)", "error=U(-1.0,1.0)"), (-1, "error=-1.0")])
def test_forms_of_errors(value, text):
    assumed = sensors.parse_assumed({"error": value})
    assert str(assumed) == text
    assert sensors.parse_assumed(assumed) is assumed
    assert sensors.parse_assumed(assumed.form) == assumed
    assert sensors.parse_assumed(0.7) == sensors.parse_accuracy(0.7)


@pytest.mark.parametrize("value", [1.1, -1.1, "U(0.5,0.2)", "U(-0.5,1.2)", "N(0,0)", "U(-2,0)", True, None, {}])
def test_what_is_no_error(value):
    with pytest.raises(ValueError, match=r"error|accuracy|needs"):
        sensors.parse_assumed({"error": value})


@pytest.mark.parametrize("value", [
    1.1, -0.1, "1.1", "U(0.9,0.6)", "U(0.5,1.5)", "N(0.5,0)", "N(2,1)", "N(0.5,inf)", "X(1,2)", "nan", float("nan"),
    None, True, [0.5], {"black": 0.9}, {"black": 0.9, "white": 0.6, "grey": 0.1}, "U(a,b)",
])  # fmt: skip
def test_what_is_refused(value):
    with pytest.raises(ValueError, match=r"accuracy|needs"):
        sensors.parse_accuracy(value)


@pytest.mark.parametrize(("value", "said"), [
    ("U(0.5)", r"U\(lo, hi\) needs 2 numbers, not 1"),
    ("N(0.5, 0.1, 0.2)", r"N\(mean, sd\) needs 2 numbers, not 3"),
    ("N()", r"N\(mean, sd\) needs 2 numbers, not 0"),
    ("U(0.9, 0.6)", r"U\(lo, hi\): it needs lo <= hi"),
    ("N(0.5, 0)", r"N\(mean, sd\): it needs sd > 0"),
    ("U(0.5, 1.5)", r"a sensor accuracy lies in \[0, 1\], and U\(0.5,1.5\) gives 1.5"),
    ("n(0.5, 0.1)", "did you mean 'N'. a sensor accuracy is a number"),
    ("unifrom(0.5, 0.6)", "did you mean 'uniform'. a sensor accuracy is"),
])  # fmt: skip
def test_a_wrong_distribution_is_refused(value, said):
    with pytest.raises(ValueError, match=said):
        sensors.parse_accuracy(value)


def test_a_spread_is_a_file_with_the_papers_letter():
    assert distributions.PLUGINS.shipped == ("measured", "normal", "uniform")
    assert sensors.parse_accuracy("uniform(0.5, 0.9)") == sensors.parse_accuracy("U(0.5,0.9)")
    assert not sensors.parse_accuracy({"black": "U(0.5, 0.9)", "white": "N(0.7, 0.1)"}).edition


def test_blindness():
    values = (0.5, {"black": 0.7, "white": 0.3}, 0.51, "U(0.5,0.5)")
    assert [sensors.parse_accuracy(value).is_blind for value in values] == [True, True, False, False]


# ---- robots that fail, on fixed networks and in motion
STUDY = """
seed = 3
trials = 3
faults = [{at = 20, robots = 3, stop = "STOP"}]
swarm = {brain = ["minimalistic", "legacy"], robots = 8, accuracy = 0.7}
world = {topology = ["full", "ring", "scale-free"], fill_ratio = 0.55}
schedule.rounds = 40
"""
MOVES = '"moving", density = 6, body.message_delay = 1'
MOVING = STUDY.replace('["full", "ring", "scale-free"]', MOVES).replace("rounds", "ticks")


@pytest.mark.parametrize(("fault", "said"), [
    ('{at = 0, robots = 3, stop = "sensing"}', "faults[0].at = 0"),
    ('{at = 5, robots = 9, stop = "sensing"}', "faults[0].robots = 9"),
    ('{at = 5, robots = 1.5, stop = "sensing"}', "a whole number of robots, or a fraction of the swarm in [0, 1]"),
    ('{at = 5, robots = 3, stop = "smiling"}', 'faults[0].stop = "smiling"'),
    ('{at = 5, robots = 3, stop = "sensing", until = 5}', "faults[0].until = 5"),
    ('{at = 5, robots = 3, stop = "sensing", until = 7.5}', "faults[0].until = 7.5"),
    ('{at = 5, robots = 3, stop = "moving"}', "these robots never move"),
    ('{at = 5, robots = 3, stops = "sensing"}', "unknown key faults[0].stops"),
])  # fmt: skip
def test_what_is_wrong_is_named(fault, said):
    with pytest.raises(sc.InputError, match=re.escape(said)):
        sc.Study.parse(STUDY.replace('{at = 20, robots = 3, stop = "STOP"}', fault))


# ---- faults that end
def test_rows_say_when_parts_work_by_definition():
    """Of overlapping spells, endless ones and none: at <= t < until of any fault means that the part does not work."""
    faults = (
        Fault(at=3, robots=3, stop=("sensing", "talking"), until=6),
        Fault(at=5, robots=0.5, stop="sensing", until=9),
        Fault(at=12, robots=2, stop="talking"),
        Fault(at=1, robots=0, stop="moving", until=4),
    )
    for trial in range(3):
        rows = stops(faults, 3, trial, 6)
        spells = outages(rows)
        assert rows.shape == (PARTS * (1 + 2 * 4), 6)
        assert spells.shape == (4, 2, PARTS, 6)
        for n, fault in enumerate(faults):
            alone = stops((*[Fault(at=1, robots=0, stop="moving")] * n, fault), 3, trial, 6)[:PARTS] == fault.at
            assert alone.sum() == len(fault.stop) * fault.count(6)
            assert (spells[n, 0] == np.where(alone, fault.at, NEVER)).all()
            assert (spells[n, 1] == np.where(alone, fault.until or NEVER, NEVER)).all()
        assert (rows[:PARTS] == spells[:, 0].min(axis=0)).all()
        for part, robot, tick in itertools.product(range(PARTS), range(6), range(1, 15)):
            due = not ((spells[:, 0, part, robot] <= tick) & (tick < spells[:, 1, part, robot])).any()
            assert works(rows, part, robot, tick) == due


def test_who_fails_is_who_failed_before_there_was_an_end():
    faults = [{"at": 20, "robots": 3, "stop": ["moving", "talking"]}]
    text = MOVING.replace('faults = [{at = 20, robots = 3, stop = "STOP"}]', "")
    both = [[faults[0] | more] for more in ({}, {"until": 30})]
    never, ends = (sc.Study(**tomllib.loads(text), faults=one).settings()[0] for one in both)
    assert (sampling.stops(never, 3, 1) == sampling.stops(ends, 3, 1)[:PARTS]).all()
    assert never.faults[0].content == {"at": 20, "robots": 3, "stop": ("moving", "talking")}
    assert addresses.fingerprint(never, 3) != addresses.fingerprint(ends, 3)
    assert addresses.walk_group(never) != addresses.walk_group(ends)


def test_oracle_hears_absent_robots_but_no_liars():
    found = np.full((PARTS * 3, 4), NEVER)
    found[[SENSING, PARTS + SENSING], 1] = 2
    found[2 * PARTS + SENSING, 1] = 5
    found[[TALKING, PARTS + TALKING], 2] = 3
    found[2 * PARTS + TALKING, 2] = 6
    heard = for_an_oracle(found, np.array([False, False, False, True]))
    for tick in range(1, 9):
        assert all(works(heard, TALKING, i, tick) for i in range(4))
        assert [works(heard, SENSING, i, tick) for i in range(4)] == [True, not 2 <= tick < 5, True, False]
