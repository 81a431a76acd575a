"""Verifies results: makes them again from their study, in full or in part, and compares the two bit for bit."""

import math
import secrets
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import (
    MAY_DIFFER,
    Brains,
    Columns,
    Values,
    differences,
    failed_in,
    failed_trials,
    finished_trials,
    is_missing,
    kinds_in,
    load_packed,
    metrics_may_run,
    missing_value,
    most_trials,
    must_be_read,
    outline,
    packed,
    same_bits,
    schema,
    settings_of,
    studies_of,
)
from swarmcensus.runs.collect import Report
from swarmcensus.runs.devices import Device, placing_of
from swarmcensus.runs.progress import showing
from swarmcensus.runs.running import half_width, recompute
from swarmcensus.studies import Setting, Study
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option, wrong_option
from swarmcensus.support.version import __version__
from swarmcensus.translation import selftest

CLOSE = {"double": 1e-12, "single": 1e-4}  # what exp, log and lgamma may make estimates differ by, relative above 1
ESTIMATED = ("final_estimate", "estimates")
DIFFER = 1  # exit code if results differ
SHARE_APART = 0.01  # of other values, such as times, that may then differ


@dataclass(frozen=True)
class Difference:
    """A stored number of a trial that differs when the trial is run again."""

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


@dataclass(repr=False)
class Verification(Answer):
    """How many trials were run again (`checked`) of how many (`stored`), and the first difference of each trial.

    `labels` are sentences about labels that do not match the study; `notes` are about what is no fault, but should be
    known; `unchecked` are phrases about what could not be compared, and why.
    """

    checked: int
    stored: int
    differences: list[Difference]
    labels: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    unchecked: list[str] = field(default_factory=list)
    seed: int | None = None  # of the sample, if not all trials were checked
    of: str = "these results"

    @property
    def code(self) -> int:  # type: ignore[override]
        """1 if anything differs."""
        return DIFFER if self.differences or self.labels else 0

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """What differs, how much was checked, and what was not."""
        trials = f"{self.checked:,} of {counted(self.stored, 'trial')} run again"
        trials += "" if self.seed is None else f" ({option('seed', self.seed)})"
        equal = "the same to the last bit"
        if self.labels or self.notes:
            equal = f"the numbers are {equal}"
        if not self.checked:
            equal = "no trial could be run again"
        found = f"{len(self.differences):,} differ" if self.differences else equal
        labels = [f"labels that do not match the study: {len(self.labels):,}"] if self.labels else []
        return [
            *self.labels, *map(str, self.differences),
            "; ".join([f"{self.of}: {trials}: {found}", *labels, *self.notes]),
            *(f"not compared: {one}" for one in self.unchecked),
        ]  # fmt: skip

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """What was checked, for JSON."""
        return {
            "results": self.of, "trials_checked": self.checked, "trials_stored": self.stored, "seed": self.seed,
            "differences": self.differences, "labels": self.labels, "notes": self.notes, "unchecked": self.unchecked,
        }  # fmt: skip


