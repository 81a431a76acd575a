"""Whether results are what they say: trials are run again and compared bit for bit."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.errors import InputError
from swarmcensus.results import Brains, load, must_be_read, studies_of
from swarmcensus.running import Progress, recompute
from swarmcensus.settings import Setting
from swarmcensus.studies import Study
from swarmcensus.values import EVERY, LOCAL, MISSING, Values


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
    """What came of it: how many trials were run again, of how many, and the first difference of each that differs."""

    checked: int
    stored: int
    differences: list[Difference]


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

    With sample=1 all are. `seed` makes the choice the same each time. Brains that are not shipped must be given.
    Raises InputError.
    """
    if not 0.0 < sample <= 1.0:
        raise InputError(f"sample = {sample:g}: should be a share above 0, and 1 at the most")
    data = results if isinstance(results, xr.Dataset) else load(results)
    done = np.argwhere(data["convergence_round"].values[:, :, 0] != MISSING)
    if not len(done):
        raise InputError("these results hold no finished trial")
    count = min(len(done), max(1, math.ceil(sample * len(done))))
    chosen = done[np.sort(np.random.default_rng(seed).permutation(len(done))[:count])]
    wanted = np.zeros(data["convergence_round"].shape[:2], np.bool_)
    wanted[chosen[:, 0], chosen[:, 1]] = True
    differences: list[Difference] = []
    left = np.asarray(wanted.any(axis=1))
    for study in (_looking(data, study) for study in studies_of(data, brain)):
        places, settings = _ours(data, study, left)
        if settings:
            left[places] = False
            differences += _compare(data, study, places, settings, wanted[places], jobs, progress)
    if left.any():
        number = int(data["setting"].values[np.flatnonzero(left)[0]])
        raise InputError(f"setting {number} is not of the study that these results name")
    return Verification(count, len(done), sorted(differences, key=lambda d: (d.setting, d.trial)))


def _looking(data: xr.Dataset, study: Study) -> Study:
    """The same study, looking at a dataset's checkpoints: merged results have those of all their studies."""
    longest = max(setting.rounds for setting in study.settings())
    looked = [c for c in data["checkpoint"].values.tolist() if c <= longest] or [longest]
    return study.with_(measure=study.measure.model_dump(exclude_none=True) | {"checkpoints": looked})


def _ours(data: xr.Dataset, study: Study, left: NDArray[np.bool_]) -> tuple[NDArray[np.intp], list[Setting]]:
    """The places in a dataset of settings that are of a study, of those that are `left`, and these settings."""
    marks = {mark: k for k, mark in enumerate(data["fingerprint"].values.tolist()) if left[k]}
    found = {marks[mark]: s for s in study.settings() if (mark := s.fingerprint(study.seed)) in marks}
    for setting in found.values():
        must_be_read(setting.brain)
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
    local = "local_convergence_step" in data
    trials = data["trial"].values
    columns = np.zeros((len(settings), int(trials.max()) + 1), np.bool_)
    columns[:, trials] = wanted
    again = recompute(study, settings, columns, local, jobs, progress)
    known = [study.checkpoints.index(c) if c in study.checkpoints else -1 for c in data["checkpoint"].values.tolist()]
    out = []
    for row, trial in np.argwhere(columns).tolist():
        where = {"setting": places[row], "trial": int(np.flatnonzero(trials == trial)[0])}
        for name in (name for name in EVERY if name in data):
            stored = np.atleast_1d(data[name].isel(where).values)
            found = _fitted(again, name, row, trial, known, data.sizes["robot"])
            if name in LOCAL and data["local_convergence_step"].isel(where)[0] == MISSING:
                continue  # not asked for by the one of merged studies that ran this trial
            if name in ("correct", "estimates"):
                found = np.where(np.isnan(stored), np.nan, found)  # nor these checkpoints
            differ = np.argwhere(~((stored == found) | ((stored != stored) & (found != found))))
            if differ.size:
                at = tuple(differ[0])
                number = int(data["setting"].values[places[row]])
                out.append(Difference(number, trial, name, stored[at].item(), found[at].item()))
                break
    return out


def _fitted(values: Values, name: str, row: int, trial: int, known: list[int], size: int) -> NDArray[np.float64]:
    """A trial's numbers as a dataset of other sizes holds them."""
    if name == "correct":
        column = values.arrays[name][row, :, trial]
        return np.array([column[k] if k >= 0 else np.nan for k in known])
    if name == "estimates":
        out = np.full((len(known), size), np.nan)
        asked = [k >= 0 for k in known]
        kept = values.arrays[name][row, [k for k in known if k >= 0], trial, :size]
        out[asked, : kept.shape[1]] = kept
        return out
    if name == "true_fill_ratio":
        return values.arrays[name][row, [trial]]
    array = values.arrays[name][row, trial]
    blank = MISSING if array.dtype.kind == "i" else np.nan
    return np.pad(array, (0, max(0, size - array.size)), constant_values=blank)[:size]
