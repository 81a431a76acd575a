"""The distribution of an accuracy over a swarm: one number for all robots, or a named spread with its numbers."""

import contextlib
import functools
import inspect
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, ValidationInfo

from swarmcensus.engine import compile_world
from swarmcensus.support.errors import BrainError, InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.plugins import PluginName, Plugins, combinations, error_message, is_unread
from swarmcensus.support.toml_types import OrElse

PLUGINS = Plugins("spread", "swarmcensus.spreads", "swarmcensus.worlds.spreads")
FILE = r"[^()\s][^()]*\.py"
FORM = re.compile(rf"\s*([A-Za-z][\w.-]*|{FILE})\s*\(([^()]*)\)\s*")
ENDS = np.array([2.0**-54, 0.5, 1.0 - 2.0**-53])  # where quantiles are tried: the least, a middle and the largest u

MIDDLES = (np.arange(1000) + 0.5) / 1000.0  # shares of a swarm: their quantiles give a mean


@dataclass(frozen=True)
class Distribution:
    """A distribution of accuracies or errors: its kind, empty for a single number, and its numbers."""

    kind: PluginName
    numbers: tuple[float, ...]

    @functools.cached_property
    def _text(self) -> str:
        numbers = ",".join(map(repr, self.numbers))
        return f"{_letter(self.kind)}({numbers})" if self.kind else numbers

    def __str__(self) -> str:
        """The canonical text, as in the dataset: 0.675, U(0.525,0.975), N(0.75,0.1)."""
        return self._text

    @property
    def form(self) -> object:
        """As in a study file."""
        return self.numbers[0] if self.is_number else str(self)

    @property
    def is_number(self) -> bool:
        """Whether all robots have the same value."""
        return not self.kind

    @functools.cached_property
    def edition(self) -> str:
        """A hash of its file, if it is not shipped: results depend on that too."""
        return PLUGINS.digest(self.kind) if self.kind else ""

    def draw(self, key: np.ndarray, first_trial: int, trials: int, robots: int) -> np.ndarray:
        """Draw accuracies (trial, robot), or (trial, 1) if all robots have the same."""
        if self.is_number:
            return np.full((trials, 1), self.numbers[0])
        out = np.empty((trials, robots))
        module = PLUGINS.module(self.kind)
        if hasattr(module, "draw") and not self.edition:
            module.draw(key, first_trial, out, *self.numbers)
            return out
        compile_world().draw_uniform(key, first_trial, 0.0, 1.0, out)
        return self._quantile(out, 0.0)

    def errors(self, key: Callable[[int], np.ndarray], first_trial: int, trials: int, robots: int) -> np.ndarray:
        """Draw errors (trial, robot) or (trial, 1), at two addresses: `key(0)` and `key(1)`."""
        if self.is_number:
            return np.full((trials, 1), self.numbers[0])
        uniform = np.empty((2, trials, robots))
        error = None if self.edition else getattr(PLUGINS.module(self.kind), "error", None)
        for part in (0,) if error is None else (0, 1):
            compile_world().draw_uniform(key(part), first_trial, 0.0, 1.0, uniform[part])
        return self._quantile(uniform[0], -1.0) if error is None else error(uniform, *self.numbers)

    def check(self, least: float) -> None:
        """Raise ValueError if its numbers make no distribution, or if values are below `least` or above 1."""
        if is_unread(self.kind):
            return
        module = PLUGINS.module(self.kind)
        if hasattr(module, "check"):
            self._call(lambda: module.check(*self.numbers), _head(self.kind))
        self._check_bounds(self._reached(least), least)

    def ends(self) -> tuple[float, float]:
        """The least and the greatest value; of a normal distribution, which is only cut to [0, 1], twice the mean.

        Both are NaN if it is a file that is not run.
        """
        if is_unread(self.kind):
            return math.nan, math.nan
        values = self._reached(0.0) if self.kind else np.array(self.numbers)
        return float(values.min()), float(values.max())

    def _reached(self, least: float) -> np.ndarray:
        """The least value, a middle one and the greatest; of a normal distribution the mean alone."""
        module = PLUGINS.module(self.kind)
        if hasattr(module, "centre") and not self.edition:
            return np.array([module.centre(*self.numbers)])
        return self._quantile(ENDS if self.edition else np.array([0.0, 0.5, 1.0]), least)

    def moments(self) -> tuple[float, float]:
        """The mean and the standard deviation of accuracies. Raises InputError."""
        if self.is_number:
            return self.numbers[0], 0.0
        module = PLUGINS.module(self.kind)
        if hasattr(module, "moments") and not self.edition:
            return module.moments(*self.numbers)  # type: ignore[no-any-return]
        values = self._quantile(MIDDLES, 0.0)
        return float(values.mean()), float(values.std())

    def _quantile(self, uniform: np.ndarray, least: float) -> np.ndarray:
        quantile = PLUGINS.module(self.kind).quantile
        if not self.edition:
            return quantile(uniform, *self.numbers)  # type: ignore[no-any-return]
        above = np.maximum(uniform, ENDS[0])
        values: np.ndarray = self._call(lambda: np.array(quantile(above, *self.numbers), np.float64))
        if values.shape != uniform.shape:
            raise self._error(f"for numbers {uniform.shape} it should give as many, not {values.shape}")
        self._check_bounds(values, least)
        if uniform is ENDS and (values != np.array(quantile(above, *self.numbers))).any():
            raise self._error("its quantiles should be the same at each call: randomness comes from u alone")
        return values

    def _check_bounds(self, values: np.ndarray, least: float) -> None:
        outside = values[~((values >= least) & (values <= 1.0))]
        if outside.size:
            raise InputError(f"{bounds(least)}, and {self} gives {outside[0]:g}", key="spread", value=self)

    def _error(self, what: str, head: str = "") -> BrainError:
        return BrainError(f"{head or self}: {what}", key="spread", value=self)

    def _call(self, call: Callable[[], Any], head: str = "") -> Any:
        try:
            return call()
        except Exception as error:
            raise self._error(error_message(error, PLUGINS.path(self.kind)), head) from error


