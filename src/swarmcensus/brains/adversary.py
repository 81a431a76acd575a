"""An adversary: a small file that alters what a robot says, with any brain. See docs/liars.md."""

import ast
import types
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from swarmcensus.brains import robot_math, robot_syntax, syntax
from swarmcensus.brains.brain_file import UNLOADED, Program
from swarmcensus.brains.contract import FUNCTIONS as OF_BRAINS, functions_in, require
from swarmcensus.brains.fields import Value, fields_of, length
from swarmcensus.brains.syntax import BELIEFS, GIVEN_ON_ASKING
from swarmcensus.support import safe_source
from swarmcensus.support.errors import BrainError
from swarmcensus.support.plugins import Plugins, read_source

PLUGINS = Plugins("adversary", "swarmcensus.adversaries", "swarmcensus.brains.adversaries")
FUNCTIONS = {"lie": 2}
MAY_HAVE = {"boast": 2, "forge": 2, "hear": 2, "plot": 1, "jam": 1}
SAYS = "say_"  # a function of this name and a field of a message returns what is said in that field
READ_ONLY = ("lie", "boast", "forge", "jam")  # these only return values; so do those of SAYS
RANDOM = ("hear", "plot")  # functions with a new random number at each call
OF_THE_BRAIN = ("MESSAGE", "SUMS", "OPTIONS", "ROLES", "OPINION")


class Lies(NamedTuple):
    """What an adversary file declares, and which optional functions it has."""

    memory: dict[str, Value]  # its own fields; the brain that it wraps has others
    parameters: dict[str, Value]
    functions: frozenset[str]  # those of MAY_HAVE and of SAYS that the file has
    knows: tuple[str, ...]  # fields of the brain that it reads


@dataclass(frozen=True)
class Adversary(Program):
    """One adversary file that keeps its contract, with values of its parameters."""

    kind: ClassVar[str] = "adversary"

    contents: Lies = field(compare=False, repr=False)

    def unsaid(self, message: Collection[str]) -> list[str]:
        """Its functions that say fields which this message does not have."""
        says = (name for name in self.contents.functions if name.startswith(SAYS))
        return sorted(name for name in says if name.removeprefix(SAYS) not in message)


def load(name: str | Path, base: Path | None = None) -> Adversary:
    """Read an adversary by its name, or by a path relative to `base`. Raises InputError."""
    path = find(name, base)
    return parse(read_source("adversary", path), str(name), path)


def find(name: str | Path, base: Path | None = None) -> Path:
    """The path of an adversary's file. Raises InputError if there is none."""
    return safe_source.find(PLUGINS, str(name), base)


def parse(source: str, name: str, path: Path) -> Adversary:
    """Check an adversary's source against its contract and run it once. Raises InputError."""
    tree, contents = _check(source, path)
    return Adversary(name, path, source, contents, safe_source.run(tree, "adversary", path))


def unloaded(source: str, name: str, path: Path) -> Adversary:
    """Read an adversary's contents from its source without running it. Raises InputError."""
    _, contents = _check(source, path)
    return Adversary(name, path, source, contents, types.ModuleType(UNLOADED))


def is_adversary(source: str) -> bool:
    """Whether a source is an adversary, and not a brain; it is not run."""
    try:
        functions = syntax.functions_of(ast.parse(source))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return "lie" in functions and not functions.keys() & OF_BRAINS.keys()


def exists(name: str, base: Path | None) -> bool:
    """Whether there is an adversary of this name, or at this path relative to `base`."""
    path = (base or Path()) / name
    if name not in PLUGINS.shipped and path.is_file():
        return is_adversary(read_source("brain", path))
    return name in PLUGINS


def refuse_adversary(name: str, base: Path | None, brains: Plugins) -> None:
    """Raise InputError if `name`, expected to be a brain, is an adversary."""
    if name in brains.shipped or not exists(name, base):
        return
    if ((base or Path()) / name).is_file() or name not in brains:
        wraps = "that is an adversary, which wraps the brain of its swarm"
        raise BrainError.named("brain", name, f"{wraps}: name it under [[members]], with honest = false")


def _check(source: str, path: Path) -> tuple[ast.Module, Lies]:
    tree, constants = safe_source.parse_checked(source, "adversary", path)
    with syntax.naming_lines("adversary", path):
        return tree, _contents(tree, constants)


def _contents(tree: ast.Module, constants: Mapping[str, Any]) -> Lies:
    functions = syntax.functions_of(tree)
    for name in (*OF_BRAINS, *OF_THE_BRAIN):
        require(
            name not in functions and name not in constants,
            f"{name} belongs to the brain that the adversary wraps: leave it out",
        )
    says = dict.fromkeys((name for name in functions if name.startswith(SAYS)), 2)
    optional = functions_in(tree, constants, FUNCTIONS, MAY_HAVE | says)
    taken = (*BELIEFS, *GIVEN_ON_ASKING)
    tables = {}
    for name, more in (("MEMORY", ()), ("PARAMETERS", ("file",))):
        table = constants.get(name, {})
        require(isinstance(table, dict), f'{name} should be a dict such as {{"rounds": 0.0}}')
        tables[name] = fields_of(table, name, (*taken, *more))
    memory, parameters = tables["MEMORY"], tables["PARAMETERS"]
    for name in parameters:
        require(name not in memory, f"PARAMETERS[{name!r}] is in MEMORY too: a value that changes is not a parameter")
    knows = _knows(constants, {**memory, **parameters})
    robot_math.check(tree)
    robot_syntax.check(tree)
    syntax.check_returns(functions, (*READ_ONLY, *says))
    own, given = ({name: length(value) for name, value in table.items()} for table in (memory, parameters))
    syntax.check(tree, own, given, (), "lie", (*READ_ONLY, *says), RANDOM, knows)
    return Lies(memory, parameters, optional, knows)


def _knows(constants: Mapping[str, Any], own: Collection[str]) -> tuple[str, ...]:
    """The fields of KNOWS; `own` are those of the adversary. Raises ValueError."""
    knows = constants.get("KNOWS", ())
    right = 'should be a tuple of fields of the brain, such as ("rounds",)'
    require(isinstance(knows, tuple) and all(map(safe_source.is_name, knows)), f"KNOWS = {knows!r}: {right}")
    for name in knows:
        require(name not in own, f"KNOWS names {name!r}, which is a field of its own: the two need different names")
        usual = f"KNOWS names {name!r}, which every adversary has: leave it out"
        require(name not in (*BELIEFS, *GIVEN_ON_ASKING), usual)
    return tuple(knows)
