"""A brain's functions as machine code, each to be called alone: the engine's loops have them joined."""

import itertools
import types
from typing import Any

import numba
import numpy as np

from swarmcensus.brains import ROUND, Brain
from swarmcensus.engine import make_strict, record_fields, spoken


def machine_code(module: types.ModuleType) -> dict[str, Any]:
    """What a brain's or the codec's module holds, by name, with functions that Numba compiles when they are called."""
    own = types.ModuleType(module.__name__)
    vars(own).update(vars(module))
    make_strict(own)  # which also has functions of math that Numba lacks
    space = vars(own)
    for name, function in list(space.items()):
        if isinstance(function, types.FunctionType):
            plain = types.FunctionType(function.__code__, space, name)
            space[name] = numba.njit(_rounded if name == ROUND else plain)
    return space


def blank_state(brain: Brain, b: float, w: float, name: float = 0.0) -> np.ndarray:
    """One blank state as a record, shape (1,)."""
    state = np.zeros(1, record_fields(brain))
    for field, value in (brain.memory | brain.parameters | {"b": b, "w": w}).items():
        state[field] = value
    if brain.uses.name:
        state["name"] = name
    return state


def exchange(brain: Brain, space: dict[str, Any], times: int = 1) -> tuple[Any, Any]:
    """`hear(me)`: a robot hears so many times what it says; and `draw(me, x)`, which sets its random number."""
    made: dict[str, Any] = {name: space[name] for name in ("broadcast", "receive")} | {"spoken": spoken}
    exec(_source(brain, times), made)
    return numba.njit(made["hear"]), numba.njit(made["draw"])


def _rounded(x: Any) -> Any:
    return np.float64(np.float32(x))


def _source(brain: Brain, times: int) -> str:
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
