"""Replaying: one trial of results again, with every robot's state after every round."""

import itertools
from pathlib import Path

import numpy as np
import xarray as xr

from swarmcensus.checks import caution
from swarmcensus.engine.constants import LISTED, NEVER, PARTS
from swarmcensus.results import Brains, as_dataset, check_held, setting_of
from swarmcensus.simulation import (
    Stepped,
    dataset_of,
    ended,
    free,
    record_estimates,
    record_readings,
    sampling,
    warn_of_estimates,
)
from swarmcensus.studies import UNNAMED, Setting, Study, addresses
from swarmcensus.summaries.labels import labels_in
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.worlds import NAMES, outages


def replay(
    results: xr.Dataset | str | Path, setting: int, trial: int, brain_file: Brains = (), links: bool = False
) -> xr.Dataset:
    """Run one trial again and return its trace: every field of the brain's memory and `estimate`, (round, robot).

    Robots that move also have, by tick: `position` (axis; metres from the arena's centre), `heading` (radians),
    `looked` (1 if an observation was made), `tile` (true colour under the sensor, 1 is black), `reading` (NaN without
    an observation) and `neighbours` (number of robots heard). With `links`, `link` (link, 3) holds tick, robot, robot.
    If robots fail, `stops` (part, robot) is the first tick without moving, sensing or talking, -1 for never; if parts
    work again, `outages` (fault, edge, part, robot) is the first tick without the part and the first with it again.

    `results` is a dataset or a results file; `setting` and `trial` are its coordinates. A brain that is not shipped
    must be given as a file. Estimates equal those of the run to the last bit. Raises InputError.
    """
    return _trace(results, setting, trial, brain_file, links)


def estimates(results: xr.Dataset | str | Path, setting: int, trial: int, brain_file: Brains = ()) -> xr.Dataset:
    """A trace as `replay` returns it; on fixed networks, with estimates only.

    This needs no compilation if the trial was run on this machine. Raises InputError.
    """
    return _trace(results, setting, trial, brain_file, only_estimates=True)


def _trace(
    results: xr.Dataset | str | Path,
    setting: int,
    trial: int,
    brain_file: Brains,
    links: bool = False,
    only_estimates: bool = False,
) -> xr.Dataset:
    """A trace with the attributes of its setting, checked against the results. Raises InputError if they differ."""
    data = as_dataset(results)
    study, chosen = _find(data, setting, trial, brain_file)
    if only_estimates and chosen.body is None:
        seen = {"estimate": record_estimates(chosen, study.seed, trial)}
        trace = dataset_of({}, seen, range(chosen.robots))
    else:
        trace = _trace_of(chosen, study.seed, trial, links)
    if chosen.change:
        says = {"long_name": "black share of the floor, as it changes"}
        trace[free("fill_ratio", trace)] = ("round", chosen.fill_ratios(trace["round"].values), says)
    honest = _name_members(trace, chosen, study.seed, trial) if chosen.members else np.ones(chosen.robots, np.bool_)
    _check_same(data, setting, trial, trace, honest)
    warn_of_estimates(chosen.brain.name, np.where(honest, trace["estimate"].values, 0.5))
    name = data.attrs["title"] if isinstance(results, xr.Dataset) else Path(results).stem
    name = name if study.name == UNNAMED else study.name
    brain = labels_in(data).get(chosen.brain.name, chosen.brain.name)
    trace.attrs |= {
        "brain": chosen.brain.name,
        "title": f"{name}, setting {setting}, trial {trial}: {brain}, {chosen.brief}",
        "setting": setting,
        "trial": trial,
        "seed": study.seed,
        "fill_ratio": chosen.fill_ratio,
        **{key: getattr(study.measure, key) for key in ("bins", "delta", "truth")},
    } | ({"opinions": 1} if chosen.brain.is_opinion else {})
    return trace


def honest_in(trace: xr.Dataset) -> np.ndarray:
    """A mask of the honest robots of a trace, which metrics count (robot,)."""
    for name, variable in trace.data_vars.items():
        if str(name).startswith("honest") and variable.dims == ("robot",):
            return np.asarray(variable.values == 1)
    return np.ones(trace.sizes["robot"], np.bool_)


def _name_members(trace: xr.Dataset, chosen: Setting, seed: int, trial: int) -> np.ndarray:
    """Add the number of each robot's table of members, and who is honest; return the latter (robot,)."""
    who = sampling.groups(chosen, seed, trial, 1)[0]
    meanings = "; ".join(f"{number}: {member}" for number, member in enumerate(chosen.members, start=1))
    trace[free("member", trace)] = ("robot", who.astype(np.int32), {"long_name": f"0: as the swarm; {meanings}"})
    honest = np.array([True, *(member.honest for member in chosen.members)])[who]
    if chosen.honest < chosen.robots:
        says = {"long_name": "1 where metrics count the robot"}
        trace[free("honest", trace)] = ("robot", honest.astype(np.int8), says)
    return np.asarray(honest)


