"""Lists in tables, which span the grid and are coordinates; labels of members and floors."""

import re
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.analysis import compare
from swarmcensus.studies import addresses
from swarmcensus.summaries import where
from swarmcensus.summaries.table_of_summary import Summary, coordinates
from swarmcensus.worlds.patterns import parse_floors
from tests.support.second import changed
from tests.support.small import moving_of, settings_of, study_of

BROKEN = {"robots": [0, 0.25], "accuracy": 0.5}
SMALL_WORLD = {"name": "small-world", "neighbours": [4, 6]}
TAKES_A_LIST = '"""Edges as given."""\n\n\ndef edges(robots, *, ends: list[int] = (0, 1), by=1):\n    return [ends]\n'


def same(spanned, listed):
    """Whether two lists of settings have the same numbers."""
    marks = [[addresses.fingerprint(setting, 3) for setting in settings] for settings in (spanned, listed)]
    return marks[0] == marks[1] and len({*marks[0]}) == len(marks[0])


def test_lists_of_a_topology_span_the_settings_of_a_list_of_tables():
    one = {**SMALL_WORLD, "rewired": [0.1, 0.5]}
    tables = [{"name": "small-world", "neighbours": n, "rewired": p} for n in (4, 6) for p in (0.1, 0.5)]
    assert same(settings_of(robots=12, topology=one), settings_of(robots=12, topology=tables))


def test_lists_of_a_floor_span_the_settings_of_a_list_of_tables():
    lists = [{"clusters": [0.1, 0.2]}, "half"], [{"clusters": 0.1}, {"clusters": 0.2}, "half"]
    spanned, listed = (study_of(floor=floors, ticks=12, robots=5).settings() for floors in lists)
    assert same(spanned, listed)
    found = [("clusters", {"length": 0.1}), ("clusters", {"length": 0.2}), ("half", {})]
    assert [(str(s.floor), s.floor.parameters) for s in spanned] == found


@pytest.mark.parametrize(("key", "table", "listed"), [
    ("accuracy", {"black": [0.8, 0.9], "white": 0.7}, [{"black": b, "white": 0.7} for b in (0.8, 0.9)]),
    ("accuracy", {"start": 0.8, "drift": [-1e-3, 1e-3]}, [{"start": 0.8, "drift": d} for d in (-1e-3, 1e-3)]),
    ("accuracy", {"spread": "N", "mean": 0.7, "sd": [0.1, 0.2]}, ["N(0.7, 0.1)", "N(0.7, 0.2)"]),
    ("accuracy", {"spread": "uniform", "lo": [0.5, 0.6], "hi": 0.9}, ["U(0.5, 0.9)", "U(0.6, 0.9)"]),
    ("assumed_accuracy", {"error": [0.0, "N(0, 0.1)"]}, [{"error": 0.0}, {"error": "N(0, 0.1)"}]),
])  # fmt: skip
def test_lists_of_a_distribution_span_the_settings_of_a_list_of_values(key, table, listed):
    assert same(settings_of(**{key: table}), settings_of(**{key: listed}))


def test_a_list_that_a_key_takes_stays_one_value(here):
    Path("mine.py").write_text(TAKES_A_LIST)
    (alone,) = settings_of(topology={"file": "mine.py", "ends": [0, 2]})
    assert alone.topology.parameters == {}
    two = settings_of(topology={"file": "mine.py", "ends": [[0, 2], [1, 2]]})
    assert [s.topology.parameters for s in two] == [{"ends": "[0,2]"}, {"ends": "[1,2]"}]
    (untyped,) = settings_of(topology={"file": "mine.py", "by": [1, 2]})  # it may well take lists
    assert dict(untyped.topology.keys)["by"] == (1, 2)
    (graph,) = settings_of(robots=6, topology={"networkx": "circulant_graph", "offsets": [1, 2]})
    assert graph.topology.parameters == {}


def test_they_are_coordinates_by_which_settings_are_chosen_and_compared():
    data = sc.run(study_of(robots=12, rounds=5, trials=3, topology=["ring", SMALL_WORLD]), jobs=1)
    assert data["topology"].values.tolist() == ["ring", "small-world", "small-world"]
    np.testing.assert_array_equal(data["neighbours"], [np.nan, 4, 6])
    assert where(data, "neighbours > 4")["setting"].values.tolist() == [2]
    assert compare(data, factor="neighbours").contenders == ["neighbours=4", "neighbours=6"]
    assert sc.plot.lines(data, x="neighbours", y="final_error").axes[0].get_xlabel() == "neighbours"
    assert sc.verify(data).labels == sc.verify(data).differences == []
    third = sc.Study.parse(data.attrs["study"]).settings()[2]
    assert "small-world, N = 12, accuracy 0.7, f = 0.55, neighbours = 6" in str(third)


def test_drifts_are_numbers_too():
    data = sc.run(study_of(rounds=4, trials=1, accuracy=[{"start": [0.8, 0.9], "drift": -0.01}, 0.7]), jobs=1)
    assert data["accuracy_drift"].values.tolist() == [-0.01, -0.01, 0.0]
    assert data["accuracy_black"].values.tolist() == [0.8, 0.9, 0.7]


