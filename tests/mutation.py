"""Mutation testing: faults are put into the source one at a time, and the tests should notice.

    pip install cosmic-ray
    python tests/mutation.py                       # a sample of 300 faults
    python tests/mutation.py faults states --sample 50

Faults are Cosmic Ray's (another operator, number, comparison or truth value; a loop that never runs), and two more that
fit addressed randomness: two neighbouring arguments of a call change places, and a keyword argument is left out. Each
place in the source is as likely to be in the sample as any other. The tests that know a module run in CPython, on small
cases; where they pass, more of them run compiled. A fault is noticed by a test that fails, or if the tests do not
end. CPython notices more than machine code: an index that is out of its array, say.
Prints what survived, and the score with its 95 % interval. Needs a checkout, and leaves it alone.
"""

import argparse
import ast
import difflib
import itertools
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

ROOT = Path(__file__).parents[1]
SOURCE = Path("src/swarmcensus")

# Survivors that no test can tell, "module: old line -> new line", and why.
EQUIVALENT = {
    "engine/kernel: first, last = 0, senders.size if whole else 0"
    " -> first, last = 0, senders.size if whole else -1": "no message either way",
    "engine/motion: STAND, STRAIGHT, LEFT, RIGHT = 0, 1, 2, 3"
    " -> STAND, STRAIGHT, LEFT, RIGHT = 0, 1, 2, 4": "a name: nothing is reckoned from it",
    "engine/neighbours: return min(max(int((x + half) / size), 0), side - 1)"
    " -> return min(max(int((x + half) / size), 0), side ^ 1)": "centres keep off the walls, in cells that are there",
    "engine/neighbours: side = heads.shape[0] -> side = heads.shape[ 1]": "the grid is square",
    "engine/neighbours: size = 2.0 * half / side -> size = 3.0 * half / side": "wider cells find the same, later",
    "engine/neighbours: crowd = robots > ALL_PAIRS -> crowd = robots is not ALL_PAIRS": "it finds the same, later",
    "engine/neighbours: near = square_distance(state, i, j) < reach2"
    " -> near = square_distance(state, j, i) < reach2": "the same square",
    "engine/neighbours: blocked |= (along > 0.0) & (along < square) & (across * across < wide)"
    " -> blocked |= (along >= 0.0) & (along < square) & (across * across < wide)": "bodies at a right angle to the line"
    " are a diameter away from its end, and so do not cross it",
    "engine/riding: if stop[0] != 0: -> if stop[ -1] != 0:": "there is one",
    "engine/scores: for column in range(nodes.shape[1]): -> for column in range(nodes.shape[ 0]):": "they are a square",
    "engine/walk: side = int(2.0 * half / size) + 1 -> side = int(2.0 * half / size) + 2": "cells that stay empty",
    "engine/walk: for n in range(max(b - 1, 0), min(b + 2, side)):"
    " -> for n in range(max(b - 1, -1), min(b + 2, side)):": "the last column is looked at, too",
    "simulation/walking: listed = max(1, robots * min(robots - 1, int(fit) + 1))"
    " -> listed = max( 0, robots * min(robots - 1, int(fit) + 1))": "a robot alone lists nobody",
    "simulation/metrics: return np.asarray(np.abs(np.take_along_axis(curves, index[np.newaxis], axis=0)[0] "
    "- fill_ratio))"
    " -> return np.asarray(np.abs(np.take_along_axis(curves, index[np.newaxis], axis=0)[ -1] - fill_ratio))": "one",
}


@dataclass(frozen=True)
class Mutant:
    """One fault: the module, the place and kind of the fault, and the module's text with it."""

    module: str
    line: int
    kind: str
    text: str

    def change(self) -> str:
        """What it changes, in a line."""
        diff = difflib.unified_diff(read(self.module).splitlines(), self.text.splitlines(), lineterm="", n=0)
        lines = [line for line in diff if line[:3] not in ("---", "+++", "@@ ")]
        old, new = (" / ".join(line[1:].strip() for line in lines if line[0] == sign) for sign in "-+")
        return f"{self.module}: {old} -> {new}"


