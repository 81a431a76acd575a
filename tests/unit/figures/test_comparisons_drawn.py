"""Figures of comparisons, and against the number of liars."""

import numpy as np
import pytest
import xarray as xr

import swarmcensus as sc
from swarmcensus.brains.library import TITLES
from swarmcensus.figures.coordinates import panels_of, varies
from swarmcensus.figures.sheets import pages_of
from swarmcensus.summaries.labels import renamed_contender
from swarmcensus.support.errors import InputError
from tests.support.contending import made_up
from tests.support.drawing import drawn, texts


def test_profiles_have_no_band_at_0_and_one_for_equal_lines():
    results = made_up(brains=4, worlds=("ring",))
    results["consensus_round"][:2], results["consensus_round"][2:] = 5.0, np.inf
    results["consensus_right"][:] = 1.0
    (ax,) = sc.plot.lines(results, form="steps", y="right_consensus_round").axes
    assert len(ax.collections) == 1
    assert "95 % interval" in texts(ax.figure)
    steps = [line for line in ax.lines if line.get_drawstyle() == "steps-post"]
    assert [line.get_linestyle() != "-" for line in steps] == [False, True] * 2


# ---- differences
def test_differences_are_those_of_the_pairs_of_a_comparison():
    results = made_up(brains=3, gap=0.3)
    (ax,) = sc.plot.compare(results, metric="final_error").axes
    pairs = sc.compare(results, "final_error").pairs
    first = pairs["one"].iloc[0]
    for name in dict.fromkeys(pairs["other"]):
        rows, called = pairs[(pairs["one"] == first) & (pairs["other"] == name)], renamed_contender(name, TITLES)
        (lines,) = (c for c in ax.collections if c.get_label() == f"interval {called}")
        ends = np.array([segment[:, 0] for segment in lines.get_segments()])
        np.testing.assert_allclose(ends, -rows[["difference_high", "difference_low"]])
        dots = [drawn(ax, f"{way} {called}") for way, there in (("apart", True), ("level", False))
                if (rows["told_apart"] == there).any()]  # fmt: skip
        np.testing.assert_allclose(sorted(np.concatenate(dots)[:, 0]), sorted(-rows["difference"]))
    assert [t.get_text() for t in ax.get_yticklabels()] == ["ring", "full"]


def test_an_axis_of_differences_says_where_it_is_logarithmic():
    results = made_up(brains=3)
    assert "logarithmic" not in texts(sc.plot.compare(results, metric="final_error"))
    results["final_estimate"][5] += 0.4
    (ax,) = sc.plot.compare(results, metric="final_error").axes
    bend = ax.xaxis.get_transform().linear_width
    assert ax.get_xlabel().endswith(f"logarithmic beyond ±{bend:g}")
    assert len(ax.get_xticks()) >= 5
    assert {0.0, bend} <= {*ax.get_xticks().round(9)}


@pytest.mark.parametrize(("kind", "options"), [
    ("compare", {"metric": "convergence_round"}),
    ("lines", {"y": "convergence_round", "x": "topology"}),
    ("lines", {"y": "convergence_error", "x": "topology"}),
    ("pareto", {"metric": "convergence_round"}),
    ("ranks", {"metric": "convergence_round"}),
    ("scatter", {"color": "brain"}),
])  # fmt: skip
def test_robots_that_never_learnt_do_not_settle_first(kind, options):
    results = made_up(brains=4)
    results["convergence_round"].values[[3, 7]] = 0  # voter
    if kind == "scatter":
        results = results.drop_vars("decision").assign_coords(observations_per_round=("setting", [1] * 8))
    figure = getattr(sc.plot, kind)(results, **options)
    assert "voter: in 2 settings half of the robots never learnt (K = 0)" in " ".join(sc.plot.caption(figure).split())
    labels = [artist.get_label() for ax in figure.axes for artist in ax.lines]
    if kind in ("compare", "lines"):
        of_error = options.get("y") == "convergence_error"
        assert ("unlearnt Voter model" if of_error else "infinite Voter model") in labels
    if kind == "scatter":
        assert {"median minimalistic", "median voter"} & {*labels} == {"median minimalistic"}


def test_differences_in_k_are_in_ticks_if_robots_move():
    (axes,) = sc.plot.compare(made_up(brains=2, worlds=("moving",)), metric="convergence_round").axes
    assert "Δ K (ticks)" in axes.get_xlabel()


