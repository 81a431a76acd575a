"""The figures show the data, all of it, and nothing else; and their files are whole."""

import itertools
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings, strategies as st
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.patches import Rectangle

import swarmcensus as sc
from swarmcensus.brains.library import TITLES
from swarmcensus.figures import plot as figures
from swarmcensus.figures.brain_colours import marks_of_brains
from swarmcensus.figures.columns import columns_grid
from swarmcensus.figures.coordinates import panels_of, varies
from swarmcensus.figures.kinds.scatter import scatter_grid
from swarmcensus.figures.page import width_of, wrapped
from swarmcensus.figures.styles import looks_of, palette
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import estimate
from tests.support.drawing import PAPER, assert_fits, drawn, forget, study, texts


def linear(colour: str) -> list[float]:
    return [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]


def luminance(colour: str) -> float:
    return float(np.dot([0.2126, 0.7152, 0.0722], linear(colour)))


# ---- looks
def test_looks_of_accuracies():
    looks = looks_of(["U(0.5,0.9)", "0.975", "0.6", "0.525", "N(0.75,0.1)", "black=0.9 white=0.6"], "o")
    assert list(looks) == ["0.525", "0.6", "0.975", "N(0.75,0.1)", "U(0.5,0.9)", "black=0.9 white=0.6"]
    spread = [look for look in looks.values() if look.spread]
    assert [look.name for look in spread] == ["N(0.75, 0.1)", "U(0.5, 0.9)", "b = 0.9, w = 0.6"]
    assert len({look.marker for look in spread}) == len({look.colour for look in looks.values()}) / 2 == 3
    assert spread[0].colour == "#000000"  # as in the paper
    many = looks_of([f"U(0.5,0.{i})" for i in range(6, 10)], "d").values()
    assert len({(look.colour, look.marker) for look in many}) == 4


def seen_without_green(colour: str) -> np.ndarray:
    """A colour as somebody with deuteranopia sees it, in CIELAB (Machado, Oliveira & Fernandes, 2009)."""
    cones = [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]]
    xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = (np.array(xyz) @ np.clip(np.array(cones) @ linear(colour), 0, 1)) / [0.9505, 1.0, 1.089]
    x, y, z = (np.cbrt(c) if c > 0.008856 else 7.787 * c + 16 / 116 for c in (x, y, z))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def test_brains_can_be_told_apart_without_green():
    mine = [f"{letter}.py" for letter in "dcab"]
    looks = looks_of([*TITLES, *mine], "o", "brain")
    seen = {look.colour: seen_without_green(look.colour) for look in looks.values()}
    assert all(np.linalg.norm(seen[one] - seen[other]) > 23 for one, other in itertools.combinations(seen, 2))
    assert len({look[2:5] for look in looks.values()}) == len(looks)
    assert len({looks[name].colour for name in [*TITLES][:11]}) == len(seen) - 4 == 11
    assert not {look.marker for look in looks.values()} & {*"<>"}  # the signs of infinity
    often = ["minimalistic", "legacy", "commons", "swift", "census", "steadfast", "alone", "oracle", "voter"]
    assert len({looks[name].colour for name in often}) == len(often)
    shipped = {part for name in TITLES for part in looks[name][2:4]}
    assert not shipped & {part for name in mine for part in looks[name][2:4]}


OFTEN = st.sampled_from([*TITLES, "mine.py", "swift gain=0.1", "swift gain=0.2", "x.py a=1", "x.py a=2"])


@settings(max_examples=50, deadline=None)
@given(st.lists(OFTEN, unique=True, min_size=1))
def test_a_brain_has_one_look(names):
    together = {name: look[2:] for name, look in looks_of(names, "o", "brain").items()}
    swift, commons = (looks_of([name], "d", "brain")[name] for name in ("swift", "commons"))
    assert len({look[:3] for look in together.values()}) == len(names)
    for name in names:
        alone = looks_of([name], "d", "brain")[name][2:]
        if name in TITLES or name == "mine.py":  # the first of one's own
            assert together[name] == alone
        elif name.startswith("swift"):  # a variant has the colour of its brain, and not its marker
            assert alone[0] == together[name][0] == swift.colour
            assert alone[:2] != swift[2:4]
        else:
            assert together[name][0] == together.get("x.py a=1", together[name])[0] != commons.colour


