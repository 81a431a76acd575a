"""How long a brain lives in single precision: the reading at which its estimate leaves that of double precision.

Two robots with one brain, one in double and one in single precision, make the same readings, one a tick. They run once
alone, and once with a neighbour in their own state.
"""

import itertools
import types
from typing import NamedTuple

import numba
import numpy as np

from swarmcensus.brains import ROUND, Numbers, rounded_to_single
from swarmcensus.engine import make_strict, record_fields, spoken

DAY = 864_000  # readings at 10 Hz
APART = 0.01  # estimates that differ by more have parted
ACCURACY = 0.8  # b and w
BLACK = 0.53  # the share of readings that say black: that of a floor of which 55 % is black
GOLDEN, PLASTIC = 0.6180339887498949, 0.7548776662466927  # multiples of these modulo 1 are evenly spread
WITHIN = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}  # of what compiled code alone calls: a third less work


class Departure(NamedTuple):
    """The reading at which single and double precision part; None if they stay together."""

    alone: int | None
    hearing: int | None


def life(brain, spans=((0, DAY),)):
    """Live a brain for spans of ticks: each begins with so many readings at once, and then has so many ticks.

    Takes seconds, in which the brain is compiled. Raises what the brain raises, and Numba's errors.
    """
    double, single = (brain.with_numbers(Numbers(precision)) for precision in ("double", "single"))
    lives = [_compiled(double), _compiled(single)]

    def parting(hears):
        for begin, ticks in spans:
            accuracy = rounded_to_single(ACCURACY)
            pair = [blank_state(double, ACCURACY, ACCURACY), blank_state(single, accuracy, accuracy)]
            curves = [run(states, begin, ticks, hears) for run, states in zip(lives, pair, strict=True)]
            apart = np.flatnonzero(~(np.abs(curves[0] - curves[1]) <= APART))
            if apart.size:
                return begin + int(apart[0])
        return None

    return Departure(parting(False), parting(True))


def _compiled(brain):
    """A function of a blank state, the readings it begins with, ticks, and whether it hears; returns all estimates."""
    space = machine_code(brain.functions, **WITHIN)
    observe, fuse, estimate = space["observe"], space["fuse"], space["estimate"]
    hear, draw = exchange(brain, space)

    @numba.njit
    def run(states, begin, ticks, hears):
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


def machine_code(module, **options):
    """What a brain's or the codec's module holds, by name, with functions that Numba compiles when they are called."""
    own = types.ModuleType(module.__name__)
    vars(own).update(vars(module))
    make_strict(own)  # which also has functions of math that Numba lacks
    space = vars(own)
    for name, function in list(space.items()):
        if isinstance(function, types.FunctionType):
            plain = types.FunctionType(function.__code__, space, name)
            space[name] = numba.njit(_rounded if name == ROUND else plain, **options)
    return space


def blank_state(brain, b, w, name=0.0):
    """One blank state as a record, shape (1,)."""
    state = np.zeros(1, record_fields(brain))
    for field, value in (brain.memory | brain.parameters | {"b": b, "w": w}).items():
        state[field] = value
    if brain.uses.name:
        state["name"] = name
    return state


def exchange(brain, space, times=1):
    """`hear(me)`: a robot hears so many times what it says; and `draw(me, x)`, which sets its random number."""
    made = {name: space[name] for name in ("broadcast", "receive")} | {"spoken": spoken}
    exec(_source(brain, times), made)
    return numba.njit(made["hear"], **WITHIN), numba.njit(made["draw"], **WITHIN)


def _rounded(x):
    return np.float64(np.float32(x))


def _source(brain, times):
    ends = list(itertools.accumulate((max(long, 1) for long in brain.message.values()), initial=0))
    blank = "".join(f"{(0.0,) * long if long else 0.0}, " for long in brain.message.values())
    lines = [f"there, said = spoken(broadcast(me), ({blank}))", "if not there:", "    return"]
    lines += [f"{''.join(f'said_{k}, ' for k, _ in enumerate(brain.message))} = said"]
    heard = []
    for k, (start, long) in enumerate(zip(ends, brain.message.values(), strict=False)):
        copies = [f"1.0 * said_{k}[{j}]" for j in range(long)] if long else [f"1.0 * said_{k}"]
        lines += [f"number_{start + j} = {copy}" for j, copy in enumerate(copies)]
        names = [f"number_{start + j}" for j, _ in enumerate(copies)]
        heard.append(f"({''.join(f'{name}, ' for name in names)})" if long else names[0])
    lines += [f"receive(me, ({''.join(f'{part}, ' for part in heard)}))"] * times
    draws = "me.luck = x" if brain.uses.luck else "pass"
    return "\n    ".join(["def hear(me):", *lines]) + f"\n\n\ndef draw(me, x):\n    {draws}\n"
