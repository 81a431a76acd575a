"""What commands cost, from the shell: python benchmarks/shell.py [QUESTION] [--quick].

Times are of processes from start to end.
"""

import contextlib
import heapq
import resource
import tempfile
import threading
import time
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from pathlib import Path

import harness
import numpy as np

from swarmcensus import Study
from swarmcensus.runs import Hardware, pools, running, tasks
from swarmcensus.runs.clusters import BUNDLES_PER_SECOND, BUNDLES_PER_WORKER, LONGEST, SHORTEST, Workers, workers
from swarmcensus.runs.pools import Threads
from swarmcensus.runs.running import run
from swarmcensus.runs.tasks import bundle_tasks, plan_tasks
from swarmcensus.support.files import shipped_study

LARGE = """trials = 1
[swarm]
robots = {robots}
accuracy = {accuracies}
[world]
topology = "{topology}"
fill_ratio = 0.55
[schedule]
rounds = 100
"""
FILLS = [0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95]
SELECTION = 'topology == "ring" and accuracy == 0.675'
ENGINE = tasks, tasks.run_batch
BUNDLES = pools, pools.run_bundle  # the engine, and what a thread does beside it
STAGES = running, running._run_stages  # planning, handing out, collecting, keeping
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


@harness.question
def starts(quick=False):
    """Seconds of commands that compute nothing, the least and the most of five."""
    asked = {
        "python -c pass": lambda: harness.process("-c", "pass"),
        "import swarmcensus": lambda: harness.process("-c", "import swarmcensus"),
        "swarmcensus --help": lambda: harness.program("--help"),
        "a results file that is not there": lambda: harness.program("show", "nothing.nc", code=2),
        "a study with a wrong key": lambda: harness.program("run", "wrong.toml", code=2),
    }
    table = harness.table("seconds from the shell", "what", "least", "most")
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Path("wrong.toml").write_text("roundz = 2\n")
        for what, run_it in asked.items():
            spent = [run_it().seconds for _ in range(1 if quick else 5)]
            table.add_row(what, f"{min(spent):.2f}", f"{max(spent):.2f}")
    harness.show(table)


@harness.question
def reproduce(quick=False):
    """`swarmcensus reproduce`, with an empty cache of compiled code and with a full one, and each of its studies."""
    more = ["--trials", "1"] if quick else []
    with tempfile.TemporaryDirectory() as folder:
        for label in ("on a machine that never ran it", "again"):
            spent = harness.program("reproduce", "--out", f"{folder}/{label}", *more, cache=f"{folder}/cache")
            print(f"{label}: {spent.seconds:.1f} s from the shell to the page")
            print("\n".join("  " + line for line in spent.out.splitlines() if line.endswith((" s", " s in all"))))
    for path in sorted(shipped_study("paper").glob("*.toml")):
        study = Study.load(path)
        results = run(study.with_(trials=1) if quick else study, 2)
        trials, seconds = results.attrs["trials_done"], results.attrs["wall_seconds"]
        print(f"study {study.name}: {trials} trials in {seconds:.1f} s with two threads")


@harness.question(unasked=False)
def leaderboard():
    """`swarmcensus leaderboard` with an empty cache of compiled code, then with a brain of one's own beside."""
    with tempfile.TemporaryDirectory() as folder:
        mine = harness.ROOT / "studies" / "example" / "my_brain.py"
        for label, more in (("all shipped brains, compiled first", []), ("one more", [mine])):
            spent = harness.program("leaderboard", *more, "--out", f"{folder}/out", cache=f"{folder}/cache")
            print(f"{label}: {spent.seconds:.1f} s from the shell to the page")


@harness.question
def memory(robots=1_000_000, topology="ring", jobs=2, quick=False):
    """Memory of studies of 1, 2 and 10 settings of a million robots, a trial of 100 rounds each; of show and verify."""
    robots = 10_000 if quick else robots
    table = harness.table("GiB at the peak", "settings", "run", "show", "verify")
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for settings in (1, 2, 10):
            accuracies = [round(0.6 + 0.02 * k, 2) for k in range(settings)]
            Path("study.toml").write_text(LARGE.format(robots=robots, accuracies=accuracies, topology=topology))
            commands = ["run study.toml --out out.nc --fresh", "show out.nc", "verify out.nc"]
            commands[0] += f" --jobs {jobs}"
            commands[2] += f" --jobs {jobs}"
            peaks = [harness.program(*command.split(), "--quiet").memory for command in commands]
            table.add_row(str(settings), *(f"{peak / 2**30:.2f}" for peak in peaks))
    harness.show(table)