def bounds(least: float) -> str:
    """The message for a value out of bounds."""
    return "an error lies in [-1, 1]" if least else "a sensor accuracy lies in [0, 1]"


def forms() -> str:
    """The forms that an accuracy may have, for messages."""
    # other packages' spreads are not imported for a message
    heads = [*map(_head, PLUGINS.shipped), *(f"{name}(...)" for name in PLUGINS.outside)]
    distributions = ", ".join(f'"{head}"' for head in heads)
    return f'a sensor accuracy is a number in [0, 1], {distributions}, "FILE.py(...)" or {{black = ..., white = ...}}'


def parse_distribution(
    value: object, accuracy: bool = True, base: Path | None = None, known: Mapping[str, Any] = {}
) -> Distribution:
    """Read a number or such as "U(lo, hi)", within [0, 1] where it is an accuracy. Raises ValueError.

    Files of spreads are looked for in `known` first, then in the folder `base`; None: no file is opened.
    """
    if isinstance(value, Distribution):
        return value
    least = 0.0 if accuracy else -1.0
    text = f"{value}()" if isinstance(value, str) and value.strip().lower().endswith(".py") else value
    match = FORM.fullmatch(text) if isinstance(text, str) else None
    if match is not None:
        distribution = _parse_named(match[1], match[2], base, known)
        distribution.check(least)
        return distribution
    try:
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise ValueError
        number = float(value if isinstance(value, str) else min(max(value, -2), 2))  # a large int would not fit a float
    except ValueError:
        raise ValueError(forms()) from None
    if not least <= number <= 1.0:
        raise ValueError(bounds(least))
    return Distribution("", (number,))


def spanned_spreads(value: object, base: Path | None, known: Mapping[str, Any]) -> list[object]:
    """The values that a table with lists spans; {spread = "N", mean = 0.7, sd = 0.1} stands for N(0.7, 0.1).

    Raises ValueError.
    """
    if not isinstance(value, Mapping):
        return [value]
    tables = [dict(one) for one in combinations(value, lambda *_: False)[0]]
    return [_spread_text(one, base, known) if "spread" in one else one for one in tables]


