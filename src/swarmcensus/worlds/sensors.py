"""Sensor accuracies: how likely a reading is right, and what robots believe about it.

A robot's sensor reads black as black with probability b and white as white with probability w (paper, Eq. 1). In a
homogeneous swarm all robots have one accuracy, b = w; in a heterogeneous one each robot's accuracy is drawn.
"""

import contextlib
import functools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field

from swarmcensus.engine import address
from swarmcensus.support.toml_types import Number, ValueTable, read, says
from swarmcensus.worlds.distributions import (
    AccuracyDistribution,
    Distribution,
    ErrorDistribution,
    parse_distribution,
    spanned_spreads,
)

KEYS = ("start", "drift", "least", "most")
FORM = "{start = 0.9, drift = -1e-5, least = 0.6}, or with a drift above 0 and most"
PAIR = r"(?:black|white|drift|least|most|error)=\S+"
PRINTED = re.compile(rf"(?:(?!{PAIR})(\S+) )?({PAIR}(?: {PAIR})*)")  # as in the dataset


@dataclass(frozen=True)
class Drift:
    """A drift: an accuracy changes by `slope` from each round (or tick) to the next, until it reaches `bound`."""

    slope: float
    bound: float

    def __str__(self) -> str:
        """As in the dataset, after the start: "drift=-1e-05 least=0.6"."""
        return " ".join(f"{key}={value}" for key, value in self.form.items())

    @property
    def form(self) -> dict[str, float]:
        """As in a study file, next to `start`."""
        return {"drift": self.slope, "least" if self.slope < 0.0 else "most": self.bound}

    @property
    def numbers(self) -> tuple[float, float, float]:
        """The slope, the least and the greatest accuracy."""
        return (self.slope, self.bound, 1.0) if self.slope < 0.0 else (self.slope, 0.0, self.bound)


