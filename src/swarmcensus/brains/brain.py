"""A brain file, read and held against the contract: see docs/brain-contract.md."""

import functools
import types
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarmcensus.basics import plain
from swarmcensus.basics.doors import Door
from swarmcensus.basics.errors import InputError

DOOR = Door("brain", "swarmcensus.brains", "swarmcensus.brains.library")
FUNCTIONS = {"observe": 3, "broadcast": 1, "receive": 2, "fuse": 1, "estimate": 1}
MAY_HAVE = {"steer": 1}
TRACED = ("estimate", "round", "robot", "blacks", "position", "heading", "looked", "tile", "reading", "neighbours",
          "link", "axis")  # fmt: skip
BELIEFS = ("b", "w")  # the sensor accuracies that a robot assumes, beside its memory
BYTES_A_NUMBER = 4  # on the robot


@dataclass(frozen=True)
class Brain:
    """One brain file, read and found to keep the contract."""

    name: str  # a shipped brain's name, or the file's path as the user gave it
    path: Path
    source: str
    memory: dict[str, float] = field(compare=False)  # every field, its value before the first observation
    message: tuple[str, ...] = field(compare=False)
    sums: tuple[str, ...] = field(
        compare=False
    )  # the fields to which `receive` only adds what depends on the message alone
    functions: types.ModuleType = field(compare=False)  # the file itself, run by CPython

    @functools.cached_property
    def sha256(self) -> str:
        """The hash of the source, as stored with results."""
        return plain.digest(self.source)

    @property
    def steers(self) -> bool:
        """Whether it says where its robot goes: such a walk depends on the brain."""
        return hasattr(self.functions, "steer")

    @property
    def memory_bytes(self) -> int:
        """What a robot remembers, beliefs about its sensor included."""
        return BYTES_A_NUMBER * (len(self.memory) + len(BELIEFS))

    @property
    def message_bytes(self) -> int:
        """What a robot broadcasts in one message."""
        return BYTES_A_NUMBER * len(self.message)

    @functools.cached_property
    def _robot(self) -> type:
        return type("Robot", (), {"__slots__": (*self.memory, *BELIEFS)})

    def robot(self, b: float, w: float) -> Any:
        """A blank mind for CPython: it can hold the fields of MEMORY and nothing else."""
        mind = self._robot()
        for name, value in self.memory.items():
            setattr(mind, name, value)
        mind.b, mind.w = b, w
        return mind


def shipped() -> list[str]:
    """The names of the brains that come with swarmcensus."""
    return list(DOOR.shipped)


def load(name: str | Path, base: Path | None = None) -> Brain:
    """Read a brain by its name, shipped or of another package, or a brain file by its path, relative to `base`.

    Raises InputError where the file is not there or breaks the contract.
    """
    path = find(name, base)
    return parse(plain.read_source("brain", path), str(name), path)


def find(name: str | Path, base: Path | None = None) -> Path:
    """Where a brain's file is. Raises InputError where there is none."""
    return plain.find(DOOR, str(name), base)


def parse(source: str, name: str, path: Path) -> Brain:
    """Check a brain's source against the contract and run it once. Raises InputError."""
    tree, _ = plain.checked(source, "brain", path)
    module = plain.loaded(tree, "brain", path)
    return Brain(name, path, source, *_check_contents(module, path), functions=module)


def _check_contents(module: types.ModuleType, path: Path) -> tuple[dict[str, float], tuple[str, ...], tuple[str, ...]]:
    def need(holds: bool, what: str) -> None:
        if not holds:
            raise InputError(f"brain file {path}: {what}")

    def names(value: object) -> bool:
        return isinstance(value, tuple) and all(plain.is_name(v) for v in value)

    memory = getattr(module, "MEMORY", None)
    need(isinstance(memory, dict) and bool(memory), 'MEMORY is missing: a dict such as {"t": 0.0, "x": 0.5}')
    assert isinstance(memory, dict)
    for key, value in memory.items():
        need(plain.is_name(key), f"MEMORY key {key!r} is not a name")
        need(key not in (*BELIEFS, *TRACED), f"MEMORY key {key!r} is taken by the engine")
        need(
            isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300,
            f"MEMORY[{key!r}] = {value!r}: not a number",
        )
    message = getattr(module, "MESSAGE", None)
    need(names(message) and bool(message), 'MESSAGE is missing: a tuple of names such as ("x_hat", "alpha")')
    sums = getattr(module, "SUMS", ())
    need(names(sums), "SUMS is a tuple of MEMORY names")
    need(len(set(sums)) == len(sums), "SUMS names a field twice")
    for key in sums:
        need(key in memory, f"SUMS names {key!r}, which is not in MEMORY")
    for name, arity in (FUNCTIONS | MAY_HAVE).items():
        if name in MAY_HAVE and not hasattr(module, name):
            continue
        need(hasattr(module, name), f"the function {name} is missing")
        function = getattr(module, name)
        need(isinstance(function, types.FunctionType), f"{name} is {function!r}, not a function")
        found = function.__code__.co_argcount
        need(found == arity, f"{name} takes {found} arguments: {arity} are right")
    assert isinstance(message, tuple)
    return {k: float(v) for k, v in memory.items()}, message, tuple(sums)
