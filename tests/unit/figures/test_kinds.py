"""`sc.plot` and `plot --kind`: shipped kinds and other packages' kinds; and `lines`, whose numbers are the data's."""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import swarmcensus as sc
from swarmcensus.brains.library import TITLES
from swarmcensus.cli.commands import main
from swarmcensus.figures.axes import Numbers
from swarmcensus.figures.kinds import PLUGINS, find
from swarmcensus.figures.styles import add_endless, looks_of
from swarmcensus.summaries.measures import numbers
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import estimate
from tests.support.contending import made_up
from tests.support.drawing import assert_fits, drawn, forget, study, texts
from tests.support.places import ROOT

OURS = ["arena", "compare", "curves", "film", "heatmap", "interaction", "lines", "pareto", "ranks", "scatter"]


def robots(counts=(10, 100, 1000), trials=12, **coordinates) -> xr.Dataset:
    """One setting a number of robots, each of 8 that are drawn."""
    parts = [study(["0.6"], trials=trials, seed=k, **coordinates) for k in range(len(counts))]
    results = xr.concat(parts, "setting").assign_coords(robots=("setting", list(counts)))
    return results.assign_coords(setting=np.arange(len(counts)))


def intervals(axes, label):
    """The ends of the intervals of a line, in the order of x."""
    found = [c for c in axes.collections if c.get_label() in (f"interval {label}", f"one-sided {label}")]
    segments = [segment for lines in found for segment in lines.get_segments() if len(segment)]
    return np.array([segment[:, 1] for segment in sorted(segments, key=lambda segment: segment[0, 0])])


# ---- finding a kind
def test_all_kinds_of_ours_are_found_in_their_folder():
    assert list(PLUGINS.shipped) == OURS
    assert dir(sc.plot) == sorted([*OURS, "caption", "save"])
    for name in OURS:
        draw = getattr(sc.plot, name)
        assert draw is find(name)
        assert draw.__name__ == name
        assert draw.__doc__.count("\n") > 3


def test_an_unknown_kind_is_refused_with_a_suggestion(small_file, refused):
    with pytest.raises(AttributeError, match=r"did you mean 'scatter'\? there are arena, compare"):
        sc.plot.scater  # noqa: B018
    assert not hasattr(sc.plot, "__wrapped__")
    assert "no figure 'line': did you mean 'lines'? there are" in refused("plot", small_file, "--kind", "line")


@pytest.mark.parametrize(("options", "said"), [
    ("--kind ranks --x robots", "--kind ranks has no key x: it has "),
    ("--kind scatter --y final_error", "--y final_error: goes with x"),
    ("--kind lines --x robot", "--x robot: did you mean 'robots'? the coordinates that vary here are top"),
    ("--kind lines --y convergence_eror", "--y convergence_eror: did you mean 'convergence_error'? what is measured"),
    ("--kind lines --y final_error --option form=columns", "goes with y = correct and x = checkpoint"),
    ("--kind lines --x robots --theory", "--theory: goes with x = checkpoint or x = belief"),
    ("--kind lines --x belief", "all robots of these results know their sensors"),
    ("--color brian", "--color brian: did you mean 'brain'? the coordinates that vary here are topology, robots"),
    ("--kind lines --option form=steps --color robts", "--color robts: did you mean 'robots'? settings differ in"),
    ("--cols robots,floors", "--cols floors: did you mean 'floor'?"),
    ("--kind heatmap --x robots --y robots", "x and y are both 'robots'"),
    ("--kind lines --option statistic=mode", "statistic = 'mode'"),
])  # fmt: skip
def test_impossible_options_are_refused_in_a_line(options, said, small_file, refused):
    assert said in refused("plot", small_file, *options.split())


def test_the_shell_draws_what_python_draws(small_file, small_results, here):
    shell = ["plot", str(small_file), "--kind", "lines", "--x", "topology", "--color", "robots", "--cols", "accuracy"]
    assert main([*shell, "--option", "title=mine", "--out", "shell.svg"]) == 0
    figure = sc.plot.lines(small_results, x="topology", color="robots", cols=["accuracy"], title="mine")
    assert sc.plot.save(figure, "python.svg") == [Path("python.svg"), Path("python.svg.caption.txt")]
    assert Path("shell.svg").read_bytes() == Path("python.svg").read_bytes()
    assert Path("shell.svg.caption.txt").read_text(encoding="utf-8") == sc.plot.caption(figure)
    assert [p.suffix for p in sc.plot.save(figure, here / "both", captioned=False)] == [".png", ".svg"]
    with pytest.raises(InputError, match="cannot write 'bmp' files, only "):
        sc.plot.save(figure, "x.bmp")


