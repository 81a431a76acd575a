"""Inference from recorded data: a brain's states after every round, in machine code or in CPython."""

import itertools
import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus import brains
from swarmcensus.engine import address, compiler, interruptible
from swarmcensus.engine.constants import SLACK
from swarmcensus.simulation import reference
from swarmcensus.simulation.blame import NO_ESTIMATE
from swarmcensus.simulation.recorded import Readings, readings_of
from swarmcensus.simulation.swarming import fields_of, swarm
from swarmcensus.simulation.traces import Trace
from swarmcensus.studies import KEYS
from swarmcensus.support.errors import BrainError, InputError
from swarmcensus.support.read_table import Table, frame_table, is_frame
from swarmcensus.worlds import edges_of_matrix, from_one, links_of, unlinked


def warn_of_estimates(name: str, estimates: np.ndarray) -> None:
    """Warn of the first estimate (round, robot) that is no number in [0, 1]: a trace shows what a run refuses."""
    for tick, robot in np.argwhere(~((estimates >= -SLACK) & (estimates <= 1.0 + SLACK)))[:1]:
        what = f"robot {robot}, after round {tick}: estimate gives {estimates[tick, robot]:.9g}: {NO_ESTIMATE}"
        warnings.warn(f"brain {name!r}, {what}", stacklevel=3)


