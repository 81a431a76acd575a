"""Plugins, such as brains and topologies, found by name among shipped files and other packages' entry points."""

from __future__ import annotations

import functools
import hashlib
import importlib
import importlib.util
import inspect
import itertools
import logging
import math
import types
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_type_hints

from swarmcensus.support.errors import BrainError, InputError, line_of, pydantic_message
from swarmcensus.support.hints import did_you_mean, did_you_mean_file
from swarmcensus.support.options import option
from swarmcensus.support.texts import read_text

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint, EntryPoints

    from pydantic import BaseModel

LOG = logging.getLogger(__name__)
MOST_SOURCE = 125_000  # bytes of a file of code: Python's own tree of it is a thousand times as large
MOST_COMBINED = 10_000  # values of lists in one table
Keys = tuple[tuple[str, Any], ...]  # a plugin's own keys and their values, in the order of its signature


def read_source(kind: str, path: Path) -> str:
    """Read the source of a file of this kind, such as "brain", without running it. Raises InputError."""
    return read_text(path, f"{kind} file {path}", BrainError, most=MOST_SOURCE, code=True)


def digest(source: str) -> str:
    """The hash of a source, as stored with results."""
    return hashlib.sha256(source.encode()).hexdigest()


@dataclass(frozen=True)
class PluginFile:
    """A plugin in a file of a user's: it has the place of a plugin's name, and is run when it is needed."""

    kind: str  # as of `Plugins`
    name: str  # its path, as in the study file
    source: str = field(repr=False)
    path: Path | None = field(compare=False)  # None: it is read, and not run

    def __str__(self) -> str:
        """As in a study file."""
        return self.name

    @property
    def sha256(self) -> str:
        """The hash of its source: results depend on it."""
        return digest(self.source)

    @functools.cached_property
    def module(self) -> types.ModuleType:
        """The module that it makes when it is run; or its outline. Raises InputError if it fails."""
        if self.path is None:
            from swarmcensus.support.signatures import outline

            try:
                return outline(self.source, lambda: not_run(self.kind, self.name))
            except (ValueError, SyntaxError, RecursionError) as error:
                raise self.error(error) from None
        LOG.info("running the %s file %s", self.kind, self.path)
        module = types.ModuleType(self.path.stem)
        module.__file__ = str(self.path)
        try:
            exec(compile(self.source, str(self.path), "exec"), vars(module))
        except Exception as error:
            raise self.error(f"fails when it is loaded: {error_message(error, self.path)}") from error
        return module

    def error(self, what: object) -> BrainError:
        """The error of this file."""
        return BrainError.of(self.path, what, self.kind, self.name, where=f"{self.kind} file {self.path or self.name}")


PluginName = str | PluginFile


def is_unread(name: PluginName) -> bool:
    """Whether this is a file of which only the outline is known."""
    return isinstance(name, PluginFile) and name.path is None


def not_run(kind: str, name: str) -> BrainError:
    """The error of a file that results name, and that is neither given nor found as it was."""
    which = "is a file. Files named in results are run only if they lie below the current folder, unchanged"
    if Path(name).is_file() and Path(name).resolve().is_relative_to(Path.cwd().resolve()):
        which = "has changed since the results were made"
    what = f"the {kind} {name!r} {which}: give it with {option('brain_file')}, as it was"
    return BrainError(what, key="brain_file", value=name)


@functools.cache
def name_what_runs(kind: str, path: Path) -> None:
    """Say on stderr, once, that a file is run because results or a recording name it."""
    LOG.warning("running the %s file %s, because what you opened was made with it", kind, path)


def entry_points(group: str) -> EntryPoints:
    """The entry points of a group; importlib.metadata is imported late because most studies do not need it."""
    from importlib.metadata import entry_points as of_group

    return of_group(group=group)