def verify(
    results: xr.Dataset | str | Path,
    sample: float = 0.01,
    *,
    brain_file: Brains = (),
    seed: int | None = None,
    jobs: int | None = None,
    progress: Report | bool = True,
    device: Device = "cpu",
) -> Verification:
    """Run a random share `sample` of the stored trials again, at least one, and compare all measurements.

    With sample=1 all trials are run again. With a `seed`, which is otherwise random, the choice is the same each
    time. Brains that do not ship must be given as `brain_file`. `progress` and `device` are as for `run`. Labels
    and attributes are always compared with the study. Where a card ran either of both, brains that use functions
    such as exp may differ as they do between machines: estimates by `CLOSE`, and other variables in a hundredth of
    their values. Raises InputError.
    """
    if not 0.0 < sample <= 1.0:
        raise wrong_option("sample", sample, "should be a share above 0, and at most 1")
    if seed is None and sample < 1.0:
        seed = secrets.randbelow(2**31)
    data = packed(results) if isinstance(results, xr.Dataset) else load_packed(results)
    schema.check_dataset(data)
    studies = studies_of(data, brain_file)
    labels = [*differences(data, outline(studies, "merged" in data.attrs), studies), *_wrong_counts(data, studies)]
    done = Values.of(data).done()
    if not done.any():
        raise InputError("these results hold no finished trial")
    tried = done | failed_trials(data)  # failed ones should fail again
    every = np.argwhere(tried)
    count = min(len(every), max(1, math.ceil(sample * len(every))))
    chosen = every[np.sort(np.random.default_rng(seed).permutation(len(every))[:count])]
    wanted = np.zeros_like(tried)
    wanted[chosen[:, 0], chosen[:, 1]] = True
    known = _runnable(data, studies, brain_file)  # before the first trial: the sample must not decide what is missing
    wanted[~known] = False  # these settings are of none of the studies, as `labels` say
    compared = (wanted | ~tried) & known[:, np.newaxis]  # trials that never ran should have left nothing
    with showing(progress, "verify") as report:
        found = _compare(data, studies, wanted, compared, jobs, report, device)
    of = {} if isinstance(results, xr.Dataset) else {"of": str(results)}
    return Verification(
        int(wanted.sum()), len(every), found, labels, list(_notes(data)), list(_unchecked(data)), seed, **of
    )


def _notes(data: xr.Dataset) -> Iterator[str]:
    version = data.attrs["swarmcensus_version"]
    if version != __version__:
        yield f"the file is of version {version}, and this is {__version__}: descriptions are not compared"
    done, total, failed = int(data.attrs["trials_done"]), int(data.attrs["trials_total"]), failed_trials(data).sum()
    if done < total:
        failures = f", {failed:,} failed" if failed else ""
        yield f"{total - done:,} of {counted(total, 'trial')} are not in the file{failures}"


def _unchecked(data: xr.Dataset) -> Iterator[str]:
    """What of a dataset may differ, and why, as phrases."""
    for one in MAY_DIFFER:
        if names := [name for name in one.names if name in data.attrs or one.only_with in data.attrs]:
            yield f"{', '.join(names)}: {one.why}"


def _wrong_counts(data: xr.Dataset, studies: Sequence[Study]) -> Iterator[str]:
    """Sentences about numbers of trials, and half-widths of rules, that do not fit the trials that are there."""
    done, failed, numbers = finished_trials(data), failed_trials(data), data.variables["trial"].values
    stored, total = int(data.attrs["trials_done"]), int(data.attrs["trials_total"])
    ruled, most = any(study.until for study in studies), max(study.trials for study in studies)
    if stored != done.sum():
        yield f"the attribute trials_done is {stored}, and {done.sum()} trials are in the file"
    if (done & failed).any() or failed.sum() != len(failed_in(data)):
        yield "the attribute failed should name trials that are not in the file, each once"
    planned, tried = sum(most_trials(studies).values()), int(done.sum() + failed.sum())
    if total != planned and not (ruled and tried <= total <= planned):
        yield f"the attribute trials_total is {total} in the file and {planned} by its study"
    if (
        not np.array_equal(numbers, np.arange(numbers.size))
        or numbers.size > most
        or (numbers.size < most and not ruled)
    ):
        yield f"trial should number the {counted(most, 'trial')} of each setting"
    for study in studies:
        if {*study.checkpoints} <= {*data.variables["checkpoint"].values.tolist()}:  # `differences` reports others
            yield from _wrong_by_rule(data.sel(checkpoint=study.checkpoints), study, failed, tried == total)


