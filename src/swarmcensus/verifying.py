"""Whether results are what they say: labels are held against the study, trials run again and compared bit for bit."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus import __version__, checking
from swarmcensus.errors import InputError
from swarmcensus.labels import unlike
from swarmcensus.origins import Brains, must_be_read, studies_of
from swarmcensus.results import load
from swarmcensus.running import Progress, half_width, recompute
from swarmcensus.settings import Setting
from swarmcensus.studies import Study
from swarmcensus.values import EVERY, MISSING, VARIABLES, Values


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
    should be known.
    """

    checked: int
    stored: int
    differences: list[Difference]
    labels: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


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
    if wrong := checking.wrong(data):
        raise InputError(f"damaged or changed: {wrong}")
    studies = studies_of(data, brain)
    labels = [*unlike(data, studies), *_widths(data, studies)]
    done = np.argwhere(data["convergence_round"].values[:, :, 0] != MISSING)
    if not len(done):
        raise InputError("these results hold no finished trial")
    count = min(len(done), max(1, math.ceil(sample * len(done))))
    chosen = done[np.sort(np.random.default_rng(seed).permutation(len(done))[:count])]
    wanted = np.zeros(data["convergence_round"].shape[:2], np.bool_)
    wanted[chosen[:, 0], chosen[:, 1]] = True
    differences: list[Difference] = []
    left = np.asarray(wanted.any(axis=1))
    for study in (_looking(data, study) for study in studies):
        places, settings = _ours(data, study, left)
        if settings:
            left[places] = False
            differences += _compare(data, study, places, settings, wanted[places], jobs, progress)
    wanted[left] = False  # of no setting of these studies, as the labels say
    differences.sort(key=lambda d: (d.setting, d.trial))
    return Verification(int(wanted.sum()), len(done), differences, labels, list(_notes(data)))


def _notes(data: xr.Dataset) -> Iterator[str]:
    version = data.attrs["swarmcensus_version"]
    if version != __version__:
        yield f"the file is of version {version}, and this is {__version__}"
    done, total = int(data.attrs["trials_done"]), int(data.attrs["trials_total"])
    if done < total:
        failed = len(checking.failures(data))
        yield f"{total - done:,} of {total:,} trials are not in the file" + (f", {failed:,} failed" if failed else "")


def _widths(data: xr.Dataset, studies: Sequence[Study]) -> Iterator[str]:
    """What is wrong with the widths of a rule, and with how many trials it needed."""
    study = studies[0]
    rule = study.until
    if rule is None or "merged" in data.attrs or "half_width" not in data or data["half_width"].dims != ("setting",):
        return  # none is due, or that it is not there is told already
    if checking.is_old(data):
        return  # intervals were others then
    values, stored = Values.of(data), data["half_width"].values
    failed = {setting for setting, _ in checking.failures(data)}
    done = values.done()
    ended = data.attrs["trials_done"] + len(checking.failures(data)) == data.attrs["trials_total"]
    for k, number in enumerate(data["setting"].values.tolist()):
        found = [math.nan]
        for trials in study.stages():
            if trials > values.trials or not done[k, :trials].all():
                break
            found.append(half_width(study, values, k, trials))
            if rule.holds(found[-1]):
                break
        whole = ended and number not in failed
        said = stored[k].item()
        if not any(said == one or (said != said and one != one) for one in (found[-1:] if whole else found)):
            yield f"setting {number}: half_width is {said!r} in the file, and {found[-1]!r} of its trials"
        elif whole and not rule.holds(found[-1]) and not done[k].sum() >= rule.at_most:
            yield f"setting {number}: {rule.until!r} does not hold yet, and no trial of it is said to be missing"


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
    out: dict[tuple[int, int], Difference] = {}
    for name in (name for name in EVERY if name in data and name in again.arrays):
        dims = EVERY[name][0]
        others = tuple(k for k, d in enumerate(dims) if d not in ("setting", "trial"))
        stored = data[name].values[places]
        found = _fitted(again.arrays[name], dims, trials, known, data.sizes["robot"])
        differ = ~((stored == found) | ((stored != stored) & (found != found)))
        there = stored != MISSING if stored.dtype.kind == "i" else ~np.isnan(stored)
        due = wanted
        if name not in VARIABLES:  # not asked for by some of merged studies
            due = due & there.any(axis=others)
        if "checkpoint" in dims:  # nor these checkpoints
            differ &= there
        for row, column in np.argwhere(differ.any(axis=others) & due).tolist():
            number, trial = int(data["setting"].values[places[row]]), int(trials[column])
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
        blank = MISSING if array.dtype.kind == "i" else np.nan
        more = [(0, max(0, robots - n)) if d == "robot" else (0, 0) for d, n in zip(dims, array.shape, strict=True)]
        array = np.pad(array, more, constant_values=blank)[..., :robots]
    return array
