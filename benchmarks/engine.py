"""What the engine costs on fixed networks: python benchmarks/engine.py [QUESTION] [--quick].

Nanoseconds per robot and round on one core for each topology and size, metrics included, beside the limit kernel in the
same run; a step of a local estimate; what a second thread gains; the time and the memory of a million robots.
"""

from functools import partial
from pathlib import Path

import harness
import numpy as np
from numba import njit

from swarmcensus import Study, run
from swarmcensus.engine.addresses import address
from swarmcensus.engine.changes import renew, source_of
from swarmcensus.engine.draws import pick
from swarmcensus.engine.layout import Sensors
from swarmcensus.engine.random import words
from swarmcensus.simulation.trials import Metrics, run_batch

SIZES = {10: (1000, 150), 100: (1000, 20), 10_000: (100, 2), 1_000_000: (100, 1)}  # robots: rounds, trials
TOPOLOGIES = ("full", "ring", "line", "scale-free")
MOST = Metrics(0.01, 10, ())
HERE = Path(__file__).parent


@njit(nogil=True)
def limit(robots, rounds, looks, b, w, fill_ratio, key, trials):
    """The limit of any engine: a ring that draws, estimates and fuses, and does nothing else.

    It has no records, brain file and metrics, and its constants are hoisted out of loops. Returns the last robot's
    estimate so that nothing is optimised away.
    """
    steady = np.array([fill_ratio, fill_ratio, 1.0, 1.0])
    source = source_of(Sensors(np.full(1, b), np.full(1, w), np.zeros((3, 0)), steady, looks, key, key))
    renew(source, 1, 0, 1)
    row = source.tables[0, 0]
    bits = np.zeros(robots, np.uint64)
    n, x_hat, alpha, x = np.zeros(robots), np.zeros(robots), np.zeros(robots), np.zeros(robots)
    slope = b + w - 1.0
    q = slope * slope
    for trial in range(trials):
        n[:] = 0.0
        for k in range(1, rounds + 1):
            words(key, trial, k, 0, 0, robots, bits)
            t = float(k * looks)
            low, high = (1.0 - w) * t, b * t
            for i in range(robots):
                n[i] += pick(row, bits[i])
                m = n[i]
                if m <= low:
                    x_hat[i] = 0.0
                    alpha[i] = q * (m / ((1.0 - w) * (1.0 - w)) + (t - m) / (w * w))
                elif m >= high:
                    x_hat[i] = 1.0
                    alpha[i] = q * (m / (b * b) + (t - m) / ((1.0 - b) * (1.0 - b)))
                else:
                    x_hat[i] = (m / t + w - 1.0) / slope
                    alpha[i] = q * t * t * t / (m * (t - m))
            for i in range(robots):
                left = i - 1 if i > 0 else robots - 1
                right = i + 1 if i < robots - 1 else 0
                beta = alpha[left] + alpha[right]
                x_bar = (alpha[left] * x_hat[left] + alpha[right] * x_hat[right]) / beta
                x[i] = (alpha[i] * x_hat[i] + beta * x_bar) / (alpha[i] + beta)
    return x[robots - 1]


def study(robots, rounds, trials, topology="ring", looks=10):
    return Study(
        trials=trials,
        swarm={"robots": robots, "accuracy": 0.675},
        world={"topology": topology, "fill_ratio": 0.55},
        schedule={"rounds": rounds, "observations_per_round": looks},
    )


@harness.question
def topologies(quick=False):
    """Each topology and size, beside the limit."""
    table = harness.table(
        "ns per robot and round, one core", "robots", *TOPOLOGIES, "limit", "ring / limit", "full / limit"
    )
    key = address(1, "benchmark")
    for robots, (rounds, trials) in SIZES.items():
        if quick and robots > 10_000:
            continue
        batches = {t: study(robots, rounds, trials, t).settings()[0] for t in TOPOLOGIES}
        for topology in TOPOLOGIES:
            run_batch(study(10, 2, 1, topology).settings()[0], 1, 0, 1, MOST, harness.GO)
        limit(10, 2, 10, 0.675, 0.675, 0.55, key, 1)
        metrics = Metrics(0.01, 10, (10,))
        runs = [partial(run_batch, one, 1, 0, trials, metrics, harness.GO) for one in batches.values()]
        runs.append(partial(limit, robots, rounds, 10, 0.675, 0.675, 0.55, key, trials))
        repeats = 5 if robots < 1_000_000 else 2  # the first of a million pays for memory that nobody had before
        *costs, bound = harness.least(runs, repeats) * 1e9 / (robots * rounds * trials)
        cost = dict(zip(TOPOLOGIES, costs, strict=True))
        ratios = (cost["ring"] / bound, cost["full"] / bound)
        table.add_row(f"{robots:,}", *(f"{x:.1f}" for x in (*costs, bound)), *(f"{x:.2f}" for x in ratios))
    harness.show(table)


@harness.question
def local_estimates():
    """A step of a local estimate."""
    for looks, trials in ((1, 20), (10, 2)):
        setting = study(100, 1000, trials, looks=looks).settings()[0]
        run_batch(study(10, 2, 1).settings()[0], 1, 0, 1, MOST, harness.GO, True)
        [cost] = harness.least([partial(run_batch, setting, 1, 0, trials, MOST, harness.GO, True)], 5)
        harness.show(f"local estimates, 100 robots, R = {looks}: {cost / (1e5 * trials * looks) * 1e9:.1f} ns a step")


@harness.question
def threads():
    """What a second thread gains."""
    paper = Study(
        trials=30,
        swarm={"robots": [10, 100], "accuracy": [0.525, 0.675, 0.825, 0.975, "U(0.525, 0.975)"]},
        world={"topology": list(TOPOLOGIES), "fill_ratio": [0.55, 0.95]},
    )
    one, two = harness.least([partial(run, paper, jobs=1), partial(run, paper, jobs=2)], 2)
    harness.show(f"threads: {one:.2f} s with one, {two:.2f} s with two: {one / two:.2f} times as fast")


@harness.question
def million(quick=False):
    """Seconds and memory of a million robots in one thread and in two, of 100,000 if `quick`."""
    robots = 100_000 if quick else 1_000_000
    for topology in ("ring", "scale-free", "full"):
        code = f"import engine; engine.run(engine.study({robots}, 100, 1, {topology!r}), jobs=int(sys.argv[1]))"
        code = f"import sys; sys.path.insert(0, {str(HERE)!r}); {code}"
        one, two = (harness.process("-c", code, jobs) for jobs in ("1", "2"))
        harness.show(
            f"{robots:,} robots, {topology}, 100 rounds: {one.seconds:.1f} s in one thread and {two.seconds:.1f} s in "
            f"two, peaks {one.memory / 2**30:.2f} and {two.memory / 2**30:.2f} GiB"
        )


if __name__ == "__main__":
    harness.answer(globals())
