"""Figures against the number of liars, and of coordinates that follow from the axes."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.figures.coordinates import panels_of, varies
from swarmcensus.support.errors import InputError

pytestmark = pytest.mark.interpreted

CHANGES = [{"from": 0.9, "to": 0.55, "at": 5}, {"from": 0.6, "to": 0.15, "at": 5}]


def liars(**tables):
    members = [{"robots": [0, 1, 2], "brain": ["always-black", "opposite"], "honest": False}]
    given = {
        "trials": 7, "swarm": {"robots": 8, "accuracy": 0.8, "brain": ["minimalistic", "legacy"]},
        "world": {"topology": "ring", "fill_ratio": 0.3}, "schedule": {"rounds": 10}, "members": members,
    }  # fmt: skip
    return sc.run(sc.Study(**given | tables), jobs=1)


@pytest.fixture(scope="module")
def data():
    return liars()


def lines_in(axes):
    """The points of each line, whose stretches may differ in their dashes."""
    found = {}
    for line in axes.lines:
        if line.get_label().startswith("line "):
            points = found.setdefault(line.get_label().removeprefix("line "), {})
            points |= dict(line.get_xydata().tolist())
    return found


def shown(figure):
    return [axes for axes in figure.axes if lines_in(axes)]


@pytest.mark.long
def test_lines_against_liars_begin_at_zero_liars(data):
    figure = sc.plot.lines(data, x="liars", y="final_estimate")
    panels = shown(figure)
    assert [axes.get_title(loc="left") for axes in panels] == ["(a) Minimalistic (paper)", "(b) Legacy (paper)"]
    for axes, brain in zip(panels, ("minimalistic", "legacy"), strict=True):
        found = lines_in(axes)
        assert [*found] == ["always-black", "opposite"]
        for name, line in found.items():
            assert [*line] == [0.0, 1.0, 2.0]
            for many, y in line.items():
                rows = (data["brain"] == brain) & (data["liars"] == many) & data["adversary"].isin(["", name])
                assert y == np.nanmedian(data["final_estimate"].values[rows.values])


@pytest.fixture(scope="module")
def grid():
    return liars(
        swarm={"robots": 8, "accuracy": 0.8},
        world={"topology": "ring", "fill_ratio": CHANGES},
        members=[{"robots": [0, 2], "brain": "opposite", "honest": False}],
    )


def test_what_follows_from_the_axes_does_not_vary_too(grid):
    assert list(varies(grid, {"adversary"})) == ["fill_ratio", "fill_ratio_change", "liars"]
    assert varies(grid, {"adversary", "fill_ratio_change"}) == {}
    assert len(panels_of(grid, ("adversary", "fill_ratio_change"))) == 1
    error, rounds = sc.plot.heatmap(grid, x="adversary", y="fill_ratio_change").axes
    cells = np.asarray(error.images[0].get_array())
    assert cells.shape == np.asarray(rounds.images[0].get_array()).shape == (2, 2)
    medians = [np.nanmedian(grid["convergence_error"].values[k]) for k in range(4)]
    assert sorted(cells.ravel()) == pytest.approx(sorted(medians))


def test_what_does_not_follow_from_the_axes_still_varies(data, grid):
    assert list(varies(data, {"adversary", "brain"})) == ["liars"]  # one of them, or two
    rows = sc.plot.heatmap(data, x="adversary", y="brain", z="final_error").axes
    assert [axes.get_title("left").split("\n")[0] for axes in rows] == ["(a) 0 liars", "(b) 1 liars", "(c) 2 liars"]
    with pytest.raises(InputError, match="fill_ratio_change vary too"):
        sc.plot.heatmap(grid, x="adversary", y="liars", cols=[])
