"""The imperfect sensor: how likely a reading is right, and how that is spread over a swarm.

A robot's sensor says black on black with probability b and white on white with probability w (paper,
Eq. 1). A homogeneous swarm has one accuracy, b = w; a heterogeneous one draws an accuracy for each robot.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from swarmcensus.engine.compiler import compile_world
from swarmcensus.engine.random import address

FORMS = 'a number in [0, 1], "U(lo, hi)", "N(mean, sd)" or {black = ..., white = ...}'
SPREAD = re.compile(r"\s*([UN])\s*\(\s*([^,()\s]+)\s*,\s*([^,()\s]+)\s*\)\s*")


@dataclass(frozen=True)
class Spread:
    """One accuracy's distribution over a swarm: "fixed" at `a`, "U" on [a, b], or "N" of mean a and sd b."""

    kind: str
    a: float
    b: float = 0.0

    def __str__(self) -> str:
        """The canonical text, as in the dataset: 0.675, U(0.525,0.975), N(0.75,0.1)."""
        return f"{self.a!r}" if self.kind == "fixed" else f"{self.kind}({self.a!r},{self.b!r})"

    @property
    def form(self) -> object:
        """As in a study file."""
        return self.a if self.kind == "fixed" else str(self)

    def draw(self, key: np.ndarray, first_trial: int, trials: int, robots: int) -> np.ndarray:
        """Accuracies (trial, robot), or (trial, 1) where all robots are alike; afresh for each trial."""
        if self.kind == "fixed":
            return np.full((trials, 1), self.a)
        out = np.empty((trials, robots))
        draw = compile_world().spread_uniform if self.kind == "U" else compile_world().spread_normal
        draw(key, first_trial, self.a, self.b, out)
        return out


@dataclass(frozen=True)
class Accuracy:
    """A swarm's sensor accuracies: b, and w where it differs (else w = b, robot by robot)."""

    black: Spread
    white: Spread | None = None

    def __str__(self) -> str:
        """The canonical text, as in the dataset."""
        return str(self.black) if self.white is None else f"black={self.black} white={self.white}"

    @property
    def form(self) -> object:
        """As in a study file."""
        return self.black.form if self.white is None else {"black": self.black.form, "white": self.white.form}

    def draw(
        self, seed: int, purpose: str, first_trial: int, trials: int, robots: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """b and w, each (trial, robot) or (trial, 1), addressed by seed, purpose and this accuracy's text."""

        def key(colour: str) -> np.ndarray:
            return address(seed, f"{purpose} {colour}", accuracy=str(self), robots=robots)

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
        return self.black.kind == white.kind == "fixed" and math.isclose(self.black.a + white.a, 1.0)


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

    def draw(
        self, seed: int, first_trial: int, trials: int, robots: int, true: tuple[np.ndarray, np.ndarray]
    ) -> tuple[np.ndarray, ...]:
        """Assumed b and w (trial, robot) or (trial, 1), given the true ones."""
        error = np.full((trials, 1), self.error.a)
        if self.error.kind != "fixed":
            uniform = np.empty((2, trials, robots))
            for part in (0, 1):
                key = address(seed, f"error {part}", error=str(self.error), robots=robots)
                compile_world().spread_uniform(key, first_trial, 0.0, 1.0, uniform[part])
            if self.error.kind == "U":
                error = self.error.a + (self.error.b - self.error.a) * uniform[0]
            else:  # Box and Muller's transform
                normal = np.sqrt(-2.0 * np.log1p(-uniform[0])) * np.cos(2.0 * np.pi * uniform[1])
                error = self.error.a + self.error.b * normal
        return tuple(np.ascontiguousarray(np.clip(side + error, 0.0, 1.0)) for side in true)


def parse_spread(value: object, accuracy: bool = True) -> Spread:
    """Read a number, "U(lo, hi)" or "N(mean, sd)", within [0, 1] where it is an accuracy. Raises ValueError."""
    if isinstance(value, str):
        match = SPREAD.fullmatch(value)
        try:
            a, b = (float(match[2]), float(match[3])) if match else (float(value), 0.0)
        except ValueError:
            raise ValueError(f"a sensor accuracy is {FORMS}") from None
        spread = Spread(match[1] if match else "fixed", a, b)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        spread = Spread("fixed", float(min(max(value, -2), 2)))  # whole numbers may be too large for a float
    else:
        raise ValueError(f"a sensor accuracy is {FORMS}")
    low = 0.0 if accuracy else -1.0
    if not low <= spread.a <= 1.0:
        raise ValueError("a sensor accuracy lies in [0, 1]" if accuracy else "an error lies in [-1, 1]")
    if spread.kind == "U" and not spread.a <= spread.b <= 1.0:
        raise ValueError(f"U(lo, hi) needs {low:.0f} <= lo <= hi <= 1")
    if spread.kind == "N" and not 0.0 < spread.b < math.inf:
        raise ValueError("N(mean, sd) needs sd > 0")
    return spread


def parse_accuracy(value: object) -> Accuracy:
    """Read any form of accuracy that a study file may hold. Raises ValueError with what would be right."""
    if isinstance(value, Accuracy):
        return value
    if isinstance(value, Mapping):
        if set(value) != {"black", "white"}:
            raise ValueError("an accuracy table has the keys black and white")
        return Accuracy(parse_spread(value["black"]), parse_spread(value["white"]))
    return Accuracy(parse_spread(value))


def parse_assumed(value: object) -> Accuracy | Misjudgement:
    """Read any form of assumed accuracy: those of an accuracy, or {error = ...}. Raises ValueError."""
    if isinstance(value, Misjudgement):
        return value
    if isinstance(value, Mapping) and set(value) == {"error"}:
        return Misjudgement(parse_spread(value["error"], accuracy=False))
    return parse_accuracy(value)
