"""The live page of a swarm that runs, in a real browser: it follows, is wound back, and is told of the end."""

import re

import pytest

from swarmcensus.watching.offers import offer_of
from swarmcensus.watching.server import listen, serving
from tests.test_watch_growing import Day, whole  # noqa: F401 - a fixture
from tests.test_watch_page import browser, come, page, playwright, until  # noqa: F401 - fixtures
from tests.test_watch_page import pytestmark as marks

pytestmark = [*marks, pytest.mark.interpreted]


def newest(shown):
    """Wait until the newest moment is drawn; returns its number."""
    until(shown, "state.live && state.drawn === rounds() && !state.asking", True)
    return shown.evaluate("rounds()")


def grown(shown, day, share, before):
    day.grow(share)
    until(shown, f"rounds() > {before}", True)


@pytest.mark.parametrize("size", [(1280, 900), (390, 844)])
def test_it_follows_is_wound_back_and_is_told_of_the_end(page, whole, tmp_path, size):  # noqa: F811 - fixtures
    page.set_viewport_size({"width": size[0], "height": size[1]})
    day = Day(whole, tmp_path / "day")
    served = listen(offer_of(day.folder))
    clock, live = page.locator("#clock"), page.locator("#live")
    with serving(served):
        come(page, served.address())
        first = newest(page)
        grown(page, day, 0.3, first)
        at = newest(page)
        playwright.expect(clock).to_have_text(f"round {at} of {at}")
        playwright.expect(live).to_have_attribute("aria-pressed", "true")
        playwright.expect(page.locator("#play")).to_have_text(re.compile("Pause"))
        assert "tick=" not in page.evaluate("fragment()")
        assert f"tick={at}" in page.evaluate("fragment(false)")

        page.locator("#moment").fill("3")
        playwright.expect(clock).to_have_text(f"round 3 of {at} so far")
        playwright.expect(live).to_have_attribute("aria-pressed", "false")
        grown(page, day, 0.5, at)
        playwright.expect(clock).to_have_text(re.compile(rf"^round 3 of (?!{at} )\d+ so far$"))
        until(page, "state.charts.histories[0].missing(rounds() + 1) === null", True)

        page.click("#play")  # plays from there, and follows when it has caught up
        at = newest(page)
        page.click("#play")
        grown(page, day, 0.7, at)
        playwright.expect(clock).to_have_text(re.compile(rf"^round {at} of \d+ so far$"))
        live.click()
        at = newest(page)
        page.evaluate("choose(1)")
        page.wait_for_selector(f'#told[data-robot="1"][data-tick="{at}"]', timeout=20_000)

        beside = page.locator("#control-beside")
        playwright.expect(beside).to_be_disabled()
        grown(page, day, 1.0, at)
        day.tell({})
        playwright.expect(live).to_be_hidden(timeout=20_000)
        playwright.expect(beside).to_be_enabled()
        last = page.evaluate("rounds()")
        playwright.expect(clock).to_have_text(f"round {last} of {last}")
        until(page, "state.charts.histories[0].missing(rounds() + 1) === null", True)
        beside.select_option("voter")
        until(page, "state.scenes.length === 2 && state.drawn === 0", True)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
