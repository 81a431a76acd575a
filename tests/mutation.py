"""Mutation testing: faults are put into the source one at a time, and the tests should notice.

    pip install cosmic-ray
    python tests/mutation.py                       # a sample of 300 faults
    python tests/mutation.py faults states --sample 50

Faults are Cosmic Ray's (another operator, number, comparison or truth value; a loop that never runs), and two more that
fit addressed randomness: two neighbouring arguments of a call change places, and a keyword argument is left out. Each
place in the source is as likely to be in the sample as any other. The tests that know a module run in CPython, on small
cases; where they pass, more of them run compiled. A fault is noticed by a test that fails, or if the module cannot even
be imported, or if the tests do not end. CPython notices more than machine code: an index that is out of its array, say.
Prints what survived, and the score with its 95 % interval. Needs a checkout, and leaves it alone.
"""

import argparse
import importlib.util
import multiprocessing
import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

from mutants import EQUIVALENT, ROOT, SOURCE, Mutant, read, sampled

NETS, WALKS, DRAWS = "reference/test_networks", "reference/test_walks", "unit/engine/test_draws"
BATCHES, FAULTS, TRACES = "unit/engine/test_batches", "unit/worlds/test_faults", "unit/simulation/test_traces"
MOVING, STEERING, FLOORS = "unit/simulation/test_moving", "unit/simulation/test_steering", "unit/worlds/test_floors"
SENSORS, WIRING = "unit/worlds/test_sensors", "unit/worlds/test_networks"
FOLLOW = " ".join(
    f"{TRACES}::test_{name}"
    for name in (
        "edges_exchange_at_the_end_of_each_round",
        "messages_are_heard_at_their_step",
        "steps_left_over_end_without_an_exchange",
    )
)
BELIEFS = "unit/analysis/explaining/test_beliefs"
QUICK_SENSORS = f"{SENSORS} --deselect=tests/{SENSORS}.py::test_truncated_normal {DRAWS}"
METRICS = "unit/brains/metrics/test_files"
WATCHED = f"{METRICS}::test_cpython_finds_what_machine_code_finds"
# The tests that know a module: first those that are quick in CPython, then those that are run compiled. Below tests/.
TESTS: dict[str, tuple[str, str]] = {
    "simulation/metrics": (f"unit/simulation/test_metrics {NETS}", BATCHES),
    "engine/agreement": (f"unit/simulation/test_metrics {NETS}", f"{WALKS} {BATCHES}"),
    "support/intervals": ("unit/support/test_intervals", "unit/runs/test_precision statistical/test_intervals"),
    "worlds/sensors": (QUICK_SENSORS, f"{SENSORS} {BELIEFS} statistical/test_theory"),
    "worlds/distributions": (QUICK_SENSORS, f"{SENSORS} {BELIEFS} statistical/test_theory"),
    "worlds/networks": (f"{WIRING} {NETS} {DRAWS}", f"cli/test_bad_inputs {BATCHES}"),
    "worlds/wiring": (f"{WIRING} {NETS} {DRAWS}", f"unit/support/test_plugins {BATCHES}"),
    "worlds/faults": (f"{DRAWS} {NETS}", FAULTS),
    "engine/random": (f"{DRAWS} unit/engine/test_random {NETS}", BATCHES),
    "engine/draws": (f"{DRAWS} unit/engine/test_random {NETS}", f"{BATCHES} statistical/test_theory"),
    "engine/world": (f"{DRAWS} {NETS} {WALKS}", FLOORS),
    "engine/scores": (DRAWS, FLOORS),
    "engine/kernel": (f"{NETS} {FOLLOW}", f"{BATCHES} {FAULTS} {TRACES} unit/simulation/test_intervals"),
    "engine/rounds": (
        f"{NETS} {FOLLOW}",
        f"{BATCHES} {FAULTS} {TRACES} unit/simulation/test_delays reference/test_optional_functions",
    ),
    "engine/shared_trials": ("unit/simulation/test_shared_trials", NETS),
    "engine/watching": (WATCHED, METRICS),
    "simulation/watches": (WATCHED, METRICS),
    "engine/failures": (FAULTS, f"{NETS} {WALKS}"),
    "engine/states": (f"{NETS} {WALKS} unit/simulation/test_decisions", f"{BATCHES} {FAULTS} {MOVING}"),
    "simulation/trials": (f"{NETS} {WALKS}", f"{BATCHES} cli/test_bad_inputs unit/summaries/test_remeasuring"),
    "engine/riding": (WALKS, f"{MOVING} {FAULTS} {STEERING}"),
    "simulation/inputs": (f"{NETS} {WALKS}", f"{BATCHES} {MOVING}"),
    "simulation/rides": (WALKS, f"{MOVING} {FLOORS} {STEERING}"),
    "engine/walk": (WALKS, f"{MOVING} statistical/test_fidelity"),
    "simulation/walking": (WALKS, f"{MOVING} {STEERING}"),
    "engine/motion": (WALKS, f"{MOVING} statistical/test_fidelity"),
    "engine/neighbours": (WALKS, MOVING),
    "engine/steering": (WALKS, STEERING),
    "engine/return_values": (WALKS, STEERING),
}
OPTIONS = ["-x", "-q", "-p", "no:cacheprovider", "--hypothesis-seed=0", "-m", "not long"]
SECONDS = 240, 900  # after which tests have noticed: the fault goes on for ever
PRELOADED = ["numba", "numpy", "scipy.stats", "xarray", "h5netcdf", "pydantic", "networkx", "pytest", "hypothesis",
             "rich.console"]  # fmt: skip