def read(module: str) -> str:
    """The text of a module."""
    return (ROOT / SOURCE / f"{module}.py").read_text(encoding="utf-8")


def rearranged(text: str) -> Iterator[tuple[tuple[int, int], str, str]]:
    """Faults in calls: the place, the kind, and the text in which arguments change places or one is left out."""
    raw = text.encode()
    starts = [0]
    for line in raw.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def span(node: ast.AST) -> tuple[int, int]:
        return starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset

    for call in ast.walk(ast.parse(text)):
        if not isinstance(call, ast.Call):
            continue
        symmetric = isinstance(call.func, ast.Name) and call.func.id in ("min", "max")
        for one, other in () if symmetric else itertools.pairwise(call.args):
            (a, b), (c, d) = span(one), span(other)
            if raw[a:b] != raw[c:d]:
                new = raw[:a] + raw[c:d] + raw[b:c] + raw[a:b] + raw[d:]
                yield (one.lineno, one.col_offset), "arguments change places", new.decode()
        for keyword in call.keywords:
            if keyword.arg is not None:
                a, b = span(keyword)
                rest = raw[b:].lstrip()
                new = raw[:a] + (rest[1:] if rest[:1] == b"," else raw[b:])
                yield (keyword.lineno, keyword.col_offset), "argument left out", new.decode()


def beyond_tests(text: str) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Annotations and decorators, by their ends: what they say is for type checkers and compilers."""
    out: list[ast.AST] = []
    for node in ast.walk(ast.parse(text)):
        out += getattr(node, "decorator_list", [])
        out += [part for name in ("annotation", "returns") if (part := getattr(node, name, None)) is not None]
    return [((n.lineno, n.col_offset), (n.end_lineno, n.end_col_offset)) for n in out]  # type: ignore[attr-defined]


def mutants_of(module: str) -> dict[tuple[int, int], list[tuple[str, int | str]]]:
    """By place (line, column) the faults that may be there: Cosmic Ray's operator and occurrence, or kind and text."""
    from cosmic_ray.ast import ast_nodes, get_ast
    from cosmic_ray.plugins import get_operator, operator_names

    text = read(module)
    places: dict[tuple[int, int], list[tuple[str, int | str]]] = {}
    nodes = list(ast_nodes(get_ast(text)))
    for name in operator_names():
        if name == "core/RemoveDecorator" or get_operator(name).arguments():
            continue
        operator = get_operator(name)()
        positions = (start for node in nodes for start, _ in operator.mutation_positions(node))
        for occurrence, start in enumerate(positions):
            places.setdefault(start, []).append((name, occurrence))
    for start, kind, new in rearranged(text):
        places.setdefault(start, []).append((kind, new))
    left_out = beyond_tests(text)
    return {at: kinds for at, kinds in places.items() if not any(a <= at < b for a, b in left_out)}


def with_fault(text: str, kind: str, which: int | str) -> str:
    """The text with a fault; the same text where the fault comes to nothing."""
    from cosmic_ray.mutating import mutate_code
    from cosmic_ray.plugins import get_operator

    if isinstance(which, str):
        return which
    try:
        return mutate_code(text, get_operator(kind)(), which) or text
    except AttributeError:  # Cosmic Ray knows no exceptions with a dot in their name
        return text


def sampled(modules: list[str], size: int, seed: int) -> list[Mutant]:
    """A sample of faults, each at a place of its own, by module and line.

    Places are drawn by lots that depend on the text there: a change elsewhere leaves nearly all of a sample as it was.
    """
    lots = []
    for module in modules:
        lines, alike = read(module).splitlines(), Counter[str]()
        for (line, column), kinds in sorted(mutants_of(module).items()):
            address = f"{seed} {module} {column} {lines[line - 1]}"
            alike[address] += 1
            lots.append((random.Random(f"{address} {alike[address]}").random(), module, line, kinds))
    out: list[Mutant] = []
    for lot, module, line, kinds in sorted(lots, key=lambda one: one[:3]):
        if len(out) == size:
            break
        kind, which = random.Random(lot).choice(kinds)
        text = with_fault(read(module), kind, which)
        if text != read(module):
            out.append(Mutant(module, line, kind.removeprefix("core/"), text))
    return sorted(out, key=lambda mutant: (mutant.module, mutant.line))


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
SECONDS = 240, 900  # in CPython and compiled, after which tests have noticed: the fault goes on for ever