def spanned_fills(value: object, base: Path | None, known: Mapping[str, Any]) -> list[object]:
    """The values of a fill ratio that a table of a spread spans; others are checked by their types."""
    return spanned_spreads(value, base, known) if isinstance(value, Mapping) and "spread" in value else [value]


def parse_fill(value: object) -> Distribution:
    """Read the spread of a fill ratio. Raises ValueError with what would be right."""
    with contextlib.suppress(ValueError):
        found = parse_distribution(value)
        if found.kind in PLUGINS.shipped:
            return found
    raise ValueError('a fill ratio is a number in [0, 1], or a shipped spread within it, such as "U(0.3, 0.7)"')


def _spread_text(table: dict[str, Any], base: Path | None, known: Mapping[str, Any]) -> str:
    kind = _kind(name := str(table.pop("spread")), base, known)
    try:
        given = inspect.Signature(_parameters(kind)).bind(**table).args
    except TypeError as error:
        raise ValueError(f"{_head(kind)}: {error}") from None
    return f"{name}({','.join(map(str, given))})"


def _in_context(accuracy: bool) -> BeforeValidator:
    def parse(value: object, info: ValidationInfo) -> Distribution:
        context = info.context or {}
        return parse_distribution(value, accuracy, context.get("base"), context.get("known", {}))

    return BeforeValidator(parse)


AccuracyDistribution = Annotated[Distribution, _in_context(accuracy=True)]
ErrorDistribution = Annotated[Distribution, _in_context(accuracy=False)]


def _parse_named(name: str, inside: str, base: Path | None, known: Mapping[str, Any]) -> Distribution:
    kind = _kind(name, base, known)
    try:
        numbers = tuple(map(float, inside.split(","))) if inside.strip() else ()
    except ValueError:
        numbers = (math.nan,)
    if not all(map(math.isfinite, numbers)):
        raise ValueError(forms())
    wanted = _parameters(kind)
    least = sum(one.default is one.empty for one in wanted)
    if len(numbers) < least or (len(numbers) > len(wanted) and not _takes_any(kind)):
        raise ValueError(f"{_head(kind)} needs {counted(least, 'number')}, not {len(numbers)}")
    return Distribution(kind, numbers)


def _kind(name: str, base: Path | None, known: Mapping[str, Any]) -> PluginName:
    """The spread of this name, letter or file. Raises ValueError."""
    if name.lower().endswith(".py"):
        return PLUGINS.from_file(name, base, known)
    letters = {_letter(kind): kind for kind in PLUGINS.shipped}
    if letters.get(name, name) not in PLUGINS:
        raise ValueError(f"{did_you_mean(name, [*letters, *PLUGINS.names])}{forms()}")
    return letters.get(name, name)


OR_SPREAD = OrElse(Annotated[Distribution, BeforeValidator(parse_fill)], str, Distribution)


@functools.cache
def _letter(kind: PluginName) -> str:
    return PLUGINS.module(kind).LETTER if kind in PLUGINS.shipped else str(kind)


def _head(kind: PluginName) -> str:
    more = ", ..." * _takes_any(kind)
    return f"{_letter(kind)}({', '.join(one.name for one in _parameters(kind))}{more})"


def _takes_any(kind: PluginName) -> bool:
    """Whether a spread takes any number of numbers."""
    return any(one.kind is one.VAR_POSITIONAL for one in _parameters(kind))


@functools.cache
def _parameters(kind: PluginName) -> list[inspect.Parameter]:
    module = PLUGINS.module(kind)
    if hasattr(module, "quantile"):
        return list(inspect.signature(module.quantile).parameters.values())[1:]
    if kind not in PLUGINS.shipped:
        raise PLUGINS.error(kind, "it has no function quantile")
    return list(inspect.signature(module.centre).parameters.values())
