"""Recordings as results: each brain is a setting of one trial, measured as a simulated one."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from swarmcensus.brains import Brain, Format
from swarmcensus.results import RELIVED, Values, dataset
from swarmcensus.robots import Clock, Logged, Recording, Relived, format_of, last_estimates
from swarmcensus.simulation import agreement, convergence, correct, error_at
from swarmcensus.studies import Study, addresses
from swarmcensus.support.errors import ResultsError
from swarmcensus.support.quantities import half_width
from swarmcensus.support.toml_text import to_toml


def dataset_of(
    recording: Recording, lived: Sequence[Relived], clock: Clock, message: Format | None = None
) -> xr.Dataset:
    """The results of a recording, a setting for each brain. Raises InputError if the fill ratio is not known."""
    if recording.fill_ratio is None:
        unknown = "the fill ratio is not known: `swarmcensus relive` takes it as --fill-ratio"
        raise ResultsError.of(recording.folder, unknown)
    honest = np.array([member.honest for member in recording.members])
    study = _study(recording, [one.brain for one in lived], clock, message)
    settings = study.settings()
    values = Values([study], settings, 1)
    for number, one in enumerate(lived):
        curves = last_estimates(Logged(recording, one, clock).estimates(0, clock.rounds + 1))[:, honest]
        if np.isnan(curves).any():
            raise ResultsError.of(recording.folder, f"not every robot's estimates are known under {one.brain.label}")
        messages = one.messages(member.number for member in recording.members if member.honest).astype(np.float64)
        index = convergence(curves, recording.delta)
        at = [correct(curves[checkpoint], recording.fill_ratio, recording.bins) for checkpoint in study.checkpoints]
        columns = {
            "convergence_round": index[np.newaxis].astype(np.int32),
            "convergence_error": error_at(curves, index, recording.fill_ratio)[np.newaxis],
            "final_estimate": curves[-1][np.newaxis],
            "correct": np.array(at)[:, np.newaxis],
            "agreement_round": np.array([agreement(curves, recording.delta)]),
            "disagreement": half_width(curves[study.checkpoints])[:, np.newaxis],
            "messages_sent": messages[:1],
            "messages_heard": messages[1:],
            "estimates": curves[study.checkpoints][:, np.newaxis],
        }
        values.put(number, 0, columns)
    marks = [addresses.fingerprint(setting, study.seed) for setting in settings]
    data = dataset([study], settings, marks, values)
    data.attrs |= {RELIVED: recording.title, "trials_done": len(lived), "trials_total": len(lived)}
    return data


def _study(recording: Recording, brains: Sequence[Brain], clock: Clock, message: Format | None) -> Study:
    """A study with settings that describe the recording: its links are those on which anything was heard."""
    states = [member.log.states[0] for member in recording.members]
    column = {member.number: k for k, member in enumerate(recording.members)}
    heard = {
        (column[one.sender], column[member.number])
        for member in recording.members for tick in member.log.ticks for one in tick.heard
        if one.sender in column and one.sender != member.number
    }  # fmt: skip
    looks = max((tick.looks for member in recording.members for tick in member.log.ticks), default=1)
    known = {brain.name: brain.as_written for brain in brains}
    black, white = (round(float(np.mean(values)), 6) for values in ([s.b for s in states], [s.w for s in states]))
    liars = sum(not member.honest for member in recording.members)
    tables = {
        "name": recording.title,
        "trials": 1,
        "seed": recording.seed,
        "swarm": {
            "brain": [{"file": brain.name, **dict(brain.overrides)} for brain in brains],
            "robots": len(recording.members),
            "accuracy": black if all(s.b == s.w for s in states) else {"black": black, "white": white},
            "precision": "single" if states[0].single else "double",
        },
        "world": {
            "topology": {"name": "heard", "directed": True, "edges": sorted(map(list, heard))},
            "fill_ratio": recording.fill_ratio,
            "message": message or format_of(brains[0], states[0]),
            "feedback": states[0].feedback,
        },
        "schedule": {"rounds": max(clock.rounds, 1), "observations_per_round": max(looks, 1)},
        "measure": {"bins": recording.bins, "delta": recording.delta, "estimates": True},
        **({"members": [{"robots": liars, "honest": False}]} if liars else {}),
    }
    context = {"base": None, "brains": known, "kept": True}
    return Study.parse(to_toml(tables), where=str(recording.folder), context=context)