@dataclass(frozen=True, eq=False)
class Plugins:
    """The plugins of one kind: shipped files in one folder, and entry points of other packages in one group.

    A shipped file `scale_free.py` has the name "scale-free". Another package names its own in its metadata:
    `[project.entry-points."swarmcensus.topologies"]`, `torus = "its_package.torus"`.
    """

    kind: str  # in messages: "topology"
    group: str  # of entry points: "swarmcensus.topologies"
    package: str  # of the shipped files: "swarmcensus.worlds.topologies"
    clashes: dict[str, str] = field(default_factory=dict, repr=False)  # names that two other packages use
    imported_hashes: dict[str, str] = field(default_factory=dict, repr=False)  # of other packages' files, when imported

    @functools.cached_property
    def shipped(self) -> tuple[str, ...]:
        """The names of the plugins that come with swarmcensus."""
        spec = importlib.util.find_spec(self.package)
        assert spec is not None
        folders = map(Path, spec.submodule_search_locations or ())
        stems = (path.stem for folder in folders for path in folder.glob("*.py") if path.stem[0] != "_")
        return tuple(sorted(stem.replace("_", "-") for stem in stems))

    @functools.cached_property
    def outside(self) -> Mapping[str, EntryPoint]:
        """The plugins of other installed packages by name, without names that are shipped."""
        entries: dict[str, EntryPoint] = {}
        for entry in entry_points(group=self.group):
            if entry.name in self.shipped:
                continue
            first = entries.setdefault(entry.name, entry)
            if first.value != entry.value:
                self.clashes[entry.name] = f"{first.value}, {entry.value}"
        return entries

    def entry(self, name: str) -> EntryPoint:
        """The entry point of another package's plugin. Raises InputError if two packages use the name."""
        entry = self.outside[name]
        if name in self.clashes:
            two = f"two packages have a {self.kind} named {name!r}: {self.clashes[name]}"
            raise BrainError(two, key=self.kind, value=name)
        return entry

    @property
    def names(self) -> list[str]:
        """The names of all plugins, shipped ones first."""
        return [*self.shipped, *sorted(self.outside)]

    def __contains__(self, name: object) -> bool:
        """Whether there is a plugin of this name; other packages are searched only if it is not shipped."""
        return name in self.shipped or name in self.outside

    def from_file(self, name: str, base: Path | None, known: Mapping[str, Any]) -> PluginFile:
        """The plugin in a file, which is `known` or lies at a path relative to `base`. Raises ValueError."""
        if isinstance(known.get(name), PluginFile):
            return known[name]  # type: ignore[no-any-return]
        if base is None:
            raise ValueError(f"the source of this {self.kind} is not stored here, and no file is opened here")
        path = base / name
        if not path.is_file():
            raise BrainError.named(self.kind, name, f"{did_you_mean_file(path)}there is no file {path}")
        return PluginFile(self.kind, name, read_source(self.kind, path), path)

    def module(self, name: PluginName) -> Any:
        """The plugin itself, imported. Raises InputError if the import fails."""
        return name.module if isinstance(name, PluginFile) else self._import(name)

    @functools.cache  # noqa: B019 (there are few instances, and they live as long as the program)
    def _import(self, name: str) -> Any:
        if name in self.shipped:
            return importlib.import_module(f"{self.package}.{name.replace('-', '_')}")
        entry = self.entry(name)
        try:
            plugin = entry.load()
        except Exception as error:
            where = f"{self.kind} {name!r}, {entry.value} of {_package(entry)}"
            raise BrainError(f"{where}: {error_message(error)}", key=self.kind, value=name) from error
        self.imported_hashes[name] = _hash(self.path(name))
        return plugin

    def digest(self, name: PluginName) -> str:
        """The hash of another's file, so that results of its versions differ; empty for a shipped plugin.

        Raises InputError if the file has changed since it was imported.
        """
        if isinstance(name, PluginFile):
            return name.sha256
        if name in self.shipped:
            return ""
        current = _hash(self.path(name))
        if self.imported_hashes.get(name, current) != current:
            changed = f"{self.path(name)} was changed since it was imported: restart Python"
            raise BrainError.named(self.kind, name, changed)
        return current

    def provider(self, name: str) -> str:
        """The name of the package that a plugin comes from."""
        return "swarmcensus" if name in self.shipped else _package(self.outside[name])

    def origin(self, name: str) -> dict[str, str]:
        """Where another package's plugin comes from: `package`, `version`, `sha256`."""
        distribution = self.outside[name].dist
        version = distribution.version if distribution is not None else ""
        sha256 = self.imported_hashes.get(name) or _hash(self.path(name))
        return {"package": self.provider(name), "version": version, "sha256": sha256}

    def path(self, name: PluginName) -> Path:
        """The path of a plugin's file, found without running it. Raises InputError if there is none."""
        if isinstance(name, PluginFile):
            return name.path or Path(name.name)
        entry = None if name in self.shipped else self.entry(name)
        try:
            module = entry.module if entry else f"{self.package}.{name.replace('-', '_')}"
            spec = importlib.util.find_spec(module)
        except ImportError:
            spec = None
        except Exception as error:  # raised by the package's __init__, or by a malformed entry point
            where = f"{self.kind} {name!r} of {self.provider(name)}"
            raise BrainError(f"{where}: {error_message(error)}", key=self.kind, value=name) from error
        if spec is None or spec.origin is None or not Path(spec.origin).is_file():
            raise BrainError.named(self.kind, name, f"{self.provider(name)} names {module}: there is no such file")
        return Path(spec.origin)

    def error(self, name: PluginName, what: object) -> BrainError:
        """The error of a plugin that is not shipped."""
        if isinstance(name, PluginFile):
            return name.error(what)
        return BrainError(f"{self.kind} {name!r}, {self.outside[name].value}: {what}", key=self.kind, value=name)


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _package(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist is not None else "an installed package"


@functools.cache
def keys_of(function: Callable[..., Any]) -> type[BaseModel]:
    """A pydantic model of a function's keyword-only parameters and their annotations. Raises InputError."""
    from pydantic import ConfigDict, create_model

    strict = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)
    config = strict | ConfigDict(arbitrary_types_allowed=True, protected_namespaces=())
    try:
        hints = get_type_hints(function, include_extras=True)
        parameters = inspect.signature(function).parameters.values()
        keys = {p.name: ... if p.default is p.empty else p.default for p in parameters if p.kind is p.KEYWORD_ONLY}
        fields: dict[str, Any] = {name: (hints.get(name, Any), default) for name, default in keys.items()}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # about keys named like a method of pydantic's
            return create_model("Keys", __config__=config, **fields)
    except Exception as error:
        name = f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', function)}"
        raise InputError(f"the keys of {name} cannot be read: {error_message(error)}") from error