def _wrong_by_rule(data: xr.Dataset, study: Study, failed: NDArray[np.bool_], ended: bool) -> Iterator[str]:
    """Sentences about settings of a study that lack trials, or whose half-width is not that of their trials."""
    values, marks = Values.of(data), settings_of(study)
    for k, mark in enumerate(data.variables["fingerprint"].values.tolist()):
        if mark not in marks:
            continue
        number = data.variables["setting"].values[k]
        widths, lacking = _rule_widths(study, values, k, failed[k])
        if ended and lacking:
            yield f"setting {number}: of its {counted(lacking, 'trial')} some are missing, and none is said to be"
        if "half_width" in data and study.until is not None:
            stored = data.variables["half_width"].values[k].item()
            whole = ended and not failed[k].any()
            if not same_bits(np.array(stored), np.array(widths[-1:] if whole else widths)).any():
                yield f"setting {number}: half_width is {stored!r} in the file, and {widths[-1]!r} of its trials"


def _rule_widths(study: Study, values: Values, k: int, failed: NDArray[np.bool_]) -> tuple[list[float], int]:
    """A rule's half-width after each finished stage, NaN before the first, and the size of the unfinished stage, or 0.

    `k` is the place of a setting in `values`; `failed` marks its failed trials.
    """
    widths = [math.nan]
    tried = values.done()[k] | failed
    for trials in study.stages():
        if trials > tried.size or not tried[:trials].all():
            return widths, trials
        if failed[:trials].any():
            return widths, 0  # a failed trial ends the stages
        if study.until is not None:
            widths.append(half_width(study, values, k, trials))
            if study.until.holds(widths[-1]):
                break
    return widths, 0


def _runnable(data: xr.Dataset, studies: Sequence[Study], brain_file: Brains) -> NDArray[np.bool_]:
    """A mask of the settings that are of a study, (setting,).

    Raises InputError for a brain, adversary or metric file that is neither given nor found.
    """
    marks = data.variables["fingerprint"].values.tolist()
    known = np.zeros(len(marks), np.bool_)
    for study in studies:
        settings = settings_of(study)
        ours = np.array([mark in settings for mark in marks])
        for mark in {*marks} & settings.keys():
            must_be_read(settings[mark])
        if ours.any():
            metrics_may_run(study, brain_file)
        known |= ours
    return known


def _compare(
    data: xr.Dataset,
    studies: Sequence[Study],
    wanted: NDArray[np.bool_],
    compared: NDArray[np.bool_],
    jobs: int | None,
    progress: Report,
    device: Device,
) -> list[Difference]:
    """The first difference of each trial that is `compared`, (setting, trial), once those `wanted` are made again."""
    stored = {name: data.variables[name].values for name in kinds_in(data)}
    parts, close = [], np.zeros(len(wanted))
    for study in studies:
        settings = settings_of(study)
        marks = data.variables["fingerprint"].values.tolist()
        places = np.array([k for k, mark in enumerate(marks) if mark in settings and wanted[k].any()], np.intp)
        if places.size:
            chosen = [settings[marks[k]] for k in places]
            made, on_card = _made_again(data, study, chosen, places, wanted, jobs, progress, device)
            parts.append(made)
            close[places] = _closeness(data, chosen, on_card)
    again = _union(stored, parts, {name: dims for name, (dims, *_) in kinds_in(data).items()})
    out: dict[tuple[int, int], Difference] = {}
    for name, (dims, *_) in kinds_in(data).items():
        differ = ~same_bits(stored[name], again[name])
        if close.any():
            differ &= _apart(name, stored[name], again[name], close.reshape(-1, *[1] * (differ.ndim - 1)))
        by_trial = differ.any(axis=_others(dims)) & compared
        for row, column in np.argwhere(by_trial).tolist():
            number, trial = int(data.variables["setting"].values[row]), int(data.variables["trial"].values[column])
            position = {"setting": row, "trial": column}
            at = tuple(position.get(d, slice(None)) for d in dims)
            values = (
                np.atleast_1d(array[at])[np.atleast_1d(differ[at])][0].item() for array in (stored[name], again[name])
            )
            out.setdefault((number, trial), Difference(number, trial, name, *values))
    return [out[key] for key in sorted(out)]


