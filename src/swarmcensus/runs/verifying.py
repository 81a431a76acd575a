"""Whether results are what they say: labels are held against the study, trials run again and compared bit for bit."""

import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.basics.version import __version__
from swarmcensus.metrics import Metric
from swarmcensus.results import structure
from swarmcensus.results.check_against_study import settings_of, unchecked, unlike
from swarmcensus.results.source_study import Brains, metrics_may_run, must_be_read, studies_of
from swarmcensus.results.store import load, provenance
from swarmcensus.results.values import (
    ESTIMATES,
    EVERY,
    LOCAL,
    MISSING,
    Values,
    blank,
    is_missing,
    kinds_in,
    same_bits,
)
from swarmcensus.runs.collect import Progress
from swarmcensus.runs.running import half_width, recompute
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study

COUNTED = ("additions", "trials_done", "trials_total", "failed", "share", "merged", "started", "finished",
           "wall_seconds", "cpu_seconds")  # fmt: skip


@dataclass(frozen=True)
class Difference:
    """A trial that did not come out as stored."""

    setting: int
    trial: int
    variable: str
    stored: float
    found: float

    def __str__(self) -> str:
        """The difference as a sentence."""
        return (
            f"setting {self.setting}, trial {self.trial}: {self.variable} is {self.stored!r} in the file and "
            f"{self.found!r} when it is run again"
        )


@dataclass(frozen=True)
class Verification:
    """What came of it: how many trials were run again, of how many, and the first difference of each that differs.

    `labels` are sentences on what else the results say otherwise than their study; `notes` on what is no fault, but
    should be known; `unchecked` are phrases on what was compared with nothing, and why.
    """

    checked: int
    stored: int
    differences: list[Difference]
    labels: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    unchecked: list[str] = field(default_factory=list)