# ---- the pages
def test_the_galleries_have_every_kind_and_each_picture():
    pages = [(ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in ("plotting", "lecture")]
    row = re.compile(r"^\| !\[\]\((images/gallery/\S+)\) \|.*--kind (\w+).*\|$", re.MULTILINE)
    assert {*OURS} == {kind for _, kind in row.findall(pages[0])} | {"film"}
    shown = {ROOT / "docs" / picture for page in pages for picture, _ in row.findall(page)}
    assert {*(ROOT / "docs" / "images" / "gallery").iterdir()} == shown


# ---- one trial
def test_a_trial_is_drawn_from_results_or_from_its_trace(small_results):
    tables = {"swarm": {"robots": 4, "accuracy": 0.8}, "schedule": {"ticks": 20}}
    moving = sc.run(sc.Study(trials=2, world={"topology": "moving", "density": 2, "fill_ratio": 0.55}, **tables))
    trace = sc.replay(moving, 0, 1, links=True)
    for figure in (sc.plot.arena(moving, trial=1, tick="1.5 s"), sc.plot.arena(trace, tick=15)):
        assert "tick 15" in texts(figure)
    for options, said in (
        ({"setting": 1}, "setting=1"), ({"tick": "7 h"}, "tick=252000: this trial has ticks 0 to 20"),
        ({"tick": "soon"}, "tick = 'soon': should be a whole number, or a time"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=re.escape(said)):
            sc.plot.arena(moving, **options)
    assert "round 20" in texts(sc.plot.arena(small_results, tick=20))
    curves = [sc.plot.curves(small_results, trial=2), sc.plot.curves(sc.replay(small_results, 0, 2))]
    one, other = (drawn(figure.axes[0], "median") for figure in curves)
    np.testing.assert_array_equal(one, other)


# ---- any coordinate
def test_scatters_and_decisions_are_coloured_by_any_coordinate():
    parts = [study(["0.6"], topology=t, seed=k, trials=8) for k, t in enumerate(("ring", "full"))]
    results = xr.concat(parts, "setting")
    (ax,) = sc.plot.scatter(results, color="topology").axes
    for k, name in enumerate(("ring", "full")):
        one = results.isel(setting=k)
        middle = [np.median(one.convergence_round), np.median(one.convergence_error)]
        np.testing.assert_allclose(drawn(ax, f"median {name}"), [middle])
    (ax,) = sc.plot.lines(results, x="checkpoint", color="topology").axes
    assert ax.get_legend().get_title().get_text() == "topology"
    np.testing.assert_allclose(drawn(ax, "right full")[:, 1], 100 * results.correct[1].mean("trial"))
    assert len(sc.plot.scatter(results).axes) == 2
    assert [ax.get_title("left") for ax in sc.plot.scatter(results, cols="topology").axes] == ["(a) ring", "(b) full"]


def test_settings_that_are_pooled_count_a_trial_once():
    results = xr.concat([study(["0.6"], trials=8, seed=k, fill_ratio=f) for k, f in enumerate((0.5, 0.9))], "setting")
    (ax,) = sc.plot.lines(results, x="checkpoint", cols=[]).axes
    (lines,) = (c for c in ax.collections if c.get_label() == "interval 0.6")
    for k, line in enumerate(lines.get_segments()):
        _, *ends = estimate(results.correct.values[:, k].T, "mean", share=True)
        np.testing.assert_allclose(line[:, 1], 100 * np.array(ends))
    figure = sc.plot.lines(results, x="accuracy", cols=[], color="accuracy")
    both = np.concatenate([*results.convergence_error.values], axis=1)  # (trial, robots of both)
    np.testing.assert_allclose(intervals(figure.axes[0], "0.6"), [estimate(both, "median")[1:]])
    some = forget(results, setting=1, trial=slice(5, None))
    (ax,) = sc.plot.lines(some, x="accuracy", cols=[], color="accuracy").axes
    assert not intervals(ax, "0.6").size
    assert drawn(ax, "0.6")[0, 1] == pytest.approx(np.nanmedian(some.convergence_error))


@pytest.mark.long(but_every=2)
@pytest.mark.parametrize(("kind", "options", "said"), [
    ("lines", {"x": "robots", "color": "topology", "cols": []}, "2 fill ratios and 2 accuracies"),
    ("lines", {"x": "checkpoint", "color": "robots", "cols": "topology"}, "2 fill ratios and 2 accuracies"),
    ("scatter", {"cols": "topology"}, "2 numbers of robots and 2 fill ratios"),
    ("scatter", {}, ""),
])  # fmt: skip
def test_what_a_figure_pools_is_in_its_caption_and_in_the_log(kind, options, said, small_results, caplog, tmp_path):
    half = small_results["topology"].isin(["ring", "full"]).values
    results = small_results if said else small_results.isel(setting=half)  # which has a panel for each setting
    figure = getattr(sc.plot, kind)(results, **options)
    with caplog.at_level("INFO", "swarmcensus"):
        *_, file = sc.plot.save(figure, tmp_path / "f.png")
    assert "pooled" not in texts(figure)
    assert [one for one in caplog.messages if "pooled" in one] == ([f"f.png: pooled over {said}"] if said else [])
    about, *remarks = file.read_text(encoding="utf-8").split("\n- ")
    assert ([f"pooled over {said}"] if said else []) == [each.strip() for each in remarks if "pooled" in each]
    sizes, settings = {*results["robots"].values.tolist()}, results.sizes["setting"]
    assert f"{min(sizes)} to {max(sizes)} robots in each of {settings} settings" in " ".join(about.split())


# ---- lines
def test_axes_of_lines_begin_at_0_or_at_a_round_number():
    results = robots()
    results["convergence_error"][:] = np.linspace(0.8, 1.0, results["convergence_error"].size).reshape(3, 12, 8)
    (ax,) = sc.plot.lines(results, x="robots").axes
    assert -0.02 < ax.get_ylim()[0] <= 0
    results["convergence_error"] = results["convergence_error"] * xr.DataArray([0.0033, 0.1, 1], dims="setting")
    (ax,) = sc.plot.lines(results, x="robots").axes
    assert ax.get_yscale() == "log"
    assert ax.get_ylim()[0] == pytest.approx(0.002)


def test_lines_of_checkpoints_are_of_the_last_or_along_them(small_results):
    few = small_results.isel(setting=small_results["robots"].values == 5)
    figure = sc.plot.lines(few, y="correct", x="checkpoint", color="topology", form="lines")
    assert len(figure.axes) == 4
    first = few.isel(setting=0)
    at = drawn(figure.axes[0], "full")
    np.testing.assert_allclose(at, np.stack([first["checkpoint"], first["correct"].mean("trial")], 1))
    assert figure.axes[-1].get_xlabel() == "communication rounds"
    short = few.assign_coords(rounds=("setting", np.full(few.sizes["setting"], 20)))
    (ax,) = sc.plot.lines(short, y="correct", x="topology", cols=[], color="rounds").axes
    ring = short["correct"].values[short["topology"].values == "ring", 0]
    assert drawn(ax, "20")[1, 1] == pytest.approx(ring.mean())


def test_any_variable_that_has_trials_is_drawn_with_its_unit():
    results = robots()
    rng = np.random.default_rng(0)
    results["battery_used"] = (("setting", "trial"), rng.gamma(2, 10, (3, 12)), {"units": "J", "long_name": "used"})
    (ax,) = sc.plot.lines(results, y="battery_used").axes
    assert (ax.get_ylabel(), ax.get_xlabel()) == ("battery used, median (J)", "robots $N$")
    assert ax.get_xscale() == "log"
    (line,) = (line for line in ax.lines if line.get_label() == "line ")
    np.testing.assert_allclose(line.get_ydata(), results["battery_used"].median("trial"))
    expected = [estimate(row[:, None], "median")[1:] for row in results["battery_used"].values]
    np.testing.assert_allclose(intervals(ax, ""), expected)
    (ax,) = sc.plot.lines(results, y="battery_used", statistic="mean").axes
    np.testing.assert_allclose(ax.lines[0].get_ydata(), results["battery_used"].mean("trial"))
    with pytest.raises(InputError, match=r"what is measured here is convergence_round, .*battery_used"):
        sc.plot.lines(results, y="weather")
    results["messages_sent"] = results["convergence_round"].astype(float)
    for options, statistic in ({}, "mean"), ({"statistic": "median"}, "median"):
        (ax,) = sc.plot.lines(results, y="messages_sent", **options).axes
        assert ax.get_ylabel() == f"messages sent by a robot, {statistic}"
    results["final_estimate"] = results["convergence_error"]
    (ax,) = sc.plot.lines(results, y="worst_error").axes
    np.testing.assert_allclose(ax.lines[0].get_ydata(), np.median(numbers(results, "worst_error"), axis=1))


def test_what_never_happens_is_marked_and_not_drawn():
    results = robots()
    when = np.random.default_rng(0).uniform(1, 50, (3, 12, 8))
    when[0, :, :5] = np.inf  # most of the robots of every trial
    when[1, :, :1] = np.inf
    when[1, :6] = np.inf  # of half of the trials, all
    results["stop_round"] = (("setting", "trial", "robot"), when, {"units": "rounds", "long_name": "when it stops"})
    (ax,) = sc.plot.lines(results, y="stop_round", color="brain").axes
    assert drawn(ax, "infinite Minimalistic (paper)").tolist() == [[10, 1], [100, 1]]  # y is of the panel's height
    (line,) = (line for line in ax.lines if line.get_label() == "line Minimalistic (paper)")
    assert line.get_ydata() == pytest.approx([np.nan, np.nan, np.median(when[2])], nan_ok=True)
    assert np.isfinite(intervals(ax, "Minimalistic (paper)")[-1]).all()
    assert ax.get_ylim()[1] < 100
    assert "the median is infinite" in texts(ax.figure)
    assert "is infinite" not in texts(sc.plot.lines(results.isel(setting=[2]), y="stop_round"))
    assert "the mean is infinite" in texts(sc.plot.lines(results, y="stop_round", statistic="mean"))
    never = results.assign(stop_round=results["stop_round"] * np.inf)
    with pytest.raises(InputError, match="y='stop_round': nothing to draw: it happened in no trial, or in"):
        sc.plot.scatter(never, x="robots", y="stop_round")
    assert_fits(sc.plot.lines(never, y="stop_round"))


def test_signs_of_infinity_hide_no_dots_and_no_others():
    parts = [robots((10, 100), brain=name) for name in ("minimalistic", "legacy", "commons", "swift")]
    results = xr.concat(parts, "setting").assign_coords(setting=np.arange(8))
    when = np.full((8, 12, 8), 40.0)
    when[1::2] = np.inf
    results["stop_round"] = (("setting", "trial", "robot"), when)
    (ax,) = sc.plot.lines(results, y="stop_round", x="robots", color="brain").axes
    ax.figure.draw_without_rendering()
    assert ax.get_ylim()[0] + 0.8 * np.diff(ax.get_ylim())[0] > 40.0
    signs = [line for line in ax.lines if "infinite" in line.get_label()]
    places = [line.get_transform().transform(line.get_xydata())[0] for line in signs]
    assert len(places) == 4
    assert min(np.abs(one - other).max() for one, other in itertools.combinations(places, 2)) > 8 * ax.figure.dpi / 72
    across = [x for x, _ in places]
    assert (min(across) + max(across)) / 2 == pytest.approx(ax.transData.transform((100, 40))[0])


def test_more_signs_than_fit_are_counted():
    axes, looks = Figure(figsize=(2, 2)).add_subplot(), [*looks_of([*TITLES][:20], "o", "brain").values()]
    add_endless(axes, {0.5: looks, 1.0: looks[:7], 0.2: looks[:2]})
    assert [text.get_text() for text in axes.texts] == ["20 ×", "7 ×"]
    assert [line.get_label().split()[1] for line in axes.lines] == ["20", "7", "Minimalistic", "Legacy"]


def test_errors_of_assumed_accuracies_are_numbers_on_their_axis():
    results = study(["0.8"] * 3, trials=6, assumed_accuracy=["error=-0.05", "error=0.0", "error=0.05"])
    (ax,) = sc.plot.lines(results, x="assumed_accuracy", width="column").axes
    ax.figure.draw_without_rendering()
    assert [label.get_text() for label in ax.get_xticklabels()] == ["-0.05", "0", "0.05"]
    assert ax.get_xlabel().endswith(", error")


def test_the_interval_of_a_median_may_reach_to_never():
    results = robots((10,))
    when = np.tile(np.arange(1.0, 9.0), (1, 12, 1))
    when[0, :5] = np.inf  # 5 of 12 trials: the median is finite, and might not be
    results["stop_round"] = (("setting", "trial", "robot"), when)
    (ax,) = sc.plot.lines(results, y="stop_round", x="robots").axes
    ((low, high),) = intervals(ax, "")
    assert 1.0 <= low < np.median(when) < high == ax.get_ylim()[1]


def never_agreeing():
    """Results of two brains in two worlds: none ever agrees in the first, one at once in the second."""
    results = made_up(brains=2, worlds=("ring", "full"), trials=6)
    times = np.full(results["consensus_round"].shape, np.inf)
    times[-1] = 3.0
    return results.assign(consensus_round=(("setting", "trial"), times),
                          consensus_right=(("setting", "trial"), times > 0))  # fmt: skip


def test_differences_of_times_that_never_come():
    figure = sc.plot.compare(never_agreeing(), metric="right_consensus_round")
    (ax,) = figure.axes
    assert [len(line.get_xdata()) for line in ax.lines if line.get_label().startswith("infinite")] == [1]
    assert not [line for line in ax.lines if line.get_label().startswith(("apart", "level"))]
    ax.figure.draw_without_rendering()
    assert [label.get_text() for label in ax.get_xticklabels()] == ["0"]
    assert "no dot" in sc.plot.caption(figure)
    assert "infinitely" in texts(figure)


def dots(*panels):
    lines = [line for ax in panels for line in ax.lines if str(line.get_label()).startswith(("apart", "level"))]
    return sorted(np.concatenate([line.get_xdata() for line in lines]).tolist())


def test_worlds_of_comparisons_have_panels_of_their_own():
    parts = [made_up(3, seed=k).assign_coords(fill_ratio=("setting", [f] * 6)) for k, f in enumerate((0.3, 0.6))]
    data = xr.concat(parts, "setting").assign_coords(setting=np.arange(12))
    every = dots(*sc.plot.compare(data, metric="final_error").axes)
    for rows, cols, count in (("topology", None, 2), (None, ["topology"], 2), ("topology", "fill_ratio", 4)):
        panels = sc.plot.compare(data, metric="final_error", rows=rows, cols=cols).axes
        assert (len(panels), dots(*panels)) == (count, every)
    panels = sc.plot.interaction(data, by="topology", cols="fill_ratio", metric="final_error").axes
    assert [ax.get_title("left") for ax in panels] == ["(a) f = 0.3", "(b) f = 0.6"]
    for ax, part in zip(panels, parts, strict=True):
        (alone,) = sc.plot.interaction(part, by="topology", metric="final_error").axes
        np.testing.assert_allclose(drawn(ax, "Voter model"), drawn(alone, "Voter model"))
    with pytest.raises(InputError, match="worlds differ in topology, fill_ratio"):
        sc.plot.compare(data, rows="robots")
    for kind in (sc.plot.compare, sc.plot.lines):
        with pytest.raises(InputError, match="it has the rows"):
            kind(data, rows="topology", cols="topology")


def test_a_front_of_one_has_no_line_in_the_key():
    assert "front: none" in texts(sc.plot.pareto(made_up(brains=4)))
    assert "front: none" not in texts(sc.plot.pareto(never_agreeing(), metric="right_consensus_round"))


def test_numbers_of_an_axis_have_one_format():
    assert Numbers().format_ticks([0, 0.0005, 0.001]) == ["0", "0.0005", "0.001"]
    assert Numbers().format_ticks([0, 0.00005, 0.0001]) == ["0", "5e-5", "1e-4"]
    assert Numbers().format_ticks([0, 5000, 10000]) == ["0", "5k", "10k"]