def files(tests: str) -> list[str]:
    """What pytest is told by a line that names tests."""
    parts = (name.partition("::") if name[0] != "-" else (name, "", "") for name in tests.split())
    return [
        file + colons + test if file[0] == "-" else f"tests/{file}.py{colons}{test}" for file, colons, test in parts
    ]


def passes(folder: Path, tests: str, compiled: bool) -> bool:
    """Whether all of these pass in time, in a copy of the tree."""
    environment = os.environ | {"NUMBA_OPT": "1", "NUMBA_DISABLE_JIT": str(int(not compiled))}
    environment |= {"PYTHONPATH": str(folder / "src"), "SWARMCENSUS_CACHE": str(folder / "cache")}
    environment |= {"PYTHONDONTWRITEBYTECODE": "1"}  # CPython takes two texts of one length and second for the same
    command = [sys.executable, "-m", "pytest", *OPTIONS, *files(tests)]
    try:
        with (folder / "log").open("w") as log:
            run = subprocess.run(
                command, cwd=folder, env=environment, stdout=log, stderr=log, timeout=SECONDS[compiled]
            )
    except subprocess.TimeoutExpired:
        return False
    return run.returncode == 0


def survives(mutant: Mutant, folder: Path) -> bool:
    """Whether no test notices the fault, in a copy of the tree."""
    place = folder / SOURCE / f"{mutant.module}.py"
    place.write_text(mutant.text, encoding="utf-8")
    try:
        return all(passes(folder, tests, bool(compiled)) for compiled, tests in enumerate(TESTS[mutant.module]))
    finally:
        place.write_text(read(mutant.module), encoding="utf-8")


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


def tested(mutants: list[Mutant], jobs: int) -> list[Mutant]:
    """Those that survive; prints as it goes. Exits where tests fail without any fault."""
    with tempfile.TemporaryDirectory(prefix="mutation-") as below, ThreadPoolExecutor(jobs) as pool:
        free = copies(jobs, Path(below))
        folder = free.get()
        for compiled, tests in sorted({one for m in mutants for one in enumerate(TESTS[m.module])}):
            if not passes(folder, tests, bool(compiled)):
                sys.exit(f"{tests} fail without any fault:\n{(folder / 'log').read_text()[-3000:]}")
        free.put(folder)

        def one(mutant: Mutant) -> bool:
            folder = free.get()
            try:
                return mutant.change() in EQUIVALENT or survives(mutant, folder)
            finally:
                free.put(folder)

        survivors = []
        for number, (mutant, alive) in enumerate(zip(mutants, pool.map(one, mutants), strict=True), start=1):
            print(f"{number:4} {'SURVIVED' if alive else 'noticed '} {mutant.line:4} {mutant.change()}", flush=True)
            survivors += [mutant] if alive else []
    return survivors


def main() -> None:
    """Sample, test, and print the score."""
    names = {Path(module).name: module for module in TESTS}
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("module", nargs="*", help=f"of {', '.join(names)}; all of them if none is named")
    parser.add_argument("--sample", type=int, default=300, metavar="N", help="how many faults [300]")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="which ones [1]")
    parser.add_argument("--jobs", type=int, default=2, metavar="J", help="how many at a time [2]")
    options = parser.parse_args()
    if unknown := set(options.module) - set(names):
        parser.error(f"no module {', '.join(sorted(unknown))}")
    mutants = sampled([names[m] for m in options.module or names], options.sample, options.seed)
    survivors = tested(mutants, options.jobs)
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
