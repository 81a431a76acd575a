"""The figures show the data, all of it, and nothing else; and their files are whole."""

import itertools
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from swarmcensus import figures
from swarmcensus.errors import InputError
from swarmcensus.panels import varies
from swarmcensus.sheets import label_dots, looks_of, palette

PAPER = [f"{a:.3f}" for a in np.arange(0.525, 0.98, 0.05)] + ["U(0.525,0.975)"]


def study(accuracies=PAPER, robots=8, trials=5, checkpoints=(10, 100), seed=0, **coordinates) -> xr.Dataset:
    """Results as a study would leave them, all trials run; `coordinates` are one value or one a setting."""
    rng = np.random.default_rng(seed)
    shape = (len(accuracies), trials, robots)
    per_robot = ("setting", "trial", "robot")
    same = {"topology": "ring", "brain": "minimalistic", "robots": robots, "density": np.nan}
    same |= {"fill_ratio": 0.55, "rounds": 1000, "observations_per_round": 10} | coordinates
    right = rng.integers(0, robots + 1, (shape[0], len(checkpoints), trials)) / robots
    return xr.Dataset(
        {
            "convergence_round": (per_robot, rng.integers(0, 1001, shape).astype(np.int32)),
            "convergence_error": (per_robot, rng.gamma(1, 0.02, shape)),
            "local_convergence_step": (per_robot, rng.integers(2000, 10001, shape).astype(np.int32)),
            "local_convergence_error": (per_robot, rng.gamma(1, 0.05, shape)),
            "correct": (("setting", "checkpoint", "trial"), right),
        },
        {k: ("setting", np.broadcast_to(v, shape[0])) for k, v in same.items()}
        | {"accuracy": ("setting", list(accuracies)), "checkpoint": list(checkpoints)},
    )


def forget(results: xr.Dataset, **where) -> xr.Dataset:
    """The same results where these trials or robots were never run."""
    results = results.copy(deep=True)
    for name in results.data_vars:
        place = {k: v for k, v in where.items() if k in results[name].dims}
        if set(place) == set(where):
            results[name][place] = -1 if results[name].dtype.kind == "i" else np.nan
    return results


def drawn(axes: Axes, label: str) -> np.ndarray:
    """The (x, y) of all points drawn under this label, in order of x."""
    points = [line.get_xydata() for line in axes.lines if line.get_label() == label]
    return np.array(sorted(map(tuple, np.concatenate(points)))) if points else np.empty((0, 2))


def texts(figure: Figure) -> str:
    figure.draw_without_rendering()
    return "\n".join(t.get_text() for t in figure.findobj(lambda a: hasattr(a, "get_text")))


def luminance(colour: str) -> float:
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    return float(np.dot([0.2126, 0.7152, 0.0722], linear))


# ---- looks


@pytest.mark.parametrize("count", [2, 5, 10, 20])
def test_palette_gets_lighter_and_stays_off_black_and_white(count):
    lightness = np.array([116 * luminance(c) ** (1 / 3) - 16 for c in palette(count)])
    steps = np.diff(lightness)
    assert steps.min() > 0.6 * steps.mean() > 0  # evenly, so that grey print keeps neighbours apart
    assert lightness[0] > 15
    assert lightness[-1] < 88


def test_looks_are_ordered_and_spread_accuracies_are_black_but_differ_in_shape():
    looks = looks_of(["U(0.5,0.9)", "0.975", "0.6", "0.525", "N(0.75,0.1)", "black=0.9 white=0.6"], "o")
    assert list(looks) == ["0.525", "0.6", "0.975", "N(0.75,0.1)", "U(0.5,0.9)", "black=0.9 white=0.6"]
    black = [look for look in looks.values() if look.colour == "#000000"]
    assert len({look.marker for look in black}) == len(black) == 3
    assert [look.name for look in black] == ["N(0.75, 0.1)", "U(0.5, 0.9)", "b = 0.9, w = 0.6"]


