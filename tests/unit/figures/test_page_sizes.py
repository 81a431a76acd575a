"""Figures for a page of given width, height, letters and style; what they call brains; what they say."""

import itertools
import re

import matplotlib as mpl
import matplotlib.style
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text
from PIL import Image

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.figures.kinds import PLUGINS, find
from swarmcensus.summaries.table_of_summary import Summary
from swarmcensus.support.terminal import as_text
from tests.support.contending import made_up
from tests.support.drawing import study, texts
from tests.support.small import study_of

BELIEFS = """
trials = 6
swarm = {robots = 8, accuracy = [0.7, 0.8], assumed_accuracy = [0.7, 0.75, {error = "N(0, 0.05)"}]}
world = {topology = "full", fill_ratio = [0.55, 0.8]}
schedule = {rounds = 30}
"""


@pytest.fixture(scope="module")
def draw(small_results):
    """A function that draws a kind with some options."""
    studies = sc.Study.parse(BELIEFS), study_of(robots=6, accuracy=0.8, ticks=20, trials=1, density=2)
    beliefs, moving = (sc.run(one, jobs=1) for one in studies)
    two = small_results.isel(setting=np.isin(small_results["topology"].values, ["ring", "full"]))
    at_055 = two.isel(setting=two["fill_ratio"].values == 0.55)
    results = {
        "lines": two, "heatmap": small_results.isel(setting=slice(0, 4)), "curves": small_results, "beliefs": beliefs,
        "arena": moving, **dict.fromkeys(("scatter", "columns"), at_055.isel(setting=at_055["robots"].values == 12)),
        **dict.fromkeys(("compare", "ranks", "pareto", "steps"), made_up(trials=6, gap=0.3)),
    }  # fmt: skip
    own = {
        "lines": {"x": "robots", "cols": "topology"}, "curves": {"setting": 3}, "columns": {"x": "checkpoint"},
        "beliefs": {"x": "belief", "theory": True}, "steps": {"form": "steps"},
    }  # fmt: skip

    def draw(kind, **options):
        return find(kind if kind in PLUGINS else "lines")(results[kind], **own.get(kind, {}), **options)

    return draw


FORMS = ("columns", "beliefs", "steps")  # of lines
KINDS = ("scatter", "lines", *FORMS, "heatmap", "curves", "arena", "compare", "ranks", "pareto")


def shown(figure: Figure) -> list[tuple[str, np.ndarray]]:
    """All texts of a figure that are not empty, with their boxes in dots."""
    figure.draw_without_rendering()
    texts = [t for t in figure.findobj(Text) if t.get_text().strip() and t.get_visible()]
    off = {id(t) for ax in figure.findobj(Axes) if not ax.axison for a in (ax.xaxis, ax.yaxis) for t in a.findobj(Text)}
    for ax in figure.findobj(mpl.axis.Axis):  # which keeps labels of ticks outside its limits
        low, high = sorted(ax.get_view_interval())
        off |= {id(t) for t in ax.get_ticklabels() if not low <= t.get_position()[ax.axis_name == "y"] <= high}
    return [(t.get_text(), t.get_window_extent()) for t in texts if id(t) not in off]


def assert_readable(figure: Figure, within: float = 1.0) -> None:
    """All texts stand on the paper, up to so many dots, none upon another, and keys are not cut in notebooks."""
    texts = shown(figure)
    for text, box in texts:
        assert min(box.x0, box.y0, figure.bbox.x1 - box.x1, figure.bbox.y1 - box.y1) >= -within, text
    for ax in figure.axes:
        assert all(ax.get_tightbbox().y0 <= key.get_window_extent().y0 + within for key in ax.findobj(Legend))
    for (one, box), (other, its) in itertools.combinations(texts, 2):
        wide = min(box.x1, its.x1) - max(box.x0, its.x0)
        high = min(box.y1, its.y1) - max(box.y0, its.y0)
        assert wide <= 1.5 or high <= 1.5, (one, other)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_readable_in_a_column_and_on_a_slide(kind, draw):
    measure = {"metric": "final_error"} if kind in ("compare", "ranks") else {}
    for width, inches in (("column", 3.5), ("slide", 10.0)):
        figure = draw(kind, width=width, **measure)
        assert figure.get_figwidth() == pytest.approx(inches)
        assert_readable(figure)


