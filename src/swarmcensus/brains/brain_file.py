"""The common base of brains and adversaries: a plain-Python file with values of its parameters."""

import functools
import types
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar, Self

from swarmcensus.brains.fields import Value, length, value_of
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.plugins import digest

UNLOADED = "unloaded"


@dataclass(frozen=True)
class Program:
    """One file that keeps its contract, with values of its parameters."""

    kind: ClassVar[str]  # in messages: "brain"

    name: str  # a shipped one's name, or the file's path as the user gave it
    path: Path
    source: str
    contents: Any = field(compare=False, repr=False)  # what the file declares
    functions: types.ModuleType = field(compare=False, repr=False)  # the file itself, run by CPython
    overrides: tuple[tuple[str, Value], ...] = ()  # parameters that differ from the file

    @functools.cached_property
    def parameters(self) -> dict[str, Value]:
        """The values of its parameters."""
        values: dict[str, Value] = self.contents.parameters | dict(self.overrides)
        return values

    @functools.cached_property
    def sha256(self) -> str:
        """The hash of the source, as stored with results."""
        return digest(self.source)

    @property
    def is_loaded(self) -> bool:
        """Whether its functions can be called."""
        return self.functions.__name__ != UNLOADED

    @property
    def label(self) -> str:
        """Its name, and the parameters that differ from the file."""
        return " ".join([self.name, *(f"{name}={value}" for name, value in self.overrides)])

    @property
    def form(self) -> str | dict[str, object]:
        """As in a study file."""
        return {"file": self.name, **dict(self.overrides)} if self.overrides else self.name

    @property
    def as_written(self) -> Self:
        """This program with the parameters of its file; machine code is shared by all values of parameters."""
        return replace(self, overrides=()) if self.overrides else self

    def with_parameters(self, values: Mapping[str, object]) -> Self:
        """This program with other values of some parameters. Raises ValueError, naming the key and the value."""
        overrides = dict(self.overrides)
        for name, value in values.items():
            own = self.contents.parameters
            if name not in own:
                known = f"{did_you_mean(name, own)}it has {', '.join(own)}" if own else "it has none"
                raise ValueError(f"the {self.kind} {self.name!r} has no parameter {name!r}: {known}")
            try:
                checked = value_of(value)
                if length(checked) != length(own[name]):
                    expected = f"a vector of {length(own[name])}" if length(own[name]) else "a number"
                    raise ValueError(f"the {self.kind} {self.name!r} needs {expected}")
            except ValueError as error:
                shown = list(value) if isinstance(value, tuple) else value
                raise ValueError(f"{name} = {shown!r}: {error}") from None
            overrides[name] = checked
        differing = {name: value for name, value in overrides.items() if value != self.contents.parameters[name]}
        return replace(self, overrides=tuple(sorted(differing.items())))
