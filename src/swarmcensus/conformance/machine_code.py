"""Whether a brain compiles, and whether machine code and CPython agree."""

import types
import warnings
from collections.abc import Callable
from itertools import product
from typing import Any

import numba
import numpy as np
import xarray as xr

from swarmcensus.basics.errors import without_colours
from swarmcensus.brains import FUNCTIONS, Brain, Vector, numbers
from swarmcensus.conformance.contract_checks import is_wish
from swarmcensus.conformance.sample_minds import ACCURACIES, SEED, Fault
from swarmcensus.engine import codegen, compiler
from swarmcensus.engine.compiling import INSIDE
from swarmcensus.engine.constants import LUCK_STEER
from swarmcensus.simulation import oracle
from swarmcensus.simulation.inferring import infer
from swarmcensus.simulation.swarming import swarm
from swarmcensus.worlds.bodies import Body

CLOSE = 1e-12  # relative: the compiled exp and log of a brain may differ from CPython's in the last place
EVERY = 5  # readings a round
LUCK = np.arange(1, 5, dtype=np.uint64)  # two keys


def compiles(brain: Brain) -> None:
    """Make machine code of all that `agrees` runs, and run none of it: what it does is for that check."""
    uses = ("recorded", "moving") if brain.steers else ("recorded",)
    try:
        try:
            for use in uses:
                compiler.compile_brain(brain, use)
        except compiler.NotCompiled:  # once more, for the line
            for use in uses:
                compiler.compile_brain(brain, use, exact=True)
    except MemoryError:
        raise
    except Exception as error:
        lines = [line.strip() for line in without_colours(error).splitlines() if line.strip()]
        said = [line for line in lines if not line.startswith(("File", "During", "Failed in", "[1]"))]
        where = [line for line in lines if line.startswith("File") and "brain.py" in line]
        line = f" (line {where[-1].split('line')[-1].strip(' :')})" if where else ""
        raise Fault(f"Numba cannot compile it{line}: {' '.join(said[:2]) or error}") from error


