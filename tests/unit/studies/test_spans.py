"""Keys of topologies, floors and distributions that have lists: they span the grid, and are coordinates."""

from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.analysis import compare
from swarmcensus.studies import addresses
from swarmcensus.summaries import where
from tests.support.second import changed
from tests.support.small import settings_of, study_of

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
    moves = {"ticks": 12, "robots": 5}
    spanned = study_of(floor=[{"clusters": [0.1, 0.2]}, "half"], **moves).settings()
    assert same(spanned, study_of(floor=[{"clusters": 0.1}, {"clusters": 0.2}, "half"], **moves).settings())
    assert [(str(s.floor), s.floor.parameters) for s in spanned] == [
        ("clusters", {"length": 0.1}), ("clusters", {"length": 0.2}), ("half", {}),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("key", "table", "listed"),
    [
        ("accuracy", {"black": [0.8, 0.9], "white": 0.7}, [{"black": b, "white": 0.7} for b in (0.8, 0.9)]),
        ("accuracy", {"start": 0.8, "drift": [-1e-3, 1e-3]}, [{"start": 0.8, "drift": d} for d in (-1e-3, 1e-3)]),
        ("accuracy", {"spread": "N", "mean": 0.7, "sd": [0.1, 0.2]}, ["N(0.7, 0.1)", "N(0.7, 0.2)"]),
        ("accuracy", {"spread": "uniform", "lo": [0.5, 0.6], "hi": 0.9}, ["U(0.5, 0.9)", "U(0.6, 0.9)"]),
        ("assumed_accuracy", {"error": [0.0, "N(0, 0.1)"]}, [{"error": 0.0}, {"error": "N(0, 0.1)"}]),
    ],
)
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
    assert "small-world, N = 12, accuracy 0.7, f = 0.55, neighbours = 6" in str(
        sc.Study.parse(data.attrs["study"]).settings()[2]
    )


def test_drifts_are_numbers_too():
    data = sc.run(study_of(rounds=4, trials=1, accuracy=[{"start": [0.8, 0.9], "drift": -0.01}, 0.7]), jobs=1)
    assert data["accuracy_drift"].values.tolist() == [-0.01, -0.01, 0.0]
    assert data["accuracy_black"].values.tolist() == [0.8, 0.9, 0.7]


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"topology": {**SMALL_WORLD, "neighbours": []}}, "neighbours = []: should be a list of at least one"),
        (
            {"topology": {"name": "small-world", "neighbours": [4] * 101, "rewired": [0.1] * 100}},
            "its lists have 10,100 combinations; 10,000 is the most",
        ),
        ({"topology": {**SMALL_WORLD, "neighbours": [4, 5]}}, "neighbours = 5: "),
        ({"topology": {"name": "small-world", "neighbors": [4, 6]}}, "has no key neighbors: did you mean 'neighbours'"),
        ({"topology": SMALL_WORLD, "brain": "mine.py"}, "neighbours cannot have a list here"),
        ({"topology": [SMALL_WORLD, {"name": "small-world", "neighbours": 6}]}, "have one name: small-world"),
        ({"accuracy": {"black": [], "white": 0.7}}, "black = []: should be a list of at least one"),
        ({"accuracy": {"spread": "N", "mean": 0.7}}, "N(mean, sd): missing a required argument: 'sd'"),
        ({"accuracy": {"spread": "N", "mean": 0.7, "ds": 0.1}}, "N(mean, sd): "),
        ({"accuracy": {"spread": "N", "mean": "x", "sd": 0.1}}, "a sensor accuracy is a number in [0, 1]"),
        ({"accuracy": {"spread": "Q", "mean": 0.7}}, "a sensor accuracy is a number in [0, 1]"),
    ],
)
def test_wrong_lists_are_refused(keys, said, here):
    Path("mine.py").write_text(changed(("MEMORY =", 'PARAMETERS = {"neighbours": 1.0}\nMEMORY =')))
    with pytest.raises(sc.InputError) as refused:
        study_of(robots=12, **keys)
    assert said in str(refused.value)
