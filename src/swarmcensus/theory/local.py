"""The local estimate, exactly: what a robot alone believes after t readings, with which probability.

Of t independent readings, n say black, and n is binomial with q = b f + (1 - w)(1 - f). The paper's Eq. 4 turns n into
x_hat = (n / t + w - 1) / (b + w - 1), cut to [0, 1]. So x_hat has t + 1 values at the most, each with the probability
of its n, and those that are cut make atoms at 0 and 1. With b + w < 1 the formula holds as it is; with b + w = 1
readings say nothing, and x_hat stays at 0.5.

It holds where readings are independent given f: on fixed networks, and not where a robot looks at one tile again and
again (see `floor`).
"""

from typing import NamedTuple

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.theory.checks import BLIND, MOST_READINGS, Floats, count, numbers, one_share, sensors


class Law(NamedTuple):
    """A discrete distribution: its values, rising, and the chance of each; both (value,)."""

    values: Floats
    chances: Floats

    @property
    def mean(self) -> float:
        """The expected value."""
        return float(self.values @ self.chances)

    @property
    def variance(self) -> float:
        """The expected square of the distance from the mean."""
        return float((self.values - self.mean) ** 2 @ self.chances)

    def at_most(self, x: float) -> float:
        """The chance of a value up to x: the distribution function."""
        return float(self.chances[: np.searchsorted(self.values, x, side="right")].sum())

    def between(self, low: float, high: float) -> float:
        """The chance of a value from `low` on and below `high`, which may be infinite."""
        first, last = np.searchsorted(self.values, [low, high], side="left")
        return float(self.chances[first:last].sum())

    def quantile(self, share: float) -> float:
        """The lowest value that is not exceeded with a chance of `share` or more. Raises InputError."""
        share = one_share("share", share)
        upto = np.cumsum(self.chances)
        at = int(np.searchsorted(upto, share * upto[-1] * (1.0 - 1e-12)))
        return float(self.values[min(at, len(self.values) - 1)])


def local_law(readings: int, fill_ratio: float, b: float, w: float | None = None) -> Law:
    """The distribution of the local estimate x_hat (paper, Eq. 4) after so many `readings`; w is b by default.

    Values are computed in the brain's own order of operations, so that those on the edge of a bin lie on the same side
    of it. Time and memory are O(readings). Raises InputError for a number out of its range and for more than 10,000,000
    readings.
    """
    t = count("readings", readings, 0, MOST_READINGS)
    b_, w_ = (float(one) for one in sensors(_single("b", b), None if w is None else _single("w", w)))
    f = one_share("fill_ratio", fill_ratio)
    slope = b_ + w_ - 1.0
    if t == 0 or abs(slope) < BLIND:
        return Law(np.array([0.5]), np.array([1.0]))
    n = np.arange(t + 1)
    estimates = np.clip((n / t + w_ - 1.0) / slope, 0.0, 1.0)
    return merged(estimates, binomial(t, b_ * f + (1.0 - w_) * (1.0 - f)))


def error_law(law: Law, fill_ratio: float) -> Law:
    """The distribution of the error |x - f| of an estimate x with this `law`: its mean, quantiles and so on.

    `error_law(law, f).quantile(0.5)` is the expected median error. Raises InputError.
    """
    return merged(np.abs(law.values - one_share("fill_ratio", fill_ratio)), law.chances)


def mixed_law(laws: list[Law]) -> Law:
    """The distribution of an estimate that has each of these laws with the same chance, as in a swarm of unequal
    sensors.

    Raises InputError where there is none.
    """
    if not isinstance(laws, list | tuple) or not all(isinstance(one, Law) for one in laws):
        raise InputError("laws: should be a list of laws, as `local_law` gives them")
    if not laws:
        raise InputError("laws = []: should hold a law")
    values, chances = (np.concatenate([law[k] for law in laws]) for k in (0, 1))
    return merged(values, chances / len(laws))


def merged(values: Floats, chances: Floats) -> Law:
    """A law of values in any order, equal ones added up, and those without a chance left out."""
    kept = chances > 0.0
    distinct, place = np.unique(values[kept], return_inverse=True)
    return Law(distinct, np.bincount(place, weights=chances[kept], minlength=len(distinct)).astype(np.float64))


def binomial(tries: int, chance: float) -> Floats:
    """The chances of 0 .. tries hits, (tries + 1,): ratios of neighbours, multiplied from the likeliest on."""
    if not 0.0 < chance < 1.0:
        return np.asarray(np.eye(1, tries + 1, tries if chance >= 1.0 else 0)[0])
    odds = chance / (1.0 - chance)
    top = min(int((tries + 1) * chance), tries)
    n = np.arange(tries + 1, dtype=np.float64)
    found = np.empty(tries + 1)
    found[top] = 1.0
    found[top + 1 :] = np.cumprod((tries - n[top:-1]) / (n[top:-1] + 1.0) * odds)
    found[:top] = np.cumprod(n[top:0:-1] / (tries - n[top:0:-1] + 1.0) / odds)[::-1]
    return np.asarray(found / found.sum())


def _single(name: str, value: float) -> float:
    if numbers(name, value).ndim:
        raise InputError(f"{name} has several numbers: should be one, of one robot; `mixed_law` joins several laws")
    return value
