"""How news spreads among robots that meet: the factor of the network where who meets whom is left to chance.

When two robots meet they stay in reach for many ticks, and their sums become the mean of both. Let a robot meet others
at a rate m, each as likely. If e_i' W holds the weights with which readings of all robots, made a time u ago, count in
robot i's sums now, the mean over robots of |e_i' W|^2 is 1 at first and 1/N where all count alike. A meeting takes
(W_i - W_j)^2 / 2 from the sum of squares, N m / 2 of them happen in a unit of time, and so, in the mean,

    |e_i' W|^2 - 1/N = (1 - 1/N) exp(-a u),    a = m N / (2 (N - 1)),

and after a time t the factor (1 / t^2) integral |e_i' W|^2 du is 1 / (N t) + (1 - 1/N) (1 - exp(-a t)) / (a t^2).

The rate is that of discs of the radio's range among others that are n to the square metre and move at random with a
speed v: m = 2 r n (4 / pi) v, 4 / pi being the mean of the relative speed over directions (kinetic theory of gases, in
the plane). Robots that turn often meet the same others again and again, so that news spreads more slowly than this.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from swarmcensus.worlds.bodies import Body


def meeting_rate(robots: int, side: float, body: Body) -> float:
    """How many others a robot meets in a tick, in a square of this side in metres."""
    run = body.straight_mean
    moving = run / (run + max(body.turn_most / 2.0, 1.0))  # turns on the spot take the rest of the time
    speed = moving * body.speed * body.tick
    return 2.0 * body.radio_range * (robots - 1) / side**2 * 4.0 / math.pi * speed


def meeting_factors(robots: int, rate: float, ticks: ArrayLike) -> NDArray[np.float64]:
    """The factor of the network after so many ticks, of the shape of `ticks`: 1/t of a robot alone, 1/(N t) of one that
    knows all."""
    t = np.asarray(ticks, np.float64)
    if robots == 1 or rate <= 0.0:
        return 1.0 / t
    a = rate * robots / (2.0 * (robots - 1))
    return np.asarray(1.0 / (robots * t) + (1.0 - 1.0 / robots) * -np.expm1(-a * t) / (a * t**2))
