"""A metric file, read and held against the contract: see docs/metrics.md."""

import ast
import functools
import math
import types
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarmcensus.basics import safe_source
from swarmcensus.basics.errors import InputError
from swarmcensus.basics.plugins import Plugins
from swarmcensus.vocabulary.coordinates import COORDINATES
from swarmcensus.vocabulary.quantities import QUANTITIES

PLUGINS = Plugins("metric", "swarmcensus.metrics", "swarmcensus.metrics.library")
FUNCTIONS = {"begin": 1, "watch": 4, "result": 1}
MAY_HAVE = {"after": 2}  # of the metrics of a swarm
GIVEN = ("low", "high", "delta", "rounds", "robots")  # what each record holds before `begin`
RESERVED = {  # names of the dataset, and of its summary
    *QUANTITIES, *COORDINATES, "setting", "trial", "robot", "checkpoint", "end", "parameters",
    "trials", "failed", "K", "error", "right",
}  # fmt: skip
BETTER = {"low": True, "high": False}
LONGEST_LABEL = 24
PREFIXES = ("edge_", "edges_", "floor_", "row_", "column_")  # of other names of the dataset
SUFFIXES = ("_low", "_high")  # of those of the summary


@dataclass(frozen=True)
class Metric:
    """One metric file, found to keep the contract; nothing of it has been run."""

    name: str  # a shipped metric's name, or the file's path as the user gave it
    path: Path
    source: str
    fields: tuple[str, ...]  # of its record, beside GIVEN
    unit: str
    meaning: str
    bounds: tuple[float, float]  # the least and the largest number that it can be
    of_swarm: bool  # one record a swarm, not one a robot
    uses: frozenset[str]  # which of GIVEN it looks at
    low: bool | None = None  # whether less of it is better; None where the file does not say
    label: str = ""  # of tables and figures; its variable's name where the file does not say

    @property
    def variable(self) -> str:
        """What it is called in the dataset."""
        return variable_of(self.name)

    @functools.cached_property
    def sha256(self) -> str:
        """The hash of the source, as stored with results."""
        return safe_source.digest(self.source)

    @functools.cached_property
    def functions(self) -> types.ModuleType:
        """The file itself, run by CPython. Raises InputError."""
        return safe_source.run(safe_source.parse_checked(self.source, "metric", self.path)[0], "metric", self.path)

    @functools.cached_property
    def _record(self) -> type:
        return type("Record", (), {"__slots__": (*GIVEN, *self.fields)})

    def record(self, **given: float) -> Any:
        """A record for CPython, of what is GIVEN: it can hold the metric's fields and nothing else."""
        one = self._record()
        for name, value in given.items():
            setattr(one, name, value)
        return one


def variable_of(name: str) -> str:
    """The variable of a metric of this name."""
    return Path(name).name.removesuffix(".py").replace("-", "_")


def load(name: str | Path, base: Path | None = None) -> Metric:
    """Read a metric by its name, shipped or of another package, or a metric file by its path, relative to `base`.

    Raises InputError where the file is not there or breaks the contract.
    """
    path = find(name, base)
    return parse(safe_source.read_source("metric", path), str(name), path)


def find(name: str | Path, base: Path | None = None) -> Path:
    """Where a metric's file is. Raises InputError where there is none."""
    return safe_source.find(PLUGINS, str(name), base)


@functools.lru_cache(maxsize=256)
def parse(source: str, name: str, path: Path) -> Metric:
    """Check a metric's source against the contract; it is not run. Raises InputError."""

    def bad(what: str, node: ast.stmt | ast.expr | None = None) -> InputError:
        return InputError(f"metric file {path}{f', line {node.lineno}' if node else ''}: {what}")

    tree, constants = safe_source.parse_checked(source, "metric", path)
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    for known, arity in (FUNCTIONS | MAY_HAVE).items():
        if known not in functions:
            if known in FUNCTIONS:
                raise bad(f"the function {known} is missing")
            continue
        found = len(functions[known].args.args) + len(functions[known].args.posonlyargs)
        if found != arity or functions[known].args.kwonlyargs:
            raise bad(f"{known} takes {found} arguments: {arity} are right", functions[known])
    given_back = [node for node in ast.walk(functions["result"]) if isinstance(node, ast.Return)]
    if not given_back or any(node.value is None for node in given_back):
        raise bad("result returns no number", functions["result"])
    says = {}
    for key, example in (("UNIT", '"rounds"'), ("MEANING", '"first round in the correct bin for good"')):
        value = constants.get(key)
        if not isinstance(value, str) or not value.strip() or not value.isprintable():
            raise bad(f"{key} is missing: a text such as {example}")
        says[key] = value
    bounds = constants.get("BOUNDS", (-math.inf, math.inf))
    if not _are_bounds(bounds):
        raise bad("BOUNDS should be two numbers, the least and the largest that the metric can be: (0.0, 1.0)")
    better = constants.get("BETTER")
    if better not in (None, *BETTER):
        raise bad(f'BETTER = {better!r}: should be "low" or "high"')
    label = constants.get("LABEL", "")
    if not isinstance(label, str) or not (label.isprintable() and len(label) <= LONGEST_LABEL):
        raise bad(f'LABEL should be a text of up to {LONGEST_LABEL} characters, such as "first right"')
    variable = variable_of(name)
    if not safe_source.is_name(variable):
        raise bad(f"{variable!r} cannot name a variable of the results: letters, digits and _ can, and .py after them")
    if variable in RESERVED or variable.startswith(PREFIXES) or variable.endswith(SUFFIXES):
        raise bad(f"the name {variable!r} is taken in the results: call the file otherwise")
    for function in functions.values():
        for node in ast.walk(function):
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and node.attr in GIVEN:
                raise bad(f"{function.name} sets {node.attr}, which is given", node)
    fields = dict.fromkeys(attribute.attr for attribute in _of_record(functions["begin"], ast.Store))
    for known in (*FUNCTIONS, *MAY_HAVE):
        for attribute in _of_record(functions[known]) if known in functions else ():
            if attribute.attr not in fields and attribute.attr not in GIVEN:
                where = f"its record has {', '.join((*fields, *GIVEN))}"
                raise bad(f"{known} uses {attribute.attr}, which begin does not set: {where}", attribute)
    uses = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)} & {*GIVEN}
    of_swarm = "after" in functions
    unit, meaning, low, high = says["UNIT"], says["MEANING"], *map(float, bounds)
    return Metric(
        name, path, source, tuple(fields), unit, meaning, (low, high), of_swarm, frozenset(uses),
        BETTER[better] if better else None, label,
    )  # fmt: skip


def _are_bounds(value: object) -> bool:
    numbers = isinstance(value, tuple) and all(isinstance(v, int | float) and v == v for v in value)
    return numbers and len(value) == 2 and value[0] < value[1]  # type: ignore[arg-type, index]


def _of_record(function: ast.FunctionDef, kind: type = ast.expr_context) -> Iterator[ast.Attribute]:
    """Where a function names a field of its first argument."""
    record = (function.args.posonlyargs + function.args.args)[0].arg
    for node in ast.walk(function):
        if not isinstance(node, ast.Attribute) or not isinstance(node.ctx, kind):
            continue
        if isinstance(node.value, ast.Name) and node.value.id == record:
            yield node
