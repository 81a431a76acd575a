"""How long a brain lives in single precision: the reading at which its estimate leaves that of double precision.

Two minds of one brain, one in double and one in single precision, make the same readings, one a tick. They live once
alone, and once hearing a neighbour that is in the same state as they are. Beyond a day, minds begin with a large number
of readings at once, so that counts come to the end of what float32 can count.
"""

import itertools
import json
import types
from typing import Any, NamedTuple

import numba
import numpy as np

from swarmcensus import brains
from swarmcensus.brains import FUNCTIONS, Brain
from swarmcensus.brains.packing import Numbers
from swarmcensus.brains.single import ROUND, rounded_to_single
from swarmcensus.conformance.single_lives import TABLE
from swarmcensus.engine.codegen import record_fields
from swarmcensus.engine.return_values import spoken

DAY = 864_000  # readings at 10 Hz
APART = 0.01  # estimates that differ by more have parted
ACCURACY = 0.8  # b and w
BLACK = 0.53  # the share of readings that say black: that of a floor of which 55 % is black
POWERS = range(20, 27)  # of two: readings at which lives beyond a day begin
FURTHER = 1 << 19  # ticks lived from there
GOLDEN, PLASTIC = 0.6180339887498949, 0.7548776662466927  # multiples of these modulo 1 are evenly spread


class Life(NamedTuple):
    """The reading at which single and double precision part; None if they stay together."""

    alone: int | None
    hearing: int | None

    @property
    def first(self) -> int | None:
        """The earlier one."""
        return min((at for at in self if at is not None), default=None)


def life(brain: Brain, readings: int = DAY, beyond: bool = False) -> Life:
    """Live a brain for so many readings, and `beyond` that also from 2^20, 2^21, ..., 2^26 readings on.

    Takes seconds, in which the brain is compiled. Raises what the brain raises, and Numba's errors.
    """
    double = brain.with_numbers(Numbers("double"))
    single = brain.with_numbers(Numbers("single"))
    lives = [_compiled(one) for one in (double, single)]
    begins = [(0, readings), *((1 << power, FURTHER) for power in POWERS if beyond and 1 << power > readings)]

    def parting(hears: bool) -> int | None:
        for begin, ticks in begins:
            pair = [_blank(one) for one in (double, single)]
            curves = [run(minds, begin, ticks, hears) for run, minds in zip(lives, pair, strict=True)]
            apart = np.flatnonzero(~(np.abs(curves[0] - curves[1]) <= APART))
            if apart.size:
                return begin + int(apart[0])
        return None

    return Life(parting(False), parting(True))


def _blank(brain: Brain) -> np.ndarray:
    """One blank mind, shape (1,)."""
    minds = np.zeros(1, record_fields(brain))
    for name, value in {**brain.memory, **brain.parameters}.items():
        minds[name] = value
    single = brain.numbers.precision == "single"
    minds["b"] = minds["w"] = rounded_to_single(ACCURACY) if single else ACCURACY
    return minds


def _compiled(brain: Brain) -> Any:
    """A function of a blank mind, the readings it begins with, ticks, and whether it hears; returns all estimates."""
    space = dict(vars(brain.functions))
    for name, function in space.items():
        if isinstance(function, types.FunctionType):
            plain = types.FunctionType(function.__code__, space, name)
            space[name] = numba.njit(_rounded if name == ROUND else plain)
    lived: dict[str, Any] = {name: space[name] for name in FUNCTIONS} | {"spoken": spoken}
    exec(_exchange(brain), lived)
    observe, fuse, estimate, hear = lived["observe"], lived["fuse"], lived["estimate"], numba.njit(lived["hear"])
    lucky = numba.njit(lived["lucky"])

    @numba.njit
    def run(minds: Any, begin: int, ticks: int, hears: bool) -> Any:
        me = minds[0]
        curve = np.empty(ticks + 1)
        black = 0.0
        lucky(me, 0.5)
        if begin > 0:
            black = np.floor(BLACK * begin)
            observe(me, black, 1.0 * begin)
        fuse(me)
        curve[0] = estimate(me)
        for tick in range(1, ticks + 1):
            lucky(me, PLASTIC * tick % 1.0)
            observe(me, 1.0 if GOLDEN * tick % 1.0 < BLACK else 0.0, 1.0)
            if hears:
                hear(me)
            fuse(me)
            curve[tick] = estimate(me)
        return curve

    return run


def _rounded(x: Any) -> Any:
    return np.float64(np.float32(x))


def _exchange(brain: Brain) -> str:
    """The source of `hear`, in which a mind hears what it says, and of `lucky`, which sets its luck."""
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
    lines += [f"receive(me, ({''.join(f'{part}, ' for part in heard)}))"]
    luck = "me.luck = x" if brain.uses.luck else "pass"
    return "\n    ".join(["def hear(me):", *lines]) + f"\n\n\ndef lucky(me, x):\n    {luck}\n"


def main() -> None:
    """Live all shipped brains and write their table; takes minutes."""
    lives = {name: life(brains.load(name), beyond=True).first for name in brains.shipped()}
    TABLE.write_text(json.dumps(lives, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
