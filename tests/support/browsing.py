"""The live page in a real browser: what its tests ask of it."""

import re
import shutil

import pytest

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")


BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)

PUT = "const put = (key, value) => { $(`control-${key}`).value = value; change(key, value); };"


pytestmark = [
    pytest.mark.skipif(BROWSER is None, reason="no Chromium here"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning"),
]


def come(page, address, tick=None):
    if tick is not None and "tick=" not in address:  # it would open playing
        address = f"{address}{'&' if '#' in address else '#'}tick={tick}"
    page.goto("about:blank")
    page.goto(address)
    page.wait_for_selector("#clock:not(:empty)", state="attached", timeout=60_000)
    if tick is not None:
        at(page, tick)


def at(page, tick):
    """Wait until a moment is shown."""
    playwright.expect(page.locator("#clock")).to_have_text(re.compile(rf"^(tick|round) {tick:,} of"), timeout=20_000)


def contrast(colours):
    """How far two colours stand out from each other, as WCAG computes it; each is three numbers up to 255."""
    lights = []
    for parts in colours:
        r, g, b = (x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in (x / 255 for x in parts))
        lights.append(0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05)
    return max(lights) / min(lights)


def until(page, what, value):
    """Wait until something in the page is so."""
    for _ in range(200):
        if page.evaluate(what) == value:
            return
        page.wait_for_timeout(50)
    assert page.evaluate(what) == value
