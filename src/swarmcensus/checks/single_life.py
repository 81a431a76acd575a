"""How long a brain lives in single precision: the reading at which its estimate leaves that of double precision.

Two robots with one brain, one in double and one in single precision, make the same readings, one a tick. They run once
alone, and once with a neighbour in their own state.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numba
import numpy as np

from swarmcensus.brains import Brain, Numbers, rounded_to_single
from swarmcensus.checks.machine import blank_state, exchange, machine_code

DAY = 864_000  # readings at 10 Hz
APART = 0.01  # estimates that differ by more have parted
ACCURACY = 0.8  # b and w
BLACK = 0.53  # the share of readings that say black: that of a floor of which 55 % is black
GOLDEN, PLASTIC = 0.6180339887498949, 0.7548776662466927  # multiples of these modulo 1 are evenly spread


class Departure(NamedTuple):
    """The reading at which single and double precision part; None if they stay together."""

    alone: int | None
    hearing: int | None


def life(brain: Brain, spans: Sequence[tuple[int, int]] = ((0, DAY),)) -> Departure:
    """Live a brain for spans of ticks: each begins with so many readings at once, and then has so many ticks.

    Takes seconds, in which the brain is compiled. Raises what the brain raises, and Numba's errors.
    """
    double, single = (brain.with_numbers(Numbers(precision)) for precision in ("double", "single"))
    lives = [_compiled(double), _compiled(single)]

    def parting(hears: bool) -> int | None:
        for begin, ticks in spans:
            accuracy = rounded_to_single(ACCURACY)
            pair = [blank_state(double, ACCURACY, ACCURACY), blank_state(single, accuracy, accuracy)]
            curves = [run(states, begin, ticks, hears) for run, states in zip(lives, pair, strict=True)]
            apart = np.flatnonzero(~(np.abs(curves[0] - curves[1]) <= APART))
            if apart.size:
                return begin + int(apart[0])
        return None

    return Departure(parting(False), parting(True))


def _compiled(brain: Brain) -> Any:
    """A function of a blank state, the readings it begins with, ticks, and whether it hears; returns all estimates."""
    space = machine_code(brain.functions)
    observe, fuse, estimate = space["observe"], space["fuse"], space["estimate"]
    hear, draw = exchange(brain, space)

    @numba.njit
    def run(states: Any, begin: int, ticks: int, hears: bool) -> Any:
        me = states[0]
        curve = np.empty(ticks + 1)
        black = 0.0
        draw(me, 0.5)
        if begin > 0:
            black = np.floor(BLACK * begin)
            observe(me, black, 1.0 * begin)
        fuse(me)
        curve[0] = estimate(me)
        for tick in range(1, ticks + 1):
            draw(me, PLASTIC * tick % 1.0)
            observe(me, 1.0 if GOLDEN * tick % 1.0 < BLACK else 0.0, 1.0)
            if hears:
                hear(me)
            fuse(me)
            curve[tick] = estimate(me)
        return curve

    return run
