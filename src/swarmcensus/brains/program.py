"""What brains and adversaries share: a plain-Python file that was read, with values of its parameters."""

import functools
import types
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar, Self

from swarmcensus.basics import safe_source
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.brains.fields import Value, length, value_of

UNLOADED = "unloaded"


@dataclass(frozen=True)
class Program:
    """One file, found to keep its contract, with values of its parameters."""

    kind: ClassVar[str]  # in messages: "brain"

    name: str  # a shipped one's name, or the file's path as the user gave it
    path: Path
    source: str
    contents: Any = field(compare=False, repr=False)  # what it says beside its functions
    functions: types.ModuleType = field(compare=False, repr=False)  # the file itself, run by CPython
    overrides: tuple[tuple[str, Value], ...] = ()  # parameters that are not as the file says

    @functools.cached_property
    def parameters(self) -> dict[str, Value]:
        """Its parameters' values here."""
        found: dict[str, Value] = self.contents.parameters | dict(self.overrides)
        return found

    @functools.cached_property
    def sha256(self) -> str:
        """The hash of the source, as stored with results."""
        return safe_source.digest(self.source)

    @property
    def is_loaded(self) -> bool:
        """Whether there are functions that can be called."""
        return self.functions.__name__ != UNLOADED

    @property
    def label(self) -> str:
        """Its name, and the parameters that are not as the file says."""
        return " ".join([self.name, *(f"{name}={value}" for name, value in self.overrides)])

    @property
    def as_written(self) -> Self:
        """The same with the file's own parameters: machine code is the same for all."""
        return replace(self, overrides=()) if self.overrides else self

    def with_parameters(self, values: Mapping[str, object]) -> Self:
        """The same with other values of some parameters. Raises ValueError, naming the key and the value."""
        given = dict(self.overrides)
        for name, value in values.items():
            own = self.contents.parameters
            if name not in own:
                known = f"{did_you_mean(name, own)}it has {', '.join(own)}" if own else "it has none"
                raise ValueError(f"the {self.kind} {self.name!r} has no parameter {name!r}: {known}")
            try:
                found = value_of(value)
                if length(found) != length(own[name]):
                    asked = f"a vector of {length(own[name])}" if length(own[name]) else "a number"
                    raise ValueError(f"the {self.kind} {self.name!r} asks for {asked}")
            except ValueError as error:
                shown = list(value) if isinstance(value, tuple) else value
                raise ValueError(f"{name} = {shown!r}: {error}") from None
            given[name] = found
        other = {name: value for name, value in given.items() if value != self.contents.parameters[name]}
        return replace(self, overrides=tuple(sorted(other.items())))
