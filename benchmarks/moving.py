"""What robots that move cost: python benchmarks/moving.py [QUESTION] [--quick].

Nanoseconds per robot and tick on one core for bodies, radio and senses at D = 1 and 10, what another brain adds that
shares the walk, what a robot costs whose brain steers, how the cost grows to 100,000 robots, and the 1,320 moving
trials of the paper. `python benchmarks/argos.py speed` measures the same robots in ARGoS. `walks` is of no cost: it
says how often robots avoid, and how far settings on the same walks agree.
"""

from functools import partial

import harness
import numpy as np

from swarmcensus import Study, run
from swarmcensus.engine.addresses import address
from swarmcensus.runs.tasks import metrics_of
from swarmcensus.simulation import sampling
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.simulation.rides import Walkers, run_ride
from swarmcensus.simulation.walking import Walk
from swarmcensus.support.files import shipped_study
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body

KEY = address(1, "walk")


def study(density, ticks, brain="minimalistic"):
    return Study(
        trials=1,
        swarm={"robots": 25, "accuracy": 0.675, "brain": brain},
        world={"topology": "moving", "density": density, "fill_ratio": 0.55},
        schedule={"ticks": ticks},
    )


def walked(robots, density, ticks, trial=0):
    body = Body()
    return list(Walk(robots, arena.side(robots, density, body), body, KEY, trial, harness.GO).chunks(ticks))


def walk_cost(robots, density, ticks, repeats=5):
    body = Body()
    side = arena.side(robots, density, body)

    def go():
        for _ in Walk(robots, side, body, KEY, 0, harness.GO).chunks(ticks):
            pass

    walked(robots, density, 2)
    return 1e9 * harness.least([go], repeats)[0] / (robots * ticks)


def brain_cost(density, ticks, repeats=5):
    (setting,) = study(density, ticks).settings()
    ground = sampling.ground(setting, 0, 0)
    chunks = [(c, ground.colours(c.tiles)) for c in walked(25, density, ticks)]

    def ride():
        rider = Walkers(setting, inputs_of(setting, 0, 0))
        for chunk, black in chunks:
            rider.ride(chunk, black, harness.GO)

    ride()
    return 1e9 * harness.least([ride], repeats)[0] / (25 * ticks)


@harness.question
def bodies():
    """A robot and tick, of its body and of its brain."""
    table = harness.table("25 robots, ns", "density", "bodies, radio, senses", "a brain")
    for density in (1, 10):
        table.add_row(str(density), f"{walk_cost(25, density, 10_000):.0f}", f"{brain_cost(density, 10_000):.0f}")
    harness.show(table)


@harness.question
def steering():
    """A robot whose brain steers, so that its walk is its own."""
    steered = study(1, 10_000, "leaver")
    metrics = metrics_of(steered)
    ride = partial(run_ride, steered.settings(), 0, 0, metrics, harness.GO)
    ride()
    cost = 1e9 * harness.least([ride], 5)[0] / (25 * 10_000)
    harness.show(f"25 robots that steer at D = 1, trials and their floors whole: {cost:.0f} ns")


@harness.question
def sizes(quick=False):
    """How the cost of a robot grows with their number."""
    small = walk_cost(1000, 1, 1000, 2)
    harness.show(f"1,000 robots at D = 1: {small:.0f} ns per robot and tick")
    if not quick:
        large = walk_cost(100_000, 1, 1000, 1)
        harness.show(f"100,000 robots at D = 1: {large:.0f} ns, {large / small:.2f} times as much per robot")


@harness.question
def walks(trials=100, ticks=10_000):
    """Share of ticks spent avoiding, and how mean final estimates of two accuracies on the same walks correlate."""
    table = harness.table(
        f"25 robots, {ticks:,} ticks, {harness.trials(trials)} trials", "density", "avoiding, %", "observations",
        "correlation of 0.925 with 0.975",
    )  # fmt: skip
    for density in (1, 10):
        chunks = (chunk for trial in range(harness.trials(trials)) for chunk in walked(25, density, ticks, trial))
        looked = np.concatenate([chunk.looked for chunk in chunks]).mean()
        swarm = {"robots": 25, "accuracy": [0.925, 0.975]}
        results = run(study(density, ticks).with_(trials=harness.trials(trials), swarm=swarm))
        alike = np.corrcoef(results["final_estimate"].mean("robot"))[0, 1]
        table.add_row(str(density), f"{100 * (1 - looked):.1f}", f"{ticks * looked:,.0f}", f"{alike:.2f}")
    harness.show(table)


@harness.question
def paper(quick=False):
    """The paper's moving trials, one of each setting if `quick`."""
    whole = Study.load(shipped_study("paper/moving.toml"))
    results = []
    [seconds] = harness.least([lambda: results.append(run(whole.with_(trials=1) if quick else whole, jobs=2))], 1)
    trials = results[0].attrs["trials_done"]
    harness.show(f"the paper's {trials:,} moving trials, all metrics, two threads: {seconds:.1f} s")


if __name__ == "__main__":
    harness.answer(globals())
