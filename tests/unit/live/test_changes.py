"""Changes on the live page: quick ones and wrong ones, sliders, links to them, and what is saved of a moment."""

import threading

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.live.sessions import Session
from tests.support.browsing import PUT, come, contrast, playwright, pytestmark, until  # noqa: F401 - marks this file
from tests.support.watching import LIARS, PAGE_STUDY


@pytest.fixture
def let(monkeypatch):
    """Lets the server begin so many trials; until then it waits."""
    may, begin = threading.Semaphore(0), Session._begin
    yield lambda: monkeypatch.setattr(Session, "_begin", lambda *given: may.acquire(timeout=60) and begin(*given)), may
    may.release(1000)


def test_quick_changes_stay(page, served, let):
    hold, may = let
    come(page, served.address("setting=1"), 30)
    hold()
    page.evaluate(f"{{ {PUT} put('robots', '9'); put('accuracy', '0.9'); seek(77); }}")
    assert "robots=9&accuracy=0.9" in page.evaluate("fragment(false)")
    may.release()
    until(page, "state.scenes[0].robots", 9)
    assert page.evaluate("[$('control-accuracy').value, state.preparing, state.tick]") == ["0.9", True, 77]
    may.release()
    until(page, "[state.preparing, state.form.now.accuracy, state.scenes[0].robots, state.drawn]",
          [False, "0.9", 9, 77])  # fmt: skip


def test_of_several_changes_only_the_wrong_one_is_lost(page, served, let):
    hold, may = let
    come(page, served.address("setting=1"), 30)
    hold()
    page.evaluate(f"{{ {PUT} put('robots', '9'); put('accuracy', 'abc'); put('link_success', '0.5'); }}")
    may.release(100)
    playwright.expect(page.locator("#error")).to_contain_text('accuracy = "abc"')
    now = "['robots', 'accuracy', 'link_success'].map(key => [state.form.now[key], $(`control-${key}`).value])"
    assert page.evaluate(now) == [["9", "9"], ["0.75", "0.75"], ["0.5", "0.5"]]
    assert page.locator("[aria-invalid]").count() == 0  # 0.75 is right
    page.fill("#control-accuracy", "abc")
    page.keyboard.press("Enter")  # what was typed stays in a field that has the focus
    playwright.expect(page.locator("[aria-invalid]")).to_have_attribute("id", "control-accuracy")
    page.evaluate(f"{{ {PUT} put('robots', '8'); }}")
    assert page.locator("#error").is_hidden()
    until(page, "[state.preparing, state.scenes[0].robots, $('error').hidden]", [False, 8, True])
    assert page.locator("[aria-invalid]").count() == 0


@pytest.mark.long
def test_slider_of_the_fill_ratio_stops_at_no_edge_of_a_bin(page, served):
    come(page, served.address("setting=1"), 30)
    assert "f = 0.6 is on the edge between two of the 10 bins" in page.inner_text(".caution")
    stops = page.evaluate("[10, 3, 100].map(bins => STOPS.fill_ratio(bins))")
    for bins, found in zip((10, 3, 100), stops, strict=True):
        inner = np.array(found)[1:-1] if bins < 100 else np.array(found)
        assert np.abs(inner * bins - np.round(inner * bins)).min() > 0.005
        assert len(found) >= 90
    page.locator("#control-fill_ratio").focus()
    page.keyboard.press("ArrowUp")
    until(page, "[state.preparing, state.form.now.fill_ratio]", [False, "0.65"])
    page.fill("#control-fill_ratio", "0.6")
    page.locator("#controls .slid:has(#control-fill_ratio) [type=range]").focus()
    until(page, "[state.preparing, state.form.now.fill_ratio]", [False, "0.6"])
    page.keyboard.press("ArrowRight")
    until(page, "[state.preparing, state.form.now.fill_ratio, $('control-fill_ratio').value]", [False, "0.61", "0.61"])
    assert page.locator(".caution").count() == 0


