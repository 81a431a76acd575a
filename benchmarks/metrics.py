"""What metrics of files cost: python benchmarks/metrics.py [--quick].

Prints, on one core and a ring of 100 robots that make 10 readings a round, ns per robot and round without metrics of
files, with each shipped one, and with all; and how long each takes to compile on a machine that has never seen it. What
is compared is run in turn, and the least of some repeats counts: on a shared machine the others measure the neighbours.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time

import numpy as np
from rich.console import Console
from rich.table import Table

from swarmcensus import Study
from swarmcensus.metrics import PLUGINS
from swarmcensus.runs.tasks import metrics_of
from swarmcensus.simulation.trials import run_batch

ROBOTS, ROUNDS, TRIALS = 100, 1000, 10
GO = np.zeros(1, np.uint8)
COMPILE = """
import sys, time, numpy as np
from swarmcensus.engine.compiler import blank_record, compile_metric
from swarmcensus.metrics import load
known = load("largest-jump" if sys.argv[1] == "mean-error" else "mean-error")  # compiles what Numba itself needs
blank = blank_record(known, rounds=1.0)
compile_metric(known).follow(blank, blank.repeat(2), np.zeros((1, 2)), 1, np.full((1, 3), 0.5), np.zeros(2))
begun = time.perf_counter()
metric = load(sys.argv[1])
blank = blank_record(metric, rounds=1.0)
compile_metric(metric).follow(blank, blank.repeat(2), np.zeros((1, 2)), 1, np.full((1, 3), 0.5), np.zeros(2))
print(time.perf_counter() - begun)
"""


def study_of(names):
    return Study(
        trials=TRIALS,
        swarm={"robots": ROBOTS, "accuracy": 0.7},
        world={"topology": "ring", "fill_ratio": 0.55},
        schedule={"rounds": ROUNDS},
        measure={"metrics": names},
    )


def seconds_of(study):
    begun = time.perf_counter()
    run_batch(study.settings()[0], study.seed, 0, TRIALS, metrics_of(study), GO)
    return time.perf_counter() - begun


def compiled_in(name):
    with tempfile.TemporaryDirectory() as cache:
        env = os.environ | {"SWARMCENSUS_CACHE": cache}
        found = subprocess.run(
            [sys.executable, "-c", COMPILE, name], env=env, capture_output=True, text=True, check=True
        )
    return float(found.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer repeats, and no compiling")
    quick = parser.parse_args().quick
    asked = {"none": [], **{name: [name] for name in PLUGINS.shipped}, "all of them": list(PLUGINS.shipped)}
    studies = {what: study_of(names) for what, names in asked.items()}
    least = dict.fromkeys(studies, np.inf)
    for study in studies.values():
        seconds_of(study)
    for _ in range(3 if quick else 15):
        for what, study in studies.items():
            least[what] = min(least[what], seconds_of(study))
    table = Table("metrics", "ns a robot and round", "ratio", "compiled in", title=f"ring of {ROBOTS} robots")
    for what, seconds in least.items():
        compiled = f"{compiled_in(what):.1f} s" if what in PLUGINS.shipped and not quick else "-"
        cost = 1e9 * seconds / (ROBOTS * ROUNDS * TRIALS)
        table.add_row(what, f"{cost:.1f}", f"{seconds / least['none']:.2f}", compiled)
    Console().print(table)


if __name__ == "__main__":
    main()
