"""The exact distribution of the local estimate after t readings.

The number n of black readings among t independent ones is binomial with q = b f + (1 - w)(1 - f). The paper's Eq. 4
turns n into x_hat = (n / t + w - 1) / (b + w - 1), cut to [0, 1]. So x_hat has at most t + 1 values, each with the
probability of its n; all that are cut add up at 0 and 1. The formula holds for b + w < 1 too. With b + w = 1 readings
say nothing, and x_hat stays at 0.5.

Readings must be independent given f. They are on fixed networks, but not where a robot reads the same tile several
times (see `floor`).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.support.bins import right_bin
from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats
from swarmcensus.theory.checks import (
    BLIND,
    MOST_READINGS,
    count,
    fitting,
    from_zero,
    numbers,
    one_share,
    sensors,
    shares,
)


class Law(NamedTuple):
    """A discrete distribution: its values, sorted, and their probabilities, both (value,)."""

    values: Floats
    chances: Floats

    @property
    def mean(self) -> float:
        """The expected value."""
        return float(self.values @ self.chances)

    @property
    def variance(self) -> float:
        """The variance."""
        return float((self.values - self.mean) ** 2 @ self.chances)

    def at_most(self, x: float) -> float:
        """The probability of a value of at most x: the distribution function."""
        return float(self.chances[: np.searchsorted(self.values, x, side="right")].sum())

    def between(self, low: float, high: float) -> float:
        """The probability of a value from `low` to below `high`, which may be infinite."""
        first, last = np.searchsorted(self.values, [low, high], side="left")
        return float(self.chances[first:last].sum())

    def quantile(self, share: float) -> float:
        """The lowest value that has a probability of `share` or more up to it. Raises InputError."""
        share = one_share("share", share)
        upto = np.cumsum(self.chances)
        at = int(np.searchsorted(upto, share * upto[-1] * (1.0 - 1e-12)))
        return float(self.values[min(at, len(self.values) - 1)])


def local_law(readings: int, fill_ratio: float, b: float, w: float | None = None) -> Law:
    """The distribution of the local estimate x_hat (paper, Eq. 4) after this number of `readings`; w is b by default.

    Values are computed with the brain's own order of operations, so that values at the edge of a bin are in the same
    bin. Takes O(readings) time and memory. Raises InputError, also for more than 10,000,000 readings.
    """
    t = count("readings", readings, 0, MOST_READINGS)
    for name, value in (("b", b), ("w", b if w is None else w)):
        if numbers(name, value).ndim:
            should = "one, of one robot; `mixed_law` joins several laws"
            raise InputError(f"{name} has several numbers: should be {should}", key=name)
    b_, w_ = map(float, sensors(b, w))
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
    """The mixture of these laws with equal weights, as for a random robot of a swarm with unequal sensors.

    Raises InputError for an empty list.
    """
    if not isinstance(laws, list | tuple) or not all(isinstance(one, Law) for one in laws):
        raise InputError("laws: should be a list of laws, as `local_law` gives them", key="laws")
    if not laws:
        raise InputError("laws = []: should contain a law", key="laws")
    values, chances = (np.concatenate([law[k] for law in laws]) for k in (0, 1))
    return merged(values, chances / len(laws))


def merged(values: Floats, chances: Floats) -> Law:
    """A law from values in any order: equal ones are added up, and those with probability 0 left out."""
    kept = chances > 0.0
    distinct, place = np.unique(values[kept], return_inverse=True)
    return Law(distinct, np.bincount(place, weights=chances[kept], minlength=len(distinct)).astype(np.float64))


def binomial(tries: int, chance: float) -> Floats:
    """The binomial probabilities of 0 .. tries hits, (tries + 1,), as products of ratios from the mode on."""
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


HALVINGS = 48  # of the unit interval, down to rounding errors

_erf = np.vectorize(math.erf, otypes=[np.float64])


def right_share(law: Law, fill_ratio: float, bins: int = 10) -> float:
    """The expected share of robots in the bin of the fill ratio, where each robot's estimate has this law.

    It equals the probability that one robot is right, whether robots are independent or not.
    Raises InputError.
    """
    low, high = right_bin(one_share("fill_ratio", fill_ratio), count("bins", bins))
    return law.between(low, high)


def normal_right_share(variance: ArrayLike, fill_ratio: float, bins: int = 10, bias: ArrayLike = 0.0) -> Floats:
    """`right_share` of estimates that are normal about f + bias with this variance, cut to [0, 1].

    With a variance of 0 all estimates are f + bias. Returns the shape of variance and bias together. Raises InputError.
    """
    f = one_share("fill_ratio", fill_ratio)
    spread, off = fitting(variance=from_zero("variance", variance), bias=numbers("bias", bias))
    low, high = right_bin(f, count("bins", bins))
    centre, sd = f + off, np.sqrt(spread)
    known = sd > 0.0
    scale = np.sqrt(2.0) * np.where(known, sd, 1.0)
    below = [0.5 * (1.0 + _erf((end - centre) / scale)) for end in (low, high)]
    return np.where(known, below[1] - below[0], (low <= centre) & (centre < high))


def normal_median_error(variances: ArrayLike, fill_ratio: float) -> Floats:
    """The median of |x - f| over robots with estimates that are normal about f, with `variances` (..., robot).

    Estimates are cut to [0, 1]. Returns (...), by bisection: the share of robots within e of f grows with e. Raises
    InputError.
    """
    f, spread = one_share("fill_ratio", fill_ratio), numbers("variances", variances)
    if spread.ndim == 0 or not spread.size or (spread < 0.0).any():
        raise InputError("variances: should be numbers from 0 on, one a robot", key="variances")
    known = spread > 0.0
    scale = np.sqrt(2.0 * np.where(known, spread, 1.0))
    low, high = np.zeros(spread.shape[:-1]), np.full(spread.shape[:-1], max(f, 1.0 - f))
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        within = np.where(known, _erf(middle[..., np.newaxis] / scale), 1.0)
        sides = [np.where(middle[..., np.newaxis] >= room, 1.0, within) for room in (f, 1.0 - f)]
        enough = ((sides[0] + sides[1]) / 2.0).mean(axis=-1) >= 0.5
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    return np.asarray(high)


def local_squared_error(
    readings: int, fill_ratio: float, b: ArrayLike, w: ArrayLike | None = None, pull: ArrayLike = 0.0
) -> Floats:
    """The mean of (x - f)^2 of the local estimate (paper, Eq. 4) after this number of `readings`, cut to [0, 1].

    A prior moves it by the share `pull` of its distance towards 1/2 before it is cut. With b + w = 1, x stays at 1/2.
    Returns the shape of the sensors; takes O(readings) time for each distinct sensor. Raises InputError.
    """
    t = count("readings", readings, 1, MOST_READINGS)
    f, (black, white) = one_share("fill_ratio", fill_ratio), sensors(b, w)
    black, white, share = fitting(b=black, w=white, pull=shares("pull", pull))
    kinds, which = np.unique(np.stack([black.ravel(), white.ravel(), share.ravel()]), axis=1, return_inverse=True)
    black_share = np.arange(t + 1) / t
    errors = []
    for b_, w_, h in kinds.T.tolist():
        slope = b_ + w_ - 1.0
        if abs(slope) < BLIND:
            errors.append((0.5 - f) ** 2)
            continue
        x = np.clip((1.0 - h) * (black_share + w_ - 1.0) / slope + 0.5 * h, 0.0, 1.0)
        errors.append(float(binomial(t, slope * f + 1.0 - w_) @ (x - f) ** 2))
    return np.array(errors)[which.ravel()].reshape(black.shape)


def pulled_squared_error(variance: ArrayLike, fill_ratio: float, pull: ArrayLike) -> Floats:
    """The mean of (x - f)^2 of an unbiased estimate that a prior moves by the share `pull` towards 1/2, not cut.

    Returns the shape of variance and pull together. Raises InputError.
    """
    spread, share = _normal(variance, pull)
    bias = share * (0.5 - one_share("fill_ratio", fill_ratio))
    return np.asarray((1.0 - share) ** 2 * spread + bias**2)


def cut_off(variance: ArrayLike, fill_ratio: float, pull: ArrayLike = 0.0) -> Floats:
    """By how much cutting to [0, 1] lowers the mean of (x - f)^2 of a normal estimate, as in `pulled_squared_error`.

    Estimates below 0 contribute the mean of (x - f)^2 - f^2, and those above 1 likewise. Returns the shape of variance
    and pull together. Raises InputError.
    """
    f, (spread, share) = one_share("fill_ratio", fill_ratio), _normal(variance, pull)
    bias, sd = share * (0.5 - f), (1.0 - share) * np.sqrt(spread)
    total = np.zeros(sd.shape)
    for end, off in ((f, bias), (1.0 - f, -bias)):
        z = (end + off) / np.where(sd > 0.0, sd, np.inf)
        density = np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi)
        beyond = 0.5 * (1.0 - _erf(z / np.sqrt(2.0)))
        part = (off**2 - end**2 + sd**2) * beyond + (sd * z - 2.0 * off) * sd * density
        total += np.where(sd > 0.0, part, 0.0)
    return total


def _normal(variance: ArrayLike, pull: ArrayLike) -> tuple[Floats, Floats]:
    """Finite variances and pulls, broadcast to one shape. Raises InputError."""
    found = from_zero("variance", variance)
    if np.isinf(found).any():
        raise InputError("variance: should be finite", key="variance")
    found, share = fitting(variance=found, pull=shares("pull", pull))
    return found, share