def test_no_two_of_many_brains_look_alike():
    names = [*TITLES, *(f"{name} gain={k}" for name in TITLES for k in range(5))]
    names += [*(f"{k}.py" for k in range(20)), *(f"x.py a={k}" for k in range(15))]
    assert len({*marks_of_brains(names).values()}) == len(names)


# ---- scatter
@pytest.mark.parametrize(("local", "x", "y", "last"), [
    (False, "convergence_round", "convergence_error", 1000),
    (True, "local_convergence_step", "local_convergence_error", 10_000),
])  # fmt: skip
def test_scatter_draws_every_robot(local, x, y, last):
    results = study()
    (ax,) = figures.scatter(results, local=local).axes
    for i, accuracy in enumerate(PAPER):
        one = results.isel(setting=i)
        data = np.stack([one[x].values.ravel(), one[y].values.ravel()], 1)
        expected = np.array(sorted(map(tuple, data)))
        np.testing.assert_allclose(drawn(ax, f"dots {accuracy}"), expected, atol=1e-9)
        np.testing.assert_allclose(drawn(ax, f"median {accuracy}"), [np.median(data, axis=0)], atol=1e-9)
    assert last <= ax.get_xlim()[1]
    assert results[y].max() <= ax.get_ylim()[1]
    assert ("observations" in ax.get_xlabel()) == local


def test_padding_and_trials_not_run_are_never_drawn():
    results = forget(forget(study(["0.6", "U(0.5,0.9)"]), trial=slice(3, None)), robot=slice(6, None))
    kept = results.isel(setting=0, trial=slice(3), robot=slice(6))
    np.testing.assert_allclose(drawn(figures.scatter(results).axes[0], "median 0.6")[0],
                               [kept.convergence_round.median(), kept.convergence_error.median()])  # fmt: skip
    results["convergence_error"][:, 3] = 0.5  # one of the two missing is enough
    results["convergence_round"][:, 4] = 500
    (ax,) = figures.scatter(results).axes
    for accuracy in ("0.6", "U(0.5,0.9)"):
        dots = drawn(ax, f"dots {accuracy}")
        assert (dots.shape, np.isfinite(dots).all(), dots[:, 0].min() >= 0) == ((3 * 6, 2), True, True)


def test_a_mixed_swarm_is_a_ring_and_lies_below():
    results = study(["0.6", "U(0.5,0.9)"])
    for name in ("convergence_round", "convergence_error"):
        results[name][1] = results[name][0]  # the same robots: one median on the other
    lines = {line.get_label(): line for line in figures.scatter(results).axes[0].lines}
    ring, dot = lines["median U(0.5,0.9)"], lines["median 0.6"]
    assert (ring.get_markerfacecolor(), dot.get_markerfacecolor()) == ("none", palette(1)[0])
    assert lines["dots U(0.5,0.9)"].get_zorder() < lines["dots 0.6"].get_zorder()


def test_medians_have_crosses_of_intervals_over_trials():
    results = study(["0.6", "0.7"], trials=8)
    results["convergence_round"][1, 2:] = -1  # two trials alone
    figure = figures.scatter(results)
    (ax,) = figure.axes
    x, y = (results[name][0].values.astype(float) for name in ("convergence_round", "convergence_error"))
    (_, left, right), (_, low, high) = estimate(x, "median"), estimate(y, "median")
    ends = [(left, np.median(y)), (right, np.median(y)), (np.median(x), low), (np.median(x), high)]
    np.testing.assert_allclose(drawn(ax, "cross 0.6"), sorted(ends))
    assert not drawn(ax, "cross 0.7").size
    assert "95 % interval" in texts(figure)
    assert "interval" not in texts(figures.scatter(results.isel(trial=slice(5))))


