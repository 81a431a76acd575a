"""A brain file, read and held against the contract: see docs/brain-contract.md."""

import ast
import functools
import types
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

from swarmcensus.basics import safe_source
from swarmcensus.basics.errors import InputError
from swarmcensus.basics.plugins import Plugins
from swarmcensus.brains.adversary import refuse_adversary
from swarmcensus.brains.contract import Contents, contents
from swarmcensus.brains.fields import Fixed, Value, Vector, length, slots
from swarmcensus.brains.program import UNLOADED, Program
from swarmcensus.brains.syntax import BELIEFS, Uses

PLUGINS = Plugins("brain", "swarmcensus.brains", "swarmcensus.brains.library")
BYTES_A_NUMBER = 4  # on the robot


@dataclass(frozen=True)
class Brain(Program):
    """One brain file, read and found to keep the contract, with values of its parameters."""

    kind: ClassVar[str] = "brain"

    contents: Contents = field(compare=False, repr=False)

    @property
    def memory(self) -> dict[str, Value]:
        """Every field that a robot remembers, and its value before the first observation."""
        return self.contents.memory

    @property
    def message(self) -> dict[str, int]:
        """What a robot says, and how long each vector of it is; 0 for a number."""
        return self.contents.message

    @property
    def sums(self) -> tuple[str, ...]:
        """The fields to which `receive` only adds what depends on the message alone."""
        return self.contents.sums

    @property
    def options(self) -> int:
        """Among how many options it decides: white and black, or bins of the fill ratio."""
        return self.contents.options

    @property
    def roles(self) -> dict[str, str]:
        """What fields of its message mean, as far as that is known: see `contract.ROLES`."""
        return self.contents.roles

    @property
    def is_opinion(self) -> bool:
        """Whether its estimate is a mere opinion, 0 or 1, which no error should be taken of."""
        return self.contents.opinion

    @property
    def is_oracle(self) -> bool:
        """Whether it is a bound: it hears every robot whatever the network, and believes in the true accuracies."""
        return self.contents.oracle

    @property
    def uses(self) -> Uses:
        """Which parts of the contract's second edition it asks for."""
        return self.contents.uses

    @property
    def steers(self) -> bool:
        """Whether it says where its robot goes: such a walk depends on the brain."""
        return "steer" in self.contents.functions

    @property
    def decides(self) -> bool:
        """Whether it decides for an option."""
        return "decide" in self.contents.functions

    @property
    def jams(self) -> bool:
        """Whether it may drown what others say."""
        return "jam" in self.contents.functions

    @property
    def ends(self) -> bool:
        """Whether it says when it has seen enough."""
        return "done" in self.contents.functions

    @property
    def has_interval(self) -> bool:
        """Whether it says between which two numbers it believes the fill ratio to lie."""
        return "interval" in self.contents.functions

    @functools.cached_property
    def lengths(self) -> dict[str, int]:
        """How long each vector of the memory is; 0 for a number."""
        return {name: length(value) for name, value in self.memory.items()}

    @functools.cached_property
    def memory_bytes(self) -> int:
        """What a robot remembers, beliefs about its sensor included; parameters are part of its program."""
        return BYTES_A_NUMBER * (len(slots(self.lengths)) + len(BELIEFS))

    @functools.cached_property
    def message_bytes(self) -> int:
        """What a robot broadcasts in one message."""
        return BYTES_A_NUMBER * len(slots(self.message))

    @functools.cached_property
    def _robot(self) -> type:
        extras = [name for name, asked in (("luck", self.uses.luck), ("name", self.uses.name)) if asked]
        return type("Robot", (), {"__slots__": (*self.memory, *self.parameters, *extras, *BELIEFS)})

    def robot(self, b: float, w: float, name: float = 0.0) -> Any:
        """A blank mind for CPython: it can hold the fields of MEMORY and nothing else, beside what it is given."""
        mind = self._robot()
        for key, value in self.memory.items():
            setattr(mind, key, Vector(value) if isinstance(value, tuple) else value)
        for key, value in self.parameters.items():
            setattr(mind, key, Fixed(value) if isinstance(value, tuple) else value)
        if self.uses.luck:
            mind.luck = 0.5
        if self.uses.name:
            mind.name = name
        mind.b, mind.w = b, w
        return mind


def shipped() -> list[str]:
    """The names of the brains that come with swarmcensus."""
    return list(PLUGINS.shipped)


def load(name: str | Path, base: Path | None = None) -> Brain:
    """Read a brain by its name, shipped or of another package, or a brain file by its path, relative to `base`.

    Raises InputError where the file is not there or breaks the contract.
    """
    refuse_adversary(str(name), base, PLUGINS)
    path = find(name, base)
    return parse(safe_source.read_source("brain", path), str(name), path)


def find(name: str | Path, base: Path | None = None) -> Path:
    """Where a brain's file is. Raises InputError where there is none."""
    return safe_source.find(PLUGINS, str(name), base)


def parse(source: str, name: str, path: Path) -> Brain:
    """Check a brain's source against the contract and run it once. Raises InputError."""
    tree, says = _read(source, path)
    return Brain(name, path, source, says, safe_source.run(tree, "brain", path))


@functools.lru_cache(maxsize=32)
def _read(source: str, path: Path) -> tuple[ast.Module, Contents]:
    """What a source holds and says. The check takes tens of milliseconds, and each study asks for the same few."""
    tree, constants = safe_source.parse_checked(source, "brain", path)
    return tree, contents(tree, constants, path)


def unloaded(name: str, source: str) -> Brain:
    """A brain of which nothing is run, and what it says is taken from its source, where that keeps the contract."""
    try:
        _, says = _read(source, Path(name))
    except InputError:
        says = Contents({}, {}, (), {}, 2, Uses(frozenset(), False, False), frozenset(), {}, False, False)
    return Brain(name, Path(name), source, says, types.ModuleType(UNLOADED))
