"""One suite that any brain file can be run through: contract, fixed memory, finite outputs, one result."""

import math
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus import brains
from swarmcensus.bodies import Body
from swarmcensus.errors import InputError

ACCURACIES = (0.0, 0.3, 0.5, 0.75, 1.0)  # liars, the blind and the perfect among them
SEED = 20
CLOSE = 1e-12  # relative: the compiled exp and log of a brain may differ from CPython's in the last place


@dataclass(frozen=True)
class Check:
    """One check: what it asks for, and what is wrong (None where nothing is)."""

    name: str
    fault: str | None


class Fault(Exception):
    """What is wrong with a brain, in words."""


def check(path: str | Path) -> list[Check]:
    """Run a brain file through the suite; never raises for the brain's faults."""
    try:
        brain = brains.load(path)
    except InputError as error:
        return [Check("keeps the contract", str(error))]
    results = [Check("keeps the contract", None)]
    for name, test in CHECKS.items():
        if test is not _agree or results[-1].fault is None:  # nothing to compare where nothing compiles
            fault = _fault(test, brain)
            known = {c.fault for c in results}
            results.append(Check(name, "the same as above" if fault in known and fault else fault))
    return results


def _fault(test: Callable[[brains.Brain], None], brain: brains.Brain) -> str | None:
    try:
        with np.errstate(all="ignore"):
            test(brain)
    except Fault as fault:
        return str(fault)
    except AttributeError as error:
        hint = "; MEMORY names all that a robot remembers" if "Robot" in str(error) else ""
        return f"{_line(error, brain)}{error}{hint}"
    except Exception as error:
        return (
            f"{_line(error, brain)}{type(error).__name__}: {str(error).strip().splitlines()[0] if str(error) else ''}"
        )
    return None


def _line(error: Exception, brain: brains.Brain) -> str:
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(brain.path)]
    return f"line {frames[-1].lineno} ({frames[-1].line}): " if frames else ""


def _histories(brain: brains.Brain) -> Iterator[tuple[str, Any]]:
    """Minds at the end of short lives: all accuracies; floors all black, all white and mixed; talk or none."""
    functions = brain.functions
    random = np.random.default_rng(SEED)
    for b, w in product(ACCURACIES, ACCURACIES):
        for floor, share in (("all black", 1.0), ("all white", 0.0), ("mixed", 0.5)):
            for talk in (True, False):
                where = f"b = {b}, w = {w}, readings {floor}, {'with' if talk else 'without'} neighbours"
                me, other = brain.robot(b, w), brain.robot(0.8, 0.7)
                yield f"{where}, before the first observation", me
                for looks in (1.0, 1.0, 10.0, 1000.0):
                    for mind in (me, other):
                        functions.observe(mind, float(random.binomial(int(looks), share)), looks)
                    if talk:
                        functions.receive(me, functions.broadcast(other))
                        functions.receive(me, functions.broadcast(brain.robot(b, w)))  # knows nothing yet
                    functions.fuse(me)
                    yield where, me


def _compiles(brain: brains.Brain) -> None:
    from swarmcensus.engine import compiler

    kernel = compiler.compile_brain(brain)
    blank = compiler.blank(brain)
    history = np.empty((2, 2), blank.dtype)
    nobody = np.zeros(0, np.uint32)
    sure = np.full(2, 0.9)
    try:
        kernel.follow(blank, sure, sure, np.ones((1, 2)), 1, True, np.zeros(1, np.int64), nobody, nobody, history)
        kernel.believe(history, np.empty((2, 2)))
        if brain.steers:
            _wishes(brain, history[0])
    except (ArithmeticError, ValueError):
        pass  # it compiles; what it does is for other checks
    except Exception as error:
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        said = [line for line in lines if not line.startswith(("File", "During", "Failed in", "[1]"))]
        where = [line for line in lines if line.startswith("File") and "brain.py" in line]
        line = f" (line {where[-1].split('line')[-1].strip(' :')})" if where else ""
        raise Fault(f"Numba cannot compile it{line}: {' '.join(said[:2]) or error}") from error


def _fixed_memory(brain: brains.Brain) -> None:
    for where, me in _histories(brain):
        for name in brain.memory:
            value = getattr(me, name)
            if not isinstance(value, int | float) or isinstance(value, bool):
                raise Fault(f"me.{name} became {value!r}, not a number ({where})")


def _finite(brain: brains.Brain) -> None:
    for where, me in _histories(brain):
        x = brain.functions.estimate(me)
        if not (isinstance(x, int | float) and 0.0 <= x <= 1.0):
            raise Fault(f"estimate gives {x!r}, not a number in [0, 1] ({where})")
        message = brain.functions.broadcast(me)
        if not isinstance(message, tuple) or len(message) != len(brain.message):
            raise Fault(f"broadcast gives {message!r}, not a tuple of {len(brain.message)} as MESSAGE says ({where})")
        for name, value in zip(brain.message, message, strict=True):
            if not (isinstance(value, int | float) and math.isfinite(value)):
                raise Fault(f"broadcast gives {name} = {value!r}, not a finite number ({where})")


def _steers(brain: brains.Brain) -> None:
    if not brain.steers:
        return
    for where, me in _histories(brain):
        wish = brain.functions.steer(me)
        if not _is_wish(wish):
            raise Fault(f"steer gives {wish!r}, neither two finite numbers, a speed and a turn, nor None ({where})")