def test_a_field_of_the_memory_is_drawn_over_time(page, served):
    trace = sc.replay(sc.run(sc.Study.parse(PAGE_STUDY), jobs=1), 1, 2)["x_bar"].values
    come(page, served.address("setting=1&trial=2&tick=120&robot=5"), 120)
    page.select_option("#plot", "x_bar")
    until(page, "state.charts.memory?.history.missing(121)", None)
    names = "['value', 'low', 'median', 'highest']"
    drawn = page.evaluate(f"{names}.map(name => state.charts.memory.history.of(name).slice(0, 121))")
    due = [trace[:121, 5], *np.quantile(trace[:121], (0.25, 0.5, 1.0), axis=1)]
    np.testing.assert_allclose(np.array(drawn), due, rtol=1e-12)
    assert page.inner_text(".chart h3 >> nth=0") == "x_bar: robot 5, and the swarm"
    until(page, "location.hash.includes('plot=x_bar')", True)  # the address follows a moment later
    come(page, served.address(page.url.split("#")[1]), 120)
    until(page, "state.charts.memory?.name", "x_bar")
    assert page.input_value("#plot") == "x_bar"


@pytest.mark.long
def test_opinions_are_counted(page, served):
    come(page, served.address(f"setting=1&brain=voter&{LIARS}"), 40)
    until(page, "state.drawn", 40)
    frame, columns = page.evaluate("[[...state.frames.get(40)[0].estimates], state.scenes[0].columns]")
    honest = np.delete(frame, page.evaluate("state.scenes[0].dishonest"))
    numbers = dict(zip(columns, page.evaluate("[...state.frames.get(40)[0].numbers]"), strict=True))
    assert numbers["black"] == pytest.approx(np.mean(honest == 65534))
    assert numbers["black"] + numbers["white"] == pytest.approx(1.0)
    assert page.inner_text(".chart h3 >> nth=0") == "Opinions of honest robots: shares for black and white"
    assert "in the right bin" not in page.inner_text("main")
    assert page.locator("#colour").is_hidden()
    assert page.locator("#full").is_hidden()  # shares have one axis
    assert "explore" not in page.inner_text("#title")


@pytest.mark.long
def test_a_picture_has_whole_curves_a_key_and_an_axis_to_read(page, served):
    come(page, served.address("tick=250&beside=voter"), 250)
    page.click("#save summary")
    with page.expect_download():
        page.click("#picture")
    assert page.evaluate("state.charts.histories.map(history => history.missing(250))") == [None, None]
    every = "(one) => { one.seen.forEach((_, k) => (one.seen[k] = 1 - k % 2)); return one.missing(100); }"
    assert page.evaluate(f"({every})(new History(state.scenes[0], 100))") == {"from": 1, "by": 1, "count": 99}
    keys, titles, axes = page.evaluate(
        """(async () => {
            const sheet = new Sheet(2);
            await new Promise(requestAnimationFrame);
            const measured = ({ axes: [{ _values, font }], ctx }) => {
                ctx.font = Array.isArray(font) ? font[0] : font;
                return _values.reduce((sum, text) => sum + ctx.measureText(text).width, 0);
            };
            return [
                sheet.keys.map(rows => rows.flat().map(({ label }) => label)),
                sheet.charts.plots.map(plot => plot.root.parentElement.firstElementChild.textContent),
                sheet.charts.plots.map(plot => [measured(plot), plot.bbox.width, plot.axes[0]._values.length]),
            ];
        })()"""
    )
    assert {"fill ratio", "median, minimalistic", "for black, voter", "middle half", "range"} <= {*keys[0]}
    assert any("on the edge" in entry for entry in keys[1])
    assert titles[0] == "Estimates, and shares of opinions"
    for wide, room, count in axes:
        assert count >= 3
        assert wide < 0.7 * room