def _made_again(
    data: xr.Dataset,
    study: Study,
    settings: list[Setting],
    places: NDArray[np.intp],
    wanted: NDArray[np.bool_],
    jobs: int | None,
    progress: Report,
    device: Device,
) -> tuple[Columns, NDArray[np.bool_]]:
    """Run trials of a study's settings, at their `places`, again.

    Returns their variables in the shape of the dataset's, with everything else missing, and which settings ran on a
    card.
    """
    trials, local = data.variables["trial"].values, study.measure.local
    own = trials < study.trials
    columns = np.zeros((len(settings), study.trials), np.bool_)
    columns[:, trials[own]] = wanted[np.ix_(places, own)]
    placing = placing_of(study, settings, columns.sum(axis=1), device, local=local)
    values, _ = recompute(study, settings, columns, local, placing, jobs, progress)
    checkpoints = data.variables["checkpoint"].values
    seen = np.isin(checkpoints, study.checkpoints)
    from_ = {"trial": trials[own], "checkpoint": np.searchsorted(study.checkpoints, checkpoints[seen])}
    into = {"setting": places, "trial": np.flatnonzero(own), "checkpoint": np.flatnonzero(seen)}
    made = {}
    for name, (dims, *_) in kinds_in(data).items():
        made[name] = np.full_like(data.variables[name].values, missing_value(data.variables[name].dtype))
        if name in values.arrays:
            robots = np.arange(min(data.sizes["robot"], max(values.robots)))
            source = [{"setting": np.arange(len(settings)), "robot": robots}.get(d, from_.get(d)) for d in dims]
            target = [{"robot": robots}.get(d, into.get(d)) for d in dims]
            made[name][np.ix_(*target)] = values.arrays[name][np.ix_(*source)]
    return made, placing.on_card


def _others(dims: Sequence[str]) -> tuple[int, ...]:
    """The axes that are neither settings nor trials."""
    return tuple(k for k, dim in enumerate(dims) if dim not in ("setting", "trial"))


def _union(stored: Columns, parts: Sequence[Columns], dims: Mapping[str, Sequence[str]]) -> Columns:
    """The variables that several studies make together: of each trial, what those measure of which it has all.

    If it has all of none, they are what all of them measure.
    """
    if len(parts) == 1:
        return parts[0]
    whole = []
    for made in parts:
        of_trial = [
            (is_missing(made[name]) | ~is_missing(stored[name])).all(axis=_others(dims[name])) for name in stored
        ]
        whole.append(np.logical_and.reduce(of_trial))
    again = {name: np.full_like(array, missing_value(array.dtype)) for name, array in stored.items()}
    none = ~np.logical_or.reduce(whole) if parts else np.zeros(0)
    for made, has in zip(parts, whole, strict=True):
        for name, array in again.items():
            taken = np.expand_dims(has | none, _others(dims[name])) & ~is_missing(made[name])
            np.copyto(array, made[name], where=taken)
    return again


def _closeness(data: xr.Dataset, settings: Sequence[Setting], on_card: NDArray[np.bool_]) -> NDArray[np.float64]:
    """By how much numbers of each setting may differ, (setting,): 0 unless it computes otherwise on a card."""
    before = "device" in data.attrs  # a card has run networks
    return np.array(
        [
            CLOSE[s.precision]
            if (now or (before and s.body is None)) and not all(map(selftest.is_exact, s.brains))
            else 0
            for s, now in zip(settings, on_card.tolist(), strict=True)
        ],
        np.float64,
    )


def _apart(name: str, stored: NDArray[Any], rerun: NDArray[Any], close: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which values differ by more than they may, where two machines compute by `close` differently."""
    far = (close == 0.0) | ~np.isclose(stored, rerun, rtol=close, atol=close, equal_nan=True)
    may = np.broadcast_to(close > 0, far.shape) & (name not in ESTIMATED)
    few = (far & may).sum() <= math.ceil(SHARE_APART * (may & ~is_missing(stored)).sum())
    return np.asarray(far & ~may if few else far)
