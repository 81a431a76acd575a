"""The faults that mutation.py puts into the source, and those of them that no test can tell."""

import ast
import difflib
import itertools
import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

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
