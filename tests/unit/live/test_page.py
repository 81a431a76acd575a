"""The live page in a real browser: it plays, tells what `replay` does, and is saved."""

import dataclasses
import math
import re
import threading
import time

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.live import server
from swarmcensus.live.choices import offer_of
from swarmcensus.live.exporting import export
from swarmcensus.live.server import listen, serving
from swarmcensus.live.sessions import Session
from swarmcensus.worlds.bodies import Body
from tests.support.browsing import PUT, at, come, contrast, playwright, pytestmark, until  # noqa: F401 - marks it
from tests.support.watching import LIARS, PAGE_STUDY

COUNTED = """(() => {
    window.asked = 0;
    const ask = state.source.ask.bind(state.source);
    state.source.ask = (...words) => { window.asked += 1; return ask(...words); };
})()"""


def told(page, robot, tick):
    """What the page says that a robot remembers."""
    page.wait_for_selector(f'#told[data-robot="{robot}"][data-tick="{tick}"]', timeout=20_000)
    return dict(page.locator("#told table", has_text="Memory").evaluate(
        "table => [...table.rows].map(row => [row.cells[0].textContent, row.cells[1].textContent])"
    ))  # fmt: skip


def number(text):
    return float(text.replace(",", ""))


@pytest.mark.long
def test_what_a_robot_looked_at_is_where_its_sensor_was(page, served):
    trace = sc.replay(sc.run(sc.Study.parse(PAGE_STUDY), jobs=1), 0, 2).isel(robot=5, round=slice(120 + 1))
    come(page, served.address("trial=2&tick=120&robot=5"), 120)  # at once, and not on the way through all before
    until(page, "state.stages[0].before.length", 121)
    page.evaluate("state.stages[0].before.sort((a, b) => a.tick - b.tick)")
    asked = "[look => !look.said, look => look.said, look => look.wrong]"
    drawn = page.evaluate(f"{asked}.map(of => state.stages[0].trail.places(of))")
    x, y, side = *trace["position"].values.T, trace.attrs["side"]
    cos, sin = np.cos(trace["heading"].values), np.sin(trace["heading"].values)
    ahead, left = Body().sensor
    places = np.stack([x + ahead * cos - left * sin, -(y + ahead * sin + left * cos)], axis=1) / side + 0.5
    looked, said, tile = (trace[name].values == 1 for name in ("looked", "reading", "tile"))
    for found, due in zip(drawn, (looked & ~said, looked & said, looked & (said != tile)), strict=True):
        assert due.any()
        np.testing.assert_allclose(found, places[due], atol=1e-3)


def test_it_plays_and_is_wound_to_and_fro(page, served):
    come(page, served.address(), 0)
    page.click("#play")
    playwright.expect(page.locator("#clock")).to_have_text(re.compile(r"^tick [1-9]\d+ of"), timeout=20_000)
    page.click("#play")
    page.keyboard.press("Home")
    at(page, 0)
    page.locator("#stages .stage").focus()
    page.keyboard.press("ArrowRight")
    at(page, 1)
    page.keyboard.press("Shift+ArrowRight")
    at(page, 101)
    page.keyboard.press("ArrowLeft")
    at(page, 100)
    page.keyboard.press("End")
    at(page, 300)
    page.locator("#moment").fill("150")
    at(page, 150)
    page.select_option("#speed", "Infinity")
    page.click("#play")
    at(page, 300)


@pytest.mark.long
def test_a_robot_is_clicked(page, served):
    come(page, served.address("setting=1"), 0)
    page.keyboard.press("ArrowRight")
    at(page, 1)
    page.locator("#stages .stage").scroll_into_view_if_needed()  # waits until it moves no more
    canvas = page.locator("#stages .stage").bounding_box()
    middle, reach = canvas["width"] / 2, 0.46 * canvas["width"]
    page.mouse.click(canvas["x"] + middle, canvas["y"] + middle - reach)  # the first of the ring stands at the top
    told(page, 0, 1)
    assert page.input_value("#which") == "0"
    page.keyboard.press("n")
    told(page, 1, 1)
    assert "Heard in this round" in page.inner_text("#told")


@pytest.mark.long
def test_a_brain_that_fails_is_asked_once(page, folder):
    text = sc.brains.load("minimalistic").source
    mine = folder / "fails.py"
    mine.write_text(text.replace("    t = me.t\n", "    t = me.t / (50.0 - me.t)\n", 1))
    with serving(made := listen(offer_of(None, (mine,)))):
        come(page, made.address(f"brain={mine}&topology=ring"), 0)
        page.evaluate(COUNTED)
        page.keyboard.press("End")
        playwright.expect(page.locator("#error")).to_contain_text("fails in trial 0", timeout=30_000)
        page.wait_for_timeout(1000)
        assert page.evaluate("window.asked") < 10
        page.keyboard.press("Home")
        playwright.expect(page.locator("#error")).to_be_hidden()