def test_names_of_ranks_are_whole_in_a_column():
    results = made_up(brains=4)
    first = str(results["brain"].values[0])
    figure = sc.plot.ranks(results, metric="final_error", width="column", labels={first: "Cross-inhibition"})
    assert "Cross-inhibition" in {text.get_text() for text in figure.axes[0].texts}
    left, right = figure.axes[0].get_xlim()
    assert 3 / (right - left) > 0.3  # of the width for the scale


def test_many_worlds_and_contenders_are_whole():
    many = made_up(brains=2, worlds=[f"net {k}" for k in range(41)], trials=6, robots=1)
    written = texts(sc.plot.compare(many, metric="final_error")).split("\n")
    assert {f"net {k}" for k in range(41)} <= {*written}
    assert "1 to 21 of 41 rows" in written
    high = made_up(brains=4, worlds=[f"net {k}" for k in range(14)], trials=6, robots=1)
    slides = pages_of(sc.plot.compare(high, metric="final_error", width="slide"))
    assert [part.box.height <= 7.51 for part in slides] == [True, True]
    names = [*TITLES][:14]
    brains = xr.concat([made_up(brains=1, worlds=("ring", "full"), trials=6, seed=k) for k in range(14)], "setting")
    brains = brains.assign_coords(brain=("setting", np.repeat(names, 2)), setting=np.arange(28))
    (ring, full) = sc.plot.compare(brains, metric="final_error").axes
    assert [label.get_text() for label in ring.get_yticklabels()] == [TITLES[name] for name in names[1:]]
    assert [ax.get_label() for ax in (ring, full)] == ["ring, final error", "full, final error"]


def test_ranks_of_many_brains_fit_a_slide_or_say_what_would():
    brains = xr.concat([made_up(brains=1, worlds=("ring",), trials=6, seed=k) for k in range(33)], "setting")
    brains = brains.assign_coords(brain=("setting", [*TITLES]), setting=np.arange(33))
    with pytest.raises(sc.InputError, match=r"33 contenders are too many .* of 7.5 inches: .* by font_size=10.0$"):
        sc.plot.ranks(brains, metric="final_error", width="slide")
    for those, size in ((brains[{"setting": slice(20)}], 13.0), (brains, 10.0)):
        assert 6.5 < sc.plot.ranks(those, metric="final_error", width="slide", font_size=size).get_figheight() <= 7.5


# ---- figures against the number of liars, and of coordinates that follow from the axes
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


@pytest.mark.interpreted
@pytest.mark.long
def test_lines_against_liars_begin_at_zero_liars(data):
    panels = [axes for axes in sc.plot.lines(data, x="liars", y="final_estimate").axes if lines_in(axes)]
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
    return liars(swarm={"robots": 8, "accuracy": 0.8}, world={"topology": "ring", "fill_ratio": CHANGES},
                 members=[{"robots": [0, 2], "brain": "opposite", "honest": False}])  # fmt: skip


@pytest.mark.interpreted
def test_what_follows_from_the_axes_does_not_vary_too(grid):
    assert list(varies(grid, {"adversary"})) == ["fill_ratio", "fill_ratio_change", "liars"]
    assert varies(grid, {"adversary", "fill_ratio_change"}) == {}
    assert len(panels_of(grid, ("adversary", "fill_ratio_change"))) == 1
    error, rounds = sc.plot.heatmap(grid, x="adversary", y="fill_ratio_change").axes
    cells = np.asarray(error.images[0].get_array())
    assert cells.shape == np.asarray(rounds.images[0].get_array()).shape == (2, 2)
    medians = [np.nanmedian(grid["convergence_error"].values[k]) for k in range(4)]
    assert sorted(cells.ravel()) == pytest.approx(sorted(medians))


@pytest.mark.interpreted
def test_what_does_not_follow_from_the_axes_still_varies(data, grid):
    assert list(varies(data, {"adversary", "brain"})) == ["liars"]  # one of them, or two
    rows = sc.plot.heatmap(data, x="adversary", y="brain", z="final_error").axes
    assert [axes.get_title("left").split("\n")[0] for axes in rows] == ["(a) 0 liars", "(b) 1 liars", "(c) 2 liars"]
    with pytest.raises(InputError, match="fill_ratio_change vary too"):
        sc.plot.heatmap(grid, x="adversary", y="liars", cols=[])
