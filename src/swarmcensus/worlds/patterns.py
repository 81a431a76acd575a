"""What a floor looks like, as a study says it: a kind of floor with its keys (see `worlds.floors`)."""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.hints import did_you_mean_any
from swarmcensus.basics.plugins import Keys, Plugins, defaults_of, error_message, keys_of, read_keys, text_of
from swarmcensus.worlds.arena import MOST_COUNTED, Arena, Paint, Score, Tiles
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.pictures import Picture

if TYPE_CHECKING:
    from pydantic import BaseModel
    from pydantic.fields import FieldInfo

PLUGINS = Plugins("floor", "swarmcensus.floors", "swarmcensus.worlds.floors")


@dataclass(frozen=True)
class Floor:
    """A kind of floor, with its own keys."""

    kind: str = "tiles"
    keys: Keys = ()

    @functools.cached_property
    def _text(self) -> str:
        usual = defaults_of(_function(self.kind))
        shown = list(self.keys)
        while shown and shown[-1][0] in usual and usual[shown[-1][0]] == shown[-1][1]:
            shown.pop()
        return f"{self.kind}({','.join(text_of(value) for _, value in shown)})" if shown else self.kind

    def __str__(self) -> str:
        """As in the dataset: "tiles", "clusters(0.2)", "image(leaves)"; without the last keys that are as usual."""
        return self._text

    @functools.cached_property
    def content(self) -> object:
        """What the random numbers of this floor depend on: its kind, and keys in the order in which they came to be."""
        keys = {key: value.digest if isinstance(value, Picture) else value for key, value in self.keys}
        first = [self.kind, keys.pop("length", 0.0), keys.pop("image", None), keys.pop("mode", "")]
        return [*first, keys] if keys else first

    @functools.cached_property
    def edition(self) -> str:
        """What else its results depend on: a hash of another package's file."""
        return PLUGINS.digest(self.kind)

    @property
    def form(self) -> object:
        """As in a study file."""
        keys = {key: value.source if isinstance(value, Picture) else value for key, value in self.keys}
        return {self.kind: keys.pop(self.keys[0][0]), **keys} if self.keys else self.kind

    @property
    def pictures(self) -> list[Picture]:
        """The images that it is made from."""
        return [value for _, value in self.keys if isinstance(value, Picture)]

    def check(self, arena: Arena) -> None:
        """Raise ValueError where the arena cannot show the floor."""
        refuse = self._given("check")
        if refuse is not None:
            self._asked(lambda: refuse(arena))
        if self.edition:  # tried once, so that what is wrong is told before anything runs
            chance = Chance(np.zeros(2, np.uint64), 0)
            colours: Any = self.paint(arena, chance, 0.5) or self.score(arena, chance)
            half = arena.across // 2
            some = np.array([[[-half, -half], [0, 0], [half - 1, 1 - half]]], np.int32)
            again: Any = self.paint(arena, chance, 0.5) or self.score(arena, chance)
            if (colours(some) != again(some[:, ::-1])[:, ::-1]).any():
                raise self._wrong("what it says of a tile should not depend on when it is asked")

    def most_counted(self, arena: Arena) -> int:
        """Of how many tiles at the most the black ones are counted."""
        most = self._given("most_counted")
        return MOST_COUNTED if most is None else int(self._asked(lambda: most(arena)))

    def paint(self, arena: Arena, chance: Chance, share: float) -> Paint | None:
        """What tells the tiles that are black, where the kind says it itself. Raises InputError."""
        make = self._given("paint")
        return None if make is None else self._sure(self._asked(lambda: make(arena, chance, share)), "b")

    def level(self, arena: Arena, chance: Chance) -> Score | None:
        """What gives tiles the shares above which they are black, where the kind does. Raises InputError."""
        make = self._given("level")
        return None if make is None else self._sure(self._asked(lambda: make(arena, chance)), "iuf")

    @property
    def can_change(self) -> bool:
        """Whether its fill ratio may change: a kind that paints its tiles itself must give their levels too."""
        return self._given("level") is not None or self._given("paint") is None

    def score(self, arena: Arena, chance: Chance) -> Score:
        """What gives tiles their scores. Raises InputError."""
        make = self._given("score")
        assert make is not None
        return self._sure(self._asked(lambda: make(arena, chance)), "iuf")

    def _given(self, name: str) -> Callable[..., Any] | None:
        found = getattr(PLUGINS.module(self.kind), name, None)
        return found and functools.partial(found, **dict(self.keys))

    def _asked(self, ask: Callable[[], Any]) -> Any:
        if not self.edition:
            return ask()
        try:
            return ask()
        except Exception as error:
            raise self._wrong(error_message(error, PLUGINS.path(self.kind))) from error

    def _wrong(self, said: object) -> InputError:
        return InputError(f"floor {self}: {said}")

    def _sure(self, function: Callable[[Tiles], Any], kinds: str) -> Callable[[Tiles], Any]:
        """The same, held to what it should give, where it is another package's."""
        if not self.edition:
            return function

        def sure(tiles: Tiles) -> np.ndarray:
            found = np.asarray(self._asked(lambda: function(tiles)))
            if found.shape != tiles.shape[:2] or found.dtype.kind not in kinds or not np.isfinite(found).all():
                what = "a truth value" if kinds == "b" else "a finite number"
                raise self._wrong(f"of each of the tiles {tiles.shape} it should give {what}, {tiles.shape[:2]}")
            return found

        return sure


