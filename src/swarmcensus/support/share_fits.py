"""A smooth curve of a share that grows with a size, fitted to independent samples at several sizes.

The size at which single samples first reach a promised share is too small on average, because luck chooses it. A curve
through all samples has no such preference, and its interval is narrower, because every sample counts.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from swarmcensus.support.intervals import LEVEL, Estimate, Floats, student, tries_of

NORMAL = NormalDist()
STEPS = 50  # of Fisher scoring
FARTHEST = 0.5  # largest change of log u in a step
PRECISION = 1e-10
LEAST, MOST = 1e-3, 6.0  # the normal deviates u that are distinguished: shares from 0.0008 to 1 - 2e-9


@dataclass(frozen=True)
class ShareFit:
    """The share 2 Phi(exp(a + s log size)) - 1, with the covariance of (a, s).

    That is the share of normal estimates within a fixed distance of the truth if their standard deviation is a power
    of the size.
    """

    intercept: float
    slope: float
    covariance: Floats
    half_width: float  # of the interval, in standard errors

    def at(self, size: float) -> Estimate:
        """The share at this size, with its 95 % interval."""
        row = np.array([1.0, math.log(size)])
        middle = self.intercept + self.slope * row[1]
        half = self.half_width * math.sqrt(max(0.0, float(row @ self.covariance @ row)))
        return Estimate(*(_share(_deviate(end)) for end in (middle, middle - half, middle + half)))


def fit_shares(sizes: Sequence[float], by_trial: Sequence[Floats]) -> ShareFit:
    """The curve of greatest likelihood through the mean shares of independent trials (trial,) at two sizes or more.

    A size counts as often as its independent tries, and if sizes scatter more than their tries explain, the covariance
    grows by Pearson's chi-squared per degree of freedom (Finney, "Probit Analysis", 1971, section 4.6). One right
    and one wrong try, divided among the sizes, keep the curve finite if all tries are right (as in Firth, 1993, "Bias
    reduction of maximum likelihood estimates").
    """
    tries = np.array([tries_of(shares, LEVEL) for shares in by_trial])
    added = 1.0 / len(sizes)
    shares = (tries * np.array([shares.mean() for shares in by_trial]) + added) / (tries + 2.0 * added)
    rows = np.stack([np.ones(len(sizes)), np.log(np.asarray(sizes, np.float64))], axis=1)
    deviates = np.array([NORMAL.inv_cdf((1.0 + share) / 2.0) for share in shares])
    fit = np.linalg.lstsq(rows, np.log(deviates), rcond=None)[0]
    for _ in range(STEPS):
        information, score, _ = _scoring(rows, fit, shares, tries)
        step = np.linalg.solve(information, score)
        fit = fit + step * min(1.0, FARTHEST / np.abs(rows @ step).max(initial=FARTHEST))
        if np.abs(step).max() < PRECISION:
            break
    information, _, chi_squared = _scoring(rows, fit, shares, tries)
    freedom = len(sizes) - 2
    scatter = max(1.0, chi_squared / freedom) if freedom else 1.0
    trials = sum(len(each) for each in by_trial)
    covariance = np.asarray(scatter * np.linalg.inv(information), np.float64)
    return ShareFit(float(fit[0]), float(fit[1]), covariance, student(trials, LEVEL))


def _scoring(rows: Floats, fit: Floats, shares: Floats, tries: Floats) -> tuple[Floats, Floats, float]:
    """The Fisher information of a fit, its score and Pearson's chi-squared."""
    u = np.array([_deviate(value) for value in rows @ fit])
    fitted, slope = np.array([(_share(value), 2.0 * NORMAL.pdf(value) * value) for value in u]).T
    variance = fitted * (1.0 - fitted) / tries
    score = rows.T @ (slope / variance * (shares - fitted))
    return rows.T @ (rows * (slope**2 / variance)[:, None]), score, float(((shares - fitted) ** 2 / variance).sum())


def _deviate(log_deviate: float) -> float:
    return min(MOST, max(LEAST, math.exp(min(log_deviate, 10.0))))


def _share(deviate: float) -> float:
    return 2.0 * NORMAL.cdf(deviate) - 1.0