@pytest.mark.long
def test_a_crowd_is_a_picture_with_robots_to_click(page, served):
    come(page, served.address("setting=1&robots=500&tick=2"), 2)
    assert "each square a robot" in page.inner_text("#legend-text")
    stage = page.locator("#stages .stage")
    stage.scroll_into_view_if_needed()  # waits until it moves no more
    cell = stage.bounding_box()["width"] / 23
    stage.click(position={"x": 1.5 * cell, "y": 2.5 * cell})  # rows of 23
    told(page, 47, 2)


def test_what_is_wrong_is_said_and_nothing_is_lost(page, served):
    come(page, served.address("tick=40"), 40)
    page.fill("#control-density", "5000")
    page.keyboard.press("Tab")
    playwright.expect(page.locator("#error")).to_contain_text("density = 5000.0: the arena cannot hold")
    assert page.input_value("#control-density") == "4"
    assert page.get_attribute("#control-density", "aria-invalid") is None  # it is right again
    page.fill("#control-density", "5000")
    page.keyboard.press("Enter")
    until(page, "$('control-density').getAttribute('aria-invalid')", "true")
    page.keyboard.press("Home")
    come(page, served.address("robots=many"))
    playwright.expect(page.locator("#error")).to_contain_text('robots = "many": should be')
    come(page, served.address("robots=20&tick=301"), 0)
    playwright.expect(page.locator("#error")).to_contain_text("tick = 301: should be a whole number from 0 to 300")
    assert page.evaluate("state.scenes[0].robots") == 20


@pytest.mark.long
def test_small_robots_are_painted_where_they_are(page, served):
    come(page, served.address("robots=2000&density=1&tick=3"), 3)
    until(page, "state.drawn", 3)
    found = page.evaluate("""(() => {
        const stage = state.stages[0];
        const to = stage.squares.width / stage.size;
        const { data } = stage.squares.getContext("2d").getImageData(0, 0, stage.squares.width, stage.squares.width);
        const at = ([x, y]) => [x * stage.scale + 8, y * stage.scale + 8].map((place) => Math.round(place * to));
        const seen = Array.from({ length: 2000 }, (_, i) => at(stage.place(i)));
        return seen.filter(([x, y]) => data[4 * (y * stage.squares.width + x) + 3] === 255).length;
    })()""")
    assert found > 1980  # some at the edge are left out


@pytest.mark.long
def test_a_request_that_ends_the_connection_is_given_up(page, served, monkeypatch):
    begun, commands = Session.answer, []

    def deadly(session, words):
        if '"robots":"77"' in words:
            commands.append(words)
            raise RuntimeError("as of a socket that is closed")
        return begun(session, words)

    monkeypatch.setattr(Session, "answer", deadly)
    come(page, served.address("setting=1"), 0)
    page.evaluate(f"{{ {PUT} put('robots', '77'); }}")
    playwright.expect(page.locator("#error")).to_contain_text("The connection was lost twice")
    page.keyboard.press("End")
    at(page, 300)
    until(page, "[state.source.tries, state.source.waiting.size, state.scenes[0].robots]", [0, 0, 12])
    assert len(commands) == 2


@pytest.mark.long
def test_page_reconnects_to_a_returning_server(browser, folder, monkeypatch):
    page = browser.new_page()
    first = listen(offer_of(folder / "study.toml"))
    port = first.port
    with serving(first):
        come(page, first.address("setting=1&tick=40"), 40)
        gone = time.monotonic()
    page.evaluate("seek(200)")
    playwright.expect(page.locator("#error")).to_contain_text("The server is gone")
    assert time.monotonic() - gone < 4  # within two seconds, on a machine that has nothing else to do
    page.wait_for_timeout(800)
    assert page.locator("#waiting").is_hidden()  # one state at a time
    again = listen(first.offer, port=port)
    with serving(dataclasses.replace(again, token=first.token)):
        at(page, 200)
        assert page.locator("#error").is_hidden()
    with serving(dataclasses.replace(listen(first.offer, port=port), token=first.token)), monkeypatch.context() as full:
        full.setattr(server, "MOST_PAGES", 0)
        playwright.expect(page.locator("#error")).to_contain_text("The server takes no more pages")
    with serving(listen(first.offer, port=port)):  # begun anew, with a token of its own
        playwright.expect(page.locator("#error")).to_contain_text("Another server answers here")
    page.close()