def test_the_axis_of_convergence_begins_where_the_data_do():
    late = study(["0.6"])
    late["convergence_round"] = late["convergence_round"] % 50 + 950
    (ax,) = figures.scatter(late).axes
    assert ax.get_xscale() == "linear"
    assert 900 < ax.get_xlim()[0] < 950 < 1000 < ax.get_xlim()[1] < 1010
    late["convergence_round"][0, :, :4] = 20
    (ax,) = figures.scatter(late).axes
    assert (ax.get_xscale(), ax.get_xlim()[0]) == ("asinh", 20)


def test_medians_have_their_names_where_there_is_room():
    results = study(["0.6", "0.7"])
    results["convergence_round"][0], results["convergence_round"][1] = 20, 900
    for apart, named in ((True, [".6", ".7"]), (False, [])):
        shown = results if apart else results.assign(convergence_round=results["convergence_round"] * 0 + 900)
        shown["convergence_error"] = shown["convergence_error"] * 0 + 0.01
        (ax,) = figures.scatter(shown).axes
        assert [text.get_text() for text in ax.texts] == named
        key = [text.get_text() for text in ax.get_legend().get_texts()]
        assert ("median, named by its\nsensor accuracy" in key, "0.6" in key) == (apart, not apart)
    parts = [study(["0.6"], brain=brain, seed=k) for k, brain in enumerate(("swift", "census"))]
    (ax,) = figures.scatter(xr.concat(parts, "setting"), color="brain").axes
    assert not ax.texts
    assert "Swift" in [text.get_text() for text in ax.findobj(Legend)[0].get_texts()]


def test_many_accuracies_have_a_colour_bar():
    for draw in (figures.scatter, partial(figures.lines, x="checkpoint"), partial(figures.lines, x="accuracy")):
        legend = draw(study(), color="accuracy").axes[0].get_legend()
        bar, mixed, *_ = (text.get_text() for text in legend.get_texts())
        assert (bar, mixed) == ("0.975\n0.825\n0.675\n0.525", "U(0.525, 0.975)")
        colours = [to_hex(patch.get_facecolor()) for patch in legend.findobj(Rectangle)]
        assert [colour for colour in colours if colour in palette(10)] == palette(10)[::-1]


def test_empty_panel_is_left_out_with_a_note():
    full = study(["0.6"])
    empty = forget(full, trial=slice(None))
    for grid in (scatter_grid, columns_grid):
        figure = grid([("run", full), ("not run", empty)])
        assert figures.caption(figure).endswith("- left out, no trial has been run: not run\n")
        [axes] = figure.axes
        assert axes.lines


# ---- decisions
def test_decisions_are_percentages_over_all_robots_and_trials():
    few, many = study(["0.6"], robots=8, trials=4), study(["0.6"], robots=24, trials=4, seed=1)
    both = xr.concat([few[["correct"]], many[["correct"]]], "setting")
    (ax,) = figures.lines(both, x="checkpoint", cols=[]).axes
    right = (few.correct * 8 + many.correct.values * 24).sum(("setting", "trial")) / (4 * 32)
    np.testing.assert_allclose(drawn(ax, "right 0.6")[:, 1], 100 * right)


def test_mark_of_perfect_decisions():
    results = study(["0.6", "0.7", "0.8"], checkpoints=(10, 100, 1000))
    results["correct"][:] = 1.0
    results["correct"][0, 1, 3] = 7 / 8
    results["correct"][1, 2, :] = np.nan
    results["correct"][2, :, 2:] = np.nan  # trials not run yet: those that were are all right
    (ax,) = figures.lines(results, x="checkpoint").axes
    bars = {name: drawn(ax, f"all right {name}") for name in ("0.6", "0.7", "0.8")}
    at = {name: np.round(found[:, 0]).tolist() for name, found in bars.items()}
    assert at == {"0.6": [0, 2], "0.7": [0, 1], "0.8": [0, 1, 2]}
    assert drawn(ax, "right 0.6")[1, 1] == pytest.approx(100 * 39 / 40)
    assert len(drawn(ax, "right 0.7")) == 2  # nothing is drawn where nothing was run
    assert {tuple(bar) for bar in bars["0.6"]} <= {tuple(diamond) for diamond in drawn(ax, "right 0.6")}