def test_labels_keep_the_order_of_their_dots_and_do_not_touch():
    figure = Figure(figsize=(4, 3))
    FigureCanvasAgg(figure)
    ax = figure.add_subplot()
    ax.set(xlim=(0, 100), ylim=(0, 1))
    dots = [(50, 0.2), (50.1, 0.3), (50.2, 0.1), (0, 0.5), (0.1, 0.5), (100, 0.5), (99, 0.1), (70, 2.0)]
    label_dots(ax, dots, [str(i) for i in range(len(dots))])
    figure.draw_without_rendering()
    boxes = [t.get_window_extent() for t in sorted(ax.texts, key=lambda t: t.get_position()[0])]
    assert [t.get_text() for t in sorted(ax.texts, key=lambda t: t.get_position()[0])] == list("34012765")
    assert all(left.x1 <= right.x0 for left, right in itertools.pairwise(boxes))
    assert all(box.y0 >= ax.bbox.y1 for box in boxes)  # above the data
    (lines,) = (c for c in ax.collections if isinstance(c, LineCollection))
    ends = {tuple(np.round(path.vertices[-1], 9)) for path in lines.get_paths()}
    assert {(0.5, 0.2), (0.501, 0.3), (1.0, 0.5), (0.7, 1.0)} <= ends


# ---- scatter


def test_scatter_draws_every_robot_of_every_trial_where_it_belongs():
    results = study()
    (ax,) = figures.scatter(results).axes
    for i, accuracy in enumerate(PAPER):
        one = results.isel(setting=i)
        data = np.stack([one.convergence_round.values.ravel(), one.convergence_error.values.ravel()], 1)
        expected = np.array(sorted(map(tuple, data)))
        np.testing.assert_allclose(drawn(ax, f"dots {accuracy}"), expected, atol=1e-9)
        np.testing.assert_allclose(drawn(ax, f"median {accuracy}"), [np.median(data, axis=0)], atol=1e-9)
    assert ax.get_xlim()[0] <= 0 < 1000 <= ax.get_xlim()[1]
    assert results.convergence_error.max() <= ax.get_ylim()[1]


def test_scatter_of_local_estimates_counts_observations():
    results = study(["0.6"])
    (ax,) = figures.scatter(results, local=True).axes
    assert "observations" in ax.get_xlabel()
    assert set(drawn(ax, "dots 0.6")[:, 0]) == set(results.local_convergence_step.values.ravel().tolist())
    assert ax.get_xlim()[1] >= 10_000


def test_padding_and_trials_not_run_are_never_drawn():
    results = forget(forget(study(["0.6", "U(0.5,0.9)"]), trial=slice(3, None)), robot=slice(6, None))
    results["convergence_error"][:, 3] = 0.5  # one of the two missing is enough
    results["convergence_round"][:, 4] = 500
    (ax,) = figures.scatter(results).axes
    for accuracy in ("0.6", "U(0.5,0.9)"):
        dots = drawn(ax, f"dots {accuracy}")
        assert len(dots) == 3 * 6
        assert np.isfinite(dots).all()
        assert (dots[:, 0] >= 0).all()
    kept = results.isel(setting=0, trial=slice(3), robot=slice(6))
    np.testing.assert_allclose(
        drawn(ax, "median 0.6")[0], [kept.convergence_round.median(), kept.convergence_error.median()]
    )


def test_robots_that_agree_make_one_dot_as_opaque_as_all_of_them():
    results = study(["0.6"], robots=50, trials=1)
    results["convergence_round"][:] = 7
    results["convergence_error"][:] = 0.01
    (ax,) = figures.scatter(results).axes
    (dots,) = (line for line in ax.lines if line.get_label() == "dots 0.6" and line.get_xdata().size)
    assert dots.get_xydata().tolist() == [[7.0, 0.01]]
    assert dots.get_alpha() > 0.99


