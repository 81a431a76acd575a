"""How smooth the live page is: pictures a second, and what memory does while it plays.

python benchmarks/watching.py [--quick]: a headless Chromium plays six swarms at 60 ticks a second, and the first for
five minutes. No tick is left out at this speed: where fewer pictures are drawn, time goes slower.
`benchmarks/trying.py` has the seconds to the first picture.
"""

import gc
import re
import shutil
import statistics
import time

import harness
import psutil
from playwright.sync_api import Page, sync_playwright

from swarmcensus.live.choices import offer_of
from swarmcensus.live.server import Served, listen, serving

SWARMS = {
    "25 robots that move": "",
    "1,000 robots that move": "robots=1000",
    "10,000 robots that move": "robots=10000",
    "1,000 robots, scale-free": "robots=1000&topology=scale-free",
    "10,000 robots, ring": "robots=10000&topology=ring",
    "10,000 robots, scale-free": "robots=10000&topology=scale-free",
}
SECONDS = 10


def tick_of(page: Page) -> int:
    return int(re.findall(r"[\d,]+", page.inner_text("#clock"))[0].replace(",", ""))


def first_picture(page: Page, address: str) -> float:
    page.goto("about:blank")
    began = time.perf_counter()
    page.goto(address)
    page.wait_for_selector("#clock:not(:empty)", state="attached", timeout=120_000)
    return time.perf_counter() - began


def watched(page: Page) -> tuple[float, float]:
    """Pictures and ticks a second, of a page that opened playing."""
    time.sleep(2)
    rates, before, began = [], tick_of(page), time.perf_counter()
    while time.perf_counter() - began < SECONDS:
        time.sleep(1)
        found = re.findall(r"\d+", page.inner_text("#rate"))
        rates += [int(found[0])] if found else []
    ticks = (tick_of(page) - before) / (time.perf_counter() - began)
    page.click("#play")
    return statistics.median(rates), ticks


def page_bytes(page: Page) -> float:
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.collectGarbage")
    used = session.send("Runtime.getHeapUsage")
    session.detach()
    return float(used["usedSize"] + used.get("backingStorageSize", 0))


def long_play(page: Page, served: Served, minutes: float) -> None:
    first_picture(page, served.address("rounds=1000000"))
    began = time.monotonic()
    while time.monotonic() - began < 60 * minutes + 1:
        gc.collect()
        server, heap = psutil.Process().memory_info().rss / 1e6, page_bytes(page) / 1e6
        at = f"{(time.monotonic() - began) / 60:4.1f} min, tick {tick_of(page):,}"
        print(f"  {at}: server {server:.0f} MB, page {heap:.1f} MB, {page.inner_text('#rate')}", flush=True)
        time.sleep(30)


@harness.question
def watching(minutes: float = 5.0, quick: bool = False) -> None:
    """Pictures a second of six swarms, and memory over so many minutes of play."""
    minutes = 0.2 if quick else minutes
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
    served = listen(offer_of(None))
    with serving(served), sync_playwright() as running:
        opened = running.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        page = opened.new_page(viewport={"width": 1280, "height": 900})
        for name, asked in SWARMS.items():
            first_picture(page, served.address(asked))  # compiles
            first = first_picture(page, served.address(asked))
            pictures, ticks = watched(page)
            told = f"first picture {first:.2f} s, {pictures:.0f} pictures and {ticks:.1f} ticks a second"
            print(f"{name}: {told}", flush=True)
        print(f"Memory over {minutes:g} minutes of play:")
        long_play(page, served, minutes)
        opened.close()


if __name__ == "__main__":
    harness.answer(globals())