@pytest.mark.parametrize(("keys", "said"), [
    ({"topology": {**SMALL_WORLD, "neighbours": []}}, "neighbours = []: should be a list of at least one"),
    ({"topology": {"name": "small-world", "neighbours": [4] * 101, "rewired": [0.1] * 100}},
     "its lists have 10,100 combinations; 10,000 is the most"),
    ({"topology": {**SMALL_WORLD, "neighbours": [4, 5]}}, "neighbours = 5: "),
    ({"topology": {"name": "small-world", "neighbors": [4, 6]}}, "has no key neighbors: did you mean 'neighbours'"),
    ({"topology": SMALL_WORLD, "brain": "mine.py"}, "neighbours cannot have a list here"),
    ({"topology": [SMALL_WORLD, {"name": "small-world", "neighbours": 6}]}, "have one name: small-world"),
    ({"accuracy": {"black": [], "white": 0.7}}, "black = []: should be a list of at least one"),
    ({"accuracy": {"spread": "N", "mean": 0.7}}, "N(mean, sd): missing a required argument: 'sd'"),
    ({"accuracy": {"spread": "N", "mean": 0.7, "ds": 0.1}}, "N(mean, sd): "),
    ({"accuracy": {"spread": "N", "mean": "x", "sd": 0.1}}, "a sensor accuracy is a number in [0, 1]"),
    ({"accuracy": {"spread": "Q", "mean": 0.7}}, "a sensor accuracy is a number in [0, 1]"),
    ({"members": [{**BROKEN, "label": "a"}, {**BROKEN, "label": "a"}]}, 'members[1].label = "a": two tables'),
    ({"members": [{**BROKEN, "label": "a\nb"}]}, "members[0].label = "),
    ({"floor": ["half", {"name": "tiles", "label": "half"}]}, '"half": this label is the name of another topology'),
    ({"floor": [{"clusters": 0.2, "label": ""}]}, "label should be a text, and not empty"),
    ({"floor": [{"name": "moon", "label": "x"}]}, "a floor is one of"),
])  # fmt: skip
def test_wrong_lists_and_labels_are_refused(keys, said, here):
    Path("mine.py").write_text(changed(("MEMORY =", 'PARAMETERS = {"neighbours": 1.0}\nMEMORY =')))
    world = {"topology": "moving", "density": 1.0} if "floor" in keys else {}
    with pytest.raises(sc.InputError, match=re.escape(said)):
        study_of(robots=12, **world, **keys)


# ---- labels of members and floors, and the word for swarms without members
def texts(members, **keys):
    return ["; ".join(map(str, setting.members)) for setting in settings_of(robots=8, members=members, **keys)]


def test_a_label_stands_for_how_members_differ_and_changes_no_number():
    plain, labelled = (settings_of(robots=8, members=[{**BROKEN, **more}]) for more in ({}, {"label": "broken"}))
    assert plain == labelled
    assert [addresses.fingerprint(s, 0) for s in plain] == [addresses.fingerprint(s, 0) for s in labelled]
    assert [str(s.members[0]) for s in (plain[1], labelled[1])] == ["0.25 accuracy 0.5", "0.25 broken"]
    assert "25 % of robots broken" in str(labelled[1])


def test_a_label_leaves_what_the_table_spans_and_who_lies():
    spanned = [{"robots": 2, "accuracy": [0.5, 0.6], "label": "worn"}]
    assert texts(spanned) == ["2 worn, accuracy 0.5", "2 worn, accuracy 0.6"]
    assert texts([{"robots": 2, "accuracy": 0.5, "honest": False, "label": "odd"}]) == ["2 odd, not honest"]


@pytest.mark.parametrize("floor", ["half", {"clusters": 0.2}, {"benchmark": "star", "cells": 10}])
def test_a_label_names_a_floor_and_changes_no_number(floor):
    table = {"name": floor} if isinstance(floor, str) else floor
    plain, labelled = (moving_of(robots=5, floor=value) for value in (floor, {**table, "label": "mine"}))
    assert plain == labelled
    assert addresses.fingerprint(plain, 0) == addresses.fingerprint(labelled, 0)
    assert (str(labelled.floor), labelled.floor.name) == ("mine", str(plain.floor))
    assert "floor mine" in str(labelled)
    assert str(*parse_floors(labelled.floor.form, None, {})) == "mine"


def test_a_swarm_without_members_is_plain_wherever_it_is_shown():
    bad = [{**BROKEN, "label": "bad"}]
    study = study_of(robots=8, rounds=4, trials=2, brain=["commons", "minimalistic"], members=bad)
    data = sc.run(study, jobs=1)
    assert data["members"].values.tolist() == ["", "0.25 bad"] * 2
    assert coordinates(data)["members"].tolist() == ["plain", "0.25 bad"] * 2
    assert [row["members"] for row in Summary(data, data).rows] == ["plain", "0.25 bad"] * 2
    assert [world["members"] for world in compare(data).grid.worlds] == ["plain", "0.25 bad"]
    assert where(data, 'members == "plain"')["setting"].values.tolist() == [0, 2]
    assert compare(data, factor="members").contenders == ["plain", "0.25 bad"]
    assert sc.plot.lines(data, x="robots", cols="members").axes[0].get_title(loc="left") == "(a) plain"
    assert sc.verify(data, 1).labels == []


def test_one_label_of_two_kinds_of_members_keeps_studies_apart():
    parts = [{"robots": 2, "accuracy": accuracy, "label": "bad"} for accuracy in (0.5, 0.6)]
    runs = [sc.run(study_of(robots=8, rounds=4, trials=1, members=[one]), jobs=1) for one in parts]
    with pytest.raises(sc.InputError, match="members '2 bad': the label of members that differ"):
        sc.merge(runs)
