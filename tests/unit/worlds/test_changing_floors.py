"""Floors whose fill ratio changes: which tiles turn, and what is drawn of them."""

import itertools

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.figures.kinds.arena import Arena
from swarmcensus.figures.kinds.curves import curves
from swarmcensus.figures.kinds.film import film
from swarmcensus.figures.one_trial import FLOOR, TURNS, scene_of
from swarmcensus.simulation import sampling
from swarmcensus.studies import addresses
from swarmcensus.worlds import patterns
from swarmcensus.worlds.changes import Change, along
from swarmcensus.worlds.ground import Ground
from tests.support.places import EXAMPLE
from tests.support.small import SEED, SLOW, SWITCH, changing, moving_of

IMAGE = str(EXAMPLE / "leaves.png")


@pytest.mark.parametrize(
    "kind", ["tiles", "half", {"clusters": 0.2}, {"stripes": 0.5}, {"image": IMAGE}, {"image": IMAGE, "mode": "dither"}]
)
def test_as_few_tiles_turn_as_can(kind):
    """Black tiles of less are among those of more; each floor is that of its fill ratio, and so is its true share."""
    world = {"density": 8.0, "floor": kind}
    setting = moving_of(ticks=50, fill_ratio={"from": 0.7, "to": 0.2, "at": 11, "until": 40}, **world)
    ground = sampling.ground(setting, SEED, 1)
    tiles, turns = ground.all_tiles().astype(bool), ground.turns()
    floors = [tiles ^ (tick >= turns) for tick in range(1, 51)]
    assert all((later <= earlier).all() for earlier, later in itertools.pairwise(floors))
    for tick in (1, 10, 11, 25, 40, 50):
        fill = float(along(setting.change.course, tick))
        same = Ground(setting.floor, setting.body, setting.arena_side, fill, addresses.floor_key(setting, SEED), 1)
        assert (same.all_tiles().astype(bool) == floors[tick - 1]).all()
        assert same.true_fill_ratio == ground.truth(tick)
        place = np.stack(np.meshgrid(np.arange(-5, 5), np.arange(-5, 5)), axis=-1).reshape(1, -1, 2).astype(np.int32)
        assert (same.colours(place) == ground.colours(place, tick)).all()
    rising = sampling.ground(
        moving_of(ticks=50, fill_ratio={"from": 0.0, "to": 1.0, "at": 11, "until": 40}, **world), SEED, 1
    )
    assert not rising.all_tiles().any()
    assert (rising.turns() >= 11).all()
    assert (rising.turns() <= 40).all()
    assert rising.truth([1, 10, 40, 99]).tolist() == [0.0, 0.0, 1.0, 1.0]


def test_figures_show_the_truth_and_the_floor_of_the_moment(tmp_path):
    world = {"topology": "moving", "density": 8}
    results = sc.run(changing([SLOW, 0.25], {"start": 0.9, "drift": -0.002}, world))
    figure = curves(results, setting=0)
    (truth,) = [line for line in figure.axes[0].lines if line.get_label() == "truth"]
    assert truth.get_ydata() == pytest.approx(along(Change(0.85, 0.25, 31, 71).course, np.arange(101)))
    trace = scene_of(results, 0)
    ground = sampling.ground(changing(SLOW, {"start": 0.9, "drift": -0.002}, world).settings()[0], 7, 0)
    arena = Arena(trace)
    for tick in (5, 50, 100):
        arena.show(tick)
        drawn = np.asarray(arena.image.get_array())
        assert (drawn < 0.9).mean() == pytest.approx(float(ground.truth(tick)), abs=0.05)
        assert f"true f = {float(along(Change(0.85, 0.25, 31, 71).course, tick)):.4g}" in [
            text.get_text() for text in arena.bar.get_yticklabels()
        ]
    assert len(arena.axes.child_axes) == 1
    assert arena.paint(100) is False
    empty = Arena(trace.drop_vars([FLOOR, TURNS]))
    before = empty.axes.get_facecolor()
    empty.show(100)
    assert empty.axes.get_facecolor() != before
    assert film(trace, out=tmp_path / "f.gif", first=29, last=33) == 3


def test_a_floor_that_cannot_tell_which_tiles_turn_is_refused(tmp_path, monkeypatch):
    module = patterns.PLUGINS.module("stripes")
    monkeypatch.delattr(module, "level")
    with pytest.raises(sc.InputError, match=r"world.floor = \{stripes"):
        changing(SWITCH, world={"topology": "moving", "density": 8, "floor": {"stripes": 0.5}})