def verify(
    results: xr.Dataset | str | Path,
    sample: float = 0.01,
    *,
    brain: Brains = (),
    seed: int | None = None,
    jobs: int | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Verification:
    """Run a random share `sample` of the trials in results again, at least one, and compare all that was measured.

    With sample=1 all are. `seed` makes the choice the same each time. Brains that are not shipped must be given, or
    found: see `origins`. What results say beside their numbers is compared in any case. Raises InputError.
    """
    if not 0.0 < sample <= 1.0:
        raise InputError(f"sample = {sample:g}: should be a share above 0, and 1 at the most")
    data = results if isinstance(results, xr.Dataset) else load(results)
    if wrong := structure.wrong(data):
        raise InputError(f"damaged or changed: {wrong}")
    studies = studies_of(data, brain)
    labels = [*unlike(data, studies), *_ended(data, studies)]
    tried = data.variables["convergence_round"].values[:, :, 0] != MISSING
    if not tried.any():
        raise InputError("these results hold no finished trial")
    for setting, trial in structure.failures(data):  # these should fail again
        tried |= np.outer(data.variables["setting"].values == setting, data.variables["trial"].values == trial)
    done = np.argwhere(tried)
    count = min(len(done), max(1, math.ceil(sample * len(done))))
    chosen = done[np.sort(np.random.default_rng(seed).permutation(len(done))[:count])]
    wanted = np.zeros(data["convergence_round"].shape[:2], np.bool_)
    wanted[chosen[:, 0], chosen[:, 1]] = True
    differences: list[Difference] = []
    left = np.asarray(wanted.any(axis=1))
    watched = list({metric.variable: metric for study in studies for metric in study.measure.metrics}.values())
    for study in (_looking(data, study, watched) for study in studies):
        places, settings = _ours(data, study, left)
        if settings:
            metrics_may_run(study, brain)
            left[places] = False
            differences += _compare(data, study, places, settings, wanted[places], jobs, progress)
    wanted[left] = False  # of no setting of these studies, as the labels say
    differences.sort(key=lambda d: (d.setting, d.trial))
    notes = list(_notes(data, studies))
    return Verification(int(wanted.sum()), len(done), differences, labels, notes, unchecked(data))


def _notes(data: xr.Dataset, studies: Sequence[Study]) -> Iterator[str]:
    version = data.attrs["swarmcensus_version"]
    if version != __version__:
        yield f"the file is of version {version}, and this is {__version__}: descriptions are not compared"
    done, total = int(data.attrs["trials_done"]), int(data.attrs["trials_total"])
    if done < total:
        failed = len(structure.failures(data))
        failures = f", {failed:,} failed" if failed else ""
        yield f"{total - done:,} of {counted(total, 'trial')} are not in the file{failures}"
    own = {*COUNTED}.union(*map(provenance, studies))  # only some of merged studies may have adversaries
    for name in sorted({*data.attrs} - own):
        yield f"the attribute {name} is not of a run"


def _ended(data: xr.Dataset, studies: Sequence[Study]) -> Iterator[str]:
    """Where results say that no trial is to come: what their rules ask for and is not there, and what they came to."""
    failed = np.zeros(data["convergence_round"].shape[:2], np.bool_)
    rows, columns = ({n: k for k, n in enumerate(data.variables[d].values.tolist())} for d in ("setting", "trial"))
    for setting, trial in structure.failures(data):
        failed[rows[setting], columns[trial]] = True
    values = Values.of(data)
    ended = data.attrs["trials_done"] + failed.sum() == data.attrs["trials_total"]
    for study in studies:
        if not {*study.checkpoints} <= {*data.variables["checkpoint"].values.tolist()}:
            continue  # which is told already
        if "merged" in data.attrs:
            values = Values.of(data.sel(checkpoint=study.checkpoints))
        ours = settings_of(study)
        for k, mark in enumerate(data.variables["fingerprint"].values.tolist()):
            if mark not in ours:
                continue
            number = data.variables["setting"].values[k]
            found, lacking = _stages(study, values, k, failed[k])
            if ended and lacking:
                yield f"setting {number}: of its {counted(lacking, 'trial')} some are missing, and none is said to be"
            if "half_width" not in data or data.variables["half_width"].dims != ("setting",) or study.until is None:
                continue
            said = data.variables["half_width"].values[k].item()
            whole = ended and not failed[k].any()
            if not same_bits(np.array(said), np.array(found[-1:] if whole else found)).any():
                yield f"setting {number}: half_width is {said!r} in the file, and {found[-1]!r} of its trials"


def _stages(study: Study, values: Values, k: int, failed: NDArray[np.bool_]) -> tuple[list[float], int]:
    """What a rule's half width was at each look, as far as there are trials, and how many more trials it asks for.

    The latter is the number of trials of the stage that was not ended, or 0.
    """
    found = [math.nan]
    tried = values.done()[k] | failed
    for trials in study.stages():
        if trials > tried.size or not tried[:trials].all():
            return found, trials
        if failed[:trials].any():
            return found, 0  # no rule is asked any more
        if study.until is not None:
            found.append(half_width(study, values, k, trials))
            if study.until.holds(found[-1]):
                break
    return found, 0


def _looking(data: xr.Dataset, study: Study, watched: list[Metric]) -> Study:
    """The same study, measuring what a dataset holds: merged results have what all their studies measure."""
    longest = max(setting.rounds for setting in study.settings())
    looked = [c for c in data.variables["checkpoint"].values.tolist() if c <= longest] or [longest]
    own = {k: v for k, v in study.measure if v is not None}
    all_of_it = {"checkpoints": looked, "estimates": "estimates" in data, "metrics": watched}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of the same study once more
        return study.with_(measure=own | all_of_it)


def _ours(data: xr.Dataset, study: Study, left: NDArray[np.bool_]) -> tuple[NDArray[np.intp], list[Setting]]:
    """The places in a dataset of settings that are of a study, of those that are `left`, and these settings."""
    marks = {mark: k for k, mark in enumerate(data.variables["fingerprint"].values.tolist()) if left[k]}
    found = {marks[mark]: s for s in study.settings() if (mark := s.fingerprint(study.seed)) in marks}
    for setting in found.values():
        must_be_read(setting)
    return np.array(sorted(found), np.intp), [found[k] for k in sorted(found)]


def _compare(
    data: xr.Dataset,
    study: Study,
    places: NDArray[np.intp],
    settings: list[Setting],
    wanted: NDArray[np.bool_],
    jobs: int | None,
    progress: Callable[[Progress], None] | None,
) -> list[Difference]:
    local, merged = "local_convergence_step" in data, "merged" in data.attrs
    trials = data.variables["trial"].values
    columns = np.zeros((len(settings), int(trials.max()) + 1), np.bool_)
    columns[:, trials] = wanted
    again = recompute(study, settings, columns, local, jobs, progress)
    known = [
        study.checkpoints.index(c) if c in study.checkpoints else -1
        for c in data.variables["checkpoint"].values.tolist()
    ]
    out: dict[tuple[int, int], Difference] = {}
    for name, (dims, *_) in kinds_in(data).items():
        others = tuple(k for k, d in enumerate(dims) if d not in ("setting", "trial"))
        stored = data.variables[name].values[places]
        if name in again.arrays:
            found = _fitted(again.arrays[name], dims, trials, known, data.sizes["robot"])
        else:  # of brains that this one of merged studies has none of
            found = np.full(stored.shape, blank(stored.dtype), stored.dtype)
        differ, there = ~same_bits(stored, found), ~is_missing(stored)
        due = wanted
        # what some of merged studies do not ask for is there of no trial or all: `unlike` tells
        if merged and (name in LOCAL or name in ESTIMATES or name not in EVERY):
            due = due & there.any(axis=others)
        if merged and "checkpoint" in dims:  # nor these checkpoints
            differ &= there
        for row, column in np.argwhere(differ.any(axis=others) & due).tolist():
            number, trial = int(data.variables["setting"].values[places[row]]), int(trials[column])
            one = {"setting": row, "trial": column}
            at = tuple(one.get(d, slice(None)) for d in dims)
            values = (np.atleast_1d(array[at])[np.atleast_1d(differ[at])][0].item() for array in (stored, found))
            out.setdefault((number, trial), Difference(number, trial, name, *values))
    return list(out.values())


def _fitted(
    array: NDArray[Any], dims: tuple[str, ...], trials: NDArray[Any], known: list[int], robots: int
) -> NDArray[Any]:
    """A variable as a dataset of other sizes holds it; `known` are the places of its checkpoints, or -1."""
    array = array.take(trials, dims.index("trial"))
    if "checkpoint" in dims:
        array = array[:, known]
        array[:, np.array(known) < 0] = np.nan
    if "robot" in dims:
        more = [(0, max(0, robots - n)) if d == "robot" else (0, 0) for d, n in zip(dims, array.shape, strict=True)]
        array = np.pad(array, more, constant_values=blank(array.dtype))[..., :robots]
    return array