def test_a_thin_line_is_the_interval_over_trials():
    results = study(["0.6", "U(0.5,0.9)"], trials=20, checkpoints=(10, 100))
    results["correct"][0, 1] = 1.0
    results["correct"][1, 1, 15:] = np.nan  # not run yet
    figure = figures.lines(results, x="checkpoint")
    (ax,) = figure.axes
    for setting, name in enumerate(("0.6", "U(0.5,0.9)")):
        (lines,) = (c for c in ax.collections if c.get_label() == f"interval {name}")
        for checkpoint, line in enumerate(lines.get_segments()):
            shares = results["correct"].values[setting, checkpoint]
            _, low, high = estimate(shares[np.isfinite(shares)][:, None], "mean", share=True)
            np.testing.assert_allclose(line[:, 1], [100 * low, 100 * high])
            np.testing.assert_allclose(line[:, 0], drawn(ax, f"right {name}")[checkpoint, 0])
            assert high > low
    assert "95 % interval" in texts(figure)
    assert "interval" not in texts(figures.lines(results.isel(trial=slice(5)), x="checkpoint"))


# ---- curves
def trace(robots: int, rounds: int = 50, **attrs) -> xr.Dataset:
    noise = np.random.default_rng(0).normal(0, 0.2, (rounds + 1, robots)) / (np.arange(rounds + 1) + 1)[:, None]
    x = np.clip(0.55 + noise, 0, 1)
    return xr.Dataset({"estimate": (("round", "robot"), x)}, {"round": np.arange(rounds + 1)}, attrs)


def test_curves_figure():
    run = trace(7, fill_ratio=0.55, title="ring, N = 7")
    figure = figures.curves(run)
    (ax,) = figure.axes
    (robots,) = ax.collections
    for i, path in enumerate(robots.get_paths()):
        np.testing.assert_allclose(path.vertices, np.stack([run["round"], run.estimate[:, i]], 1))
    np.testing.assert_allclose(drawn(ax, "median")[:, 1], run.estimate.median("robot"))
    assert set(drawn(ax, "truth")[:, 1]) == {0.55}
    (shade,) = ax.patches
    np.testing.assert_allclose(shade.get_extents().transformed(ax.transData.inverted()).intervaly, [0.5, 0.6])
    written = texts(figure)
    assert all(t in written for t in ("ring, N = 7", "each of 7 robots", "median robot", "right bin of 10"))


@pytest.mark.parametrize(("truth", "bottom", "top"), [(0.0, 0, 0.1), (0.3, 0.3, 0.4), (0.95, 0.9, 1), (1.0, 0.9, 1)])
def test_the_shaded_bin_holds_the_truth(truth, bottom, top):
    (ax,) = figures.curves(trace(2, fill_ratio=truth)).axes
    (shade,) = ax.patches
    low, high = shade.get_extents().transformed(ax.transData.inverted()).intervaly
    assert (low, high) == (pytest.approx(bottom), pytest.approx(top))


# ---- heatmap
def grid_study(**coordinates) -> xr.Dataset:
    accuracies = ["0.6", "0.9", "U(0.5,0.9)"]
    parts = [study(accuracies, seed=i, fill_ratio=f, **coordinates) for i, f in enumerate((0.55, 0.95))]
    return xr.concat(parts, "setting")


