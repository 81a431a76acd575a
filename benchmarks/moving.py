"""What robots that move cost: python benchmarks/moving.py [--quick].

Prints ns per robot and tick on one core for bodies, radio and senses at D = 1 and 10, what a mind riding along adds,
what a robot costs whose brain steers, body and mind together, how the cost per robot grows to 100,000 robots, and the
1,320 moving trials of the paper. Beside them stands what a physics simulation (ARGoS) cost, measured once each on one
core of such a machine.
"""

import argparse
import time

import numpy as np
from rich.console import Console
from rich.table import Table

from swarmcensus import Study, run
from swarmcensus.basics.files import shipped_study
from swarmcensus.engine.addresses import address
from swarmcensus.runs.tasks import metrics_of
from swarmcensus.simulation import sampling
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.rides import Rider, run_ride
from swarmcensus.simulation.walking import walk
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body

PHYSICS = {1: 394_000, 10: 630_000}  # ns per robot and tick
GO = np.zeros(1, np.uint8)
KEY = address(1, "walk")


def best(function, repeats):
    """The least of some repeats: on a shared machine the others measure the neighbours."""
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        function()
        times.append(time.perf_counter() - begun)
    return min(times)


def walked(robots, density, ticks):
    body = Body()
    return list(walk(robots, arena.side(robots, density, body), body, KEY, 0, ticks, GO))


def walk_cost(robots, density, ticks, repeats=5):
    body = Body()
    side = arena.side(robots, density, body)

    def go():
        for _ in walk(robots, side, body, KEY, 0, ticks, GO):
            pass

    walked(robots, density, 2)
    return 1e9 * best(go, repeats) / (robots * ticks)


def mind_cost(density, ticks, repeats=5):
    study = Study(
        trials=1,
        swarm={"robots": 25, "accuracy": 0.675},
        world={"topology": "moving", "density": density, "fill_ratio": 0.55},
        schedule={"ticks": ticks},
    )
    (setting,) = study.settings()
    ground = sampling.ground(setting, 0, 0)
    chunks = [(c, ground.colours(c.tiles)) for c in walked(25, density, ticks)]

    def ride():
        rider = Rider(setting, inputs_of(setting, 0, 0))
        for chunk, black in chunks:
            rider.ride(chunk, black, GO)

    ride()
    return 1e9 * best(ride, repeats) / (25 * ticks)


def steered_cost(density, ticks, repeats=5):
    study = Study(
        trials=1,
        swarm={"robots": 25, "accuracy": 0.675, "brain": "leaver"},
        world={"topology": "moving", "density": density, "fill_ratio": 0.55},
        schedule={"ticks": ticks},
    )
    (setting,) = study.settings()
    metrics = metrics_of(study)
    run_ride([setting], 0, 0, metrics, GO)
    return 1e9 * best(lambda: run_ride([setting], 0, 0, metrics, GO), repeats) / (25 * ticks)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="no swarm above 1,000 robots, no paper")
    options = parser.parse_args()
    console = Console(width=100)
    table = Table(
        "density", "bodies, radio, senses", "a mind", "physics simulation", "times as fast", title="25 robots, ns"
    )
    for density in (1, 10):
        body, mind = walk_cost(25, density, 10_000), mind_cost(density, 10_000)
        table.add_row(
            str(density),
            f"{body:.0f}",
            f"{mind:.0f}",
            f"{PHYSICS[density]:,}",
            f"{PHYSICS[density] / (body + mind):,.0f}",
        )
    console.print(table)
    console.print(f"25 robots that steer at D = 1, trials and their floors whole: {steered_cost(1, 10_000):.0f} ns")
    small = walk_cost(1000, 1, 1000, 2)
    console.print(f"1,000 robots at D = 1: {small:.0f} ns per robot and tick")
    if options.quick:
        return
    large = walk_cost(100_000, 1, 1000, 1)
    console.print(f"100,000 robots at D = 1, 1,000 ticks: {large:.0f} ns, {large / small:.2f} times as much per robot")
    begun = time.perf_counter()
    results = run(Study.load(shipped_study("paper/moving.toml")), jobs=2)
    trials = results.attrs["trials_done"]
    console.print(
        f"the paper's {trials:,} moving trials, all metrics, two threads: {time.perf_counter() - begun:.1f} s"
    )


if __name__ == "__main__":
    main()