@pytest.mark.long(only=["0"])
@pytest.mark.parametrize("setting", [0, 1])
def test_an_export_opens_from_disk(page, folder, setting):
    path = folder / f"run-{setting}.html"
    export(offer_of(folder / "study.toml"), {"setting": str(setting), "trial": "2"}, path, {"tick": "77"})
    text = path.read_text()
    assert not re.search(r"(src|href)=.https?:|url\(|import ", text.split('<script id="recorded"')[0])
    come(page, f"file://{path}", 77)
    come(page, f"file://{path}#tick=120&robot=5", 120)
    trace = sc.replay(sc.run(sc.Study.parse(PAGE_STUDY), jobs=1), setting, 2)
    shown = told(page, 5, 120)
    for name in ("t", "n", "x_hat", "x"):
        assert number(shown[name]) == pytest.approx(float(trace[name].values[120, 5]), rel=1e-6)
    page.select_option("#plot", "x_hat")
    until(page, "state.charts.memory?.history.missing(121)", None)
    row = page.evaluate("['value', 'median', 'highest'].map(name => state.charts.memory.history.of(name)[120])")
    values = trace["x_hat"].values[120]
    assert row == pytest.approx([values[5], np.median(values), values.max()], rel=1e-6)
    page.click("#play")
    at(page, 300)


@pytest.mark.long(but=["light-360"])
@pytest.mark.parametrize(("scheme", "width"), [("light", 360), ("dark", 640), ("light", 1280)])
def test_text_stands_out_and_nothing_sticks_out_sideways(page, served, scheme, width):
    """Each text by at least 4.5 to 1 from what lies behind it, as WCAG asks. At 640 a page of 1280 is read at 200 %."""
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": width, "height": 800})
    come(page, served.address("robot=1&tick=20&beside=commons"), 20)
    told(page, 1, 20)
    time.sleep(0.3)
    assert page.locator("html").evaluate("root => root.scrollWidth") <= width
    found = page.locator("h1, h2, h3, p, label, th, td, button, option, figcaption, output, dt, summary").evaluate_all(
        """all => all.filter(one => one.offsetParent && one.textContent.trim()).map(one => {
            const ground = of => getComputedStyle(of).backgroundColor;
            let behind = one;
            while (behind.parentElement && ground(behind) === "rgba(0, 0, 0, 0)") behind = behind.parentElement;
            return [getComputedStyle(one).color, ground(behind), one.textContent];
        })"""
    )

    assert len(found) > 40
    for *colours, words in found:
        assert contrast([map(int, re.findall(r"\d+", one)[:3]) for one in colours]) >= 4.5, (*colours, words)


def test_it_opens_playing_with_curves(page, served):
    come(page, served.address("setting=1"))
    until(page, "state.playing && state.drawn > 5 && state.charts.histories[0].of('median')[5] !== null", True)
    assert page.input_value("#colour") == "off"
    page.click("#play")
    until(page, "state.settled?.length", 1)
    [k] = page.evaluate("state.settled")
    assert k > 1
    for tick, said in ((1, "not yet"), (math.ceil(k), str(round(k)))):  # not before it happens
        page.evaluate(f"seek({tick})")
        until(page, "state.drawn", tick)
        assert re.search(rf"K, round of settling\s+{said}\b", page.inner_text("#numbers"))
    page.emulate_media(reduced_motion="reduce")
    come(page, served.address("setting=1"))
    until(page, "[state.drawn, state.playing]", [0, False])


@pytest.mark.long
def test_an_address_holds_the_view(page, served):
    come(page, served.address("tick=40&robot=3&zoom=4&follow=1&log=1&full=1&speed=15"), 40)
    seen = "[state.view.zoom, $('follow').checked, $('log').checked, $('full').checked, state.speed, state.chosen]"
    assert page.evaluate(seen) == [4, True, True, True, 15, 3]
    assert page.evaluate("$('speed').selectedOptions[0].text") == "15 per second"  # though the page has no such choice
    page.keyboard.press("+")
    page.keyboard.press("l")
    page.keyboard.press("d")  # which ends following
    page.wait_for_url(re.compile(r"zoom=5\.6&centre=[\d.]+%2C[\d.]+&full=1&speed=15$"))


@pytest.mark.long
def test_liars_lead_one_of_two_brains_astray(page, served):
    come(page, served.address(), 40)
    page.click("#among")
    until(page, "state.drawn > 40 && state.scenes.length", 2)
    sizes = page.evaluate("state.charts.plots.map(plot => [plot.width, plot.height])")
    page.evaluate("pause(); seek(300)")
    until(page, "state.drawn", 300)
    off = "state.charts.now(side, 'mean') - state.charts.now(side, 'truth')"
    (led, far), (firm, near) = page.evaluate(f"state.scenes.map(({{brain}}, side) => [brain, {off}])")
    assert (led, firm, far > 0.2, abs(near) < 0.1) == ("commons", "steadfast", True, True)
    assert page.evaluate("$('legend-high').textContent") == "0.25+ too high"  # at any moment
    assert page.evaluate("state.charts.plots.map(plot => [plot.width, plot.height])") == sizes
    page.evaluate("change('floor', 'half')")
    until(page, "[state.preparing, state.drawn]", [False, 300])
    page.click("#among")
    until(page, "[state.preparing, state.scenes.length, state.scenes[0].dishonest.length]", [False, 1, 0])