def test_heatmap_shows_medians_of_finished_cells():
    results = forget(grid_study(), setting=4)  # accuracy 0.9, f = 0.95
    error, rounds = figures.heatmap(results, title="ring").axes
    assert "grey: no finished trial" in texts(error.figure)  # in the key
    cells = {tuple(np.round(t.get_position()).astype(int)): t for t in error.texts}
    assert set(cells) == {(x, y) for x in range(2) for y in range(3)} - {(1, 1)}
    assert cells[0, 0].get_text() == f"{float(results.convergence_error[0].median()):.4f}"
    image = np.asarray(rounds.images[0].get_array().filled(np.nan))
    np.testing.assert_allclose(image[2], [results.convergence_round[i].median() for i in (2, 5)])
    assert [t.get_text() for t in error.get_yticklabels()] == ["0.6", "0.9", "U(0.5, 0.9)"]
    assert [t.get_text() for t in error.get_xticklabels()] == ["0.55", "0.95"]
    for ax, text in ((axes, text) for axes in (error, rounds) for text in axes.texts):
        x, y = np.round(text.get_position()).astype(int)
        ground = ax.images[0].to_rgba(ax.images[0].get_array())[y, x, :3]
        low, high = sorted([luminance(ground), luminance(text.get_color())])
        assert (high + 0.05) / (low + 0.05) >= 4.2  # legible


def test_heatmap_does_not_call_a_k_of_robots_that_never_learnt_the_best():
    results = grid_study()
    results["convergence_round"][1] = 0  # accuracy 0.9, f = 0.55
    figure = figures.heatmap(results)
    _, rounds = figure.axes
    assert (len(rounds.texts), np.isnan(rounds.images[0].get_array().filled(np.nan)).sum()) == (5, 1)
    best = {text for text in texts(figure).split("\n") if text.endswith(" best")}
    assert len(best - {"0 best"}) == 2  # a colour bar for each measure
    assert "grey: robots never learnt (K = 0)" in figures.caption(figure)
    assert "grey: robots never learnt" in texts(figure).replace("\n", " ")  # in the key
    results["convergence_round"][:] = 0
    assert "best" not in texts(figures.heatmap(results, z="convergence_round"))


def test_names_of_many_brains_are_whole_in_rows():
    names = [*TITLES][:20]
    results = xr.concat([study(["0.6", "0.8"], brain=name) for name in names], "setting")
    results["convergence_round"][0] = [34, 35] * 4
    figure = figures.heatmap(results, width="column")
    error, rounds = figure.axes
    assert [label.get_text() for label in error.get_yticklabels()] == [TITLES[name] for name in names]
    assert error.yaxis_inverted()  # the first one is on top
    assert "34.5" in {text.get_text() for text in rounds.texts}
    assert figure.get_figheight() <= 9
    for kind, more in ((figures.lines, {}), (figures.heatmap, {"y": "accuracy"})):  # upright, or refused
        lowest = kind(results, x="brain", width="column", **more).axes[-1]
        assert [label.get_text() for label in lowest.get_xticklabels()] == [TITLES[name] for name in names]
        with pytest.raises(InputError, match="no room for all names of brain"):
            kind(results, x="brain", width="column", font_size=14, **more)


def test_heatmaps_of_several_worlds_share_their_colours():
    both = xr.concat([grid_study(), grid_study(topology="full") * 0.5], "setting")
    ring, full = figures.heatmap(both, z="convergence_error").axes
    assert [ax.get_title("left").split("\n")[0] for ax in (ring, full)] == ["(a) ring", "(b) full"]
    assert ring.images[0].get_clim() == full.images[0].get_clim()
    assert len(figures.heatmap(both).axes) == 4
    with pytest.raises(InputError, match="topology varies too: name it in rows or cols"):
        figures.heatmap(both, cols=[])


def test_no_formula_is_written_raw_and_no_name_is_read_as_one():
    assert "costs $2 or $3" in texts(figures.heatmap(grid_study(), title="costs $2 or $3"))
    for figure in (figures.scatter(study(["0.6"]), title="$2 or $3"), figures.curves(trace(3), title="$2 or $3")):
        assert "$2 or $3" in texts(figure)
        figure.canvas.draw()
        assert not figure.axes[0]._left_title.get_parse_math()


