"""The live page of a swarm that runs, in a real browser: it follows, is wound back, and is told of the end."""

import re

import pytest

from swarmcensus.live.choices import offer_of
from swarmcensus.live.server import listen, serving
from tests.support.browsing import come, playwright, pytestmark as marks, until

pytestmark = [*marks, pytest.mark.interpreted]


@pytest.fixture
def watched(page, recording):
    """The page of a day that grows, and the day."""
    with serving(served := listen(offer_of(recording.folder))):
        come(page, served.address())
        yield page, recording


def newest(shown):
    """Wait until the newest moment is drawn; returns its number."""
    until(shown, "state.live && state.drawn === rounds() && !state.asking", True)
    return shown.evaluate("rounds()")


def grown(shown, recording, share, before):
    recording.grow(share)
    until(shown, f"rounds() > {before}", True)


@pytest.mark.long(but=["size0"])
@pytest.mark.parametrize("size", [(1280, 900), (390, 844)])
def test_it_follows_rewinds_and_learns_of_the_end(watched, size):
    shown, recording = watched
    shown.set_viewport_size({"width": size[0], "height": size[1]})
    clock, live = shown.locator("#clock"), shown.locator("#live")
    grown(shown, recording, 0.3, newest(shown))
    at = newest(shown)
    playwright.expect(clock).to_have_text(f"round {at} of {at}")
    playwright.expect(live).to_have_attribute("aria-pressed", "true")
    playwright.expect(shown.locator("#play")).to_have_text(re.compile("Pause"))
    assert "tick=" not in shown.evaluate("fragment()")
    assert f"tick={at}" in shown.evaluate("fragment(false)")

    shown.locator("#moment").fill("3")
    playwright.expect(clock).to_have_text(f"round 3 of {at} so far")
    playwright.expect(live).to_have_attribute("aria-pressed", "false")
    grown(shown, recording, 0.5, at)
    playwright.expect(clock).to_have_text(re.compile(rf"^round 3 of (?!{at} )\d+ so far$"))
    until(shown, "state.charts.histories[0].missing(rounds() + 1) === null", True)

    shown.click("#play")  # plays from there, and follows when it has caught up
    at = newest(shown)
    shown.click("#play")
    grown(shown, recording, 0.7, at)
    playwright.expect(clock).to_have_text(re.compile(rf"^round {at} of \d+ so far$"))
    live.click()
    at = newest(shown)
    shown.evaluate("choose(1)")
    shown.wait_for_selector(f'#told[data-robot="1"][data-tick="{at}"]', timeout=20_000)

    grown(shown, recording, 1.0, at)
    recording.tell({})
    playwright.expect(live).to_be_hidden(timeout=20_000)
    last = shown.evaluate("rounds()")
    playwright.expect(clock).to_have_text(f"round {last} of {last}")
    until(shown, "state.charts.histories[0].missing(rounds() + 1) === null", True)
    assert shown.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_a_page_shows_nothing_that_needs_an_unknown_fill_ratio(page, recording):
    recording.grow(1.0)
    recording.tell({"fill_ratio": None, "ended": 1.0})
    with serving(served := listen(offer_of(recording.folder))):
        come(page, f"{served.address()}#colour=error&robot=1", 9)
        page.wait_for_selector("#told table")
        assert page.evaluate("[state.colour, state.charts.plots.length]") == ["belief", 2]
        words = page.locator("body").inner_text().lower()
        assert "mean estimate" in words
        assert not [one for one in ("truth", "fill ratio", "right bin", "f = ", "too high") if one in words]
