"""What more workers are worth: python benchmarks/scaling.py.

Measured here: a study on one and two threads and on one and two worker processes, and what it costs to hand out a
bundle. Simulated from that: how long the paper's studies with a hundred times their trials would take on many workers.
"""

import argparse
import heapq
import time
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

import numpy as np
from rich.console import Console
from rich.table import Table

from swarmcensus import Study, run
from swarmcensus.basics.files import shipped_study
from swarmcensus.runs.clusters import BUNDLES_PER_SECOND, BUNDLES_PER_WORKER, LONGEST, SHORTEST, Workers, workers
from swarmcensus.runs.pools import Threads
from swarmcensus.runs.tasks import bundle_tasks, plan_tasks

SCALED = """
trials = 1500
[swarm]
robots = 100
accuracy = [0.6, 0.8]
[world]
topology = ["ring", "line"]
fill_ratio = 0.55
"""
EMPTY = 2000  # bundles with nothing in them
TIMES = 100  # as many trials as the paper's
CROWDS = (1, 10, 100, 1000)
LATE = 60.0  # seconds over which workers come


def makespan(costs, workers, dispatch=0.0, latency=0.0, late=0.0):
    """Seconds until the last result is there, of bundles in order with these costs.

    One scheduler hands them out one by one, each to the worker that is free first, and is busy for `dispatch` seconds
    with each; a worker is idle for `latency` seconds between a result and the next bundle. Workers come evenly over
    `late` seconds.
    """
    free = [late * k / workers for k in range(workers)]
    scheduler = end = 0.0
    for cost in costs:
        scheduler = max(scheduler, free[0]) + dispatch
        done = scheduler + latency + cost
        heapq.heapreplace(free, done)
        end = max(end, done)
    return end


def seconds_of(study, **where):
    """Seconds from the first bundle to the last result: without the start of processes."""
    begun = []

    def show(progress):
        if progress.total and not progress.note and not begun:
            begun.append(time.perf_counter())

    run(study, progress=show, **where)
    return time.perf_counter() - begun[0]


def overheads(pool):
    """Seconds a bundle with nothing in it, of many at a time, and of one after the other."""
    for _ in range(20):
        pool.submit(()).result()
    begun = time.perf_counter()
    waiting = set()
    for _ in range(EMPTY):
        waiting.add(pool.submit(()))
        if len(waiting) >= pool.queue_length:
            waiting = wait(waiting, return_when=FIRST_COMPLETED).not_done
    wait(waiting)
    many = (time.perf_counter() - begun) / EMPTY
    begun = time.perf_counter()
    for _ in range(EMPTY // 10):
        pool.submit(()).result()
    return many, (time.perf_counter() - begun) / (EMPTY // 10)


def costs_here():
    """The predicted seconds of each task of the paper's studies with more trials, corrected by what they take here."""
    tasks = []
    for path in sorted(shipped_study("paper").glob("*.toml")):
        study = Study.load(path)
        settings, few = study.settings(), np.ones((len(study.settings()), 2), np.bool_)
        local = study.measure.local
        predicted = sum(task.cost for task in plan_tasks(settings, few, few if local else None, 0.1))
        seconds_of(study.with_(trials=1), jobs=1)  # compiles
        correction = seconds_of(study.with_(trials=2), jobs=1) / predicted
        wanted = np.ones((len(settings), TIMES * study.trials), np.bool_)
        tasks.append((correction, settings, wanted, wanted if local else None))
    return tasks


def bundles_of(tasks, count):
    """What each bundle costs, cut as for so many workers."""
    work = sum(task.cost for _, settings, wanted, local in tasks for task in plan_tasks(settings, wanted, local, 1.0))
    long = min(max(work / (BUNDLES_PER_WORKER * count), SHORTEST), max(LONGEST, count / BUNDLES_PER_SECOND))
    return [
        correction * sum(task.cost for task in bundle)
        for correction, settings, wanted, local in tasks
        for bundle in bundle_tasks(plan_tasks(settings, wanted, local, long), long)
    ]


def main():
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    console = Console()
    study = Study.parse(SCALED)
    seconds_of(study.with_(trials=10), jobs=1)  # compiles
    table = Table("", "1", "2", "ratio", title=f"{4 * study.trials:,} trials of 100 robots, seconds")
    for label, ways in (
        ("threads", ({"jobs": 1}, {"jobs": 2})),
        ("processes", ({"cluster": "local:1"}, {"cluster": "local:2"})),
    ):
        one, two = (seconds_of(study, **way) for way in ways)
        table.add_row(label, f"{one:.2f}", f"{two:.2f}", f"{one / two:.2f}")
    console.print(table)

    table = Table("", "many at a time", "one after the other", title="a bundle with nothing in it, ms")
    with ThreadPoolExecutor(2) as executor:
        threads = overheads(Threads(executor, 2, study, study.settings()))
    with workers("local:2", study, lambda _: None) as pool:
        assert isinstance(pool, Workers)
        dispatch, trip = overheads(pool)
    for label, (many, single) in {"threads": threads, "two processes": (dispatch, trip)}.items():
        table.add_row(label, f"{1e3 * many:.3f}", f"{1e3 * single:.3f}")
    console.print(table)

    tasks = costs_here()
    table = Table("workers", "bundles", "seconds", "speed-up", "of perfect", "workers late", "speed-up, late",
                  title=f"simulated: the paper's studies with {TIMES} times their trials")  # fmt: skip
    for count in CROWDS:
        costs = bundles_of(tasks, count)
        took = makespan(costs, count, dispatch, trip)
        late = makespan(costs, count, dispatch, trip, LATE)
        table.add_row(
            f"{count:,}", f"{len(costs):,}", f"{took:,.1f}", f"{sum(costs) / took:,.1f}",
            f"{100 * sum(costs) / took / count:.0f} %", f"{late:,.1f}", f"{sum(costs) / late:,.1f}",
        )  # fmt: skip
    console.print(table)


if __name__ == "__main__":
    main()