def test_what_a_page_has_no_room_for_is_in_further_files(small_file, small_results, here):
    lines = ["plot", str(small_file), "--kind", "lines", "--x", "robots", "--cols", "topology,fill_ratio"]
    assert main([*lines, "--width", "column", "--out", "f.png"]) == 0
    pages = sorted(here.glob("f*.png"))
    assert [page.name for page in pages] == [f"f-{k}.png" for k in range(1, len(pages) + 1)]
    assert len(pages) > 1
    for page in pages:
        with Image.open(page) as picture:
            assert picture.width == round(3.5 * 150)
            assert picture.height <= 9 * 150 + 1
    figure = sc.plot.lines(small_results, x="robots", cols=["topology", "fill_ratio"], width="column")
    assert_readable(figure)
    assert len(figure.findobj(Legend)) == len(pages)
    sc.plot.save(figure, "g.svg")
    written = [(here / f"g-{k}.svg").read_text() for k in (1, 2)]
    assert "(a) " in written[0]
    assert "(a) " not in written[1]
    assert all("sensor accuracy" in text and "robots" in text for text in written)
    high = sc.plot.lines(small_results, x="robots", cols="topology", width="column", height=12.0)
    assert high.get_figheight() == pytest.approx(12.0)


def test_variants_of_a_brain_are_contenders():
    given = {"brain": ["census", "steadfast", "mine.py", "mine.py"], "gain": [np.nan, np.nan, 0.1, 1.0]}
    given = {name: np.repeat(values, 2) for name, values in (given | {"z": [5.0, 4.0, np.nan, np.nan]}).items()}
    results = study(["0.7", "0.8"] * 4, **given)
    results.attrs["parameters"] = '{"census": ["z"], "steadfast": ["z"], "mine.py": ["gain"]}'
    figure = sc.plot.lines(results, x="accuracy", color="brain", width="column")
    assert len(figure.axes) == 1
    assert {"mine.py gain=0.1", "mine.py gain=1", "Census", "Steadfast"} <= {*texts(figure).splitlines()}
    assert (1 - figure.axes[0].get_position().y1) * figure.get_figheight() < 0.15, "no room for a missing caption"
    captions = [ax.get_title("left")[4:] for ax in sc.plot.scatter(results).axes]
    assert captions == ["Census", "Steadfast", "mine.py gain=0.1", "mine.py gain=1"]
    assert len(sc.plot.lines(results, x="gain", color="accuracy").axes) == 3
    assert sc.plot.heatmap(results, z="convergence_error").axes[0].images[0].get_array().shape == (4, 2)
    alone = results.isel(setting=results["brain"].values == "mine.py")
    assert len(sc.plot.lines(alone, x="gain").axes) == 1


def test_a_slide_has_thick_lines_and_room_for_four_panels(draw):
    thin, thick = (draw("lines", **page).axes[0].lines[0].get_linewidth() for page in ({}, {"width": "slide"}))
    assert thick == pytest.approx(13.0 / 7.5 * thin)
    figure = sc.plot.pareto(made_up(worlds=("ring", "full", "line", "tree"), trials=6), width="slide")
    assert figure.get_figheight() == pytest.approx(7.5)
    assert_readable(figure)


@pytest.mark.parametrize(("width", "height"), [("slide", 5.625), (6.0, 2.5)])
def test_an_arena_is_readable_on_a_low_page(width, height, draw):
    figure = draw("arena", width=width, height=height)
    assert figure.get_figheight() == height
    assert_readable(figure)


def test_height_and_font_size(draw):
    for kind in ("scatter", "heatmap", "arena"):
        figure = draw(kind, width=5.0, height=8.0, font_size=6)
        assert figure.get_size_inches().tolist() == pytest.approx([5.0, 8.0]), kind
        assert_readable(figure)
    assert {t.get_fontsize() for t in draw("lines", font_size=12).axes[0].get_xticklabels()} == {12.0}