def files(tests: str) -> list[str]:
    """What pytest is told by a line that names tests."""
    parts = (name.partition("::") if name[0] != "-" else (name, "", "") for name in tests.split())
    return [
        file + colons + test if file[0] == "-" else f"tests/{file}.py{colons}{test}" for file, colons, test in parts
    ]


def in_cpython(folder: str, tests: list[str], log: str) -> None:
    """Run tests of a copy of the tree in this process, with everything uncompiled, and end it with their status."""
    import numpy as np
    import pytest

    with open(log, "wb") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    os.chdir(folder)
    sys.path[:0] = [str(Path(folder) / "src"), folder]
    os.environ |= {"SWARMCENSUS_CACHE": str(Path(folder) / "cache"), "PYTHONPATH": str(Path(folder) / "src")}
    np.seterr(over="ignore")  # uint64 arithmetic is meant to wrap
    ignored = ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
    os._exit(int(pytest.main([*OPTIONS, *ignored, *tests])))


def passes_in_cpython(folder: Path, tests: list[str]) -> bool:
    """Whether all of these pass in time, uncompiled, in a process that was forked with its libraries loaded."""
    server = multiprocessing.get_context("forkserver")
    process = server.Process(target=in_cpython, args=(str(folder), tests, str(folder / "log")))
    process.start()
    process.join(SECONDS[0])
    if process.exitcode is None:
        process.kill()
        process.join()
    return process.exitcode == 0


def passes_compiled(folder: Path, tests: list[str]) -> bool:
    """Whether all of these pass in time, compiled."""
    environment = {**os.environ, "NUMBA_OPT": "1", "PYTHONPATH": str(folder / "src")}
    environment |= {"NUMBA_DISABLE_JIT": "0", "SWARMCENSUS_CACHE": str(folder / "cache")}
    command = [sys.executable, "-m", "pytest", *OPTIONS, *tests]
    try:
        with (folder / "log").open("w") as log:
            run = subprocess.run(command, cwd=folder, env=environment, stdout=log, stderr=log, timeout=SECONDS[1])
    except subprocess.TimeoutExpired:
        return False
    return run.returncode == 0


def survives(mutant: Mutant, folder: Path, thorough: bool) -> bool:
    """Whether no test notices the fault, in a copy of the tree."""
    quick, compiled = map(files, TESTS[mutant.module])
    place = folder / SOURCE / f"{mutant.module}.py"
    place.write_text(mutant.text, encoding="utf-8")
    # CPython takes two texts of the same length and second for the same
    Path(importlib.util.cache_from_source(place)).unlink(missing_ok=True)
    try:
        if not passes_in_cpython(folder, quick):
            return False
        if not thorough or passes_compiled(folder, compiled):
            return True
    finally:
        place.write_text(read(mutant.module), encoding="utf-8")
    if not passes_compiled(folder, compiled):
        sys.exit(f"{' '.join(compiled)} fail without any fault")
    return False