def test_a_change_of_the_network_keeps_the_moment_or_says_why_not(page, served):
    come(page, served.address("setting=1"), 30)
    for network, tick, note in (
        ("line", 30, "A change keeps the moment."),
        ("moving", 0, "A round is no tick, so this trial begins at tick 0."),
    ):
        page.select_option("#control-topology", network)
        until(page, "[state.preparing, state.drawn, $('world-note').textContent]", [False, tick, note])
    page.evaluate("location.hash = '#setting=1&tick=50'")  # a link names its own moment
    until(page, "[state.preparing, state.scenes[0].unit, state.drawn]", [False, "round", 50])


@pytest.mark.long
def test_two_fingers_zoom(browser, served):
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    phone = context.new_page()
    come(phone, served.address(), 0)
    until(phone, "state.drawn", 0)
    phone.locator("#stages .stage").scroll_into_view_if_needed()
    box = phone.locator("#stages .stage").bounding_box()
    x, y = box["x"] + box["width"] / 4, box["y"] + box["height"] / 2
    session = context.new_cdp_session(phone)

    def touch(kind, apart):
        points = [{"x": x - apart, "y": y, "id": 0}, {"x": x + apart, "y": y, "id": 1}] if apart else []
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    for name in ("first", "back", "forth", "last", "nearer", "farther"):
        assert min(phone.locator(f"#{name}").bounding_box()[side] for side in ("width", "height")) >= 24
    touch("touchStart", 20)
    for apart in (25, 30, 40):
        touch("touchMove", apart)
    touch("touchEnd", 0)
    zoom, centre = phone.evaluate("[state.view.zoom, state.view.centre]")
    assert zoom == pytest.approx(2.0)
    assert centre == pytest.approx([0.375, 0.5], abs=0.02)  # what was between the fingers still is
    assert phone.evaluate("visualViewport.scale") == 1
    context.close()


def test_the_old_picture_stays_dimmed_until_the_new_one_is_there(page, served, monkeypatch):
    goes_on, begin = threading.Event(), Session._begin
    come(page, served.address("setting=1"), 30)
    monkeypatch.setattr(Session, "_begin", lambda *given: goes_on.wait(60) and begin(*given))
    run, robots = page.evaluate(f"{PUT} put('robots', '9'); [state.run, state.scenes[0].robots]")
    playwright.expect(page.locator("main[data-waits='1']")).to_be_visible(timeout=20_000)
    until(page, "[state.run, state.drawn, state.scenes[0].robots]", [run, 30, robots])  # drawn again in its new size
    page.wait_for_function("getComputedStyle(document.querySelector('#stages figure')).opacity < 0.5")
    goes_on.set()
    until(page, "[state.preparing, state.scenes[0].robots, state.drawn]", [False, 9, 30])
    playwright.expect(page.locator("main[data-waits]")).to_have_count(0)


@pytest.mark.long
def test_pictures_films_and_the_page_are_saved(page, served, tmp_path):
    come(page, served.address(f"setting=1&beside=commons&{LIARS}"), 0)
    found = {}
    for button in ("picture", "film", "page"):
        page.click("#save summary")
        page.fill("#seconds", "1")
        with page.expect_download(timeout=60_000) as saved:
            page.click(f"#{button}")
        saved.value.save_as(tmp_path / saved.value.suggested_filename)
        found[button] = tmp_path / saved.value.suggested_filename
        until(page, "$('save').open", False)
    assert re.fullmatch(r"minimalistic-commons-round-0\.png", found["picture"].name)
    content = found["picture"].read_bytes()
    assert (content[:4], content[16:24]) == (b"\x89PNG", (2560).to_bytes(4, "big") + (1440).to_bytes(4, "big"))
    film = found["film"].read_bytes()
    assert film[4:8] == b"ftyp" if found["film"].suffix == ".mp4" else film[:4] == b"\x1aE\xdf\xa3"
    assert len(film) > 10_000
    page.goto("about:blank")
    page.goto(f"file://{found['page']}")
    until(page, "[state.scenes.length, state.scenes[0]?.dishonest.length, state.settled?.length]", [2, 3, 2])
