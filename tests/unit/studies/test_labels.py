"""Labels of members and floors, and the word for swarms without members."""

import pytest

import swarmcensus as sc
from swarmcensus.analysis import compare
from swarmcensus.studies import addresses
from swarmcensus.summaries import where
from swarmcensus.summaries.table_of_summary import Summary, coordinates
from swarmcensus.worlds.patterns import parse_floors
from tests.support.small import moving_of, settings_of, study_of

BROKEN = {"robots": [0, 0.25], "accuracy": 0.5}


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


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"members": [{**BROKEN, "label": "a"}, {**BROKEN, "label": "a"}]}, 'members[1].label = "a": two tables'),
        ({"members": [{**BROKEN, "label": "a\nb"}]}, "members[0].label = "),
        (
            {"floor": ["half", {"name": "tiles", "label": "half"}]},
            '"half": this label is the name of another topology or floor',
        ),
        ({"floor": [{"clusters": 0.2, "label": ""}]}, "label should be a text, and not empty"),
        ({"floor": [{"name": "moon", "label": "x"}]}, "a floor is one of"),
    ],
)
def test_wrong_labels_are_refused(keys, said):
    world = {"topology": "moving", "density": 1.0} if "floor" in keys else {}
    with pytest.raises(sc.InputError) as refused:
        study_of(robots=8, **world, **keys)
    assert said in str(refused.value)


def test_a_swarm_without_members_is_plain_wherever_it_is_shown():
    study = study_of(
        robots=8, rounds=4, trials=2, brain=["commons", "minimalistic"], members=[{**BROKEN, "label": "bad"}]
    )
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
