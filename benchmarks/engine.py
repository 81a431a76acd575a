"""What the engine costs: python benchmarks/engine.py [--quick].

Prints ns per robot and round on one core for each topology and size, metrics included, beside the limit
kernel in the same run; then what a step of a local estimate costs, thread scaling, and the peak memory of a million
robots.
"""

import argparse
import resource
import subprocess
import sys
import time

import numpy as np
from limit import limit
from rich.console import Console
from rich.table import Table

from swarmcensus import Study, run
from swarmcensus.engine.addresses import address
from swarmcensus.simulation.trials import Metrics, run_batch

SIZES = {10: (1000, 150), 100: (1000, 20), 10_000: (100, 2), 1_000_000: (100, 1)}  # robots: rounds, trials
TOPOLOGIES = ("full", "ring", "line", "scale-free")
GO = np.zeros(1, np.uint8)


def study(robots, rounds, trials, topology="ring", looks=10):
    return Study(
        trials=trials,
        swarm={"robots": robots, "accuracy": 0.675},
        world={"topology": topology, "fill_ratio": 0.55},
        schedule={"rounds": rounds, "observations_per_round": looks},
    )


def timed(function, repeats):
    """The best of some repeats: on a shared machine the others measure the neighbours."""
    best = float("inf")
    for _ in range(repeats):
        begun = time.perf_counter()
        function()
        best = min(best, time.perf_counter() - begun)
    return best


def topologies(console, quick):
    table = Table(
        "robots", *TOPOLOGIES, "limit", "ring / limit", "full / limit", title="ns per robot and round, one core"
    )
    key = address(1, "benchmark")
    for robots, (rounds, trials) in SIZES.items():
        if quick and robots > 10_000:
            continue
        scale = 1e9 / (robots * rounds * trials)
        repeats = 5 if robots < 1_000_000 else 2  # the first of a million pays for memory that nobody had before
        cost = {}
        for topology in TOPOLOGIES:
            setting = study(robots, rounds, trials, topology).settings()[0]
            run_batch(study(10, 2, 1, topology).settings()[0], 1, 0, 1, Metrics(0.01, 10, ()), GO)
            cost[topology] = scale * timed(
                lambda s=setting, n=trials: run_batch(s, 1, 0, n, Metrics(0.01, 10, (10,)), GO), repeats
            )
        limit(10, 2, 10, 0.675, 0.675, 0.55, key, 1)
        bound = scale * timed(lambda n=robots, c=rounds, t=trials: limit(n, c, 10, 0.675, 0.675, 0.55, key, t), repeats)
        table.add_row(
            f"{robots:,}",
            *(f"{cost[t]:.1f}" for t in TOPOLOGIES),
            f"{bound:.1f}",
            f"{cost['ring'] / bound:.2f}",
            f"{cost['full'] / bound:.2f}",
        )
    console.print(table)


def local_estimates(console):
    for looks, trials in ((1, 20), (10, 2)):
        setting = study(100, 1000, trials, looks=looks).settings()[0]
        run_batch(study(10, 2, 1).settings()[0], 1, 0, 1, Metrics(0.01, 10, ()), GO, True)
        cost = timed(lambda s=setting, n=trials: run_batch(s, 1, 0, n, Metrics(0.01, 10, ()), GO, True), 5)
        console.print(f"local estimates, 100 robots, R = {looks}: {cost / (1e5 * trials * looks) * 1e9:.1f} ns a step")


def threads(console):
    paper = Study(
        trials=30,
        swarm={"robots": [10, 100], "accuracy": [0.525, 0.675, 0.825, 0.975, "U(0.525, 0.975)"]},
        world={"topology": list(TOPOLOGIES), "fill_ratio": [0.55, 0.95]},
    )
    one = timed(lambda: run(paper, jobs=1), 2)
    two = timed(lambda: run(paper, jobs=2), 2)
    console.print(f"threads: {one:.2f} s with one, {two:.2f} s with two: {one / two:.2f} times as fast")


def memory(console):
    for topology in ("ring", "scale-free", "full"):
        done = subprocess.run(
            [sys.executable, __file__, "--million", topology], capture_output=True, text=True, check=True
        )
        console.print(done.stdout.strip())


def million(topology):
    begun = time.perf_counter()
    run(study(1_000_000, 100, 1, topology), jobs=1)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"1,000,000 robots, {topology}, 100 rounds: {time.perf_counter() - begun:.1f} s, peak {peak:.2f} GiB")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="no swarm above 10,000 robots")
    parser.add_argument("--million", metavar="TOPOLOGY", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.million:
        return million(options.million)
    console = Console(width=110)
    topologies(console, options.quick)
    local_estimates(console)
    threads(console)
    if not options.quick:
        memory(console)
    return None


if __name__ == "__main__":
    main()
