"""Doors: how an addition is found by its name, as a file of ours or as another package's entry point."""

from __future__ import annotations

import functools
import hashlib
import importlib
import importlib.util
import inspect
import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_type_hints

from swarmcensus.basics.errors import InputError, line_of, worded
from swarmcensus.basics.hints import did_you_mean

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint, EntryPoints

    from pydantic import BaseModel

Keys = tuple[tuple[str, Any], ...]  # an addition's own keys and their values, in the order in which it names them


def entry_points(group: str) -> EntryPoints:
    """What other packages give of a group; imported when it is asked, for most studies ask for nothing."""
    from importlib.metadata import entry_points as known

    return known(group=group)


@dataclass(frozen=True, eq=False)
class Door:
    """A kind of addition: where ours lie, and the group of entry points through which others come in.

    A file `scale_free.py` of ours has the name "scale-free". Another package names its own in its metadata:
    `[project.entry-points."swarmcensus.topologies"]`, `torus = "its_package.torus"`.
    """

    what: str  # in messages: "topology"
    group: str  # "swarmcensus.topologies"
    package: str  # in whose folder ours lie: "swarmcensus.worlds.topologies"
    clashes: dict[str, str] = field(default_factory=dict, repr=False)  # names that two packages give
    loaded: dict[str, str] = field(default_factory=dict, repr=False)  # hashes of others' files as they were imported

    @functools.cached_property
    def shipped(self) -> tuple[str, ...]:
        """The names of those that come with swarmcensus."""
        spec = importlib.util.find_spec(self.package)
        assert spec is not None
        folders = map(Path, spec.submodule_search_locations or ())
        stems = (path.stem for folder in folders for path in folder.glob("*.py") if path.stem[0] != "_")
        return tuple(sorted(stem.replace("_", "-") for stem in stems))

    @functools.cached_property
    def outside(self) -> Mapping[str, EntryPoint]:
        """Those of other installed packages by name; ours come first."""
        found: dict[str, EntryPoint] = {}
        for entry in entry_points(group=self.group):
            if entry.name in self.shipped:
                continue
            known = found.setdefault(entry.name, entry)
            if known.value != entry.value:
                self.clashes[entry.name] = f"{known.value}, {entry.value}"
        return found

    def entry(self, name: str) -> EntryPoint:
        """Where another package has it. Raises InputError where two packages do."""
        entry = self.outside[name]
        if name in self.clashes:
            raise InputError(f"two packages give a {self.what} named {name!r}: {self.clashes[name]}")
        return entry

    @property
    def names(self) -> list[str]:
        """The names of all that there are, ours first."""
        return [*self.shipped, *sorted(self.outside)]

    def __contains__(self, name: object) -> bool:
        """Whether there is one of this name; other packages are looked through only where it is not ours."""
        return name in self.shipped or name in self.outside

    @functools.cache  # noqa: B019 (doors are few, and live as long as the program)
    def module(self, name: str) -> Any:
        """What the name stands for, imported. Raises InputError where it cannot be."""
        if name in self.shipped:
            return importlib.import_module(f"{self.package}.{name.replace('-', '_')}")
        entry = self.entry(name)
        try:
            found = entry.load()
        except Exception as error:
            raise InputError(f"{self.what} {name!r}, {entry.value} of {_package(entry)}: {told(error)}") from error
        self.loaded[name] = _hash(self.path(name))
        return found

    def digest(self, name: str) -> str:
        """A hash of another package's file, so that results of two editions of it are told apart; of ours nothing.

        Raises InputError where the file is not what was imported.
        """
        if name in self.shipped:
            return ""
        found = _hash(self.path(name))
        if self.loaded.get(name, found) != found:
            raise InputError(f"{self.what} {name!r}: {self.path(name)} was changed since it was imported: begin anew")
        return found

    def giver(self, name: str) -> str:
        """The package that a name is of."""
        return "swarmcensus" if name in self.shipped else _package(self.outside[name])

    def origin(self, name: str) -> dict[str, str]:
        """Whose another package's addition is, and which edition: `package`, `version`, `sha256`."""
        distribution = self.outside[name].dist
        version = distribution.version if distribution is not None else ""
        return {
            "package": self.giver(name),
            "version": version,
            "sha256": self.loaded.get(name) or _hash(self.path(name)),
        }

    def path(self, name: str) -> Path:
        """Where its file lies, which is not run. Raises InputError where there is none."""
        ours = f"{self.package}.{name.replace('-', '_')}"
        try:
            module = ours if name in self.shipped else self.entry(name).module
            spec = importlib.util.find_spec(module)
        except InputError:
            raise
        except ImportError:
            spec = None
        except Exception as error:  # what a package's __init__ does, or an entry point that cannot be read
            raise InputError(f"{self.what} {name!r} of {self.giver(name)}: {told(error)}") from error
        if spec is None or spec.origin is None or not Path(spec.origin).is_file():
            raise InputError(f"{self.what} {name!r}: {self.giver(name)} names {module}: there is no such file")
        return Path(spec.origin)


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _package(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist is not None else "an installed package"


@functools.cache
def keys_of(function: Callable[..., Any]) -> type[BaseModel]:
    """A model of a function's keyword-only parameters: what each may be, as it is annotated. Raises InputError."""
    from pydantic import ConfigDict, create_model

    config = ConfigDict(
        extra="forbid", strict=True, allow_inf_nan=False, arbitrary_types_allowed=True, protected_namespaces=()
    )
    try:
        hints = get_type_hints(function, include_extras=True)
        fields: dict[str, Any] = {
            p.name: (hints.get(p.name, Any), ... if p.default is p.empty else p.default)
            for p in inspect.signature(function).parameters.values()
            if p.kind is p.KEYWORD_ONLY
        }
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of keys that have the name of a method of pydantic's
            return create_model("Keys", __config__=config, **fields)
    except Exception as error:
        name = f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', function)}"
        raise InputError(f"the keys of {name} cannot be told: {told(error)}") from error


def read_keys(what: str, function: Callable[..., Any], given: Mapping[str, Any], context: Any = None) -> Keys:
    """A function's keyword-only arguments, checked, with its defaults. Raises ValueError with what would be right."""
    from pydantic import ValidationError

    model = keys_of(function)
    try:
        checked = model.model_validate(dict(given), context=context)
    except ValidationError as error:
        # what may be a slip of the pen comes first
        first = min(error.errors(), key=lambda e: {"extra_forbidden": 0, "literal_error": 1}.get(e["type"], 2))
        key, known = str(first["loc"][0]), ", ".join(model.model_fields)
        if first["type"] == "extra_forbidden":
            has = f"{did_you_mean(key, model.model_fields)}it has {known}" if known else "it has none"
            raise ValueError(f"{what} has no key {key}: {has}") from None
        if first["type"] == "missing":
            raise ValueError(f"{what} needs the key {key}") from None
        message = worded(first["msg"])
        if first["type"] == "literal_error":
            hint = did_you_mean(str(first["input"]), re.findall("'(.*?)'", first["ctx"]["expected"]))
            message += f": {hint.rstrip()}" if hint else ""
        unit = model.model_fields[str(first["loc"][0])].description
        raise ValueError(f"{what}: {key} = {first['input']!r}: {message}{f' ({unit})' if unit else ''}") from None
    keys = tuple((name, _frozen(getattr(checked, name))) for name in model.model_fields)
    for name, value in keys:
        if not _is_plain(value):
            raise ValueError(f"{what}: {name} should be a number, a text, true or false, or a list of them")
    return keys


def defaults_of(function: Callable[..., Any]) -> dict[str, Any]:
    """The keys of a function that need not be given, and what they then are."""
    fields = keys_of(function).model_fields.items()
    return {name: _frozen(field.default) for name, field in fields if not field.is_required()}


def told(error: Exception, path: Path | None = None) -> str:
    """In a line what an addition raised: a ValueError is its own words, anything else a fault of its code.

    Of its file, `path`, the line is told.
    """
    if isinstance(error, SyntaxError):
        return f"not Python: {error.msg}, at {error.filename}, line {error.lineno}: {(error.text or '').strip()}"
    if isinstance(error, ValueError) and not isinstance(error, UnicodeError):
        return " ".join(str(error).split())
    return f"{type(error).__name__}: {' '.join(str(error).split())}{line_of(error, path) if path else ''}"


def text_of(value: Any) -> str:
    """A key's value as datasets show it: of numbers twelve digits, of pictures their name."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"[{','.join(map(text_of, value))}]"
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _is_plain(value: Any) -> bool:
    """Whether it can be part of an address: what has a digest, as pictures do, goes by that."""
    if isinstance(value, tuple):
        return all(map(_is_plain, value))
    return value is None or isinstance(value, bool | int | float | str) or hasattr(value, "digest")


def _frozen(value: Any) -> Any:
    return tuple(map(_frozen, value)) if isinstance(value, list | tuple) else value
