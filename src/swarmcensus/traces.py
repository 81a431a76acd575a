"""Traces: every robot's mind after every round, of a simulated trial or of recorded data."""

import itertools
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus import arena, brains
from swarmcensus.engine import compiler, oracle
from swarmcensus.engine.modes import NEVER
from swarmcensus.engine.rides import record_ride
from swarmcensus.engine.trials import record_readings, record_trial
from swarmcensus.errors import InputError
from swarmcensus.faults import PARTS
from swarmcensus.origins import setting_of
from swarmcensus.results import load
from swarmcensus.settings import Setting
from swarmcensus.studies import Study

ROUND = {"units": "rounds", "long_name": "communication round; 0 is before any observation"}


def replay(
    results: xr.Dataset | str | Path, setting: int, trial: int, brain: str | Path | None = None, links: bool = False
) -> xr.Dataset:
    """One trial again, in full: dimensions round and robot, each field of the brain's memory, `estimate`.

    Of robots that move also `position` (axis; metres, the arena's centre at 0), `heading` (radians), `looked`
    (whether an observation was made), `tile` (the true colour under the sensor, 1 black), `reading` (NaN where
    none was made) and `neighbours` (robots heard), by tick; with `links`, `link` (link, 3) of tick, robot, robot;
    where robots fail, `stops` (part, robot), the first tick without moving, sensing or talking, -1 for never.

    `results` is a dataset or a results file, `setting` and `trial` are its coordinates. A brain that is not
    shipped with swarmcensus must be given as a file. The curves are those that the run measured, to the last
    bit. Raises InputError.
    """
    study, found = _find(results, setting, trial, brain)
    if found.body is not None:
        trace = _moving_trace(found, study.seed, trial, links)
    else:
        history, estimates, blacks = record_trial(found, study.seed, trial)
        trace = _trace({name: history[name] for name in found.brain.memory}, estimates, found.brain)
        trace["blacks"] = (("round", "robot"), blacks, {"long_name": "black readings in this round"})
    _check_same(results if isinstance(results, xr.Dataset) else load(results), setting, trial, trace)
    trace.attrs |= {
        "title": f"{study.name}, setting {setting}, trial {trial}: {found.brain.name}, {found}",
        "setting": setting,
        "trial": trial,
        "seed": study.seed,
        "fill_ratio": found.fill_ratio,
        "bins": study.measure.bins,
        "delta": study.measure.delta,
        "truth": study.measure.truth,
    }
    return trace


def _check_same(data: xr.Dataset, setting: int, trial: int, trace: xr.Dataset) -> None:
    """Raise InputError where a trial that was run ended otherwise: results put together from several studies."""
    stored = data["final_estimate"].sel(setting=setting, trial=trial).values[: trace.sizes["robot"]]
    ran = np.isfinite(stored).all() and len(stored) == trace.sizes["robot"]
    if ran and not np.allclose(stored, trace["estimate"].values[-1], rtol=0.0, atol=1e-9):
        raise InputError(
            f"setting {setting}, trial {trial}: the replay ends elsewhere than the run did: these results are not of "
            "the study that they name, or of another version"
        )


def _moving_trace(found: Setting, seed: int, trial: int, links: bool) -> xr.Dataset:
    assert found.body is not None
    assert found.density is not None
    ride = record_ride(found, seed, trial)
    trace = _trace({name: ride.history[name] for name in found.brain.memory}, ride.estimates, found.brain)
    dims = ("round", "robot")
    trace["position"] = ((*dims, "axis"), ride.poses[..., :2], {"units": "m", "long_name": "from the arena's centre"})
    trace["heading"] = (dims, ride.poses[..., 2], {"units": "rad"})
    trace["looked"] = (dims, ride.looked.astype(np.int8), {"long_name": "1 where an observation was made"})
    trace["tile"] = (dims, ride.colours, {"long_name": "the true colour under the ground sensor, 1 black"})
    trace["reading"] = (dims, ride.readings, {"long_name": "what the ground sensor said, 1 black"})
    heard = np.zeros(ride.looked.shape, np.int32)
    for side in (1, 2):
        np.add.at(heard, (ride.links[:, 0], ride.links[:, side]), 1)
    trace["neighbours"] = (dims, heard, {"long_name": "robots in reach and sight"})
    if links:
        trace["link"] = (("link", "end"), ride.links, {"long_name": "tick, robot, robot"})
    if found.faults:
        stops = found.stops(seed, trial)
        says = {"units": "ticks", "long_name": "first tick without moving, sensing, talking; -1: never"}
        trace["stops"] = (("part", "robot"), np.where(stops == NEVER, -1, stops), says)
        trace = trace.assign_coords(part=sorted(PARTS, key=PARTS.__getitem__))
    trace = trace.assign_coords(axis=["x", "y"])
    trace["round"].attrs = {"units": "ticks", "long_name": "tick; 0 is before any observation"}
    trace.attrs |= {
        "true_fill_ratio": ride.true_fill_ratio,
        "side": arena.side(found.robots, found.density, found.body),
        "radio_range": found.body.radio_range,
        "radius": found.body.radius,
        "tile_side": found.body.tile,
        "tick_seconds": found.body.tick,
    }
    return trace