def small_settings(settings):
    """A study of so many settings of N = 10, C = 100, two trials each."""
    accuracies = sorted({0.675, *(round(0.5 + (k + 1) * 0.49 / (settings // 20), 7) for k in range(settings // 20))})
    return Study(
        name="size",
        trials=2,
        swarm={"robots": 10, "accuracy": accuracies[-(settings // 20) :] if 0.675 in accuracies else accuracies},
        world={"topology": ["ring", "scale-free"], "fill_ratio": FILLS},
        schedule={"rounds": 100},
        measure={"checkpoints": [50, 100]},
    )


def summed(module, function):
    """Have a function add up the processor time of its calls; returns what says the sum."""
    spent, lock = [0.0], threading.Lock()

    def wrapped(*arguments):
        begun = time.thread_time()
        try:
            return function(*arguments)
        finally:
            with lock:
                spent[0] += time.thread_time() - begun

    setattr(module, function.__name__, wrapped)
    return lambda: spent[0]


@harness.question
def size(settings=100_000, quick=False):
    """What very many small settings cost beside their computing: time, scheduling, memory; listing and drawing them."""
    settings = 200 if quick else settings
    run(small_settings(20), 1)  # compiles, and imports what is imported late
    engine, bundles, stages = summed(*ENGINE), summed(*BUNDLES), summed(*STAGES)
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        wall, cpu = time.perf_counter(), time.process_time()
        data = run(small_settings(settings), 2, out=Path("size.nc"))
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        count, scheduling = data.sizes["setting"], stages() + bundles() - engine()
        harness.show(f"{count:,} settings of two trials, two threads: {wall:.1f} s, {1e6 * wall / count:.0f} us each")
        harness.show(
            f"processor time: {engine():.1f} s computing; {scheduling:.1f} s scheduling "
            f"({100 * scheduling / engine():.0f} %); {cpu - engine() - scheduling:.1f} s reading and writing"
        )
        harness.show(f"peak of memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB")
        for command in (["status"], ["show"], ["export", "--where", SELECTION], ["plot", "--where", SELECTION]):
            seconds = harness.program(command[0], "size.nc", *command[1:]).seconds
            harness.show(f"swarmcensus {command[0]}: {seconds:.1f} s")


# ---- more workers


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


def processes(count):
    """Processes of this machine as a cluster."""
    from distributed import LocalCluster

    return LocalCluster(n_workers=count, threads_per_worker=1, host="127.0.0.1", silence_logs="CRITICAL")


def overheads(pool, count):
    """Seconds a bundle with nothing in it, of many at a time, and of one after the other."""
    for _ in range(20):
        pool.submit(()).result()
    begun = time.perf_counter()
    waiting = set()
    for _ in range(count):
        waiting.add(pool.submit(()))
        if len(waiting) >= pool.queue_length:
            waiting = wait(waiting, return_when=FIRST_COMPLETED).not_done
    wait(waiting)
    many = (time.perf_counter() - begun) / count
    begun = time.perf_counter()
    for _ in range(count // 10):
        pool.submit(()).result()
    return many, (time.perf_counter() - begun) / (count // 10)


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


@harness.question(unasked=False)
def scaling(quick=False):
    """What more workers are worth: threads, processes, the cost of a bundle, and from that many workers, simulated.

    Simulated is how long the paper's studies with a hundred times their trials would take.
    """
    study = Study.parse(SCALED)
    study = study.with_(trials=30) if quick else study
    seconds_of(study.with_(trials=10), jobs=1)  # compiles
    table = harness.table(f"{4 * study.trials:,} trials of 100 robots, seconds", "", "1", "2", "ratio")
    took = {"threads": [seconds_of(study, jobs=jobs) for jobs in (1, 2)], "processes": []}
    for count in (1, 2):
        with processes(count) as cluster:
            took["processes"].append(seconds_of(study, cluster=cluster.scheduler_address))
    for label, (one, two) in took.items():
        table.add_row(label, f"{one:.2f}", f"{two:.2f}", f"{one / two:.2f}")
    harness.show(table)

    empty = EMPTY // 20 if quick else EMPTY
    table = harness.table("a bundle with nothing in it, ms", "", "many at a time", "one after the other")
    with ThreadPoolExecutor(2) as executor:
        threads = overheads(Threads(executor, 2, study, study.settings()), empty)
    with processes(2) as cluster, workers(Hardware(cluster=cluster.scheduler_address), study) as pool:
        assert isinstance(pool, Workers)
        dispatch, trip = overheads(pool, empty)
    for label, (many, single) in {"threads": threads, "two processes": (dispatch, trip)}.items():
        table.add_row(label, f"{1e3 * many:.3f}", f"{1e3 * single:.3f}")
    harness.show(table)

    tasks = costs_here()
    table = harness.table(
        f"simulated: the paper's studies with {TIMES} times their trials",
        *("workers", "bundles", "seconds", "speed-up", "of perfect", "workers late", "speed-up, late"),
    )
    for count in CROWDS:
        costs = bundles_of(tasks, count)
        took = makespan(costs, count, dispatch, trip)
        late = makespan(costs, count, dispatch, trip, LATE)
        table.add_row(
            f"{count:,}", f"{len(costs):,}", f"{took:,.1f}", f"{sum(costs) / took:,.1f}",
            f"{100 * sum(costs) / took / count:.0f} %", f"{late:,.1f}", f"{sum(costs) / late:,.1f}",
        )  # fmt: skip
    harness.show(table)


if __name__ == "__main__":
    harness.answer(globals())
