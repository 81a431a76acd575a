"""A brain file, read and checked against the contract. See docs/brain-contract.md."""

import ast
import functools
import types
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

from swarmcensus.brains.adversary import refuse_adversary
from swarmcensus.brains.brain_file import UNLOADED, Program
from swarmcensus.brains.contract import Contents, kinds_of, read_contents
from swarmcensus.brains.fields import Fixed, Value, Vector, length, slots
from swarmcensus.brains.float32 import in_single, rounded_to_single
from swarmcensus.brains.kinds import Kinds
from swarmcensus.brains.packing import PLAIN, Numbers, Part, bytes_of, parts
from swarmcensus.brains.requirements import values_of
from swarmcensus.brains.syntax import BELIEFS, Uses, never_speaks
from swarmcensus.support import safe_source
from swarmcensus.support.errors import InputError
from swarmcensus.support.plugins import Plugins, read_source

PLUGINS = Plugins("brain", "swarmcensus.brains", "swarmcensus.brains.library")
BYTES_A_NUMBER = 4  # on the robot


@dataclass(frozen=True)
class Brain(Program):
    """One brain file that keeps the contract, with values of its parameters."""

    kind: ClassVar[str] = "brain"

    contents: Contents = field(compare=False, repr=False)
    numbers: Numbers = PLAIN

    def with_numbers(self, numbers: Numbers) -> "Brain":
        """This brain in other number formats; in single precision its functions and initial values are rounded."""
        if numbers == self.numbers:
            return self
        if numbers.precision == self.numbers.precision:
            return replace(self, numbers=numbers)
        tree, contents = _read(self.source, self.path)
        if numbers.precision == "single":
            tree = in_single(tree, self.kinds)
            rounded = {k: _round(v) for k, v in contents.memory.items()}
            contents = contents._replace(memory=rounded)
        functions = safe_source.run(tree, "brain", self.path) if self.is_loaded else self.functions
        return replace(self, numbers=numbers, contents=contents, functions=functions)

    @functools.cached_property
    def running_source(self) -> str:
        """The source that is run: the file's, or that in single precision."""
        if self.numbers.precision == "double":
            return self.source
        return ast.unparse(in_single(_read(self.source, self.path)[0], self.kinds))

    @functools.cached_property
    def kinds(self) -> Kinds:
        """The kinds of its source's expressions."""
        lengths = self.lengths | {name: length(value) for name, value in self.parameters.items()}
        return kinds_of(_read(self.source, self.path)[0], lengths, self.message)

    @property
    def memory(self) -> dict[str, Value]:
        """Every field that a robot remembers, and its initial value."""
        return self.contents.memory

    @property
    def message(self) -> dict[str, int]:
        """The fields of a message, and the length of each vector; 0 for a number."""
        return self.contents.message

    @property
    def sums(self) -> tuple[str, ...]:
        """The fields to which `receive` only adds values that depend on the message alone."""
        return self.contents.sums

    @property
    def options(self) -> int:
        """The number of options that it decides between: white and black, or bins of the fill ratio."""
        return self.contents.options

    @property
    def roles(self) -> dict[str, str]:
        """The meaning of message fields, where known. See `contract.ROLES`."""
        return self.contents.roles

    @property
    def is_opinion(self) -> bool:
        """Whether its estimate is an opinion, 0 or 1, so that its error means little."""
        return self.contents.opinion

    @functools.cached_property
    def needs(self) -> dict[str, float]:
        """What it needs of a study, with the values of its parameters. See `needs.KEYS`."""
        return ({"binary": 1.0} if self.is_opinion else {}) | values_of(self.contents.needs, self.parameters)

    @property
    def is_oracle(self) -> bool:
        """Whether it is an upper bound: it hears every robot, whatever the network, and knows the true accuracies."""
        return self.contents.oracle

    @property
    def uses(self) -> Uses:
        """Which optional parts of the contract it uses."""
        return self.contents.uses

    @functools.cached_property
    def never_speaks(self) -> bool:
        """Whether it plainly sends nothing, ever."""
        return never_speaks(ast.parse(self.source))

    @property
    def steers(self) -> bool:
        """Whether it steers its robot, so that the trajectory depends on the brain."""
        return "steer" in self.contents.functions

    @property
    def decides(self) -> bool:
        """Whether it decides between options."""
        return "decide" in self.contents.functions

    @property
    def jams(self) -> bool:
        """Whether it may jam the messages of others."""
        return "jam" in self.contents.functions

    @property
    def ends(self) -> bool:
        """Whether it says when it is done."""
        return "done" in self.contents.functions

    @property
    def has_interval(self) -> bool:
        """Whether it gives an interval for the fill ratio."""
        return "interval" in self.contents.functions

    @functools.cached_property
    def lengths(self) -> dict[str, int]:
        """The length of each vector of the memory; 0 for a number."""
        return {name: length(value) for name, value in self.memory.items()}

    @functools.cached_property
    def memory_bytes(self) -> int:
        """The size of a robot's memory, with its beliefs and what its messages owe; parameters are in its program."""
        return BYTES_A_NUMBER * (len(slots(self.lengths)) + len(self.owed) + len(BELIEFS))

    @functools.cached_property
    def message_bytes(self) -> int:
        """The size of one message, in bytes."""
        return bytes_of(self.parts) if self.parts else BYTES_A_NUMBER * len(slots(self.message))

    @functools.cached_property
    def parts(self) -> tuple[Part, ...]:
        """How its message becomes bytes; empty without a format."""
        return parts(self.message, self.roles, self.numbers.message)

    @functools.cached_property
    def owed(self) -> tuple[int, ...]:
        """Which numbers of the message owe to the next one what rounding takes of them."""
        exact = "float32" if self.numbers.precision == "single" else ""
        kept = [part for part in self.parts if part.owed and part.coding != exact] if self.numbers.feedback else []
        return tuple(k for part in kept for k in part.places)

    @functools.cached_property
    def _robot(self) -> type:
        extras = [name for name, used in (("luck", self.uses.luck), ("name", self.uses.name)) if used]
        return type("Robot", (), {"__slots__": (*self.memory, *self.parameters, *extras, *BELIEFS)})

    def robot(self, b: float, w: float, name: float = 0.0) -> Any:
        """A blank state for CPython: it has the fields of MEMORY, the parameters and what is given, and no others."""
        state = self._robot()
        for key, value in self.memory.items():
            setattr(state, key, Vector(value) if isinstance(value, tuple) else value)
        for key, given in self.parameters.items():
            value = _round(given) if self.numbers.precision == "single" else given
            setattr(state, key, Fixed(value) if isinstance(value, tuple) else value)
        if self.uses.luck:
            state.luck = 0.5
        if self.uses.name:
            state.name = name
        state.b, state.w = b, w
        return state


