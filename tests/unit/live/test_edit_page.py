"""The live page in a real browser: it opens playing, follows a brain file, keeps its view, and saves what it shows."""

import re

import pytest

from swarmcensus import brains
from swarmcensus.live.offers import offer_of
from swarmcensus.live.server import listen, serving
from tests.support.browsing import come, playwright, pytestmark as marks, until
from tests.support.watching import save

pytestmark = marks


def test_it_opens_playing_with_curves(page, served):
    come(page, served.address("setting=1"))
    until(page, "state.playing && state.drawn > 5 && state.charts.histories[0].of('median')[5] !== null", True)
    assert page.input_value("#colour") == "off"
    page.click("#play")
    until(page, "state.settled?.length", 1)
    assert "K, round of settling" in page.inner_text("#numbers")
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
def test_two_fingers_zoom(browser, served):
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    phone = context.new_page()
    come(phone, served.address(), 0)
    phone.locator("#stages .stage").scroll_into_view_if_needed()
    box = phone.locator("#stages .stage").bounding_box()
    x, y = box["x"] + box["width"] / 4, box["y"] + box["height"] / 2
    session = context.new_cdp_session(phone)

    def touch(kind, apart):
        points = [{"x": x - apart, "y": y, "id": 0}, {"x": x + apart, "y": y, "id": 1}] if apart else []
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    touch("touchStart", 20)
    for apart in (25, 30, 40):
        touch("touchMove", apart)
    touch("touchEnd", 0)
    zoom, centre = phone.evaluate("[state.view.zoom, state.view.centre]")
    assert zoom == pytest.approx(2.0)
    assert centre == pytest.approx([0.375, 0.5], abs=0.02)  # what was between the fingers still is
    assert phone.evaluate("visualViewport.scale") == 1
    context.close()


@pytest.mark.long
def test_a_brain_is_edited_while_it_is_watched(page, tmp_path):
    mine = tmp_path / "mine.py"
    text = brains.load("census").source
    save(mine, text, 100)
    with serving(made := listen(offer_of(None, (mine,)))):
        come(page, made.address(f"brain={mine}&topology=ring&robots=6&tick=33"), 33)
        assert (
            page.evaluate("[...document.querySelectorAll('#parameters input')].map(one => one.name)")[0] == "momentum"
        )
        page.fill("#control-momentum", "0.5")
        page.keyboard.press("Tab")
        until(page, "[state.drawn, state.scenes[0].title.includes('momentum = 0.5')]", [33, True])
        save(mine, text.replace("def fuse(me):", "def fuse(me:"), 200)
        playwright.expect(page.locator("#broken")).to_contain_text("The page shows the brain as it was before.")
        save(mine, text.replace('"crowd": 50.0', '"crowd": 60.0'), 300)
        until(page, "[state.drawn, state.scenes[0].title.includes('crowd = 60.0')]", [33, True])
        assert page.locator("#broken").is_hidden()
        assert page.input_value("#control-momentum") == "0.5"
        page.fill("#control-momentum", "much")
        page.keyboard.press("Tab")
        playwright.expect(page.locator("#error")).to_contain_text("momentum = 'much'")
        page.select_option("#control-brain", "minimalistic")  # which has no such parameter
        until(page, "[state.preparing, state.form.parameters.length, state.drawn]", [False, 0, 33])


@pytest.mark.long
def test_pictures_films_and_the_page_are_saved(page, served, tmp_path):
    come(page, served.address("setting=1&beside=commons&liars=0.3"), 0)
    page.click("#save summary")
    page.fill("#seconds", "1")
    found = {}
    for button in ("picture", "film", "page"):
        with page.expect_download(timeout=60_000) as saved:
            page.click(f"#{button}")
        saved.value.save_as(tmp_path / saved.value.suggested_filename)
        found[button] = tmp_path / saved.value.suggested_filename
    assert re.fullmatch(r"minimalistic-commons-round-0\.png", found["picture"].name)
    content = found["picture"].read_bytes()
    assert (content[:4], content[16:24]) == (b"\x89PNG", (2560).to_bytes(4, "big") + (1440).to_bytes(4, "big"))
    film = found["film"].read_bytes()
    assert film[4:8] == b"ftyp" if found["film"].suffix == ".mp4" else film[:4] == b"\x1aE\xdf\xa3"
    assert len(film) > 10_000
    page.goto("about:blank")
    page.goto(f"file://{found['page']}")
    until(page, "[state.scenes.length, state.scenes[0]?.dishonest.length, state.settled?.length]", [2, 4, 2])