def history() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Accuracies b and w of 25 robots on a ring, their readings (step, robot; NaN where none) and its links."""
    random = np.random.default_rng(SEED)
    b, w = (np.array(side) for side in zip(*product(ACCURACIES, ACCURACIES), strict=True))
    robots = len(b)
    readings = (random.random((60, robots)) < random.random(robots)).astype(float)
    readings[random.random(readings.shape) < 0.1] = np.nan
    return b, w, readings, np.stack([np.arange(robots), (np.arange(robots) + 1) % robots], axis=1)


def agrees(brain: Brain) -> None:
    """Live a random history in CPython and in machine code."""
    b, w, readings, ring = history()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # some of these sensors are blind, and meant to be
        slow = infer(readings, ring, (b, w), EVERY, brain, compiled=False)
        fast = infer(readings, ring, (b, w), EVERY, brain)
    for name in (*(str(name) for name in slow.data_vars if name != "estimate"), "estimate"):
        x, y = fast[name].values, slow[name].values
        far = ~np.isclose(x, y, rtol=CLOSE, atol=CLOSE, equal_nan=True)
        if far.any():
            k, i, *item = np.argwhere(far)[0]
            place = "".join(f"[{one}]" for one in item)
            raise Fault(
                f"compiled, {name}{place} is {x[k, i, *item]!r} and in CPython {y[k, i, *item]!r} "
                f"(b = {b[i]}, w = {w[i]}, round {k} of a random history)"
            )
    if brain.steers:
        wishes_agree(brain, slow, b, w)


def wishes_of(brain: Brain, minds: np.ndarray) -> np.ndarray:
    """What minds (robot, field) want, compiled: (what, robot): whether anything, speed, turn; wheels have no limit."""
    body = Body(tick=1.0).numbers
    body["step"] = body["turn"] = np.inf
    wishes = np.empty((3, len(minds)))
    made = swarm((brain,), np.zeros(len(minds), np.int64), "moving", LUCK)
    compiler.compile_world("riding").steer(made, minds, body, np.full(len(minds), np.inf), 0, 1, wishes)
    return wishes


def wishes_agree(brain: Brain, trace: xr.Dataset, b: np.ndarray, w: np.ndarray) -> None:
    """Ask the minds of a trace (round, robot) where they want to go, in CPython and in machine code."""
    luck = oracle.own_luck(brain, LUCK, 0, 1, LUCK_STEER, len(b))
    for k in range(trace.sizes["round"]):
        minds = np.empty((len(b), compiler.array_layout(brain).mind_width))
        said = []
        for i in range(len(b)):
            me = brain.robot(float(b[i]), float(w[i]), float(i))
            for name, long in brain.lengths.items():
                value = trace[name].values[k, i].tolist()
                setattr(me, name, Vector(value) if long else value)
            oracle.give(brain, me, luck, i)
            minds[i] = numbers({n: tuple(v) if isinstance(v := getattr(me, n), list) else v for n in me.__slots__})
            said.append(brain.functions.steer(me))
        if not all(map(is_wish, said)):
            return  # which is another check's to say
        fast = wishes_of(brain, minds).T
        for i, wish in enumerate(said):
            slow = (0.0, 0.0, 0.0) if wish is None else (1.0, *wish)
            if not np.allclose(fast[i], slow, rtol=CLOSE, atol=CLOSE):
                compiled = tuple(fast[i, 1:].tolist()) if fast[i, 0] else None
                raise Fault(
                    f"compiled, steer gives {compiled} and in CPython {wish} "
                    f"(b = {b[i]}, w = {w[i]}, round {k} of a random history)"
                )


def step_by_step(brain: Brain) -> Callable[[], object]:
    """The same history in machine code, call by call, each printed before it is made: the last one is that which hangs.

    All is compiled before this returns, nothing run.
    """
    b, w, readings, ring = history()
    module = compiler.phases_of(brain)
    real = numba.float64
    kind = np.dtype((np.record, codegen.record_fields(brain)))  # what Numba takes: it asks a record for NumPy's `data`
    same: dict[int, tuple[Any, Any]] = {}  # of each mind: as the oracle has it, and as Numba takes it
    record = numba.from_dtype(kind)
    blank = tuple((0.0,) * long if long else 0.0 for long in brain.message.values())
    message = numba.typeof(blank)  # type: ignore[no-untyped-call]
    given = {"observe": (real, real), "receive": (message,)}

    def robot(b: float, w: float, name: float) -> Any:
        layout = compiler.array_layout(brain)
        minds = layout.records(layout.blank[np.newaxis].copy())
        minds["b"], minds["w"] = b, w
        if brain.uses.name:
            minds["name"] = name
        me = minds[0]
        same[id(me)] = me, minds.view(kind)[0]
        return me

    def told(name: str) -> Any:
        if name == "jam":  # compiled it is a part of what is said, and cannot be called
            function = brain.functions.jam
        else:
            inside = getattr(module, name)
            function = numba.jit(**inside.targetoptions | dict.fromkeys(INSIDE, False))(inside.py_func)
            function.compile((record, *given.get(name, ())))

        def one(me: Any, *values: Any) -> Any:
            print(f"{name}({', '.join(['me', *map(repr, values)])}) (b = {me.b}, w = {me.w})", flush=True)
            return function(me if name == "jam" else same[id(me)][1], *values)

        return one

    more = [name for name in ("decide", "done", "interval", "jam") if name in brain.contents.functions]
    functions = types.SimpleNamespace(**{name: told(name) for name in (*FUNCTIONS, *more)})
    alike = {name: getattr(brain, name) for name in ("memory", "uses", "decides", "ends", "has_interval", "jams")}
    robots: Any = types.SimpleNamespace(functions=functions, robot=robot, **alike)
    links = [np.concatenate([ring, ring[:, ::-1]])] * len(readings)
    return lambda: oracle.follow(robots, b, w, readings, 1, EVERY, True, links, LUCK)