@pytest.mark.long
def test_any_key_of_a_study_can_be_given(page, served):
    come(page, served.address("setting=1&body.tick=0.2"))
    playwright.expect(page.locator("#error")).to_contain_text("world.body is of robots that move")
    come(page, served.address("setting=1&missing_links=0.3"), 5)
    assert page.input_value("#control-missing_links") == "0.3"
    page.fill("[id='control-KEY=VALUE']", "bins = 4")
    page.keyboard.press("Enter")
    until(page, "[state.preparing, state.scenes[0].bins, $('control-bins')?.value]", [False, 4, "4"])
    page.wait_for_url("**missing_links=0.3*bins=4**")
    page.fill("#control-missing_links", "")
    page.keyboard.press("Enter")
    until(page, "[state.preparing, state.form.asked.missing_links ?? '', $('control-missing_links')]",
          [False, "", None])  # fmt: skip
    page.fill("[id='control-KEY=VALUE']", "bins")
    page.keyboard.press("Enter")
    playwright.expect(page.locator("#error")).to_contain_text("bins: should be KEY=VALUE, such as missing_links=0.1")


def test_liars_of_the_controls_are_members_of_the_study(page, served):
    come(page, served.address("setting=1&members=[{robots = 2, accuracy = 0.9}]"), 5)
    page.select_option("#control-adversary", "jammer")  # nobody lies yet
    page.fill("#control-liars", "0.25")
    page.keyboard.press("Enter")
    until(page, "[state.preparing, state.scenes[0].dishonest.length]", [False, 3])
    liars = '{robots = 0.25, brain = "jammer", honest = false}'
    assert page.evaluate("state.ask.members") == f"[{{robots = 2, accuracy = 0.9, honest = true}}, {liars}]"
    page.fill("#control-liars", "1")
    page.keyboard.press("Enter")
    playwright.expect(page.locator("#error")).to_contain_text("that is 14 of 12 robots")
    playwright.expect(page.locator("[aria-invalid]")).to_have_attribute("id", "control-liars")
    page.fill("#control-liars", "0")
    page.keyboard.press("Enter")
    until(page, "[state.preparing, state.scenes[0].dishonest.length]", [False, 0])


@pytest.mark.long
def test_all_is_on_one_screen(page, served):
    page.set_viewport_size({"width": 1280, "height": 800})
    for asked in ("robot=3&plot=t&fill_ratio=0.3", f"setting=1&brain=voter&{LIARS}", "beside=commons"):
        come(page, served.address(asked), 100)
        until(page, "state.settled?.length > 0 && state.drawn === 100", True)
        until(page, "document.documentElement.scrollHeight", 800)
        parts = page.locator("#stages, #plots, #controls, #numbers")
        assert max(parts.evaluate_all("all => all.map(one => one.getBoundingClientRect().bottom)")) <= 800
        assert page.locator("header").bounding_box()["height"] < 40
        assert page.locator("#title").evaluate("title => title.scrollHeight <= title.clientHeight")  # it is not cut
        assert min(stage.bounding_box()["width"] for stage in page.locator(".stage").all()) > 350
    page.set_viewport_size({"width": 390, "height": 844})
    come(page, served.address(), 100)
    picture, player = (page.locator(name).bounding_box() for name in ("#stages", "#player"))
    assert picture["y"] < 100
    assert picture["y"] < player["y"] < 844


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_links_and_robots_stand_out(page, served, scheme):
    """By at least 3 to 1 from the ground, as WCAG asks of what is no text; a full network is no solid disc."""
    page.emulate_media(color_scheme=scheme)
    come(page, served.address("setting=1&topology=full&robots=80&fill_ratio=0.65"), 5)
    until(page, "state.drawn", 5)

    ground, *drawn = (page.evaluate(f"tone('--{name}')") for name in ("sheet", "link", "edge"))
    for one in drawn:
        assert contrast([[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour in (one, ground)]) >= 3.0, one
    covered = page.evaluate(
        """(() => {
            const canvas = state.stages[0].web.getNativeCanvasElement();
            const inner = [0.3, 0.3, 0.4, 0.4].map(part => part * canvas.width);
            const { data } = canvas.getContext("2d").getImageData(...inner);
            return data.reduce((sum, value, k) => sum + (k % 4 === 3 ? value : 0), 0) / (data.length / 4) / 255;
        })()"""
    )
    assert 0.05 < covered < 0.6
