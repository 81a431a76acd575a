"""Plans with liars, several networks, densities and accuracies: each world apart, the worst of what is not known."""

from dataclasses import replace

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.figures.plan_lines import draw_plan
from swarmcensus.search.planning.areas import capacity, fewest
from swarmcensus.search.planning.mission import missions_of
from swarmcensus.search.planning.predictions import predict, readings_needed, with_worst_accuracy, worst_fill_ratios
from swarmcensus.search.planning.search import Search
from swarmcensus.studies.assignments import with_values
from swarmcensus.worlds import Body, arena

QUIET = {"progress": lambda _: None}
RING = {
    "trials": 100,
    "swarm": {"robots": 10, "accuracy": 0.7},
    "world": {"topology": "ring", "fill_ratio": 0.55},
    "wanted": {"error": 0.05},
}


def changed(**values):
    return with_values(RING, values)


def mission_of(tables):
    [mission] = missions_of(tables)
    return mission


def liars(share=0.2, lie="shouter"):
    return [{"robots": share, "brain": lie, "honest": False}]


def among_liars(share=0.2, lie="shouter", **values):
    return changed(members=liars(share, lie), **({"brain": "steadfast"} | values))


def test_numbers_of_liars_and_of_robots_that_fail_are_those_of_the_study():
    for lying, failing in ((0.1, 0.0), (0.3, 0.6), (0.1, 0.9)):
        fault = {"at": 1, "robots": failing, "stop": "sensing"}
        mission = mission_of(among_liars(lying, faults=[fault] if failing else []))
        for robots in (5, 7, 10, 30):
            gone, fails = mission.lying(robots), mission.failing(robots)
            assert gone == round(lying * robots)
            assert fails == min(round(failing * robots), robots - gone - 1)


def test_which_brains_are_compared_depends_on_liars():
    lying = mission_of(changed(members=liars(0.1)))
    told = [[b.name for b in mission.study.swarm.brain] for mission in (mission_of(RING), lying)]
    assert told == [["commons", "minimalistic"], ["steadfast", "minimalistic"]]
    assert [lie.name for lie in lying.lies] == ["shouter"]
    assert mission_of(RING).lies == []


@pytest.mark.long
def test_a_world_is_planned_as_if_it_were_alone():
    several = sc.plan(changed(topology=["ring", "full", "moving"], brain="commons", density=[5, 10]), **QUIET)
    assert [(row.topology, row.density) for row in several.needs] == [
        ("ring", None), ("full", None), ("moving", 5.0), ("moving", 10.0),
    ]  # fmt: skip
    for row in several.needs:
        world = {"topology": row.topology, "truth": "floor" if row.density else "nominal"}
        world |= {"density": row.density} if row.density else {}
        assert sc.plan(changed(brain="commons", **world), **QUIET).needs == [replace(row, world={})]


def test_the_fewest_and_the_most_robots_have_room_to_move():
    for density in (0.1, 10.0, 30.0, 44.0):
        world = mission_of(changed(topology="moving", density=density, robots={"choose": [20, 30]}))
        least = fewest(density, world.body)
        assert density <= arena.largest_density(least, world.body)
        assert least == 1 or density > arena.largest_density(least - 1, world.body)
    most = capacity(2, body := Body())
    assert arena.smallest_side(most, body) <= 2 < arena.smallest_side(most + 1, body)


def test_the_smallest_swarm_at_a_density_brings_its_area_along():
    values = {"robots": {"choose": [4, 16]}, "minutes": 0.15, "density": 10, "brain": "commons", "trials": 40}
    found = sc.plan({}, set=values | {"accuracy": 0.8, "fill_ratio": 0.55, "error": 0.1}, **QUIET)
    [row] = found.needs
    assert found.question == "how many"
    assert row.side == pytest.approx(arena.side(row.robots, 10, found.mission.body))


