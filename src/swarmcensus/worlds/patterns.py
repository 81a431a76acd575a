"""Floors: a kind of floor with its keys, as a study gives it (see `worlds.floors`)."""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from swarmcensus.support.errors import BrainError, InputError
from swarmcensus.support.hints import did_you_mean_any
from swarmcensus.support.plugins import (
    Keys,
    PluginFile,
    PluginName,
    Plugins,
    combinations,
    defaults_of,
    error_message,
    is_unread,
    keys_of,
    read_keys,
    takes,
    text_of,
)
from swarmcensus.support.toml_types import label_of
from swarmcensus.worlds.arena import MOST_COUNTED, Arena, Paint, Score, Tiles
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.naming import Titled
from swarmcensus.worlds.pictures import Picture

PLUGINS = Plugins("floor", "swarmcensus.floors", "swarmcensus.worlds.floors")
TAKEN = {"file", "name", "label"}  # keys of all floors


@dataclass(frozen=True)
class Floor(Titled):
    """A kind of floor, with its own keys."""

    kind: PluginName = "tiles"
    keys: Keys = ()
    label: str = field(default="", compare=False)  # in place of the name, in datasets
    spanned: tuple[str, ...] = field(default=(), compare=False)  # those of `keys` that span the grid

    @functools.cached_property
    def name(self) -> str:  # type: ignore[override]
        """As "tiles", "clusters(0.2)", "image(leaves)"."""
        return self.name_without(())

    def name_without(self, keys: tuple[str, ...]) -> str:
        """Its name if some of its keys are not shown; last keys with default values are left out."""
        usual = defaults_of(_function(self.kind))
        shown = [one for one in self.keys if one[0] not in keys]
        while shown and shown[-1][0] in usual and usual[shown[-1][0]] == shown[-1][1]:
            shown.pop()
        return f"{self.kind}({','.join(text_of(value) for _, value in shown)})" if shown else str(self.kind)

    @functools.cached_property
    def content(self) -> object:
        """What the random numbers of this floor depend on: its kind and keys. Their order is fixed by older results."""
        keys = {key: value.digest if isinstance(value, Picture) else value for key, value in self.keys}
        first = [str(self.kind), keys.pop("length", 0.0), keys.pop("image", None), keys.pop("mode", "")]
        return [*first, keys] if keys else first

    @functools.cached_property
    def edition(self) -> str:
        """A hash of its file, if it is not shipped: results depend on that too."""
        return PLUGINS.digest(self.kind)

    @property
    def form(self) -> object:
        """As in a study file."""
        keys = {key: value.source if isinstance(value, Picture) else value for key, value in self.keys}
        own: dict[str, Any] = keys | ({"label": self.label} if self.label else {})
        is_file = isinstance(self.kind, PluginFile)
        if is_file or not keys:
            return {"file" if is_file else "name": str(self.kind), **own} if own else str(self.kind)
        return {str(self.kind): own.pop(self.keys[0][0]), **own}

    @property
    def pictures(self) -> list[Picture]:
        """Its images."""
        return [value for _, value in self.keys if isinstance(value, Picture)]

    def check(self, arena: Arena) -> None:
        """Raise ValueError if the floor does not fit the arena."""
        refuse = self._own_function("check")
        if refuse is not None:
            self._call(lambda: refuse(arena))
        if self.edition and not is_unread(self.kind):  # tried once, so that errors are found before anything runs
            chance = Chance(np.zeros(2, np.uint64), 0)
            colours: Any = self.paint(arena, chance, 0.5) or self.score(arena, chance)
            half = arena.across // 2
            tiles = np.array([[[-half, -half], [0, 0], [half - 1, 1 - half]]], np.int32)
            again: Any = self.paint(arena, chance, 0.5) or self.score(arena, chance)
            if (colours(tiles) != again(tiles[:, ::-1])[:, ::-1]).any():
                raise self._error("a tile should have the same value at each call, in any order")

    def most_counted(self, arena: Arena) -> int:
        """The largest number of tiles among which black ones are counted."""
        most = self._own_function("most_counted")
        return MOST_COUNTED if most is None else int(self._call(lambda: most(arena)))

    def paint(self, arena: Arena, chance: Chance, share: float) -> Paint | None:
        """A function that tells which tiles are black, if the kind has one. Raises InputError."""
        make = self._own_function("paint")
        return None if make is None else self._with_checks(self._call(lambda: make(arena, chance, share)), "b")

    def level(self, arena: Arena, chance: Chance) -> Score | None:
        """A function that gives each tile the share above which it is black, if the kind has one. Raises InputError."""
        make = self._own_function("level")
        return None if make is None else self._with_checks(self._call(lambda: make(arena, chance)), "iuf")

    @property
    def can_change(self) -> bool:
        """Whether its fill ratio may change: a kind with `paint` needs `level` too."""
        return self._own_function("level") is not None or self._own_function("paint") is None

    def score(self, arena: Arena, chance: Chance) -> Score:
        """A function that gives tiles their scores. Raises InputError."""
        make = self._own_function("score")
        assert make is not None
        return self._with_checks(self._call(lambda: make(arena, chance)), "iuf")

    def _own_function(self, name: str) -> Callable[..., Any] | None:
        found = getattr(PLUGINS.module(self.kind), name, None)
        return found and functools.partial(found, **dict(self.keys))

    def _call(self, call: Callable[[], Any]) -> Any:
        if not self.edition:
            return call()
        try:
            return call()
        except Exception as error:
            raise self._error(error_message(error, PLUGINS.path(self.kind))) from error

    def _error(self, message: object) -> InputError:
        return BrainError(f"floor {self}: {message}", key="floor", value=self)

    def _with_checks(self, function: Callable[[Tiles], Any], kinds: str) -> Callable[[Tiles], Any]:
        """`function` itself, or if it is not shipped, one that checks what it returns."""
        if not self.edition:
            return function

        def checked(tiles: Tiles) -> np.ndarray:
            values = np.asarray(self._call(lambda: function(tiles)))
            if values.shape != tiles.shape[:2] or values.dtype.kind not in kinds or not np.isfinite(values).all():
                what = "a truth value" if kinds == "b" else "a finite number"
                raise self._error(f"for tiles {tiles.shape} it should give {what} each, {tiles.shape[:2]}")
            return values

        return checked


