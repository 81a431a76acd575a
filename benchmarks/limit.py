"""The limit: a hand-written kernel of a ring that draws, estimates and fuses, and does nothing else.

No records, no brain file, no metrics, constants hoisted out of loops: what the engine is measured against.
"""

import numpy as np
from numba import njit

from swarmcensus.engine.changes import renew, source_of
from swarmcensus.engine.draws import pick
from swarmcensus.engine.layout import Sensors
from swarmcensus.engine.random import words


@njit(nogil=True)
def limit(robots, rounds, looks, b, w, fill_ratio, key, trials):
    """Run trials of a homogeneous ring; returns the last robot's estimate so that nothing is optimised away."""
    steady = np.array([fill_ratio, fill_ratio, 1.0, 1.0])
    source = source_of(Sensors(np.full(1, b), np.full(1, w), np.zeros((3, 0)), steady, looks, key, key))
    renew(source, 1)
    row = source.tables[0, 0]
    bits = np.zeros(robots, np.uint64)
    n, x_hat, alpha, x = np.zeros(robots), np.zeros(robots), np.zeros(robots), np.zeros(robots)
    slope = b + w - 1.0
    q = slope * slope
    for trial in range(trials):
        n[:] = 0.0
        for k in range(1, rounds + 1):
            words(key, trial, k, 0, 0, robots, bits)
            t = float(k * looks)
            low, high = (1.0 - w) * t, b * t
            for i in range(robots):
                n[i] += pick(row, bits[i])
                m = n[i]
                if m <= low:
                    x_hat[i] = 0.0
                    alpha[i] = q * (m / ((1.0 - w) * (1.0 - w)) + (t - m) / (w * w))
                elif m >= high:
                    x_hat[i] = 1.0
                    alpha[i] = q * (m / (b * b) + (t - m) / ((1.0 - b) * (1.0 - b)))
                else:
                    x_hat[i] = (m / t + w - 1.0) / slope
                    alpha[i] = q * t * t * t / (m * (t - m))
            for i in range(robots):
                left = i - 1 if i > 0 else robots - 1
                right = i + 1 if i < robots - 1 else 0
                beta = alpha[left] + alpha[right]
                x_bar = (alpha[left] * x_hat[left] + alpha[right] * x_hat[right]) / beta
                x[i] = (alpha[i] * x_hat[i] + beta * x_bar) / (alpha[i] + beta)
    return x[robots - 1]