def test_of_several_accuracies_the_worst_is_planned_for():
    given = ["U(0.6, 0.8)", 0.65, {"black": 0.9, "white": 0.7}, "N(0.75, 0.05)", 0.75]
    alone = [mission_of(changed(accuracy=one)) for one in given]
    needs = [readings_needed(mission, worst_fill_ratios(mission)[0]) for mission in alone]
    [chosen] = with_worst_accuracy(missions_of(changed(accuracy={"worst": given})))
    assert chosen.accuracy == alone[int(np.argmax(needs))].accuracy
    assert str(chosen.accuracy) == "0.65"
    both, single = (sc.plan(changed(accuracy=one), **QUIET) for one in ({"worst": [0.75, 0.65]}, 0.65))
    assert both.needs == single.needs


def test_worlds_and_lies_are_in_the_rows():
    [row] = sc.plan(among_liars(trials=40), **QUIET).rows
    assert (row["topology"], row["accuracy"], row["lie"], row["density"]) == ("ring", "0.7", "shouter", None)
    moving = mission_of(changed(topology="moving", density=4))
    assert Search(moving, 1, QUIET["progress"]).predict(10).alone > 1


def test_a_figure_has_a_line_a_brain_and_world():
    found = sc.plan(changed(topology=["ring", "full"], robots={"choose": [5, 6]}, trials=40), **QUIET)
    [axes] = draw_plan(found).axes[:1]
    lines = [line for line in axes.get_lines() if line.get_linestyle() == "-" and line.get_marker() in ("None", None)]
    assert len(lines) == 4
    assert len({line.get_color() for line in lines}) == 2  # of worlds; markers are of brains
    for line in lines:
        assert len(line.get_xdata()) == 2


@pytest.mark.long
def test_of_several_lies_the_worst_is_planned_for():
    """An interval of times errs in one plan of 20, and the share of 400 other trials by 0.02 in one of a hundred."""
    rows = {}
    for lie in ("opposite", "jammer", {"worst": ["opposite", "jammer"]}):
        [rows[str(lie)]] = sc.plan(among_liars(lie=lie), **QUIET).needs
    *alone, both = rows.values()
    worst = max(alone, key=lambda row: row.minutes)
    assert (both.minutes, both.lie) == (worst.minutes, worst.lie)
    row = rows["opposite"]
    for minutes, low, high in ((row.minutes_low, 0.0, 0.97), (row.minutes_high, 0.93, 1.0)):
        data = sc.run(sc.Study(
            trials=400, seed=991, swarm={"robots": 10, "accuracy": 0.7, "brain": "steadfast"},
            world={"fill_ratio": 0.55, "topology": "ring"}, schedule={"rounds": round(minutes * 60)},
            members=[{"robots": 2, "brain": "opposite", "honest": False}],
        ), jobs=2)  # fmt: skip
        assert low <= (np.abs(data["final_estimate"].values - 0.55) <= 0.05).mean() <= high


@pytest.mark.long
def test_liars_may_do_most_harm_inside_the_range():
    """At 0.9 min ten robots of which two lie are right at 0.3, 0.5 and 0.7, and in only 70 % near 0.43."""
    values = {"fill_ratio": {"worst": [0.3, 0.7]}, "topology": "full", "minutes": 0.9, "trials": 40}
    [row] = sc.plan(among_liars(lie="opposite", **values), **QUIET).needs
    assert row.answer == "not reached"
    assert row.fill_ratio not in (0.3, 0.5, 0.7)
    assert row.share.high < 0.95


@pytest.mark.long
def test_an_oracle_hears_no_liar():
    [row] = sc.plan(among_liars(brain="oracle"), **QUIET).needs
    assert row.answer == "reached"
    assert row.minutes_low <= 1.2 * row.theory.pooled


def test_theory_is_of_the_others_as_if_nobody_lied():
    honest, lying = mission_of(RING), mission_of(changed(members=liars(0.5)))
    assert predict(lying, 10, 1000.0).pooled == pytest.approx(2 * predict(honest, 10, 1000.0).pooled)
    assert predict(lying, 10, 1000.0).alone == predict(honest, 10, 1000.0).alone