def test_all_settings_of_an_accuracy_share_its_series():
    results = xr.concat([study(["0.6", "0.7"]), study(["0.6", "0.7"], seed=1, topology="line")], "setting")
    (ax,) = figures.scatter(results).axes
    assert len(drawn(ax, "dots 0.6")) == 2 * 5 * 8
    mine = results.isel(setting=[0, 2])
    assert drawn(ax, "median 0.6")[0, 1] == pytest.approx(float(mine.convergence_error.median()))


def test_dots_above_the_limit_are_counted():
    results = study(["0.6"])
    figure = figures.scatter(results, error_limit=0.03)
    assert figure.axes[0].get_ylim()[1] == 0.03
    above = int((results.convergence_error > 0.03).sum())
    assert above > 0
    assert f"{above} of 40 dots" in texts(figure)
    assert "lie above" not in texts(figures.scatter(results))


@pytest.mark.parametrize("scale", ["log", "linear"])
def test_axes_begin_below_zero_and_the_key_names_accuracies_and_scale(scale):
    results = study(["0.6", "U(0.525,0.975)"])
    results["convergence_round"][0, 0, 0] = 0
    figure = figures.scatter(results, title="a title", scale=scale)
    (ax,) = figure.axes
    assert ax.get_xlim()[0] < 0
    assert ax.get_ylim()[0] < 0
    written = texts(figure)
    assert all(name in written for name in ("a title", "0.6", "U(0.525, 0.975)", "communication rounds"))
    assert ("logarithmic" in written) == (scale == "log")


def test_panels_share_limits_unless_they_set_their_own():
    small, large = study(["0.6"]), study(["0.6"], seed=1)
    large["convergence_error"] *= 4
    panels = [("one", small), ("two", large), ("local", small, True), ("own", large, False, 0.05)]
    figure = figures.scatter_grid(panels, title="all")
    one, two, local, own = figure.axes
    assert one.get_ylim() == two.get_ylim() == local.get_ylim()
    assert one.get_ylim()[1] >= large.convergence_error.max()
    assert own.get_ylim()[1] == 0.05
    assert one.get_xlim() == two.get_xlim() == own.get_xlim() != local.get_xlim()
    assert [ax.get_title("left") for ax in figure.axes] == ["(a) one", "(b) two", "(c) local", "(d) own"]
    assert sum(ax.get_legend() is not None for ax in figure.axes) == 1


def test_an_empty_panel_says_so_and_leaves_the_others():
    full = study(["0.6"])
    empty = forget(full, trial=slice(None))
    for grid in (figures.scatter_grid, figures.decisions_grid):
        figure = grid([("run", full), ("not run", empty)])
        assert "no trial has been run" in texts(figure)
        assert not figure.axes[1].lines
        assert figure.axes[0].lines


def test_figures_draw_into_axes_of_the_caller():
    figure = Figure()
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    assert figures.scatter(study(), axes=left) is figure
    assert figures.decisions(study(), axes=right) is figure
    assert len(drawn(left, "dots 0.525")) == 40
    assert len(drawn(right, "right 0.525")) == 2


# ---- decisions


def test_decisions_are_percentages_over_all_robots_and_trials():
    few, many = study(["0.6"], robots=8, trials=4), study(["0.6"], robots=24, trials=4, seed=1)
    both = xr.concat([few[["correct"]], many[["correct"]]], "setting")
    (ax,) = figures.decisions(both).axes
    right = (few.correct * 8 + many.correct.values * 24).sum(("setting", "trial")) / (4 * 32)
    np.testing.assert_allclose(drawn(ax, "right 0.6")[:, 1], 100 * right)