@dataclass(frozen=True)
class Accuracy:
    """A swarm's sensor accuracies: b, w (None: w = b for each robot), and how both drift."""

    black: Distribution
    white: Distribution | None = None
    drift: Drift | None = None

    def __str__(self) -> str:
        """The canonical text, as in the dataset."""
        text = str(self.black) if self.white is None else f"black={self.black} white={self.white}"
        return text if self.drift is None else f"{text} {self.drift}"

    @property
    def form(self) -> object:
        """As in a study file."""
        if self.drift is not None:
            return {"start": self.black.form, **self.drift.form}
        return self.black.form if self.white is None else {"black": self.black.form, "white": self.white.form}

    def side(self, colour: str) -> float:
        """b or w of a single sensor, by "black" or "white". Raises ValueError for a spread or a drift."""
        side = self.white if colour == "white" and self.white else self.black
        if self.drift is not None or not side.is_number:
            raise ValueError(f"{self} is no accuracy of a single sensor: a number, or {{black = 0.9, white = 0.6}}")
        return side.numbers[0]

    @property
    def start(self) -> Self:
        """The accuracies of round 1, which are drawn, and which robots believe in by default."""
        return self if self.drift is None else replace(self, drift=None)

    def draw(
        self, seed: int, purpose: str, first_trial: int, trials: int, robots: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """b and w of the first round, (trial, robot) or (trial, 1), addressed by seed, purpose and start."""

        def key(colour: str) -> np.ndarray:
            return address(seed, f"{purpose} {colour}", accuracy=str(self.start), robots=robots)

        b = self.black.draw(key("black"), first_trial, trials, robots)
        if self.white is None:
            return b, b
        w = self.white.draw(key("white"), first_trial, trials, robots)
        width = max(b.shape[1], w.shape[1])
        return tuple(np.array(np.broadcast_to(v, (trials, width))) for v in (b, w))  # type: ignore[return-value]

    @property
    def is_blind(self) -> bool:
        """Whether all readings carry no information: b + w = 1 for every robot."""
        white = self.white or self.black
        fixed = self.black.is_number and white.is_number
        return fixed and math.isclose(self.black.numbers[0] + white.numbers[0], 1.0)

    @property
    def moments(self) -> tuple[float, float, float]:
        """The means of b and w over robots, and the larger standard deviation; of round 1. Raises InputError."""
        (black, sd_black), (white, sd_white) = self.black.moments(), (self.white or self.black).moments()
        return black, white, max(sd_black, sd_white)

    @property
    def distributions(self) -> tuple[Distribution, ...]:
        """The distributions that it is drawn from."""
        return (self.black, self.white) if self.white else (self.black,)

    @functools.cached_property
    def edition(self) -> str:
        """Hashes of other packages' files that it uses: results depend on them too."""
        return "".join(distribution.edition for distribution in self.distributions)


@dataclass(frozen=True)
class Misjudgement:
    """Assumed accuracies: the true b and w plus an error, one for each robot, cut to [0, 1]."""

    error: Distribution

    def __str__(self) -> str:
        """The canonical text, as in the dataset."""
        return f"error={self.error}"

    @property
    def form(self) -> object:
        """As in a study file."""
        return {"error": self.error.form}

    @property
    def distributions(self) -> tuple[Distribution, ...]:
        """The distributions that it is drawn from."""
        return (self.error,)

    @property
    def edition(self) -> str:
        """A hash of another package's file that it uses."""
        return self.error.edition

    def draw(
        self, seed: int, first_trial: int, trials: int, robots: int, true: tuple[np.ndarray, np.ndarray]
    ) -> tuple[np.ndarray, ...]:
        """Assumed b and w (trial, robot) or (trial, 1), given the true ones."""

        def key(part: int) -> np.ndarray:
            return address(seed, f"error {part}", error=str(self.error), robots=robots)

        error = self.error.errors(key, first_trial, trials, robots)
        return tuple(np.ascontiguousarray(np.clip(side + error, 0.0, 1.0)) for side in true)


BLIND, PERFECT = 0.5, 1.0  # where a drift ends by default
SLOPE = says("should be a number in [-1, 1] other than 0")


class SidesTable(ValueTable):
    """b and w, where they differ."""

    black: AccuracyDistribution
    white: AccuracyDistribution


class FallingTable(ValueTable):
    """An accuracy that falls by `drift` a round, from `start` to `least`."""

    start: AccuracyDistribution
    drift: Annotated[Number, Field(ge=-1.0, lt=0.0), SLOPE]
    least: Annotated[Number, Field(ge=0.0, lt=1.0), says("should be a number in [0, 1)")] = BLIND


class RisingTable(ValueTable):
    """An accuracy that rises by `drift` a round, from `start` to `most`."""

    start: AccuracyDistribution
    drift: Annotated[Number, Field(gt=0.0, le=1.0), SLOPE]
    most: Annotated[Number, Field(gt=0.0, le=1.0), says("should be a number in (0, 1]")] = PERFECT


class ErrorTable(ValueTable):
    """Assumed accuracies, as the true ones plus an error."""

    error: ErrorDistribution


def parse_accuracies(value: object, base: Path | None, known: Mapping[str, Any]) -> list[Accuracy]:
    """The accuracies of a value in a study, as `parse_accuracy` reads one: a table with lists spans several."""
    return [parse_accuracy(one, base, known) for one in spanned_spreads(value, base, known)]


def parse_beliefs(value: object, base: Path | None, known: Mapping[str, Any]) -> list[Accuracy | Misjudgement]:
    """The assumed accuracies of a value in a study: a table with lists spans several."""
    return [parse_assumed(one, base, known) for one in spanned_spreads(value, base, known)]


def parse_accuracy(value: object, base: Path | None = None, known: Mapping[str, Any] = {}) -> Accuracy:
    """Read any form of accuracy that a study file may contain. Raises ValueError with what would be right.

    `base` and `known` are as for `parse_distribution`.
    """
    context = {"base": base, "known": known}
    if isinstance(value, Accuracy):
        return value
    value = _as_table(value)
    if not isinstance(value, Mapping):
        return Accuracy(parse_distribution(value, True, base, known))
    if "start" in value or "drift" in value:
        return _drifting(value, context)
    if any(isinstance(side, Mapping) for side in value.values()):
        raise ValueError("black and white cannot drift: a drift {start = ..., drift = ...} is of b = w")
    return _of_sides(value, "an accuracy table has the keys black and white, or start and drift", KEYS, context)


def _of_sides(value: Mapping[str, Any], right: str, others: tuple[str, ...], context: Mapping[str, Any]) -> Accuracy:
    sides = read(SidesTable, value, lambda: right, ("black", "white", *others), context)
    return Accuracy(sides.black, sides.white)


def _as_table(value: object) -> object:
    """The table of an accuracy that stands as it is printed, such as "black=0.9 white=0.6"."""
    printed = PRINTED.fullmatch(value) if isinstance(value, str) else None
    if printed is None:
        return value
    table: dict[str, object] = {"start": printed[1]} if printed[1] else {}
    for key, text in (pair.split("=", 1) for pair in printed[2].split()):
        table[key] = text
        with contextlib.suppress(ValueError):  # of a spread
            table[key] = float(text)
    return table


def parse_assumed(value: object, base: Path | None = None, known: Mapping[str, Any] = {}) -> Accuracy | Misjudgement:
    """Read any form of assumed accuracy: an accuracy without drift, or {error = ...}. Raises ValueError.

    `base` and `known` are as for `parse_distribution`.
    """
    context = {"base": base, "known": known}
    if isinstance(value, Misjudgement):
        return value
    value = _as_table(value)
    if not isinstance(value, Mapping):
        return parse_accuracy(value, base, known)
    if "start" in value or "drift" in value:
        raise ValueError("an assumed accuracy does not drift: give one accuracy, or leave it out: that of round 1")
    right = "an assumed accuracy has the keys black and white, or error"
    if "error" in value:
        return Misjudgement(read(ErrorTable, value, lambda: right, ("black", "white", "error"), context).error)
    return _of_sides(value, right, ("error",), context)


def _drifting(value: Mapping[str, Any], context: Mapping[str, Any]) -> Accuracy:
    slope: Any = value.get("drift")
    rises = slope > 0 if isinstance(slope, int | float) else "most" in value
    model: type[FallingTable | RisingTable] = RisingTable if rises else FallingTable
    table = read(model, value, lambda: f"an accuracy that drifts is {FORM}", KEYS, context)
    bound = table.most if isinstance(table, RisingTable) else table.least
    low, high = table.start.ends()
    if (high >= bound) if rises else (low <= bound):
        side = f"below most = {bound}" if rises else f"above least = {bound}"
        raise ValueError(f"start = {table.start} should lie {side}, where the drift ends")
    return Accuracy(table.start, None, Drift(table.drift, bound))