def _is_wish(wish: object) -> bool:
    def finite(value: object) -> bool:  # for the engine, that is below 1e300
        return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300

    return wish is None or (isinstance(wish, tuple) and len(wish) == 2 and all(map(finite, wish)))


def _wishes(brain: brains.Brain, minds: np.ndarray) -> np.ndarray:
    """What compiled minds (robot) want, (what, robot): whether anything, speed and turn, on wheels without a limit."""
    from swarmcensus.engine import compiler

    body = Body(tick=1.0).numbers
    body["step"] = body["turn"] = np.inf
    wishes = np.empty((3, len(minds)))
    compiler.compile_brain(brain, "riding").wish(minds, body, wishes)
    return wishes


def _reads_only(brain: brains.Brain) -> None:
    for where, me in _histories(brain):
        before = {name: getattr(me, name) for name in brain.memory}
        for name in ("broadcast", "estimate", *(("steer",) if brain.steers else ())):
            getattr(brain.functions, name)(me)
            changed = [k for k in before if getattr(me, k) != before[k]]
            if changed:
                raise Fault(f"{name} changes me.{changed[0]}: it may only read ({where})")


def _agree(brain: brains.Brain) -> None:
    from swarmcensus.traces import infer

    random = np.random.default_rng(SEED)
    b, w = (np.array(side) for side in zip(*product(ACCURACIES, ACCURACIES), strict=True))
    robots = len(b)
    readings = (random.random((60, robots)) < random.random(robots)).astype(float)
    readings[random.random(readings.shape) < 0.1] = np.nan
    ring = np.stack([np.arange(robots), (np.arange(robots) + 1) % robots], axis=1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # some of these sensors are blind, and meant to be
        fast = infer(readings, ring, (b, w), 5, brain)
        slow = infer(readings, ring, (b, w), 5, brain, compiled=False)
    for name in (*brain.memory, "estimate"):
        x, y = fast[name].values, slow[name].values
        far = ~np.isclose(x, y, rtol=CLOSE, atol=CLOSE, equal_nan=True)
        if far.any():
            k, i = np.argwhere(far)[0]
            raise Fault(
                f"compiled, {name} is {x[k, i]!r} and in CPython {y[k, i]!r} "
                f"(b = {b[i]}, w = {w[i]}, round {k} of a random history)"
            )
    if brain.steers:
        _wishes_agree(brain, slow, b, w)


def _wishes_agree(brain: brains.Brain, trace: xr.Dataset, b: np.ndarray, w: np.ndarray) -> None:
    from swarmcensus.engine import compiler

    for k in range(trace.sizes["round"]):
        minds = np.empty(len(b), compiler.record_type(brain))
        said = []
        for i in range(len(b)):
            me = brain.robot(float(b[i]), float(w[i]))
            for name in brain.memory:
                setattr(me, name, float(trace[name].values[k, i]))
            minds[i] = tuple(getattr(me, name) for name in minds.dtype.names or ())
            said.append(brain.functions.steer(me))
        if not all(map(_is_wish, said)):
            return  # which is another check's to say
        fast = _wishes(brain, minds).T
        for i, wish in enumerate(said):
            slow = (0.0, 0.0, 0.0) if wish is None else (1.0, *wish)
            if not np.allclose(fast[i], slow, rtol=CLOSE, atol=CLOSE):
                compiled = tuple(fast[i, 1:].tolist()) if fast[i, 0] else None
                raise Fault(
                    f"compiled, steer gives {compiled} and in CPython {wish} "
                    f"(b = {b[i]}, w = {w[i]}, round {k} of a random history)"
                )


def _sums_add(brain: brains.Brain) -> None:
    for name in brain.sums:
        if brain.memory[name] != 0.0:
            raise Fault(f"MEMORY[{name!r}] is {brain.memory[name]}: a field of SUMS starts at 0")
    if not brain.sums:
        return
    message = brain.functions.broadcast(brain.robot(0.8, 0.7))
    for where, me in _histories(brain):
        fresh = brain.robot(me.b, me.w)
        before = {k: getattr(me, k) for k in brain.memory}
        brain.functions.receive(me, message)
        brain.functions.receive(fresh, message)
        for name in brain.memory:
            added = getattr(me, name) - before[name]
            expected = getattr(fresh, name) - brain.memory[name] if name in brain.sums else 0.0
            if not math.isclose(added, expected, rel_tol=1e-9, abs_tol=1e-9 * max(1.0, abs(before[name]))):
                raise Fault(
                    f"receive adds {added!r} to me.{name}, {expected!r} to a blank mind: by SUMS it adds to "
                    f"{', '.join(brain.sums)} alone, and what it adds depends on the message alone ({where})"
                )
        message = brain.functions.broadcast(me)


CHECKS: dict[str, Callable[[brains.Brain], None]] = {
    "remembers numbers in MEMORY's fields, nothing else": _fixed_memory,
    "gives finite messages and estimates in [0, 1]": _finite,
    "steers by a speed and a turn, or not at all": _steers,
    "broadcast, estimate and steer only read": _reads_only,
    "SUMS only add up": _sums_add,
    "compiles": _compiles,
    "CPython and machine code agree": _agree,
}