def copies(number: int, below: Path) -> SimpleQueue[Path]:
    """So many copies of the tree."""
    out: SimpleQueue[Path] = SimpleQueue()
    for k in range(number):
        for part in ("src", "tests", "studies", "docs"):
            shutil.copytree(ROOT / part, below / str(k) / part, ignore=shutil.ignore_patterns("__pycache__", ".*"))
        for part in ("pyproject.toml", "README.md", "CHANGELOG.md"):
            shutil.copy(ROOT / part, below / str(k) / part)
        out.put(below / str(k))
    return out


def tested(mutants: list[Mutant], jobs: int, thorough: bool, log: Path | None) -> list[Mutant]:
    """Those that survive; prints as it goes. Exits where tests fail without any fault."""
    survivors = []
    known = set(log.read_text(encoding="utf-8").splitlines()) if log and log.exists() else set()
    with tempfile.TemporaryDirectory(prefix="mutation-") as below:
        free = copies(jobs, Path(below))

        def sound(tests: list[str]) -> bool:
            folder = free.get()
            try:
                return passes_in_cpython(folder, tests) or bool(print((folder / "log").read_text()[-3000:]))
            finally:
                free.put(folder)

        def one(mutant: Mutant) -> bool:
            if mutant.change() in known | set(EQUIVALENT):
                return mutant.change() in EQUIVALENT
            folder = free.get()
            try:
                return survives(mutant, folder, thorough)
            finally:
                free.put(folder)

        with ThreadPoolExecutor(jobs) as pool:
            every = sorted({TESTS[m.module][0] for m in mutants if m.change() not in known | set(EQUIVALENT)})
            if not all(pool.map(sound, map(files, every))):
                sys.exit("tests fail without any fault")
            for number, (mutant, alive) in enumerate(zip(mutants, pool.map(one, mutants), strict=True), start=1):
                print(f"{number:4} {'SURVIVED' if alive else 'noticed '} {mutant.line:4} {mutant.change()}", flush=True)
                survivors += [mutant] if alive else []
                if log and not alive and mutant.change() not in known:
                    with log.open("a", encoding="utf-8") as file:
                        file.write(mutant.change() + "\n")
    return survivors


def main() -> None:
    """Sample, test, and print the score."""
    names = {Path(module).name: module for module in TESTS}
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("module", nargs="*", help=f"of {', '.join(names)}; all of them if none is named")
    parser.add_argument("--sample", type=int, default=300, metavar="N", help="how many faults [300]")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="which ones [1]")
    parser.add_argument("--jobs", type=int, default=2, metavar="J", help="how many at a time [2]")
    parser.add_argument("--log", type=Path, metavar="FILE", help="keep here what is noticed, and do not try it again")
    parser.add_argument("--quick", action="store_true", help="do not try compiled what survives in CPython")
    options = parser.parse_args()
    if unknown := set(options.module) - set(names):
        parser.error(f"no module {', '.join(sorted(unknown))}")
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    server = multiprocessing.get_context("forkserver")
    server.set_forkserver_preload(PRELOADED)
    mutants = sampled([names[m] for m in options.module or names], options.sample, options.seed)
    survivors = tested(mutants, options.jobs, not options.quick, options.log)
    equivalent = [m for m in survivors if m.change() in EQUIVALENT]
    killed, tried = len(mutants) - len(survivors), len(mutants) - len(equivalent)
    sys.path.insert(0, str(ROOT / "src"))
    from swarmcensus.support.intervals import share_interval

    for m in survivors:
        print(f"\n{m.module}.py:{m.line}: {m.kind}\n    {m.change()}\n    {EQUIVALENT.get(m.change(), 'survived')}")
    share, low, high = share_interval(killed, tried)
    print(f"\n{len(mutants)} faults, {len(equivalent)} of them equivalent; {killed} of {tried} noticed: ", end="")
    print(f"{share:.3f}, 95 % interval [{low:.3f}, {high:.3f}]")


if __name__ == "__main__":
    main()
