"""Measured, "M(value, error, ...)": robots' own accuracies one after another, each with its standard error.

The robots of a swarm have them in this order, from the first one again where there are more robots. `swarmcensus
calibrate` writes them into robots.toml, and a study that names this file has them.
"""

import numpy as np

from swarmcensus.engine import compile_world

LETTER = "M"
WIDE = 10.0  # standard deviations between the ends of what is drawn


def check(*numbers: float) -> None:
    """Refuse half a pair, and errors below 0."""
    if len(numbers) % 2 or min(numbers[1::2]) < 0.0:
        raise ValueError("it needs pairs of a value and its standard error, which is 0 or above")


def quantile(u: np.ndarray, *numbers: float) -> np.ndarray:
    """The value below which a share u of the robots lies, without their errors."""
    return np.asarray(np.quantile(numbers[::2], u, method="inverted_cdf"))


def moments(*numbers: float) -> tuple[float, float]:
    """The mean over robots and the standard deviation."""
    values, errors = np.array(numbers[::2]), np.array(numbers[1::2])
    return float(values.mean()), float(np.sqrt(values.var() + (errors**2).mean()))


def draw(key: np.ndarray, first_trial: int, out: np.ndarray, *numbers: float) -> None:
    """Each robot's value plus a normal error, cut to [0, 1]."""
    which = np.arange(out.shape[1]) % (len(numbers) // 2)
    errors = np.array(numbers[1::2])[which]
    out[:] = 0.5
    if errors.any():
        compile_world().draw_normal(key, first_trial, 0.5, 1.0 / WIDE, out)
    np.clip(np.array(numbers[::2])[which] + errors * WIDE * (out - 0.5), 0.0, 1.0, out=out)