@pytest.mark.parametrize(("kind", "options", "said"), [
    ("lines", {"width": "wide"}, r"width='wide': should be 2 to 60 inches, or one of column, double, slide"),
    ("lines", {"font_size": float("nan")}, "font_size=nan: should be 4 to 40 points"),
    ("lines", {"width": "column", "height": 2.0}, r"height=2.0: this figure needs \d+\.\d inches at least"),
    ("ranks", {"height": 3.0}, "height=3.0: the height of this figure follows from the names in it"),
    ("arena", {"height": 2.0, "width": "column"}, r"height=2.0: this figure needs \d+\.\d inches at least"),
    ("lines", {"widht": 3.5}, "lines has no option 'widht': did you mean 'width'"),
    ("lines", {"labels": 3}, "labels=3: should be names by names"),
    ("pareto", {"labels": {"votre": "x"}}, r"labels=\{'votre': 'x'\}: did you mean 'voter'\? the brains here are"),
    ("pareto", {"labels": {"voter": "minimalistic"}}, "minimalistic and voter would both be called 'minimalistic'"),
    ("pareto", {"labels": {"bayes-bots": "Voter model"}}, "bayes-bots and voter would both be called 'Voter model"),
])  # fmt: skip
def test_impossible_pages_are_refused_in_a_line(kind, options, said, draw):
    with pytest.raises(sc.InputError, match=said):
        draw(kind, **options)


@pytest.mark.long
def test_figure_size_in_each_format(small_file, here, refused):
    plot = ["plot", str(small_file), "--kind", "lines", "--x", "robots", "--cols", "topology", "--color", "accuracy"]
    size = ["--width", "column", "--height", "8", "--dpi", "100", "--font-size", "6"]
    for out in ("f", "f.pdf"):  # without a suffix, a PNG and an SVG
        assert main([*plot, *size, "--out", out]) == 0
    with Image.open("f.png") as picture:
        assert picture.size == (350, 800)
    svg = (here / "f.svg").read_text()
    assert 'width="252pt" height="576pt"' in svg
    assert re.search("<text [^>]*>scale-free</text>|<text [^>]*>\\(\\w\\) scale-free</text>", svg)  # text stays text
    assert b"/FontFile2" in (here / "f.pdf").read_bytes()  # TrueType: letters that editors know
    for wrong, said in (
        ("--dpi 5", "--dpi 5: should be 10 to 2400 dots per inch"),
        ("--style gplot", "--style gplot: is neither a style nor a file of one: there are "),
        ("--width tiny", "--width tiny: should be 2 to 60 inches, or one of column, double, slide"),
        ("--label minimalistic=a --label minimalistic=b", "--label"),
    ):
        assert said in refused(*plot, *wrong.split(), "--out", "wrong.png")


def test_styles_are_respected(draw, small_file, here):
    with mpl.rc_context({"font.size": 5.0, "axes.facecolor": "#ffeeee", "axes.grid": True}):
        axes = draw("lines").axes[0]
    assert {t.get_fontsize() for t in axes.get_xticklabels()} == {5.0}
    assert mpl.colors.to_hex(axes.get_facecolor()) == "#ffeeee"
    (here / "mine.mplstyle").write_text("axes.facecolor: eeffee\nsavefig.dpi: 50\n")
    plot = ["plot", str(small_file), "--kind", "curves", "--width", "4", "--height", "3"]
    assert main([*plot, "--style", "mine.mplstyle", "--out", "styled.png"]) == 0
    with Image.open("styled.png") as picture:
        picture = picture.convert("RGB")
    assert picture.size == (200, 150)
    assert (238, 255, 238) in {colour for _, colour in picture.getcolors(100_000)}
    assert mpl.rcParams["axes.facecolor"] == "white"  # as before


# ---- names of brains
def test_labels_are_written_as_they_are(draw, tmp_path):
    labels = {"minimalistic": r"bad $\frac$ x", "bayes-bots": "voter and more", "voter": "census"}
    for kind in ("pareto", "compare"):
        figure = draw(kind, labels=labels)
        sc.plot.save(figure, tmp_path / "f.png")  # no part of a label is a formula
        written = " ".join(" ".join(text.split()) for text, _ in shown(figure)).replace(r"\$", "$")
        assert all(each in written for each in (*labels.values(), "voter and more prior=1")), kind
    long = {"minimalistic": "word " * 30}
    assert_readable(draw("compare", width="column", metric="final_error", labels=long))


TWO = """
trials = 2
swarm = {brain = ["minimalistic", "legacy"], robots = 4, accuracy = 0.8}
world = {topology = "ring", fill_ratio = 0.5}
schedule = {rounds = 5}
"""


