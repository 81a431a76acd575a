"""A metric file, read and checked against its contract. See docs/metrics.md."""

import ast
import functools
import math
import types
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swarmcensus.brains.contract import functions_in, require
from swarmcensus.brains.syntax import BrokenContract, arguments_of, functions_of, is_name, naming_lines
from swarmcensus.support import safe_source
from swarmcensus.support.plugins import Plugins, digest, read_source

PLUGINS = Plugins("metric", "swarmcensus.metrics", "swarmcensus.brains.metrics.library")
FUNCTIONS = {"begin": 1, "watch": 4, "result": 1}
MAY_HAVE = {"after": 2}  # only in metrics of a swarm
GIVEN = ("low", "high", "delta", "rounds", "robots")  # fields that each record has before `begin`
BETTER = {"low": True, "high": False}
LONGEST_LABEL = 24


@dataclass(frozen=True)
class Metric:
    """One metric file that keeps the contract; it has not been run."""

    name: str  # a shipped metric's name, or the file's path as the user gave it
    path: Path
    source: str
    fields: tuple[str, ...]  # of its record, without GIVEN
    unit: str
    meaning: str
    bounds: tuple[float, float]  # its smallest and largest possible values
    of_swarm: bool  # whether it has one record per swarm, not per robot
    uses: frozenset[str]  # those of GIVEN that it reads
    low: bool | None = None  # whether low values are better; None if the file does not say
    label: str = ""  # in tables and figures; empty for the variable's name

    @property
    def form(self) -> str:
        """As in a study file."""
        return self.name

    @property
    def variable(self) -> str:
        """The name of its variable in the dataset."""
        return variable_of(self.name)

    @functools.cached_property
    def sha256(self) -> str:
        """The hash of the source, as stored with results."""
        return digest(self.source)

    @functools.cached_property
    def functions(self) -> types.ModuleType:
        """The file as a module, run by CPython. Raises InputError."""
        return safe_source.run(safe_source.parse_checked(self.source, "metric", self.path)[0], "metric", self.path)

    @functools.cached_property
    def _record(self) -> type:
        return type("Record", (), {"__slots__": (*GIVEN, *self.fields)})

    def record(self, **given: float) -> Any:
        """A record for CPython with values of GIVEN; it has these and the metric's fields, and no others."""
        record = self._record()
        for name, value in given.items():
            setattr(record, name, value)
        return record


def variable_of(name: str) -> str:
    """The name of the dataset's variable for a metric of this name."""
    return Path(name).name.removesuffix(".py").replace("-", "_")


def load(name: str | Path, base: Path | None = None) -> Metric:
    """Read a metric by its name, shipped or of another package, or a metric file by its path, relative to `base`.

    Raises InputError if the file is missing or breaks the contract.
    """
    path = find(name, base)
    return parse(read_source("metric", path), str(name), path)


def find(name: str | Path, base: Path | None = None) -> Path:
    """The path of a metric's file. Raises InputError if there is none."""
    return safe_source.find(PLUGINS, str(name), base)


@functools.lru_cache(maxsize=256)
def parse(source: str, name: str, path: Path) -> Metric:
    """Check a metric's source against the contract without running it. Raises InputError."""
    tree, constants = safe_source.parse_checked(source, "metric", path)
    with naming_lines("metric", path):
        return _metric(source, name, path, tree, constants)


def _metric(source: str, name: str, path: Path, tree: ast.Module, constants: Mapping[str, Any]) -> Metric:
    of_swarm = "after" in functions_in(tree, constants, FUNCTIONS, MAY_HAVE)
    functions = functions_of(tree)
    returns = [node for node in ast.walk(functions["result"]) if isinstance(node, ast.Return)]
    if not returns or any(node.value is None for node in returns):
        raise BrokenContract("result returns no number", functions["result"].lineno)
    for key, example in (("UNIT", '"rounds"'), ("MEANING", '"first round in the correct bin for good"')):
        value = constants.get(key)
        is_text = isinstance(value, str) and bool(value.strip()) and value.isprintable()
        require(is_text, f"{key} is missing: a text such as {example}")
    bounds = constants.get("BOUNDS", (-math.inf, math.inf))
    require(_are_bounds(bounds), "BOUNDS should be two numbers, the least and the largest that it can be: (0.0, 1.0)")
    better, label = constants.get("BETTER"), constants.get("LABEL", "")
    require(better in (None, *BETTER), f'BETTER = {better!r}: should be "low" or "high"')
    is_short = isinstance(label, str) and label.isprintable() and len(label) <= LONGEST_LABEL
    require(is_short, f'LABEL should be a text of up to {LONGEST_LABEL} characters, such as "first right"')
    variable = variable_of(name)
    right = "use letters, digits and _ before .py"
    require(safe_source.is_name(variable), f"{variable!r} cannot name a variable of the results: {right}")
    for function in functions.values():
        for node in ast.walk(function):
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and node.attr in GIVEN:
                raise BrokenContract(f"{function.name} sets {node.attr}, which is read-only", node.lineno)
    fields = dict.fromkeys(attribute.attr for attribute in _record_fields(functions["begin"], ast.Store))
    for known in (*FUNCTIONS, *MAY_HAVE):
        for attribute in _record_fields(functions[known]) if known in functions else ():
            if attribute.attr not in fields and attribute.attr not in GIVEN:
                where = f"its record has {', '.join((*fields, *GIVEN))}"
                raise BrokenContract(
                    f"{known} uses {attribute.attr}, which begin does not set: {where}", attribute.lineno
                )
    uses = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)} & {*GIVEN}
    low, high = map(float, bounds)
    return Metric(
        name, path, source, tuple(fields), constants["UNIT"], constants["MEANING"], (low, high), of_swarm,
        frozenset(uses), BETTER[better] if better else None, label,
    )  # fmt: skip


def _are_bounds(value: object) -> bool:
    numbers = isinstance(value, tuple) and all(isinstance(v, int | float) and v == v for v in value)
    return numbers and len(value) == 2 and value[0] < value[1]  # type: ignore[arg-type, index]


def _record_fields(function: ast.FunctionDef, kind: type = ast.expr_context) -> Iterator[ast.Attribute]:
    """The attributes of a function's first argument that it uses."""
    record = arguments_of(function)[0]
    for node in ast.walk(function):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, kind) and is_name(node.value, record):
            yield node
