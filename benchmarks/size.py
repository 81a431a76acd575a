"""What a study of very many small settings costs beside its computing: python benchmarks/size.py [--settings N].

Runs settings of N = 10, C = 100, two trials each (by default 100,000 of them), with an output, and prints the wall
time, the processor time inside the engine's calls, that of scheduling (planning, handing out, collecting, keeping
shards), that of all else, the peak of memory, and how long it takes to list and show the file, and to draw and export a
selection.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from rich.console import Console

from swarmcensus import Study
from swarmcensus.runs import pools, running, tasks
from swarmcensus.runs.running import run

FILLS = [0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95]
SELECTION = 'topology == "ring" and accuracy == 0.675'


def study(settings):
    accuracies = sorted({0.675, *(round(0.5 + (k + 1) * 0.49 / (settings // 20), 7) for k in range(settings // 20))})
    return Study(
        name="size",
        trials=2,
        swarm={"robots": 10, "accuracy": accuracies[-(settings // 20) :] if 0.675 in accuracies else accuracies},
        world={"topology": ["ring", "scale-free"], "fill_ratio": FILLS},
        schedule={"rounds": 100},
        measure={"checkpoints": [50, 100]},
    )


ENGINE = tasks, tasks.run_batch
BUNDLES = pools, pools.run_bundle  # the engine, and what a thread does beside it
STAGES = running, running._run_stages  # planning, handing out, collecting, keeping


def timed(module, function):
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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--settings", type=int, default=100_000)
    options = parser.parse_args()
    console = Console(width=100)
    run(study(20), 1)  # compiles, and imports what is imported late
    engine, bundles, stages = timed(*ENGINE), timed(*BUNDLES), timed(*STAGES)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "size.nc"
        wall, cpu = time.perf_counter(), time.process_time()
        data = run(study(options.settings), 2, out=out)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        count = data.sizes["setting"]
        scheduling = stages() + bundles() - engine()
        console.print(f"{count:,} settings of two trials, two threads: {wall:.1f} s, {1e6 * wall / count:.0f} us each")
        console.print(
            f"processor time: {engine():.1f} s computing; {scheduling:.1f} s scheduling "
            f"({100 * scheduling / engine():.0f} %); {cpu - engine() - scheduling:.1f} s reading the study and writing "
            "the dataset"
        )
        console.print(f"peak of memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB")
        for command in (["status"], ["show"], ["export", "--where", SELECTION], ["plot", "--where", SELECTION]):
            begun = time.perf_counter()
            arguments = [command[0], str(out), *command[1:]]
            subprocess.run(
                [sys.executable, "-m", "swarmcensus", *arguments], cwd=folder, check=True, capture_output=True
            )
            console.print(f"swarmcensus {command[0]}: {time.perf_counter() - begun:.1f} s")


if __name__ == "__main__":
    main()
