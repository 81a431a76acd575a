"""The imperfect sensor: how likely a reading is right, and what robots believe of it.

A robot's sensor says black on black with probability b and white on white with probability w (paper,
Eq. 1). A homogeneous swarm has one accuracy, b = w; a heterogeneous one draws an accuracy for each robot.
"""

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from swarmcensus.basics.hints import did_you_mean, did_you_mean_any
from swarmcensus.engine.addresses import address
from swarmcensus.worlds.spreading import Spread, parse_spread

KEYS = ("start", "drift", "least", "most")


FORM = "{start = 0.9, drift = -1e-5, least = 0.6}"


@dataclass(frozen=True)
class Drift:
    """What an accuracy gains from each round (or tick) to the next, below 0 where it is lost, and where it stays."""

    slope: float
    bound: float

    def __str__(self) -> str:
        """As in the dataset, after what it starts from: "drift=-1e-05 least=0.6"."""
        return " ".join(f"{key}={value}" for key, value in self.form.items())

    @property
    def form(self) -> dict[str, float]:
        """As in a study file, beside its start."""
        return {"drift": self.slope, "least" if self.slope < 0.0 else "most": self.bound}

    @property
    def numbers(self) -> tuple[float, float, float]:
        """What is gained a round, the least and the greatest."""
        return (self.slope, self.bound, 1.0) if self.slope < 0.0 else (self.slope, 0.0, self.bound)


@dataclass(frozen=True)
class Accuracy:
    """A swarm's sensor accuracies: b, and w where it differs (else w = b, robot by robot), and how both drift."""

    black: Spread
    white: Spread | None = None
    drift: Drift | None = None

    def __str__(self) -> str:
        """The canonical text, as in the dataset."""
        told = str(self.black) if self.white is None else f"black={self.black} white={self.white}"
        return told if self.drift is None else f"{told} {self.drift}"

    @property
    def form(self) -> object:
        """As in a study file."""
        if self.drift is not None:
            return {"start": self.black.form, **self.drift.form}
        return self.black.form if self.white is None else {"black": self.black.form, "white": self.white.form}

    @property
    def start(self) -> Self:
        """Those of the first round: what chance draws, and what robots believe in that know their sensors."""
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
        """Whether every robot's readings carry no information: b + w = 1."""
        white = self.white or self.black
        fixed = self.black.is_number and white.is_number
        return fixed and math.isclose(self.black.numbers[0] + white.numbers[0], 1.0)

    @property
    def spreads(self) -> tuple[Spread, ...]:
        """What it is drawn from."""
        return (self.black, self.white) if self.white else (self.black,)

    @functools.cached_property
    def edition(self) -> str:
        """What its results depend on beside its text: hashes of other packages' files."""
        return "".join(spread.edition for spread in self.spreads)


@dataclass(frozen=True)
class Misjudgement:
    """What a swarm assumes of its sensors: the truth plus an error, one a robot for both b and w, within [0, 1]."""

    error: Spread

    def __str__(self) -> str:
        """The canonical text, as in the dataset."""
        return f"error={self.error}"

    @property
    def form(self) -> object:
        """As in a study file."""
        return {"error": self.error.form}

    @property
    def spreads(self) -> tuple[Spread, ...]:
        """What it is drawn from."""
        return (self.error,)

    @property
    def edition(self) -> str:
        """As of an accuracy."""
        return self.error.edition

    def draw(
        self, seed: int, first_trial: int, trials: int, robots: int, true: tuple[np.ndarray, np.ndarray]
    ) -> tuple[np.ndarray, ...]:
        """Assumed b and w (trial, robot) or (trial, 1), given the true ones."""

        def key(part: int) -> np.ndarray:
            return address(seed, f"error {part}", error=str(self.error), robots=robots)

        error = self.error.errors(key, first_trial, trials, robots)
        return tuple(np.ascontiguousarray(np.clip(side + error, 0.0, 1.0)) for side in true)


TABLE_KEYS = ("black", "white", "start", "drift")
BELIEF_KEYS = ("black", "white", "error")


def parse_accuracy(value: object) -> Accuracy:
    """Read any form of accuracy that a study file may hold. Raises ValueError with what would be right."""
    if isinstance(value, Accuracy):
        return value
    if isinstance(value, Mapping) and ("start" in value or "drift" in value):
        start, drift = parse_drift(value)
        return Accuracy(start, None, drift)
    if isinstance(value, Mapping):
        if set(value) != {"black", "white"}:
            raise ValueError(
                f"{did_you_mean_any(value, TABLE_KEYS)}"
                "an accuracy table has the keys black and white, or start and drift"
            )
        if any(isinstance(side, Mapping) for side in value.values()):
            raise ValueError(
                "an accuracy that drifts is b = w: {start = ..., drift = ...} alone, not of black or white"
            )
        return Accuracy(parse_spread(value["black"]), parse_spread(value["white"]))
    return Accuracy(parse_spread(value))


def parse_assumed(value: object) -> Accuracy | Misjudgement:
    """Read any form of assumed accuracy: those of an accuracy, or {error = ...}. Raises ValueError."""
    if isinstance(value, Misjudgement):
        return value
    if isinstance(value, Mapping) and set(value) == {"error"}:
        return Misjudgement(parse_spread(value["error"], accuracy=False))
    if isinstance(value, Mapping) and ("start" in value or "drift" in value):
        raise ValueError("a belief does not drift: robots believe in one accuracy, or in the first of their own")
    if isinstance(value, Mapping) and set(value) != {"black", "white"}:
        raise ValueError(
            f"{did_you_mean_any(value, BELIEF_KEYS)}a table of beliefs has the keys black and white, or error"
        )
    return parse_accuracy(value)


BLIND, PERFECT = 0.5, 1.0  # where a drift ends that says nothing else


def parse_drift(value: Mapping[str, object]) -> tuple[Spread, Drift]:
    """Read the accuracies that robots start from, and how they drift. Raises ValueError with what would be right."""
    for key in value:
        if key not in KEYS:
            raise ValueError(f"unknown key {key}: {did_you_mean(str(key), KEYS)}an accuracy that drifts is {FORM}")
    for key in KEYS[:2]:
        if key not in value:
            raise ValueError(f"{key} is missing: an accuracy that drifts is {FORM}")
    start, slope = parse_spread(value["start"]), _number("drift", value["drift"], -1.0)
    if slope == 0.0:
        raise ValueError("drift = 0 is none: give the accuracy as a plain number or spread")
    falls = slope < 0.0
    key, other = ("least", "most") if falls else ("most", "least")
    if other in value:
        raise ValueError(f"{other} means nothing where the drift is {'below' if falls else 'above'} 0: give {key}")
    bound = _number(key, value.get(key, BLIND if falls else PERFECT), 0.0)
    low, high = start.ends()
    if (low <= bound) if falls else (high >= bound):
        way = "above" if falls else "below"
        raise ValueError(f"start = {start} should lie {way} {key} = {bound}, where the drift ends")
    return start, Drift(slope, bound)


def _number(key: str, value: object, least: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= 1.0:
        raise ValueError(f"{key} should be a number in [{least:g}, 1]")
    return float(value)