def infer(
    observations: Any,
    links: Any = None,
    accuracy: Any = None,
    observations_per_round: int | None = None,
    brain: str | Path | brains.Brain = "minimalistic",
    compiled: bool = True,
    *,
    time: str | None = None,
    robot: str | None = None,
    reading: str | None = None,
    period: float | None = None,
) -> xr.Dataset:
    """Run a brain on recorded observations and links instead of a simulated world, and return a trace.

    - `observations`: array (step, robot) of 0 (white) and 1 (black), NaN for no observation (in a masked array also
      what is masked); or a data frame with the columns of a file. Robots with names are labels of the trace.
    - `links`: undirected edges (edge, 2) along which robots exchange messages at the end of every round, or rows
      (message, 3) of step, sender and receiver, each heard at its step; or a data frame with the columns of a file;
      None for robots that never communicate.
    - `accuracy`: a number or an array (robot,), in the trace's order; or these as {"black": ..., "white": ...}.
    - `observations_per_round`: steps in a round, by default 10 with edges and 1 with messages. Steps left over form a
      last round without messages.
    - `compiled=False`: CPython runs the brain file itself, slowly and with the same numbers.
    - `time`, `robot`, `reading`: columns of a data frame whose names do not say it; `period`: the seconds of a step,
      for times in seconds or timestamps.

    Raises InputError.
    """
    seen = observations
    if is_frame(observations):
        seen = readings_of(frame_table(observations, "observations"), time, robot, reading, period)
        for note in seen.notes:
            warnings.warn(f"observations: {note}", stacklevel=2)
    elif isinstance(observations, str | os.PathLike):
        what = f"{observations} is a file: give what pandas.read_csv reads, or an array"
        raise InputError.within("observations", what, "observations")
    elif given := [name for name in (time, robot, reading, period) if name is not None]:
        raise InputError(f"{given[0]!r}: time, robot, reading and period are for data frames", key="observations")
    elif not isinstance(observations, Readings):
        seen = Readings(_readings(observations))
    readings, robots = seen.values, seen.values.shape[1]
    b, w = _accuracies(accuracy, robots)
    if (np.abs(b + w - 1.0) < 1e-12).any():
        blind = "a sensor with b + w = 1 carries no information: it says the same of black and white"
        warnings.warn(blind, stacklevel=2)
    rows = _rows(links, seen)
    periodic = rows.shape[1] == 2
    _check_robots(rows, slice(0, 2) if periodic else slice(1, 3), robots)
    if periodic:
        pairs, first = np.unique(np.concatenate([rows, rows[:, ::-1]]), axis=0), np.zeros(1, np.int64)
    else:
        pairs, first = _messages(rows, len(readings))
    if rows.size and (said := unlinked(robots, pairs)):
        warnings.warn(f"links: {said}", stacklevel=2)
    default = KEYS["observations_per_round"].default if periodic else 1
    every = default if observations_per_round is None else observations_per_round
    if isinstance(every, bool) or not isinstance(every, int | np.integer) or every < 1:
        raise InputError.at("observations_per_round", repr(every), "should be a whole number from 1")
    used = brain if isinstance(brain, brains.Brain) else brains.load(brain)
    draws = np.concatenate([address(0, "luck", recorded=True), address(0, "luck of messages", recorded=True)])
    if compiled:
        shape = (-(-len(readings) // every) + 1, robots)
        layout = compiler.array_layout(used)
        history, estimates = np.empty((*shape, layout.record.itemsize), np.uint8), np.empty(shape)
        outbox = np.zeros((robots, layout.message_bytes), np.uint8)
        signals = np.zeros(robots if layout.is_signalled else 0, np.uint8)
        receivers, senders = (np.ascontiguousarray(pairs[:, k], np.uint32) for k in (0, 1))
        try:
            swarmed = swarm((used,), np.zeros(robots, np.int64), "recorded", draws)
            follow, ways = interruptible(compiler.compile_world("kernel").follow), (periodic, first, senders, receivers)
            follow(swarmed, outbox, signals, (b, w), readings, int(every), *ways, used.ends, history, estimates)
            fields = fields_of((used,), swarmed, history, estimates)
        except Exception as error:
            what = f"brain {used.name!r} fails: {type(error).__name__}: {error}"
            raise BrainError(what, key="brain", value=used.name) from error
    else:
        steps = itertools.repeat(pairs, len(readings)) if periodic else iter(np.split(pairs, first[1:-1]))
        fields, estimates = reference.follow(used, b, w, readings, int(every), periodic, steps, draws)
    warn_of_estimates(used.name, estimates)
    trace = Trace(estimates, fields, seen.labels or range(robots)).dataset()
    trace.attrs |= {"brain": used.name, "title": f"{used.name} on recorded data", "observations_per_round": int(every)}
    return trace


def _unmasked(values: Any) -> Any:
    """The values of an array, with NaN for those that are masked."""
    return np.ma.filled(values.astype(np.float64), np.nan) if isinstance(values, np.ma.MaskedArray) else values


def _readings(observations: Any) -> np.ndarray:
    try:
        readings = np.ascontiguousarray(_unmasked(observations), np.float64)
    except (TypeError, ValueError):
        raise InputError("observations: should be an array of 0, 1 and NaN", key="observations") from None
    if readings.ndim != 2 or 0 in readings.shape:
        shape = f"observations of shape {readings.shape}"
        raise InputError(f"{shape}: should be (step, robot), one of each at least", key="observations")
    wrong = ~(np.isnan(readings) | (readings == 0.0) | (readings == 1.0))
    if wrong.any():
        step, robot = np.argwhere(wrong)[0]
        found = f"{readings[step, robot]:g}"
        raise InputError.at(f"observations[{step}, {robot}]", found, "should be 0 (white), 1 (black) or NaN (none)")
    return readings


def _accuracies(accuracy: Any, robots: int) -> tuple[np.ndarray, np.ndarray]:
    if accuracy is None:
        must = 'how good the sensors are must be said: a number, or {"black": ..., "white": ...}'
        raise InputError(f"accuracy: {must}", key="accuracy")
    sides = accuracy if isinstance(accuracy, Mapping) else {"black": accuracy, "white": accuracy}
    if {*sides} != {"black", "white"}:
        keys = ", ".join(map(str, sides))
        raise InputError(f"accuracy has the keys {keys}: should be black and white", key="accuracy", value=keys)
    out = []
    for side in (sides["black"], sides["white"]):
        try:
            values = np.asarray(_unmasked(side), np.float64)
            if values.shape not in ((), (robots,)):
                raise ValueError
            values = np.array(np.broadcast_to(values, (robots,)))
        except (TypeError, ValueError):
            should = f"should be a number or one for each of {robots:,} robots"
            raise InputError(f"accuracy of shape {np.shape(side)}: {should}", key="accuracy") from None
        wrong = values[~((values >= 0.0) & (values <= 1.0))]
        if wrong.size:
            raise InputError(f"accuracy {wrong[0]:g}: should lie in [0, 1]", key="accuracy", value=float(wrong[0]))
        out.append(values)
    return out[0], out[1]


def rows_of(table: Table, readings: Readings) -> np.ndarray:
    """Edges (edge, 2) of a table, or messages (message, 3) as step, sender, receiver. Raises InputError."""
    links = links_of(edges_of_matrix(table, False)[0], messages=True)
    steps = [readings.steps(links.table, links.step)] if links.step else []
    return np.stack([*steps, *(readings.robots(links.table, name) for name in links.ends)], axis=1)


def _rows(links: Any, readings: Readings) -> np.ndarray:
    """Edges (edge, 2), or messages (message, 3)."""
    if links is None:
        return np.zeros((0, 2), np.int64)
    if is_frame(links):
        return rows_of(frame_table(links, "links"), readings)
    try:
        rows = np.asarray(_unmasked(links))
        with np.errstate(invalid="ignore"):
            whole = rows.astype(np.int64)
        if rows.size and (rows.dtype == bool or not (whole == rows).all()):
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise InputError("links: should be an array of whole numbers", key="links") from None
    if not whole.size:
        return np.zeros((0, 2), np.int64)
    if whole.ndim != 2 or whole.shape[1] not in (2, 3):
        raise InputError(f"links of shape {whole.shape}: should be (edge, 2) or (message, 3)", key="links")
    if whole.shape == (3, 3) and whole.max() <= 1 and (whole == whole.T).all():
        raise InputError("links look like a matrix of who hears whom: give edges, np.argwhere(links)", key="links")
    return whole


def _check_robots(rows: np.ndarray, columns: slice, robots: int) -> None:
    wrong = ((rows[:, columns] < 0) | (rows[:, columns] >= robots)).any(axis=1)
    if wrong.any():
        key, row = f"links[{np.argmax(wrong)}]", rows[np.argmax(wrong)].tolist()
        there = f"the robots are numbered 0 to {robots - 1}{from_one(rows[:, columns])}"
        raise InputError(f"{key} = {row} names a robot that is not there: {there}", key=key, value=row)
    loops = rows[:, columns][:, 0] == rows[:, columns][:, 1]
    if loops.any():
        key = f"links[{int(np.argmax(loops))}]"
        raise InputError(f"{key} joins a robot to itself", key=key)


def _messages(rows: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of receiver and sender, ordered by step, and the first pair of each step."""
    late = (rows[:, 0] < 0) | (rows[:, 0] >= steps)
    if late.any():
        k = int(np.argmax(late))
        raise InputError.at(f"links[{k}]", rows[k].tolist(), f"the steps are numbered 0 to {steps - 1}")
    rows = rows[np.lexsort((rows[:, 1], rows[:, 2], rows[:, 0]))]
    first = np.searchsorted(rows[:, 0], np.arange(steps + 1))
    return rows[:, [2, 1]], first.astype(np.int64)