# ---- panels
@pytest.mark.parametrize(("varied", "captions"), [
    ([{"assumed_accuracy": "error=-0.09999999999999998"}, {"assumed_accuracy": "error=0.05"}],
    ["assumed accuracy error=-0.1", "assumed accuracy error=0.05"]),
    ([{"fill_ratio": f, "link_success": s} for f in (0.12345671, 0.12345672) for s in (0.9999999, 1.0)],
    ["f = 0.12345671, link success 0.9999999", "f = 0.12345671, link success 1",
    "f = 0.12345672, link success 0.9999999", "f = 0.12345672, link success 1"]),
    ([{"weather": "dry"}, {"weather": "dry", "topology": "moving", "density": 10.0}, {"weather": "rain"}],
    ["ring, weather = dry", "moving, D = 10, weather = dry", "ring, weather = rain"]),
    ([{"topology": t, "fill_ratio": f, "robots": n} for t in ("ring", "full") for f, n in ((0.5, 8), (0.9, 1000))],
    ["ring, N = 8, f = 0.5", "ring, N = 1,000, f = 0.9", "full, N = 8, f = 0.5", "full, N = 1,000, f = 0.9"]),
    ([{}], [""]),
])  # fmt: skip
def test_captions_tell_panels_apart(varied, captions):
    parts = [study(["0.6", "0.7"], **coordinates)[["correct"]] for coordinates in varied]
    panels = panels_of(xr.concat(parts, "setting"))
    assert [", ".join(filter(None, (panel.row, panel.caption))) for panel in panels] == captions
    assert all(panel.results.accuracy.values.tolist() == ["0.6", "0.7"] for panel in panels)


def test_robots_that_know_their_sensors_are_one_panel():
    known = study(["0.6", "0.7"], assumed_accuracy=["0.6", "0.7"])
    fixed = study(["0.6", "0.7"], assumed_accuracy="0.8")
    assert len(panels_of(known)) == len(panels_of(fixed)) == 1
    assert [p.caption for p in panels_of(xr.concat([known, fixed], "setting"))] == ["", "assumed accuracy 0.8"]
    assert varies(known, set()) == {"accuracy": ["0.6", "0.7"]}


def test_number_of_panels():
    results = study(["0.6", "0.7"])
    figure = columns_grid([(str(i), results) for i in range(16)])
    assert len({ax.get_position().x0 for ax in figure.axes}) == 4
    for count, said in ((121, "120 panels, not 121: select some"), (0, "not 0")):
        with pytest.raises(InputError, match=said):
            scatter_grid([("", results)] * count)


def test_panels_by_two_coordinates_are_a_table():
    parts = [study(["0.6"], topology=t, robots=n, seed=n) for t in ("ring", "full") for n in (8, 9, 10)]
    results = xr.concat([part[["correct"]] for part in parts], "setting")
    for options, top, side in (
        ({}, ["N = 8", "N = 9", "N = 10"], ["ring", "full"]),
        ({"rows": "robots", "cols": "topology"}, ["ring", "full"], ["N = 8", "N = 9", "N = 10"]),
    ):
        axes = figures.lines(results, x="checkpoint", **options).axes
        table = {(round(-ax.get_position().y0, 3), round(ax.get_position().x0, 3)): ax for ax in axes}
        rows, columns = (sorted({place[k] for place in table}) for k in (0, 1))
        first = [table[rows[0], column] for column in columns]
        assert [ax.get_title("left") for ax in first] == top
        assert [table[row, columns[-1]].texts[-1].get_text() for row in rows] == side
        assert [bool(table[row, columns[0]].get_ylabel()) for row in rows] == [True] * len(rows)
        assert not any(ax.get_xlabel() for ax in first)  # it is under the lowest row
        assert not any(table[row, columns[1]].get_ylabel() for row in rows)
    one = figures.lines(results, x="checkpoint", rows="topology", cols=[])
    assert [ax.texts[-1].get_text() for ax in one.axes] == ["ring", "full"]
    assert "pooled over 3 numbers of robots" in figures.caption(one)