def test_labels_change_names_only(here, accepted):
    path = here / "two.toml"
    path.write_text(TWO)
    assert main(["run", "two.toml", "-q"]) == 0
    before = sc.load("two.nc")
    path.write_text(TWO + '[labels]\nlegacy = "The old rule"\n')
    assert "found 4 of 4 trials" in accepted("run", "two.toml").err.replace("all ", "")  # nothing is run again
    after = sc.load("two.nc")
    assert after.equals(before)
    assert after["fingerprint"].values.tolist() == before["fingerprint"].values.tolist()
    assert "The old rule" in accepted("show", "two.nc").out
    out = accepted("compare", "two.nc", "--against", "legacy", "--label", "minimalistic=New").out
    assert "better, - worse than The old rule" in out
    assert "New" in out
    figure = sc.plot.lines(after, x="brain")
    assert [t.get_text() for t in figure.axes[0].get_xticklabels()] == ["Minimalistic (paper)", "The old rule"]
    for labels, said in (
        ('{legaci = "x"}', "labels: no brain is called 'legaci': did you mean 'legacy'?"),
        ('{legacy = "Minimalistic (paper)"}', r"minimalistic and legacy would both be called 'Minimalistic \(paper\)'"),
        ('{legacy = ""}', "labels.legacy"),
    ):
        with pytest.raises(sc.InputError, match=said):
            sc.Study.parse(f"labels = {labels}\n{TWO}")


def test_a_label_changes_no_colour():
    results, colours = made_up(worlds=("ring",), trials=6), []
    for labels in ({}, {"voter": "Ours", "bayes-bots": "B"}):
        legend = sc.plot.pareto(results, labels=labels).axes[0].get_legend()
        colours.append([handle.get_markerfacecolor() for handle in legend.legend_handles[:4]])
    assert colours[0] == colours[1]


def test_equal_labels_of_two_brains():
    texts = [f"labels.{brain} = 'Ours'\n{TWO}".replace('["minimalistic", "legacy"]', f'"{brain}"')
             for brain in ("minimalistic", "legacy")]  # fmt: skip
    merged = sc.merge([sc.run(sc.Study.parse(text), jobs=1) for text in texts])
    figure = sc.plot.lines(merged, x="brain")
    assert [t.get_text() for t in figure.axes[0].get_xticklabels()] == ["Minimalistic (paper)", "Legacy (paper)"]
    assert sc.compare(merged).grid.contenders == ["minimalistic", "legacy"]


# ---- what figures say
def test_too_few_trials_are_said_as_compare_says_it(draw):
    data = made_up(trials=6, gap=0.3)
    said = [caution for caution in sc.compare(data).cautions if "cannot tell anything apart" in caution]
    assert len(said) == 2
    ranks, compared = (" ".join(sc.plot.caption(draw(kind)).split()) for kind in ("ranks", "compare"))
    assert said[1] in ranks
    assert said[0] in compared
    assert "cannot tell" not in sc.plot.caption(sc.plot.ranks(made_up(trials=20, gap=0.3)))


def test_ranks_say_which_test_a_bar_shows(draw):
    written = " ".join(" ".join(text for text, _ in shown(draw("ranks", width="column", metric="final_error"))).split())
    assert "A bar joins those that tests of pairs (corrected) do not tell apart" in written
    assert "Friedman's test: p < 0.001" in written


def test_one_sided_interval_is_dotted():
    text = BELIEFS.replace("[0.55, 0.8]", "0.55").replace("[0.7, 0.8]", "0.99")
    study = sc.Study.parse(text.replace('[0.7, 0.75, {error = "N(0, 0.05)"}]', "0.99"))
    results = sc.run(study, jobs=1)
    assert (results["correct"].isel(checkpoint=-1) == 1).all()
    figure = sc.plot.lines(results, x="checkpoint")
    assert "one-sided" in {c.get_label().split()[0] for axes in figure.axes for c in axes.collections}
    assert any("lower end only" in text for text, _ in shown(figure))
    out = as_text(Summary(results, results).print_on, 500)
    assert re.search(r"100\.0 +\[>= \d\d\.\d\]", out)
    assert "[>= x]: the same in all trials, so a lower end only" in out
    assert "medians, pooled over 6 trials of 8 robots" in out
