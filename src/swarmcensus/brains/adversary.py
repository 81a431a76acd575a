"""An adversary: a small file that alters what a robot says, whatever its brain: see docs/adversaries.md."""

import ast
import types
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from swarmcensus.basics import safe_source
from swarmcensus.basics.errors import InputError
from swarmcensus.basics.plugins import Plugins
from swarmcensus.brains import syntax
from swarmcensus.brains.contract import FUNCTIONS as OF_BRAINS
from swarmcensus.brains.contract import functions_in, require
from swarmcensus.brains.fields import Value, fields_of, length
from swarmcensus.brains.program import UNLOADED, Program
from swarmcensus.brains.syntax import BELIEFS, GIVEN_ON_ASKING

PLUGINS = Plugins("adversary", "swarmcensus.adversaries", "swarmcensus.brains.adversaries")
FUNCTIONS = {"lie": 2}
MAY_HAVE = {"boast": 2, "forge": 2, "hear": 2, "plot": 1, "jam": 1}
TELL = ("lie", "boast", "forge", "jam")  # these tell, and change nothing
LUCKY = ("hear", "plot")  # luck is fresh at each call of these
NOT_ITS_OWN = ("MESSAGE", "SUMS", "OPTIONS", "ROLES", "OPINION")


class Lies(NamedTuple):
    """What an adversary's file says beside its functions."""

    memory: dict[str, Value]  # its own fields, beside those of the brain that it wears
    parameters: dict[str, Value]
    functions: frozenset[str]  # which of MAY_HAVE there are


@dataclass(frozen=True)
class Adversary(Program):
    """One adversary's file, found to keep its contract, with values of its parameters."""

    kind: ClassVar[str] = "adversary"

    contents: Lies = field(compare=False, repr=False)


def load(name: str | Path, base: Path | None = None) -> Adversary:
    """Read an adversary by its name, or a file by its path, relative to `base`. Raises InputError."""
    path = find(name, base)
    return parse(safe_source.read_source("adversary", path), str(name), path)


def find(name: str | Path, base: Path | None = None) -> Path:
    """Where an adversary's file is. Raises InputError where there is none."""
    return safe_source.find(PLUGINS, str(name), base)


def parse(source: str, name: str, path: Path) -> Adversary:
    """Check an adversary's source against its contract and run it once. Raises InputError."""
    tree, says = _checked(source, path)
    return Adversary(name, path, source, says, safe_source.run(tree, "adversary", path))


def unloaded(source: str, name: str, path: Path) -> Adversary:
    """An adversary of which nothing is run, and what it says is taken from its source. Raises InputError."""
    _, says = _checked(source, path)
    return Adversary(name, path, source, says, types.ModuleType(UNLOADED))


def is_adversary(source: str) -> bool:
    """Whether a source is an adversary's, and no brain's; nothing of it is run."""
    try:
        functions = syntax.functions_of(ast.parse(source))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return "lie" in functions and not functions.keys() & OF_BRAINS.keys()


def exists(name: str, base: Path | None) -> bool:
    """Whether a name, or the path of a file relative to `base`, is that of an adversary."""
    path = (base or Path()) / name
    if name not in PLUGINS.shipped and path.is_file():
        return is_adversary(safe_source.read_source("brain", path))
    return name in PLUGINS


def refuse_adversary(name: str, base: Path | None, brains: Plugins) -> None:
    """Raise InputError if `name`, expected to be a brain, is an adversary."""
    if name in brains.shipped or not exists(name, base):
        return
    if ((base or Path()) / name).is_file() or name not in brains:
        raise InputError(
            f"brain {name!r}: that is an adversary, which wears the brain of its swarm: it goes under [[members]], "
            "with honest = false"
        )


def _checked(source: str, path: Path) -> tuple[ast.Module, Lies]:
    tree, constants = safe_source.parse_checked(source, "adversary", path)
    try:
        return tree, _contents(tree, constants)
    except syntax.Wrong as wrong:
        raise InputError(f"adversary file {path}, line {wrong.line}: {wrong}") from None
    except ValueError as wrong:
        raise InputError(f"adversary file {path}: {wrong}") from None


def _contents(tree: ast.Module, constants: Mapping[str, Any]) -> Lies:
    functions = syntax.functions_of(tree)
    for name in (*OF_BRAINS, *NOT_ITS_OWN):
        require(
            name not in functions and name not in constants, f"{name} is the brain's that it wears, and not its own"
        )
    found = functions_in(tree, constants, FUNCTIONS, MAY_HAVE)
    taken = (*BELIEFS, *GIVEN_ON_ASKING)
    tables = {}
    for name, also in (("MEMORY", ()), ("PARAMETERS", ("file",))):
        given = constants.get(name, {})
        require(isinstance(given, dict), f'{name} should be a dict such as {{"rounds": 0.0}}')
        tables[name] = fields_of(given, name, (*taken, *also))
    memory, parameters = tables["MEMORY"], tables["PARAMETERS"]
    for name in parameters:
        require(name not in memory, f"PARAMETERS[{name!r}] is in MEMORY too: what changes is no parameter")
    syntax.check_returns(functions, TELL)
    held, given = ({name: length(value) for name, value in table.items()} for table in (memory, parameters))
    syntax.check(tree, held, given, (), "lie", TELL, LUCKY)
    return Lies(memory, parameters, found)
