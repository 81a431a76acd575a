"""The squared error of estimates from mixed running sums that are cut to [0, 1], from their exact distribution.

The ratio s / v of `mixing.py` is a weighted sum of binomials, f + e with

    e = sum_{m,j} c_mj (n_mj - R q_j),    c_mj = [W^m]_ij k_j / v_i,    n_mj binomial of R readings with q_j,

whose characteristic function is a product. The mean of a function g of e is then a cosine series over an interval that
holds e up to a probability of 1e-14 (Fang and Oosterlee, "A novel pricing method for European options based on
Fourier-cosine series expansions", 2008). It holds for any f, so also at 0 and 1, where about half of all estimates are
cut and the normal law of `local.cut_off` misses the skew of e.
"""

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.support.intervals import Floats
from swarmcensus.theory.checks import count, fitting, one_share, sensors, shares
from swarmcensus.theory.matrices import checked
from swarmcensus.theory.mixing import mixed_sums, powers

OUTSIDE = np.log(2e14)  # of a probability of 1e-14 on both sides
FEW, MANY = 128, 4096  # terms of the series: for sums of many weights, and of few, which have a law with distinct steps
SMOOTH = 4.0  # standard deviations in the largest step of a sum of many weights


def cut_squared_error(
    matrix: ArrayLike,
    rounds: int,
    observations_per_round: int,
    fill_ratio: float,
    b: ArrayLike,
    w: ArrayLike | None = None,
    pull: ArrayLike = 0.0,
) -> Floats:
    """The mean of (x - f)^2 of each robot's estimate after round t, cut to [0, 1], (robot,).

    A prior moves estimates by the share `pull` of their distance to 1/2 before they are cut. Messages arrive in the
    same round. If all robots of a network are equivalent, one is computed. Raises InputError.
    """
    found, t = checked(matrix), count("rounds", rounds, 1)
    looks, f = count("observations_per_round", observations_per_round, 1), one_share("fill_ratio", fill_ratio)
    sums = mixed_sums(found, t, looks, f, b, w)
    robots = np.arange(len(found))
    black, white = sensors(b, w)
    black, white, share, _ = fitting(b=black, w=white, pull=shares("pull", pull), robots=np.zeros(len(found)))
    equal = all(np.ptp(one) == 0.0 for one in (black, white, share)) and all_equivalent(found)
    if equal:
        robots = robots[:1]
    slope = black + white - 1.0
    q = slope * f + 1.0 - white
    sd = np.sqrt(sums.variance[robots])
    rows = [(power[robots], times) for power, times in powers(found, t)]
    step = np.max([(weights * np.abs(slope)).max(axis=1) for weights, _ in rows], axis=0) / sums.evidence[robots]
    half = step * OUTSIDE / 3.0 + np.sqrt((step * OUTSIDE / 3.0) ** 2 + 2.0 * OUTSIDE * sd**2)  # Bernstein's bound
    terms = FEW if (sd >= SMOOTH * step).all() else MANY
    out = np.empty(len(robots))
    for k in range(len(robots)):
        if sd[k] == 0.0:
            out[k] = (min(max((1.0 - share[k]) * f + 0.5 * share[k], 0.0), 1.0) - f) ** 2
            continue
        frequency = np.arange(terms) * np.pi / (2.0 * half[k])
        log = np.zeros(terms, np.complex128)
        for weights, times in rows:
            used = weights[k] != 0.0
            angle = np.multiply.outer(weights[k, used] * slope[used] / sums.evidence[robots[k]], frequency)
            chance = q[used, np.newaxis]
            log += times * looks * (np.log1p(chance * np.expm1(1j * angle)) - 1j * chance * angle).sum(axis=0)
        at_left = np.exp(log + 1j * frequency * half[k]).real
        at_left[0] *= 0.5
        out[k] = at_left @ _coefficients(f, float(share[k]), float(half[k]), frequency)
    return np.maximum(np.full(len(found), out[0]) if equal else out, 0.0)


def all_equivalent(matrix: Floats) -> bool:
    """Whether each row is the one before, shifted by one, as in rings and full networks."""
    return bool((np.roll(matrix, (1, 1), (0, 1)) == matrix).all())


def terms_for(matrix: Floats, rounds: int) -> float:
    """About how many complex numbers `cut_squared_error` computes, for equal sensors."""
    return (1 if all_equivalent(matrix) else len(matrix)) * float(len(matrix)) * rounds * FEW


def _coefficients(f: float, pull: float, half: float, frequency: Floats) -> Floats:
    """Those of (cut((1 - pull) (f + e) + pull / 2) - f)^2 in a cosine series over e from -half to half."""
    slope, at_zero = 1.0 - pull, (1.0 - pull) * f + 0.5 * pull - f  # the error before it is cut is slope e + at_zero
    low, high = -half, half
    if slope > 0.0:
        low, high = (min(max((end - f - at_zero) / slope, -half), half) for end in (0.0, 1.0))
    parts, ends = [(0.0, -f), (slope, at_zero), (0.0, 1.0 - f)], [-half, low, high, half]
    u = frequency[1:]
    total = np.zeros(len(frequency))
    for (a, c), left, right in zip(parts, ends[:-1], ends[1:], strict=True):
        for end, sign in ((right, 1.0), (left, -1.0)):
            error, phase = a * end + c, u * (end + half)
            waves = (error**2 / u - 2.0 * a**2 / u**3) * np.sin(phase) + 2.0 * a * error / u**2 * np.cos(phase)
            total[1:] += sign * waves
            whole = c**2 * end + a * c * end**2 + a**2 * end**3 / 3.0
            total[0] += sign * whole
    return total / half