@pytest.mark.long
def test_pictures_of_a_part_say_so():
    results = grid_study(link_success=1.0)
    part = forget(results, trial=slice(3, None)).assign_attrs(trials_done=18, trials_total=30)
    for draw in (figures.scatter, partial(figures.lines, x="checkpoint"), figures.heatmap):
        assert "drawn: 18 of 30 trials" in figures.caption(draw(part))
        assert "drawn:" not in figures.caption(draw(results.assign_attrs(trials_done=30, trials_total=30)))
        assert "drawn: 6 of 10 trials" in figures.caption(draw(part.isel(setting=[0, 1])))
        few = figures.caption(draw(part.isel(trial=slice(3))))  # all of what is asked for
        assert "drawn:" not in few
        assert "95 %" not in few
        ruled = part.assign(half_width=("setting", np.full(6, np.nan)))
        assert "drawn: 18 trials so far" in figures.caption(draw(ruled))


# ---- names of any length
NAMES = "watts_strogatz_graph(k=4,p=0.1), my_quite_long_brain_name_of_2024.py, N = 10, f = 0.55"


@pytest.mark.parametrize("width", [20, 60, 200])
@pytest.mark.parametrize("text", [NAMES, "w" * 500, "a b " * 100, "", "$x^2$", "tab\tand\nline"])
def test_lines_are_no_wider_than_their_room_and_few(text, width):
    lines = wrapped(text, width, 9, 6)
    assert len(lines) <= 6
    assert all(0 < width_of(line, 9) <= width for line in lines)
    if not any("…" in line for line in lines):
        assert "".join(lines).replace(" ", "") == "".join(text.split())


def test_the_end_of_a_broken_word_is_not_a_letter():
    name = "a_second_long_named_brain_for_the_paper_of_next_year.py"
    for letters in range(12, 56):
        assert len(wrapped(name, width_of(name[:letters], 9), 9)[-1]) >= 4


LONG = ("watts_strogatz_graph(k=4,p=0.1)", "warehouse_measured_links_2024-05-17_north_wing_final_v2", "w" * 300)
MIXED = ("black=U(0.525,0.975) white=N(0.75,0.1)", "black=U(0.525,0.975) white=U(0.55,0.975)")


@pytest.mark.long
@pytest.mark.parametrize("count", [1, 4, 8])
def test_long_names_stay_in_their_panels(count):
    results = study(["0.6", *MIXED], robots=2)
    captions = [f"{LONG[i % 3]}, {LONG[(i + 1) % 2]}, N = 1,000, f = 0.55" for i in range(count)]
    if count < 8:
        assert_fits(scatter_grid([(caption, results) for caption in captions], title="a title of many words " * 40))
    figure = columns_grid([(caption, results) for caption in captions])
    assert_fits(figure)
    for ax, caption in zip(figure.axes, captions, strict=True):
        written = ax.get_title("left").replace("\n", "").replace(" ", "")
        assert written.endswith("N=1,000,f=0.55")
        assert "…" in written or caption.replace(" ", "") in written


@pytest.mark.long
def test_long_titles_stay_on_their_page():
    title = f"{LONG[1]} of {LONG[0]} $x$, setting 2, trial 0: {LONG[1]}.py, N = 4, accuracy 0.6"
    parts = [study(["0.6", *MIXED], seed=i, fill_ratio=0.123456 + i / 9) for i in range(7)]
    assert_fits(figures.heatmap(xr.concat(parts, "setting"), title=title))
    figure = figures.curves(trace(4, fill_ratio=0.55, title=title))
    assert_fits(figure)
    assert "setting 2, trial 0:" in texts(figure).replace("\n", " ")


