"""Long lives of a swarm in double or single precision: a ring with two neighbours on each side, compiled."""

import types

import numba
import numpy as np

from swarmcensus.brains.float32 import ROUND, rounded_to_single
from swarmcensus.brains.packing import Numbers
from swarmcensus.engine.codegen import record_fields


def median_error(brain, precision, ticks, loss, robots=20, b=0.8, f=0.55, seed=1):
    """The median error of a swarm after so many ticks of one reading each; a share `loss` of the messages is lost."""
    brain = brain.with_numbers(Numbers(precision))
    states = np.zeros(robots, record_fields(brain))
    for name, value in {**brain.memory, **brain.parameters}.items():
        states[name] = value
    states["b"] = states["w"] = rounded_to_single(b) if precision == "single" else b
    if brain.uses.name:
        states["name"] = np.arange(robots)
    return float(np.median(np.abs(_compiled(brain)(states, ticks, f, b, loss, np.random.default_rng(seed)) - f)))


def _compiled(brain):
    space = dict(vars(brain.functions))
    for name, function in space.items():
        if isinstance(function, types.FunctionType):
            plain = types.FunctionType(function.__code__, space, name)
            space[name] = numba.njit((lambda x: np.float64(np.float32(x))) if name == ROUND else plain)
    observe, broadcast, receive, fuse, estimate = (
        space[name] for name in ("observe", "broadcast", "receive", "fuse", "estimate")
    )

    @numba.njit
    def recording(states, ticks, f, b, loss, chance):
        robots = states.size
        said = [broadcast(states[0]) for _ in range(robots)]
        for _ in range(ticks):
            for i in range(robots):
                right = chance.random() < b
                black = chance.random() < f
                observe(states[i], 1.0 if black == right else 0.0, 1.0)
            for i in range(robots):
                said[i] = broadcast(states[i])
            for i in range(robots):
                for j in (i - 2, i - 1, i + 1, i + 2):
                    if chance.random() >= loss:
                        receive(states[i], said[j % robots])
            for i in range(robots):
                fuse(states[i])
        return np.array([estimate(states[i]) for i in range(robots)])

    return recording