def test_a_bar_stands_only_where_all_robots_of_all_trials_are_right():
    results = study(["0.6", "0.7", "0.8"], checkpoints=(10, 100, 1000))
    results["correct"][:] = 1.0
    results["correct"][0, 1, 3] = 7 / 8
    results["correct"][1, 2, :] = np.nan
    results["correct"][2, :, 2:] = np.nan  # trials not run yet: those that were are all right
    (ax,) = figures.decisions(results).axes
    assert np.round(drawn(ax, "all right 0.6")[:, 0]).tolist() == [0, 2]
    assert np.round(drawn(ax, "all right 0.7")[:, 0]).tolist() == [0, 1]
    assert np.round(drawn(ax, "all right 0.8")[:, 0]).tolist() == [0, 1, 2]
    assert drawn(ax, "right 0.6")[1, 1] == pytest.approx(100 * 39 / 40)
    assert len(drawn(ax, "right 0.7")) == 2  # nothing is drawn where nothing was run
    bars, diamonds = drawn(ax, "all right 0.6"), drawn(ax, "right 0.6")
    assert {tuple(bar) for bar in bars} <= {tuple(diamond) for diamond in diamonds}


@pytest.mark.parametrize("panels", [1, 4, 12])
def test_no_diamond_hides_another(panels):
    results = study(checkpoints=(10, 50, 100, 200, 500, 1000))
    results["correct"][:] = 1.0
    ax = figures.decisions_grid([("", results)] * panels).axes[0]
    places = np.sort(np.concatenate([drawn(ax, f"right {a}")[:, 0] for a in PAPER]))
    gap = np.diff(ax.transData.transform(np.stack([places, places], 1))[:, 0]).min() * 72 / ax.figure.dpi
    (line,) = (line for line in ax.lines if line.get_label() == "right 0.525")
    shape = line.get_marker()
    assert shape == "d"
    assert gap >= 0.6 * np.sqrt(2) * line.get_markersize()  # the thin diamond's width


def test_of_many_checkpoints_a_choice_with_both_ends_is_shown_and_said():
    results = study(["0.6", "0.7"], checkpoints=range(10, 1010, 10))
    results = forget(results, checkpoint=slice(90, None))
    figure = figures.decisions(results)
    assert "12 of 90 checkpoints" in texts(figure)
    labels = [t.get_text() for t in figure.axes[0].get_xticklabels()]
    assert (len(labels), labels[0], labels[-1]) == (12, "10", "900")
    shown = results.correct.mean("trial").sel(checkpoint=[int(label) for label in labels])
    np.testing.assert_allclose(drawn(figure.axes[0], "right 0.7")[:, 1], 100 * shown.isel(setting=1))


# ---- curves


def trace(robots: int, rounds: int = 50, **attrs) -> xr.Dataset:
    noise = np.random.default_rng(0).normal(0, 0.2, (rounds + 1, robots)) / (np.arange(rounds + 1) + 1)[:, None]
    x = np.clip(0.55 + noise, 0, 1)
    return xr.Dataset({"estimate": (("round", "robot"), x)}, {"round": np.arange(rounds + 1)}, attrs)


def test_curves_show_each_robot_the_median_the_truth_and_its_bin():
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


def test_curves_of_one_robot_and_of_a_thousand():
    alone = figures.curves(trace(1), title="alone")
    assert not alone.axes[0].collections
    assert "the robot" in texts(alone)
    assert "true fill ratio" not in texts(alone)
    run = trace(1000, fill_ratio=0.55)
    crowd = figures.curves(run)
    assert all(t in texts(crowd) for t in ("30 of 1,000 robots", "middle 90 %", "middle 50 %"))
    band = next(c for c in crowd.axes[0].collections if c.get_label() == "90 %")
    corners = band.get_paths()[0].vertices
    expected = run.estimate.isel(round=3).quantile([0.05, 0.95])
    np.testing.assert_allclose(
        [corners[corners[:, 0] == 3][:, 1].min(), corners[corners[:, 0] == 3][:, 1].max()], expected
    )


