"""Normal, "N(mean, sd)": accuracies are truncated to [0, 1], errors are not."""

import math

import numpy as np

from swarmcensus.engine import compile_world

LETTER = "N"


def check(mean: float, sd: float) -> None:
    """Refuse standard deviations of 0 or below."""
    if sd <= 0.0:
        raise ValueError("it needs sd > 0")


def centre(mean: float, sd: float) -> float:
    """The mean, which must be in bounds."""
    return mean


def moments(mean: float, sd: float) -> tuple[float, float]:
    """The mean and the standard deviation of accuracies, which are truncated to [0, 1]."""
    low, high = -mean / sd, (1.0 - mean) / sd
    density = [math.exp(-end * end / 2.0) / math.sqrt(2.0 * math.pi) for end in (low, high)]
    inside = (math.erf(high / math.sqrt(2.0)) - math.erf(low / math.sqrt(2.0))) / 2.0
    shift = (density[0] - density[1]) / inside
    variance = 1.0 + (low * density[0] - high * density[1]) / inside - shift * shift
    return mean + sd * shift, sd * math.sqrt(variance)


def draw(key: np.ndarray, first_trial: int, out: np.ndarray, mean: float, sd: float) -> None:
    """Accuracies, by rejection."""
    compile_world().draw_normal(key, first_trial, mean, sd, out)


def error(u: np.ndarray, mean: float, sd: float) -> np.ndarray:
    """Errors, by Box and Muller's transform."""
    return np.asarray(mean + sd * (np.sqrt(-2.0 * np.log1p(-u[0])) * np.cos(2.0 * np.pi * u[1])))
