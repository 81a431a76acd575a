"""Checks whether a brain compiles, and whether machine code and CPython agree."""

import warnings
from itertools import product

import numpy as np
import xarray as xr

from swarmcensus.brains import Brain, Vector
from swarmcensus.checks.contract_checks import is_command
from swarmcensus.checks.sample_states import ACCURACIES, SEED, Violation
from swarmcensus.engine import compiler, interruptible
from swarmcensus.engine.constants import DRAW_STEER
from swarmcensus.simulation import infer, reference, swarm
from swarmcensus.support.errors import without_colours
from swarmcensus.worlds import Body

CLOSE = 1e-12  # relative: compiled exp and log may differ from CPython's in the last digit
EVERY = 5  # readings per round
KEYS = np.arange(1, 5, dtype=np.uint64)  # two keys


def compiles(brain: Brain) -> None:
    """Compile all that `agrees` runs, without running it. Raises Violation."""
    uses = ("recorded", "moving") if brain.steers else ("recorded",)
    try:
        try:
            for use in uses:
                compiler.compile_brain(brain, use)
        except compiler.NotCompiled:  # compiles again, to find the line
            for use in uses:
                compiler.compile_brain(brain, use, exact=True)
    except Exception as error:
        lines = [line.strip() for line in without_colours(error).splitlines() if line.strip()]
        message_lines = [line for line in lines if not line.startswith(("File", "During", "Failed in", "[1]"))]
        where = [line for line in lines if line.startswith("File") and "brain.py" in line]
        line = f" (line {where[-1].split('line')[-1].strip(' :')})" if where else ""
        said = " ".join(message_lines[:2]) or type(error).__name__
        raise Violation(f"Numba cannot compile it{line}: {said}") from error


def history() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Accuracies b and w of 25 robots on a ring, their readings (step, robot; NaN if none) and the ring's links."""
    random = np.random.default_rng(SEED)
    b, w = (np.array(side) for side in zip(*product(ACCURACIES, ACCURACIES), strict=True))
    robots = len(b)
    readings = (random.random((60, robots)) < random.random(robots)).astype(float)
    readings[random.random(readings.shape) < 0.1] = np.nan
    return b, w, readings, np.stack([np.arange(robots), (np.arange(robots) + 1) % robots], axis=1)


def agrees(brain: Brain) -> None:
    """Run a random history in CPython and in machine code; both must agree. Raises Violation."""
    b, w, readings, ring = history()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # some of these sensors are blind on purpose
        slow = infer(readings, ring, {"black": b, "white": w}, EVERY, brain, compiled=False)
        fast = infer(readings, ring, {"black": b, "white": w}, EVERY, brain)
    for name in (*(str(name) for name in slow.data_vars if name != "estimate"), "estimate"):
        x, y = fast[name].values, slow[name].values
        far = ~np.isclose(x, y, rtol=CLOSE, atol=CLOSE, equal_nan=True)
        if far.any():
            k, i, *item = np.argwhere(far)[0]
            place = "".join(f"[{index}]" for index in item)
            raise Violation(
                f"compiled, {name}{place} is {x[k, i, *item]!r} and in CPython {y[k, i, *item]!r} "
                f"(b = {b[i]}, w = {w[i]}, round {k} of a random history)"
            )
    if brain.steers:
        commands_agree(brain, slow, b, w)


@interruptible
def commands_of(brain: Brain, states: np.ndarray) -> np.ndarray:
    """How states, records (robot), steer, compiled, without limits of wheels.

    Returns (3, robot): whether they steer at all, speed, turn.
    """
    body = Body(tick=1.0).numbers
    body["step"] = body["turn"] = np.inf
    commands = np.empty((3, len(states)))
    made = swarm((brain,), np.zeros(len(states), np.int64), "moving", KEYS)
    memory = states.view(np.uint8).reshape(len(states), -1)
    compiler.compile_world("riding").steer(made, memory, body, np.full(len(states), np.inf), 0, 1, commands)
    return commands


def commands_agree(brain: Brain, trace: xr.Dataset, b: np.ndarray, w: np.ndarray) -> None:
    """Compare how the states of a trace (round, robot) steer in CPython and in machine code. Raises Violation."""
    draws = reference.own_draws(KEYS, 0, 1, DRAW_STEER, len(b))
    for k in range(trace.sizes["round"]):
        states = np.zeros(len(b), compiler.array_layout(brain).record)
        commands = []
        for i in range(len(b)):
            me = brain.robot(float(b[i]), float(w[i]), float(i))
            for name, long in brain.lengths.items():
                value = trace[name].values[k, i].tolist()
                setattr(me, name, Vector(value) if long else value)
            reference.give(brain, me, draws, i)
            for name in me.__slots__:
                states[name][i] = getattr(me, name)
            commands.append(brain.functions.steer(me))
        if not all(map(is_command, commands)):
            return  # another check reports this
        fast = commands_of(brain, states).T
        for i, command in enumerate(commands):
            slow = (0.0, 0.0, 0.0) if command is None else (1.0, *command)
            if not np.allclose(fast[i], slow, rtol=CLOSE, atol=CLOSE):
                compiled = tuple(fast[i, 1:].tolist()) if fast[i, 0] else None
                raise Violation(
                    f"compiled, steer gives {compiled} and in CPython {command} "
                    f"(b = {b[i]}, w = {w[i]}, round {k} of a random history)"
                )