def _check_same(data: xr.Dataset, setting: int, trial: int, trace: xr.Dataset, honest: np.ndarray) -> None:
    """Raise InputError if the run of this trial ended differently, as in results assembled by hand."""
    last = trace["estimate"].values[-1][honest]
    stored = data["final_estimate"].sel(setting=setting, trial=trial).values[: last.size]
    ran = np.isfinite(stored).all() and len(stored) == last.size
    if ran and not np.allclose(stored, last, rtol=0.0, atol=1e-9):
        why = "these results come from another study than they name, or from another version"
        differs = f"setting {setting}, trial {trial}: the replay ends with other estimates than the run: {why}"
        raise ResultsError(differs, key="setting", value=setting)


def _name_faults(trace: xr.Dataset, chosen: Setting, seed: int, trial: int) -> xr.Dataset:
    """The trace with the ticks at which parts of robots stop, and work again."""
    stops = sampling.stops(chosen, seed, trial)
    says = {"units": "ticks", "long_name": "first tick without moving, sensing, talking; -1: never"}
    name, part = free("stops", trace), free("part", trace)
    shown = np.where(stops == NEVER, -1, stops)
    trace[name] = ((part, "robot"), shown[:PARTS], says)
    if len(stops) > PARTS:
        says = {"units": "ticks", "long_name": "of each fault: first tick without, first one with it again"}
        trace[free("outages", trace)] = (("fault", "edge", part, "robot"), outages(shown), says)
    return trace.assign_coords({part: sorted(NAMES, key=NAMES.__getitem__)})


def _trace_of(chosen: Setting, seed: int, trial: int, links: bool) -> xr.Dataset:
    """One trial in full, and what only simulated ones have."""
    stepped = Stepped(chosen, seed, trial, use=chosen.use)
    trace = stepped.dataset(links)
    if chosen.body is None:
        blacks = stepped.blacks()
        if any(brain.ends for brain in chosen.brains):
            blacks[1:][ended(chosen.brains, trace)] = 0.0
        trace["blacks"] = (("round", "robot"), blacks, {"long_name": "black readings in this round"})
        return trace
    truths = stepped.truths(trace["round"].values, on_floor=True)
    if chosen.change:
        says = {"long_name": "black share of the floor that robots can reach, as it changes"}
        trace[free("true_fill_ratio", trace)] = ("round", truths, says)
    trace = _name_faults(trace, chosen, seed, trial) if chosen.faults else trace
    trace.attrs |= {
        "true_fill_ratio": float(truths[-1]),
        "side": chosen.arena_side,
        "radio_range": chosen.body.radio_range,
        "radius": chosen.body.radius,
        "tile_side": chosen.body.tile,
        "tick_seconds": chosen.body.tick,
    }
    return trace


def recording(
    results: xr.Dataset | str | Path, setting: int, trial: int, brain_file: Brains = ()
) -> tuple[np.ndarray, np.ndarray]:
    """The observations and links of one trial, in the form that `infer` takes.

    Returns readings (step, robot), 1 for black, and undirected edges (edge, 2). For robots that move and for directed
    links, it returns messages (message, 3) of step, sender, receiver instead of edges. Raises InputError.
    """
    study, chosen = _find(as_dataset(results), setting, trial, brain_file)
    moving_oracle = chosen.brain.is_oracle and chosen.body is not None
    some_lost = chosen.link_success < 1.0 or chosen.faults or chosen.message_delay > 0
    for wrong, why in (
        (len(chosen.brains) > 1, "is for one brain, and the robots of this setting have several"),
        (moving_oracle, "holds the messages between neighbours, and an oracle hears all robots"),
        (some_lost, "holds no lost messages, no delays and no faults, and this setting has some"),
    ):
        if wrong:
            raise InputError(f"a recording {why}", key="setting", value=setting)
    if chosen.body is not None:
        trace = Stepped(chosen, study.seed, trial).dataset(links=True)
        tick, i, j = trace["link"].values.T
        messages = np.concatenate([np.stack([tick - 1, i, j], axis=1), np.stack([tick - 1, j, i], axis=1)])
        return trace["reading"].values[1:], messages[np.lexsort(messages.T[::-1])]
    readings = record_readings(chosen, study.seed, trial)
    if any(brain.ends for brain in chosen.brains):  # robots that are done read nothing
        done = ended(chosen.brains, Stepped(chosen, study.seed, trial, use=chosen.use).states(0, chosen.rounds + 1))
        readings[np.repeat(done, chosen.observations_per_round, axis=0)] = np.nan
    links = sampling.links(chosen, study.seed, trial, 1)
    if links.mode != LISTED and chosen.robots > 1:
        return readings, np.array(list(itertools.combinations(range(chosen.robots), 2)))
    pairs = np.stack([links.senders, links.receivers], axis=1).astype(np.int64)
    if np.array_equal(pairs[np.lexsort(pairs.T)], pairs[np.lexsort(pairs.T[::-1])][:, ::-1]):
        return readings, pairs[pairs[:, 0] > pairs[:, 1], ::-1]
    steps = np.arange(1, chosen.rounds + 1) * chosen.observations_per_round - 1
    return readings, np.column_stack([np.repeat(steps, len(pairs)), np.tile(pairs, (len(steps), 1))])


def _find(data: xr.Dataset, setting: int, trial: int, brain_file: Brains) -> tuple[Study, Setting]:
    check_held(data, trial=trial)
    study, chosen = setting_of(data, setting, brain_file)
    caution(chosen.brains)
    return study, addresses.in_trial(chosen, study.seed, trial)