def test_curves_skip_robots_and_rounds_without_estimate():
    run = trace(4)
    run["estimate"][:, 3] = np.nan
    run["estimate"][40:] = np.nan
    (ax,) = figures.curves(run).axes
    assert len(ax.collections[0].get_paths()) == 3
    assert drawn(ax, "median")[-1, 0] == 39


# ---- heatmap


def grid_study(**coordinates) -> xr.Dataset:
    parts = [
        study(["0.6", "0.9", "U(0.5,0.9)"], seed=i, fill_ratio=f, **coordinates) for i, f in enumerate((0.55, 0.95))
    ]
    return xr.concat(parts, "setting")


def test_heatmap_writes_the_median_of_each_cell_and_leaves_out_what_was_not_run():
    results = forget(grid_study(), setting=4)  # accuracy 0.9, f = 0.95
    error, rounds = figures.heatmap(results, title="ring").axes
    cells = {tuple(np.round(t.get_position()).astype(int)): t for t in error.texts}
    assert set(cells) == {(x, y) for x in range(2) for y in range(3)} - {(1, 1)}
    median = float(results.convergence_error[0].median())
    assert cells[0, 0].get_text() == f"{median:.4f}".removeprefix("0")
    image = np.asarray(rounds.images[0].get_array().filled(np.nan))
    np.testing.assert_allclose(image[2], [results.convergence_round[i].median() for i in (2, 5)])
    assert [t.get_text() for t in error.get_yticklabels()] == ["0.6", "0.9", "U(0.5, 0.9)"]
    assert [t.get_text() for t in error.get_xticklabels()] == ["0.55", "0.95"]
    for ax in (error, rounds):
        for text in ax.texts:
            x, y = np.round(text.get_position()).astype(int)
            back = luminance(ax.images[0].to_rgba(ax.images[0].get_array())[y, x, :3])
            fore = luminance(text.get_color())
            assert (max(back, fore) + 0.05) / (min(back, fore) + 0.05) >= 4.2  # legible


def test_heatmap_names_what_varies_and_how_to_select():
    both = xr.concat([grid_study(), grid_study(topology="full")], "setting")
    with pytest.raises(
        InputError, match=r"topology varies too \(ring, full\).*--where 'topology == \"ring\"'"
    ) as caught:
        figures.heatmap(both)
    advice = str(caught.value).partition("in Python ")[2]
    selected = eval(advice, {"results": both})
    assert set(selected.topology.values) == {"ring"}
    figures.heatmap(selected)


# ---- panels


def test_panels_have_captions_made_of_what_varies():
    swarms = [(t, f, n) for t in ("ring", "full") for f, n in ((0.5, 8), (0.9, 1000))]
    parts = [study(["0.6", "0.7"], topology=t, fill_ratio=f, robots=n)[["correct"]] for t, f, n in swarms]
    results = xr.concat(parts, "setting")
    panels = figures.panels_of(results)
    assert [p.caption for p in panels] == [
        "ring, N = 8, f = 0.5",
        "ring, N = 1,000, f = 0.9",
        "full, N = 8, f = 0.5",
        "full, N = 1,000, f = 0.9",
    ]
    assert [p.results.sizes["setting"] for p in panels] == [2, 2, 2, 2]
    assert list(panels[2].results.accuracy.values) == ["0.6", "0.7"]
    assert [p.caption for p in figures.panels_of(parts[0])] == [""]


def test_captions_leave_out_the_density_of_fixed_networks_and_name_unknown_coordinates():
    parts = [
        study(["0.6"], weather="dry"),
        study(["0.6"], weather="dry", topology="moving", density=10.0),
        study(["0.6"], weather="rain"),
    ]
    results = xr.concat(parts, "setting")
    captions = [p.caption for p in figures.panels_of(results)]
    assert captions == ["ring, weather = dry", "moving, D = 10, weather = dry", "ring, weather = rain"]