def _function(kind: str) -> Callable[..., Any]:
    module = PLUGINS.module(kind)
    found = getattr(module, "paint", None) or getattr(module, "score", None)
    if not callable(found):
        raise InputError(f"floor {kind!r}, {PLUGINS.outside[kind].value}: it has no function score")
    return cast(Callable[..., Any], found)


def parse_floor(value: object, base: Path | None, known: Mapping[str, np.ndarray]) -> Floor:
    """Read any form of floor that a study may hold. Raises ValueError or InputError with what would be right.

    Image files are looked for in `known` (path to grey levels) first, then below `base`; without it none is opened.
    """
    if isinstance(value, Floor):
        return value
    table = value if isinstance(value, Mapping) else {}
    names = [value] if isinstance(value, str) else list(table)
    kind = next((name for name in names if name in PLUGINS), None)
    if kind is None:
        raise ValueError(f"{did_you_mean_any(names, PLUGINS.names)}a floor is {_forms()}")
    function, given = _function(kind), {key: one for key, one in table.items() if key != kind}
    first = next(iter(keys_of(function).model_fields), None)
    if table and (first is None or first in given):
        raise ValueError(f"floor {kind}: " + (f"{kind} is its {first}" if first else f'it has no keys: write "{kind}"'))
    if table:
        given[str(first)] = table[kind]
    try:
        return Floor(kind, read_keys(f"floor {kind}", function, given, {"base": base, "images": known}))
    except ValueError as error:
        raise error if table else ValueError(f"{error}: write {_form(kind)}") from None


def keys(kind: str) -> "type[BaseModel]":
    """What the keys of a kind may be; the first goes by the kind's name."""
    return keys_of(_function(kind))


def _form(kind: str) -> str:
    """How a kind is written, with values such as its keys may have."""
    fields = keys_of(_function(kind)).model_fields
    first = next(iter(fields), None)
    shown = (f"{kind if key == first else key} = {_example(field)}" for key, field in fields.items())
    return f"{{{', '.join(shown)}}}" if fields else f'"{kind}"'


def _example(field: "FieldInfo") -> str:
    value = field.default if not field.is_required() else field.examples[0] if field.examples else None
    return "..." if value is None else f'"{value}"' if isinstance(value, str) else text_of(value)


def _forms() -> str:
    outside = (f'"{kind}"' for kind in PLUGINS.names if kind not in PLUGINS.shipped)  # not imported for a message
    return f"one of {', '.join([*map(_form, PLUGINS.shipped), *outside])}"