def recording(
    results: xr.Dataset | str | Path, setting: int, trial: int, brain: str | Path | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """What the robots of one trial saw and who heard whom, as `infer` takes it.

    Returns readings (step, robot), 1 black, and undirected edges (edge, 2); of robots that move and of directed
    links, messages (message, 3) of step, sender, receiver. Raises InputError.
    """
    study, found = _find(results, setting, trial, brain)
    if found.link_success < 1.0 or found.faults or (found.body is not None and found.body.message_delay > 0):
        raise InputError("a recording tells neither lost nor late messages nor faults, which this setting has")
    if found.body is not None:
        ride = record_ride(found, study.seed, trial)
        tick, i, j = ride.links.T
        messages = np.concatenate([np.stack([tick - 1, i, j], axis=1), np.stack([tick - 1, j, i], axis=1)])
        return ride.readings[1:], messages[np.lexsort(messages.T[::-1])]
    links = found.links(study.seed, trial, 1)
    if links.senders.size or found.robots == 1 or found.topology.name != "full":
        pairs = np.stack([links.senders, links.receivers], axis=1).astype(np.int64)
        if not np.array_equal(pairs[np.lexsort(pairs.T)], pairs[np.lexsort(pairs.T[::-1])][:, ::-1]):
            steps = np.arange(1, found.rounds + 1) * found.observations_per_round - 1
            messages = np.column_stack([np.repeat(steps, len(pairs)), np.tile(pairs, (len(steps), 1))])
            return record_readings(found, study.seed, trial), messages
        edges = pairs[pairs[:, 0] > pairs[:, 1], ::-1]
    else:
        edges = np.array(list(itertools.combinations(range(found.robots), 2)))
    return record_readings(found, study.seed, trial), edges


def _find(
    results: xr.Dataset | str | Path, setting: int, trial: int, brain: str | Path | None
) -> tuple[Study, Setting]:
    data = results if isinstance(results, xr.Dataset) else load(results)
    known = data["trial"].values
    if trial not in known:
        raise InputError(f"trial {trial}: these results hold trial {known.min()} to {known.max()}")
    return setting_of(data, setting, brain)


def _trace(fields: dict[str, np.ndarray], estimates: np.ndarray, brain: brains.Brain) -> xr.Dataset:
    dims = ("round", "robot")
    trace = xr.Dataset(
        {name: (dims, np.ascontiguousarray(values)) for name, values in fields.items()},
        coords={"round": ("round", np.arange(len(estimates)), ROUND), "robot": np.arange(estimates.shape[1])},
    )
    trace["estimate"] = (dims, estimates, {"units": "1", "long_name": "the fill ratio that the robot believes in"})
    trace.attrs["brain"] = brain.name
    return trace


def infer(
    observations: Any,
    links: Any = None,
    accuracy: Any = None,
    observations_per_round: int | None = None,
    brain: str | Path | brains.Brain = "minimalistic",
    compiled: bool = True,
) -> xr.Dataset:
    """Run a brain on recorded observations and links instead of a simulated world; returns a trace.

    `observations`: array (step, robot) of 0 (white) and 1 (black), NaN where a robot made none. `links`: fixed
    undirected edges (edge, 2) along which all robots exchange at the end of every round, or (message, 3) rows
    of step, sender and receiver, each heard at its step; None for robots that never talk. `accuracy`: a number
    or an array (robot) where b = w, or a tuple (b, w) of such. A round is `observations_per_round` steps: by
    default 10 with edges and 1 with messages. Steps left over end in a last round without an exchange.
    With compiled=False CPython runs the brain file itself: slow, the same numbers. Raises InputError.
    """
    readings = _readings(observations)
    robots = readings.shape[1]
    b, w = _accuracies(accuracy, robots)
    if (np.abs(b + w - 1.0) < 1e-12).any():
        warnings.warn(
            "a sensor with b + w = 1 carries no information: it says the same of black and white", stacklevel=2
        )
    rows = np.zeros((0, 2), np.int64) if links is None else _whole_rows(links)
    periodic = rows.shape[1] == 2
    pairs, first = _edges(rows, robots) if periodic else _messages(rows, *readings.shape)
    every = observations_per_round if observations_per_round is not None else (10 if periodic else 1)
    if isinstance(every, bool) or not isinstance(every, int | np.integer) or every < 1:
        raise InputError(f"observations_per_round = {every!r}: should be a whole number from 1")
    used = brain if isinstance(brain, brains.Brain) else brains.load(brain)
    if compiled:
        blank = compiler.blank(used)
        kernel = compiler.compile_brain(used)
        history = np.empty((-(-len(readings) // every) + 1, robots), blank.dtype)
        receivers, senders = (np.ascontiguousarray(pairs[:, k], np.uint32) for k in (0, 1))
        try:
            kernel.follow(blank, b, w, readings, int(every), periodic, first, senders, receivers, history)
        except Exception as error:
            raise InputError(f"brain {used.name!r} fails: {type(error).__name__}: {error}") from error
        estimates = np.empty(history.shape)
        kernel.believe(history, estimates)
        fields = {name: history[name] for name in used.memory}
    else:
        steps = itertools.repeat(pairs, len(readings)) if periodic else iter(np.split(pairs, first[1:-1]))
        fields, estimates = oracle.follow(used, b, w, readings, 1, int(every), periodic, steps)
    trace = _trace(fields, estimates, used)
    trace.attrs |= {"title": f"{used.name} on recorded data", "observations_per_round": int(every)}
    return trace


def _readings(observations: Any) -> np.ndarray:
    try:
        readings = np.ascontiguousarray(observations, np.float64)
    except (TypeError, ValueError):
        raise InputError("observations: should be an array of 0, 1 and NaN") from None
    if readings.ndim != 2 or 0 in readings.shape:
        raise InputError(f"observations of shape {readings.shape}: should be (step, robot), one of each at least")
    wrong = ~(np.isnan(readings) | (readings == 0.0) | (readings == 1.0))
    if wrong.any():
        step, robot = np.argwhere(wrong)[0]
        raise InputError(
            f"observations[{step}, {robot}] = {readings[step, robot]:g}: should be 0 (white), 1 (black) or NaN (none)"
        )
    return readings


def _accuracies(accuracy: Any, robots: int) -> tuple[np.ndarray, np.ndarray]:
    if accuracy is None:
        raise InputError("accuracy: how good the sensors are must be said: a number, or a pair (b, w)")
    sides = accuracy if isinstance(accuracy, tuple) else (accuracy, accuracy)
    if len(sides) != 2:
        raise InputError(f"accuracy is a tuple of {len(sides)}: should be a pair (b, w)")
    out = []
    for side in sides:
        try:
            values = np.asarray(side, np.float64)
            if values.shape not in ((), (robots,)):
                raise ValueError
            values = np.array(np.broadcast_to(values, (robots,)))
        except (TypeError, ValueError):
            raise InputError(
                f"accuracy of shape {np.shape(side)}: should be a number or one for each of {robots} robots"
            ) from None
        if not ((values >= 0.0) & (values <= 1.0)).all():
            raise InputError(f"accuracy {values[~((values >= 0.0) & (values <= 1.0))][0]:g}: should lie in [0, 1]")
        out.append(values)
    return out[0], out[1]


def _whole_rows(links: Any) -> np.ndarray:
    try:
        rows = np.asarray(links)
        whole = rows.astype(np.int64)
        if rows.size and not (whole == rows).all():
            raise ValueError
    except (TypeError, ValueError):
        raise InputError("links: should be an array of whole numbers") from None
    if not whole.size:
        return np.zeros((0, 2), np.int64)
    if whole.ndim != 2 or whole.shape[1] not in (2, 3):
        raise InputError(f"links of shape {whole.shape}: should be (edge, 2) or (message, 3)")
    return whole


def _check_robots(rows: np.ndarray, columns: slice, robots: int) -> None:
    wrong = ((rows[:, columns] < 0) | (rows[:, columns] >= robots)).any(axis=1)
    if wrong.any():
        k = int(np.argmax(wrong))
        raise InputError(
            f"links[{k}] = {rows[k].tolist()} names a robot that is not there: "
            f"{robots} robots are numbered 0 to {robots - 1}"
        )
    loops = rows[:, columns][:, 0] == rows[:, columns][:, 1]
    if loops.any():
        raise InputError(f"links[{int(np.argmax(loops))}] joins a robot to itself")


def _edges(rows: np.ndarray, robots: int) -> tuple[np.ndarray, np.ndarray]:
    _check_robots(rows, slice(0, 2), robots)
    pairs = np.unique(np.concatenate([rows, rows[:, ::-1]]), axis=0)  # (receiver, sender), in order
    return pairs, np.zeros(1, np.int64)


def _messages(rows: np.ndarray, steps: int, robots: int) -> tuple[np.ndarray, np.ndarray]:
    _check_robots(rows, slice(1, 3), robots)
    late = (rows[:, 0] < 0) | (rows[:, 0] >= steps)
    if late.any():
        k = int(np.argmax(late))
        raise InputError(f"links[{k}] = {rows[k].tolist()}: the steps are numbered 0 to {steps - 1}")
    rows = rows[np.lexsort((rows[:, 1], rows[:, 2], rows[:, 0]))]
    first = np.searchsorted(rows[:, 0], np.arange(steps + 1))
    return rows[:, [2, 1]], first.astype(np.int64)