def test_robots_that_know_their_sensors_are_one_panel():
    results = study(["0.6", "0.7"])
    known = results.assign_coords(assumed_accuracy=("setting", ["0.6", "0.7"]))
    fixed = results.assign_coords(assumed_accuracy=("setting", ["0.8", "0.8"]))
    assert len(figures.panels_of(known)) == len(figures.panels_of(fixed)) == 1
    captions = [p.caption for p in figures.panels_of(xr.concat([known, fixed], "setting"))]
    assert captions == ["", "assumed accuracy 0.8"]
    assert varies(known, set()) == {"accuracy": ["0.6", "0.7"]}


def test_sixteen_panels_make_four_columns_and_twenty_five_are_too_many():
    results = study(["0.6", "0.7"])
    figure = figures.decisions_grid([(str(i), results) for i in range(16)])
    assert figure.axes[0].get_gridspec().ncols == 4
    for grid in (figures.scatter_grid, figures.decisions_grid):
        with pytest.raises(InputError, match=r"24 panels, not 25: select"):
            grid([("", results)] * 25)
        with pytest.raises(InputError, match="not 0"):
            grid([])


# ---- bad input


def test_nothing_left_to_draw_is_an_input_error():
    empty = forget(study(), trial=slice(None))
    for draw in (figures.scatter, figures.decisions, figures.heatmap):
        with pytest.raises(InputError, match="nothing to draw"):
            draw(empty)
        with pytest.raises(InputError, match="no setting"):
            draw(study().isel(setting=[]))
    with pytest.raises(InputError, match="nothing to draw"):
        figures.curves(trace(3).where(False))


def test_a_missing_variable_is_named():
    with pytest.raises(InputError, match="'local_convergence_step': set local = true"):
        figures.scatter(study().drop_vars("local_convergence_step"), local=True)
    with pytest.raises(InputError, match="'correct'"):
        figures.decisions(study().drop_vars("correct"))
    with pytest.raises(InputError, match="no setting"):
        figures.scatter(study().isel(setting=0))
    with pytest.raises(InputError, match="no round"):
        figures.curves(study())


# ---- files


def test_files_are_the_same_bytes_from_any_thread(tmp_path: Path):
    results = study(["0.6", "0.7"])

    def write(i: int) -> list[bytes]:
        paths = figures.save(figures.scatter(results), tmp_path / f"{i}" / "f0.55")
        assert [p.name for p in paths] == ["f0.55.png", "f0.55.svg"]
        return [p.read_bytes() for p in paths]

    with ThreadPoolExecutor(3) as pool:
        first, *others = pool.map(write, range(3))
    assert all(other == first for other in others)
    assert first[0].startswith(b"\x89PNG")
    assert b"<dc:date>" not in first[1]
    assert sorted(p.name for p in (tmp_path / "0").iterdir()) == ["f0.55.png", "f0.55.svg"]


def test_many_dots_are_one_picture_inside_the_svg(tmp_path: Path):
    results = study(robots=100, trials=30)
    (svg,) = figures.save(figures.scatter(results), tmp_path / "many", ["svg"])
    text = svg.read_text()
    assert text.count("<image") == 1
    assert len(text) < 1_000_000


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    figure = figures.decisions(study())
    (path,) = figures.save(figure, tmp_path / "decisions", ["png"])
    before = path.read_bytes()

    def fail(place: Path, **_: object) -> None:
        Path(place).write_bytes(before[:100])
        raise RuntimeError("the disk is full")

    monkeypatch.setattr(figure, "savefig", fail)
    with pytest.raises(RuntimeError):
        figures.save(figure, tmp_path / "decisions", ["png"])
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_an_unknown_format_is_an_input_error_before_anything_is_written(tmp_path: Path):
    with pytest.raises(InputError, match="'bmpp'"):
        figures.save(figures.decisions(study()), tmp_path / "x", ["png", "bmpp"])
    assert not list(tmp_path.iterdir())


def test_no_display_is_needed():
    code = "import sys; import swarmcensus.figures; sys.exit('matplotlib.pyplot' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