def _function(kind: PluginName) -> Callable[..., Any]:
    module = PLUGINS.module(kind)
    found = next((getattr(module, name) for name in ("paint", "score", "level") if hasattr(module, name)), None)
    if not callable(found):
        raise PLUGINS.error(kind, "it has no function score")
    return cast(Callable[..., Any], found)


def parse_floors(value: object, base: Path | None, known: Mapping[str, Any]) -> list[Floor]:
    """Read any form of floor that a study may contain; a table with lists spans several.

    Raises ValueError or InputError with what would be right.

    Image files are looked for in `known` (path to grey levels) first, and so are files of floors, then in the folder
    `base`; None: no file is opened.
    """
    if isinstance(value, Floor):
        return [value]
    table = dict(value) if isinstance(value, Mapping) else {}
    label = label_of(table)
    table.pop("label", None)
    bare = table["name"] if table.keys() == {"name"} else table or value
    return [replace(floor, label=label) for floor in _of_kind(bare, base, known)]


def _of_kind(value: object, base: Path | None, known: Mapping[str, Any]) -> list[Floor]:
    """Floors without a label: a kind's name, or a table with its keys."""
    table = value if isinstance(value, Mapping) else {}
    context = {"base": base, "images": known}
    file = str(table.get("file", value if isinstance(value, str | Path) else ""))
    if file.lower().endswith(".py"):
        plugin = PLUGINS.from_file(file, base, known)
        given = {key: one for key, one in table.items() if key != "file"}
        for key in keys_of(_function(plugin)).model_fields.keys() & TAKEN:
            raise plugin.error(f"it has a key {key}, which means something else in study files")
        return _spanned(plugin, given, context)
    names = [value] if isinstance(value, str) else list(table)
    kind = next((name for name in names if name in PLUGINS), None)
    if kind is None:
        outside = [f'"{name}"' for name in sorted(PLUGINS.outside)]  # not imported for a message
        forms = f"one of {', '.join([*map(_form, PLUGINS.shipped), *outside])}, or the path of a .py file"
        raise ValueError(f"{did_you_mean_any(names, PLUGINS.names)}a floor is {forms}")
    function, given = _function(kind), {key: one for key, one in table.items() if key != kind}
    first = next(iter(keys_of(function).model_fields), None)
    if table and (first is None or first in given):
        raise ValueError(f"floor {kind}: " + (f"{kind} is its {first}" if first else f'it has no keys: write "{kind}"'))
    if table:
        given[str(first)] = table[kind]
    try:
        return _spanned(kind, given, context)
    except ValueError as error:
        raise error if table else ValueError(f"{error}: write {_form(kind)}") from None


def _spanned(kind: PluginName, given: Mapping[str, Any], context: Mapping[str, Any]) -> list[Floor]:
    function = _function(kind)
    every, lists = combinations(given, lambda key, one: takes(function, key, one, context))
    keys = [read_keys(f"floor {kind}", function, dict(one), context) for one in every]
    return [Floor(kind, one, spanned=tuple(lists)) for one in keys]


def _form(kind: str) -> str:
    """How a kind is written, with example values of its keys."""
    examples: list[str] = []
    for key, known in keys_of(_function(kind)).model_fields.items():
        value = (known.examples or [None])[0] if known.is_required() else known.default
        text = "..." if value is None else f'"{value}"' if isinstance(value, str) else text_of(value)
        examples.append(f"{key if examples else kind} = {text}")
    return f"{{{', '.join(examples)}}}" if examples else f'"{kind}"'
