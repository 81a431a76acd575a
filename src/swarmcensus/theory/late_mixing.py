"""Mixed running sums with late messages: the weight of each reading in them.

Let D be the diagonal of the weights W, and O the rest. In round t robots send y(t) = s(t - 1) + the new s of that
round's readings, and they hear what was sent d rounds before, so that

    s(t) = D y(t) + O y(t - d),   but s(t) = y(t) up to round d, when no message has arrived yet.

So y follows the powers of a companion matrix. Its response to one new s, n rounds later, is X(n), with X(0) = 1, 0
before it, and

    X(n + 1) = D X(n) + O X(n - d).

A reading of round r > d has the weights X(t - r + 1) in s(t). One of round r <= d is sent again in each round up to
d + 1. Summed over these rounds, its weights are, with n = t - d,

    X(n) + (X(n - r) + ... + X(n - d)) O.

With d = 0, X(n) is W^n: the mixing of `mixing.py`. With any d, weights tend to the same limit, as X(n) tends to
1 pi' / (1 + d (1 - sum pi_i W_ii)), with the pi of W. It only takes longer: in a large full network the sums of every
(d + 1)-th round hardly mix with the others.
"""

from collections import deque

import numpy as np

from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.intervals import Floats
from swarmcensus.theory.matrices import product_with

MOST_LATE = 20_000_000  # robots squared, times rounds that are kept


def fits(robots: int, delay: int) -> bool:
    """Whether the weights fit in memory."""
    return robots**2 * (delay + 1) <= MOST_LATE


def late_moments(matrix: Floats, delay: int, at: list[int], squared: Floats, summed: Floats) -> tuple[Floats, Floats]:
    """sum_{r,j} c_ij(r)^2 squared_j and sum_{r,j} c_ij(r) summed_j, each (t, robot), for the times t of `at`.

    c_ij(r) is the weight of a reading of robot j in round r = 1 .. t in s_i(t). Takes O(links N t) steps, or O(N^3 t)
    if nearly all robots hear each other, and O(N^3 d) for each time. Raises InputError if it needs too much memory.
    """
    robots = len(matrix)
    if not fits(robots, delay):
        late = f"{counted(robots, 'robot')} with messages {counted(delay, 'round')} late"
        raise InputError(f"{late}: the weights do not fit in memory", key="delay", value=delay)
    own = np.diag(matrix)[:, np.newaxis]
    others = matrix - np.diagflat(own)
    squares, sums = np.zeros((2, len(at), robots))
    square, total = np.zeros((2, robots))
    before = deque([np.zeros((robots, robots))] * delay + [np.eye(robots)], delay + 1)  # X(n - d) ... X(n)
    heard = product_with(others)
    for t in range(1, max(at) + 1):
        if t > delay:
            before.append(own * before[-1] + heard(before[0]))
            square, total = square + before[-1] ** 2 @ squared, total + before[-1] @ summed
        for k in (k for k, one in enumerate(at) if one == t):
            if t <= delay:
                squares[k], sums[k] = t * squared, t * summed
                continue
            squares[k], sums[k] = square, total
            tail = np.zeros((robots, robots))
            for r in range(delay, 0, -1):
                tail += before[delay - r]
                weights = before[-1] + tail @ others
                squares[k], sums[k] = squares[k] + weights**2 @ squared, sums[k] + weights @ summed
    return squares, sums
