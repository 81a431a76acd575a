"""What a new user waits for: python benchmarks/trying.py [--cold] [--quick].

Seconds from the shell to a study's first results, to its curves, through `reproduce`, and to a moving picture of
`watch`, in a headless Chromium that is open already. With `--cold` also where
seconds of the processor go.
"""

import contextlib
import itertools
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import harness
import where_seconds_go
from playwright.sync_api import sync_playwright

from swarmcensus import brains

NETWORK = """trials = 2
[swarm]
brain = "minimalistic"
robots = 20
accuracy = 0.675
[world]
topology = "ring"
fill_ratio = 0.55
[schedule]
rounds = 200
"""
MOVING = NETWORK.replace('topology = "ring"', 'topology = "moving"\ndensity = 2.0').replace(
    "rounds = 200", "ticks = 1000"
)


def program(*words, edits=False):
    """A command; with `edits` its brain is another one each time."""

    def seconds(cache):
        if edits:
            edited()
        return [harness.program(*words, cache=cache).seconds]

    return seconds


def edited():
    """A brain file like the shipped one, that no cache knows."""
    source = brains.load("minimalistic").source
    Path("mine.py").write_text(source.replace("1e-12", f"1e-12 * (1.0 + {time.time_ns()}e-16)"))


def watched(page, *words):
    """A page of `watch` until its picture moves."""

    def seconds(cache):
        command = [sys.executable, "-m", "swarmcensus", "watch", "--quiet", "--no-browser", *words]
        environment = os.environ | ({"SWARMCENSUS_CACHE": str(cache)} if cache else {})
        begun = time.perf_counter()
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as running:
            page.goto(running.stdout.readline().strip())
            while not page.evaluate("typeof state !== 'undefined' && state.drawn > 0"):
                time.sleep(0.02)
            spent = time.perf_counter() - begun
            page.goto("about:blank")
            running.terminate()
        return [spent]

    return seconds


def parts_of(words, cache):
    """The processor's seconds of a command by part, of all its processes together."""
    written = Path("seconds.json")
    written.unlink(missing_ok=True)
    harness.process(where_seconds_go.__file__, written, *words, cache=cache)
    return sum((Counter(json.loads(line)) for line in written.read_text().splitlines()), Counter())


def show_parts(repeats):
    """Print where the seconds of first runs go, and of the same commands once compiled."""
    commands = {name: ("run", f"{name}.toml", "--out", "out.nc", "--fresh") for name in ("network", "moving")}
    commands["reproduce"] = ("reproduce", "--fresh")
    spent = {(name, kind): [] for name in commands for kind in ("first", "then")}
    for _ in range(repeats):
        for together in (("network", "moving"), ("reproduce",)):
            with tempfile.TemporaryDirectory() as empty:
                for name, kind in itertools.product(together, ("first", "then")):
                    spent[name, kind].append(parts_of(commands[name], empty))
    least = {key: min(runs, key=Counter.total) for key, runs in spent.items()}
    table = harness.table("seconds of the processor", "part", *(f"{name}, {kind}" for name, kind in least))
    for part in where_seconds_go.PARTS:
        table.add_row(part, *(f"{one[part]:.2f}" for one in least.values()))
    table.add_row("all", *(f"{one.total():.2f}" for one in least.values()))
    harness.show(table)


@harness.question
def trying(cold=False, quick=False):
    """The least and the most of three, or one if `quick`, once compiled; if `cold`, of one with nothing compiled."""
    again = "--out", "out.nc", "--fresh"
    network, moving = program("run", "network.toml", *again), program("run", "moving.toml", *again)
    curves = program("plot", "out.nc", "--kind", "curves")
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder), sync_playwright() as running:
        opened = running.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        page = opened.new_page(viewport={"width": 1280, "height": 900})
        asked = {
            ("a study of networks", "then its curves", "then one of robots that move"): (network, curves, moving),
            ("a study of robots that move alone",): (moving,),
            ("the first figure of `reproduce`",): (program("reproduce", "--only", "fig2", "--fresh"),),
            ("all of `reproduce`",): (program("reproduce", "--fresh"),),
            ("`watch`, a network",): (watched(page, "--set", "topology=ring"),),
            ("`watch`, robots that move",): (watched(page),),
        }
        if not cold:
            new, new_moving = (program("run", f"my-{name}.toml", *again, edits=True) for name in ("network", "moving"))
            asked |= {
                ("a study of networks, with a new brain", "then its curves"): (new, curves),
                ("a study of robots that move, with a new brain",): (new_moving,),
            }
        for name, study in ("network", NETWORK), ("moving", MOVING):
            Path(f"{name}.toml").write_text(study)
            Path(f"my-{name}.toml").write_text(study.replace('"minimalistic"', '"mine.py"'))
        edited()
        table = harness.table("seconds from the shell", "what", "least", "most")
        for names, commands in asked.items():
            rows = []
            for _ in range(1 if cold else 2 if quick else 4):
                with tempfile.TemporaryDirectory() as empty:
                    rows.append([spent for command in commands for spent in command(empty if cold else None)])
            rows = rows if cold else rows[1:]  # the first may compile
            for name, *spent in zip(names, *rows, strict=True):
                table.add_row(name, f"{min(spent):.2f}", f"{max(spent):.2f}")
        opened.close()
        harness.show(table)
        if cold:
            show_parts(1 if quick else 3)


if __name__ == "__main__":
    harness.answer(globals())