def read_keys(what: str, function: Callable[..., Any], given: Mapping[str, Any], context: Any = None) -> Keys:
    """Check values for a function's keyword-only arguments, and add its defaults. Raises InputError."""
    from pydantic import ValidationError

    model = keys_of(function)
    try:
        checked = model.model_validate(dict(given), context=context)
    except ValidationError as error:
        # probable typing errors come first
        first = min(error.errors(), key=lambda e: {"extra_forbidden": 0, "literal_error": 1}.get(e["type"], 2))
        key, known = str(first["loc"][0]), ", ".join(model.model_fields)
        if first["type"] == "extra_forbidden":
            has = f"{did_you_mean(key, model.model_fields)}it has {known}" if known else "it has none"
            raise InputError(f"{what} has no key {key}: {has}", key=key) from None
        if first["type"] == "missing":
            raise InputError(f"{what} needs the key {key}", key=key) from None
        unit = model.model_fields[str(first["loc"][0])].description
        found = f"{what}: {key} = {first['input']!r}: {pydantic_message(first)}{f' ({unit})' if unit else ''}"
        raise InputError(found, key=key, value=first["input"]) from None
    keys = tuple((name, _frozen(getattr(checked, name))) for name in model.model_fields)
    for name, value in keys:
        if not _is_plain(value):
            raise InputError(f"{what}: {name} should be a number, a text, true or false, or a list of them", key=name)
    return keys


def combinations(given: Mapping[str, Any], is_one: Callable[[str, Any], bool]) -> tuple[list[Keys], list[str]]:
    """All combinations of values of keys, and the names of those with a list of them; `is_one` says which are values.

    Raises ValueError for an empty list, and for too many combinations.
    """
    lists = {n: list(v) for n, v in given.items() if isinstance(v, list | tuple) and not is_one(n, v)}
    for name in (name for name, values in lists.items() if not values):
        raise ValueError(f"{name} = []: should be a list of at least one")
    if (many := math.prod(map(len, lists.values()))) > MOST_COMBINED:
        raise ValueError(f"its lists have {many:,} combinations; {MOST_COMBINED:,} is the most")
    values = ([(name, one) for one in lists.get(name, [value])] for name, value in given.items())
    return list(itertools.product(*values)), [*lists]


def takes(function: Callable[..., Any], key: str, value: Any, context: Any = None) -> bool:
    """Whether a value is one of a function's keyword-only argument."""
    from pydantic import ValidationError

    try:
        keys_of(function).model_validate({key: value}, context=context)
    except ValidationError as error:
        return all(one["loc"][:1] != (key,) for one in error.errors())
    return True


def defaults_of(function: Callable[..., Any]) -> dict[str, Any]:
    """The default values of a function's optional keys."""
    fields = keys_of(function).model_fields.items()
    return {name: _frozen(field.default) for name, field in fields if not field.is_required()}


def error_message(error: Exception, path: Path | None = None) -> str:
    """An exception of a plugin in one line: the text of a ValueError, otherwise the type, the text and the line.

    The line is given only if `path`, the plugin's file, is.
    """
    if isinstance(error, SyntaxError):
        return f"not Python: {error.msg}, at {error.filename}, line {error.lineno}: {(error.text or '').strip()}"
    if isinstance(error, ValueError) and not isinstance(error, UnicodeError):
        return " ".join(str(error).split())
    return f"{type(error).__name__}: {' '.join(str(error).split())}{line_of(error, path) if path else ''}"


def text_of(value: Any) -> str:
    """A key's value as datasets show it: numbers with twelve digits, pictures by their name."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"[{','.join(map(text_of, value))}]"
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _is_plain(value: Any) -> bool:
    """Whether a value can be part of a random address; pictures and the like are represented by their digest."""
    if isinstance(value, tuple):
        return all(map(_is_plain, value))
    return value is None or isinstance(value, bool | int | float | str) or hasattr(value, "digest")


def _frozen(value: Any) -> Any:
    return tuple(map(_frozen, value)) if isinstance(value, list | tuple) else value
