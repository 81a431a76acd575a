"""What it costs to try something, from the shell: python benchmarks/trying.py [--cold].

Prints seconds, the least and the most of five: Python's own start, the program's, a small study that is compiled, and
one with a brain that nobody ever compiled, on a network, moving, then its first curves; then the same brain with
another comment. With --cold, also the first run on a machine, which compiles the engine's loops too.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

from swarmcensus import brains

NETWORK = """trials = 2
[swarm]
brain = "mine.py"
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
REPEATS = 5


def seconds(*words, cache=None, code=0):
    environment = os.environ | ({"SWARMCENSUS_CACHE": cache} if cache else {})
    begun = time.perf_counter()
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True, env=environment, check=False)
    spent = time.perf_counter() - begun
    assert done.returncode == code, done.stderr
    return spent


def program(*words, **more):
    return seconds("-m", "swarmcensus", *words, **more)


def edited(number, comment=""):
    """A brain like the shipped one that no cache knows."""
    source = brains.load("minimalistic").source.replace("1e-12", f"1e-12 * (1.0 + {number}e-16)")
    Path("mine.py").write_text(source + f"# {comment}\n")


def removed(name):
    Path(name).unlink(missing_ok=True)


def fresh(study, *then):
    """A run with a brain that was never compiled, or what follows it."""
    edited(time.time_ns())
    removed("out.nc")
    first = program("run", study, "--out", "out.nc")
    return program(*then) if then else first


def known(study):
    removed("out.nc")
    return program("run", study, "--out", "out.nc")


def commented():
    edited(1)
    known("network.toml")
    edited(1, f"a comment of {time.time_ns()}")
    return known("network.toml")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cold", action="store_true", help="also the first run on a machine: half a minute more")
    options = parser.parse_args()
    asked = {
        "python -c pass": lambda: seconds("-c", "pass"),
        "import swarmcensus": lambda: seconds("-c", "import swarmcensus"),
        "swarmcensus --help": lambda: program("--help"),
        "a results file that is not there": lambda: program("show", "nothing.nc", code=2),
        "a study with a wrong key": lambda: program("run", "wrong.toml", code=2),
        "run, compiled": lambda: known("network.toml"),
        "run, compiled, moving": lambda: known("moving.toml"),
        "run with a fresh brain": lambda: fresh("network.toml"),
        "run with a fresh brain, moving": lambda: fresh("moving.toml"),
        "then its first curves": lambda: fresh("network.toml", "plot", "out.nc", "--kind", "curves"),
        "curves again": lambda: program("plot", "out.nc", "--kind", "curves"),
        "run with another comment": commented,
    }
    table = Table("seconds from the shell", "least", "most")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("network.toml").write_text(NETWORK)
        Path("moving.toml").write_text(MOVING)
        Path("wrong.toml").write_text(NETWORK.replace("rounds", "roundz"))
        edited(0)
        for study in ("network.toml", "moving.toml"):
            known(study)  # the engine's loops
        program("plot", "out.nc", "--kind", "curves")
        for what, run in asked.items():
            spent = [run() for _ in range(REPEATS)]
            table.add_row(what, f"{min(spent):.2f}", f"{max(spent):.2f}")
        if options.cold:
            for study in ("network.toml", "moving.toml"):
                removed("out.nc")
                cost = program("run", study, "--out", "out.nc", cache=f"{folder}/{study}-cache")
                table.add_row(f"the first run on a machine, {study}", f"{cost:.2f}", "")
                cost = program("plot", "out.nc", "--kind", "curves", cache=f"{folder}/{study}-cache")
                table.add_row("then its first curves", f"{cost:.2f}", "")
        os.chdir("/")
    Console(width=100).print(table)


if __name__ == "__main__":
    main()