def _round(value: Value) -> Value:
    """The nearest value in single precision."""
    return tuple(map(rounded_to_single, value)) if isinstance(value, tuple) else rounded_to_single(value)


def shipped() -> list[str]:
    """The names of the brains that come with swarmcensus."""
    return list(PLUGINS.shipped)


def is_shipped(brain: Brain) -> bool:
    """Whether a brain is one that comes with swarmcensus, unchanged: its tests show that it fails nowhere."""
    return brain.name in PLUGINS.shipped and brain.source == load(brain.name).source


def load(name: str | Path, base: Path | None = None) -> Brain:
    """Read a brain by its name, shipped or of another package, or a brain file by its path, relative to `base`.

    Raises InputError if the file is missing or breaks the contract.
    """
    refuse_adversary(str(name), base, PLUGINS)
    path = find(name, base)
    return parse(read_source("brain", path), str(name), path)


def find(name: str | Path, base: Path | None = None) -> Path:
    """The path of a brain's file. Raises InputError if there is none."""
    return safe_source.find(PLUGINS, str(name), base)


def parse(source: str, name: str, path: Path) -> Brain:
    """Check a brain's source against the contract and run it once. Raises InputError."""
    _, contents = _read(source, path)
    return Brain(name, path, source, contents, _module(source, path))


@functools.lru_cache(maxsize=128)
def _module(source: str, path: Path) -> types.ModuleType:
    """The module of a source; cached, for studies with many values of a brain's parameters."""
    return safe_source.run(_read(source, path)[0], "brain", path)


@functools.lru_cache(maxsize=128)
def _read(source: str, path: Path) -> tuple[ast.Module, Contents]:
    """The syntax tree and contents of a source; cached, because the check takes tens of milliseconds."""
    tree, constants = safe_source.parse_checked(source, "brain", path)
    return tree, read_contents(tree, constants, path)


def unloaded(name: str, source: str) -> Brain:
    """Read a brain's contents from its source without running it; they are empty if it breaks the contract."""
    try:
        _, contents = _read(source, Path(name))
    except InputError:
        contents = Contents({}, {}, (), {}, 2, Uses(frozenset(), False, False), frozenset(), {}, False, False, {})
    return Brain(name, Path(name), source, contents, types.ModuleType(UNLOADED))