# ---- bad input
def test_nothing_left_to_draw_is_an_input_error():
    empty = forget(study(), trial=slice(None))
    for draw in (figures.scatter, partial(figures.lines, x="checkpoint"), figures.heatmap):
        with pytest.raises(InputError, match="nothing to draw"):
            draw(empty)
        with pytest.raises(InputError, match="no setting"):
            draw(study().isel(setting=[]))
    without = study().drop_vars("local_convergence_step")
    for draw, what, said in (
        (figures.curves, trace(3).where(False), "nothing to draw"),
        (figures.curves, trace(3).isel(round=[]), "no round"),
        (figures.scatter, study().isel(setting=0), "no setting"),
        (partial(figures.lines, x="checkpoint"), study().drop_vars("correct"), "'correct'"),
        (partial(figures.scatter, local=True), without, "'local_convergence_step': set local = true"),
    ):
        with pytest.raises(InputError, match=said):
            draw(what)


# ---- files
def test_files_are_the_same_bytes_from_any_thread(tmp_path: Path):
    results = study(["0.6", "0.7"])

    def write(i: int) -> list[bytes]:
        paths = figures.save(figures.scatter(results), tmp_path / f"{i}" / "f0.55")
        assert [p.name for p in paths] == ["f0.55.png", "f0.55.svg", "f0.55.caption.txt"]
        return [p.read_bytes() for p in paths]

    with ThreadPoolExecutor(3) as pool:
        first, *others = pool.map(write, range(3))
    assert all(other == first for other in others)
    assert first[0].startswith(b"\x89PNG")
    assert b"<dc:date>" not in first[1]
    assert sorted(p.name for p in (tmp_path / "0").iterdir()) == ["f0.55.caption.txt", "f0.55.png", "f0.55.svg"]


@pytest.mark.parametrize(("given", "said"), [
    ({"figure": 3}, "figure='int': should be a figure"),
    ({"path": 3}, "path=3: should be the name of a file"),
    ({"formats": "png"}, r"formats='png': should be a list of endings, such as \['png', 'pdf'\]"),
    ({"formats": [3]}, "formats=.*should be a list"),
    ({"dpi": "x"}, "dpi='x': should be 10 to 2400"),
])  # fmt: skip
def test_what_is_no_figure_and_no_path_is_refused(given, said, tmp_path: Path):
    with pytest.raises(InputError, match=said):
        figures.save(**{"figure": Figure(), "path": tmp_path / "x", **given})
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("kind", "options", "said"), [
    ("scatter", {"scale": "nix"}, "scale='nix': should be one of log, log-y, linear"),
    ("scatter", {"error_limit": -1}, "error_limit=-1: should be a number above 0"),
    ("scatter", {"local": 1}, "local=1: should be True or False"),
    ("scatter", {"color": 3}, "color=3: should be a text"),
    ("lines", {"y": "stop_round"}, "y='stop_round': nothing to draw: no trial of these settings has numbers of it"),
    ("film", {"fps": 0}, "fps=0: should be 1 to 240 frames a second"),
    ("film", {"fps": True}, "fps=True: should be a whole number"),
    ("arena", {"tick": 1.5}, "tick=1.5: should be a whole number or a text"),
])  # fmt: skip
def test_options_of_wrong_types_are_refused_before_anything_is_computed(kind, options, said):
    results = study().assign(stop_round=lambda data: data["convergence_error"] * np.nan)
    with pytest.raises(InputError, match=said):
        getattr(sc.plot, kind)(trace(3) if kind == "film" else results, **options)


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    figure = figures.lines(study(), x="checkpoint")
    files = figures.save(figure, tmp_path / "decisions", ["png"])
    before = [file.read_bytes() for file in files]

    def fail(place, **_):
        place.write(before[0][:100])
        raise RuntimeError("the disk is full")

    monkeypatch.setattr(figure, "savefig", fail)
    with pytest.raises(RuntimeError):
        figures.save(figure, tmp_path / "decisions", ["png"])
    assert [file.read_bytes() for file in files] == before
    assert {*tmp_path.iterdir()} == {*files}
