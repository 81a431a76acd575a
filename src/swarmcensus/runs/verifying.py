"""Verifies results: compares labels with the study, and runs trials again to compare them bit for bit."""

import math
import secrets
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.brains.metrics import Metric
from swarmcensus.results import (
    AGREEMENT,
    ALL_VARIABLES,
    ESTIMATES,
    LOCAL,
    MISSING,
    NETWORKS,
    Brains,
    Values,
    differences_from_study,
    is_missing,
    kinds_in,
    load_packed,
    metrics_may_run,
    missing_value,
    must_be_read,
    packed,
    provenance,
    same_bits,
    settings_of,
    structure,
    studies_of,
    uncheckable,
    wrong_layout,
)
from swarmcensus.runs.collect import Report
from swarmcensus.runs.devices import Device, placing_of
from swarmcensus.runs.progress import showing
from swarmcensus.runs.running import half_width, recompute
from swarmcensus.studies import Setting, Study
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option, wrong_option
from swarmcensus.support.version import __version__
from swarmcensus.translation import selftest

RUN_ATTRIBUTES = (  # attributes of the run, not of the study
    "additions", "trials_done", "trials_total", "failed", "share", "merged", "started", "finished", "wall_seconds",
    "cpu_seconds", "device",
)  # fmt: skip


CLOSE = {"double": 1e-12, "single": 1e-4}  # what exp, log and lgamma may make estimates differ by, relative above 1
ESTIMATED = ("final_estimate", "estimates")
DIFFER = 1  # exit code if results differ
MAY_DIFFER = 0.01  # the share of other values, such as times, that may then differ


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
    if wrong := structure.fault_of(data):
        raise ResultsError(f"damaged or changed: {wrong}")
    studies = studies_of(data, brain_file)
    labels = [*differences_from_study(data, studies), *_rule_problems(data, studies)]
    if not isinstance(results, xr.Dataset):
        labels += wrong_layout(results, data)
    tried = data.variables["convergence_round"].values[:, :, 0] != MISSING
    if not tried.any():
        raise InputError("these results hold no finished trial")
    for setting, trial in structure.failed_pairs(data):  # these should fail again
        tried |= np.outer(data.variables["setting"].values == setting, data.variables["trial"].values == trial)
    done = np.argwhere(tried)
    count = min(len(done), max(1, math.ceil(sample * len(done))))
    chosen = done[np.sort(np.random.default_rng(seed).permutation(len(done))[:count])]
    wanted = np.zeros(data["convergence_round"].shape[:2], np.bool_)
    wanted[chosen[:, 0], chosen[:, 1]] = True
    watched = list({metric.variable: metric for study in studies for metric in study.measure.metrics}.values())
    # before the first trial, and of all settings: which of them are sampled must not decide whether a file is missing
    matches = _matches(data, [_measuring_all_stored(data, study, watched) for study in studies], brain_file)
    matched = np.zeros(len(wanted), np.bool_)
    differences: list[Difference] = []
    with showing(progress, "verify") as report:
        for study, settings in matches:
            matched[[*settings]] = True
            sampled = [place for place in settings if wanted[place].any()]
            if sampled:
                chosen_settings = [settings[place] for place in sampled]
                differences += _compare(data, study, np.array(sampled), chosen_settings, wanted, jobs, report, device)
    wanted[~matched] = False  # these settings are of none of the studies, as `labels` say
    differences.sort(key=lambda d: (d.setting, d.trial))
    notes = list(_notes(data, studies))
    of = {} if isinstance(results, xr.Dataset) else {"of": str(results)}
    return Verification(int(wanted.sum()), len(done), differences, labels, notes, uncheckable(data), seed, **of)


def _notes(data: xr.Dataset, studies: Sequence[Study]) -> Iterator[str]:
    version = data.attrs["swarmcensus_version"]
    if version != __version__:
        yield f"the file is of version {version}, and this is {__version__}: descriptions are not compared"
    done, total = int(data.attrs["trials_done"]), int(data.attrs["trials_total"])
    if done < total:
        failed = len(structure.failed_pairs(data))
        failures = f", {failed:,} failed" if failed else ""
        yield f"{total - done:,} of {counted(total, 'trial')} are not in the file{failures}"
    lacking = done - int((~is_missing(data["agreement_round"].values)).sum() if "agreement_round" in data else 0)
    if lacking:
        yield f"{' and '.join(AGREEMENT)} are not in {counted(lacking, 'trial')}: earlier versions did not store them"
    known = {*RUN_ATTRIBUTES}.union(*map(provenance, studies))  # only some of merged studies may have adversaries
    for name in sorted({*data.attrs} - known):
        yield f"the attribute {name} is not of a run"


def _rule_problems(data: xr.Dataset, studies: Sequence[Study]) -> Iterator[str]:
    """Sentences about trials that are missing although the run ended, and about half-widths that do not match."""
    failed = np.zeros(data["convergence_round"].shape[:2], np.bool_)
    rows, columns = ({n: k for k, n in enumerate(data.variables[d].values.tolist())} for d in ("setting", "trial"))
    for setting, trial in structure.failed_pairs(data):
        failed[rows[setting], columns[trial]] = True
    values = Values.of(data)
    ended = data.attrs["trials_done"] + failed.sum() == data.attrs["trials_total"]
    for study in studies:
        if not {*study.checkpoints} <= {*data.variables["checkpoint"].values.tolist()}:
            continue  # `unlike` reports this
        if "merged" in data.attrs:
            values = Values.of(data.sel(checkpoint=study.checkpoints))
        fingerprints = settings_of(study)
        for k, mark in enumerate(data.variables["fingerprint"].values.tolist()):
            if mark not in fingerprints:
                continue
            number = data.variables["setting"].values[k]
            widths, lacking = _rule_widths(study, values, k, failed[k])
            if ended and lacking:
                yield f"setting {number}: of its {counted(lacking, 'trial')} some are missing, and none is said to be"
            if "half_width" not in data or data.variables["half_width"].dims != ("setting",) or study.until is None:
                continue
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


def _measuring_all_stored(data: xr.Dataset, study: Study, watched: list[Metric]) -> Study:
    """The study, measuring all that a dataset stores: merged results have the measurements of all their studies."""
    longest = max(setting.rounds for setting in study.settings())
    checkpoints = [c for c in data.variables["checkpoint"].values.tolist() if c <= longest] or [longest]
    own: Any = {k: v for k, v in study.measure if v is not None}
    all_of_it = {"checkpoints": checkpoints, "estimates": "estimates" in data, "metrics": watched}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # they were shown when the study was read
        return study.with_(measure=own | all_of_it)


def _matches(data: xr.Dataset, studies: Sequence[Study], brain_file: Brains) -> list[tuple[Study, dict[int, Setting]]]:
    """The settings of each study by their places in a dataset, each place once.

    Raises InputError for a brain, adversary or metric file that is neither given nor found.
    """
    marks = {mark: k for k, mark in enumerate(data.variables["fingerprint"].values.tolist())}
    matches = []
    for study in studies:
        by_mark = settings_of(study)
        settings = {k: by_mark[mark] for mark, k in marks.items() if mark in by_mark}
        marks = {mark: k for mark, k in marks.items() if k not in settings}
        for setting in settings.values():
            must_be_read(setting)
        if settings:
            metrics_may_run(study, brain_file)
        matches.append((study, settings))
    return matches


def _compare(
    data: xr.Dataset,
    study: Study,
    places: NDArray[np.intp],
    settings: list[Setting],
    wanted: NDArray[np.bool_],
    jobs: int | None,
    progress: Report,
    device: Device,
) -> list[Difference]:
    local, merged = "local_convergence_step" in data, "merged" in data.attrs
    trials = data.variables["trial"].values
    columns = np.zeros((len(settings), int(trials.max()) + 1), np.bool_)
    columns[:, trials] = wanted = wanted[places]
    placing = placing_of(study, settings, columns.sum(axis=1), device, local=local)
    again, _ = recompute(study, settings, columns, local, placing, jobs, progress)
    close = _closeness(data, settings, placing.on_card)
    known = [
        study.checkpoints.index(c) if c in study.checkpoints else -1
        for c in data.variables["checkpoint"].values.tolist()
    ]
    out: dict[tuple[int, int], Difference] = {}
    for name, (dims, *_) in kinds_in(data).items():
        others = tuple(k for k, d in enumerate(dims) if d not in ("setting", "trial"))
        stored = data.variables[name].values[places]
        if name in again.arrays:
            rerun = _in_shape_of(again.arrays[name], dims, trials, known, data.sizes["robot"])
        else:  # merged results: this study has no brain with such a variable
            rerun = np.full(stored.shape, missing_value(stored.dtype), stored.dtype)
        differ, there = ~same_bits(stored, rerun), ~is_missing(stored)
        if close.any():
            differ &= _apart(name, stored, rerun, close.reshape(-1, *[1] * (stored.ndim - 1)))
        expected = wanted & there.any(axis=others) if name in AGREEMENT | NETWORKS else wanted
        # what only some merged studies measure is stored for all trials of a setting or none; `unlike` reports others
        if merged and (name in LOCAL or name in ESTIMATES or name not in ALL_VARIABLES):
            expected = expected & there.any(axis=others)
        if merged and "checkpoint" in dims:  # this study may not have all checkpoints either
            differ &= there
        for row, column in np.argwhere(differ.any(axis=others) & expected).tolist():
            number, trial = int(data.variables["setting"].values[places[row]]), int(trials[column])
            position = {"setting": row, "trial": column}
            at = tuple(position.get(d, slice(None)) for d in dims)
            values = (np.atleast_1d(array[at])[np.atleast_1d(differ[at])][0].item() for array in (stored, rerun))
            out.setdefault((number, trial), Difference(number, trial, name, *values))
    return list(out.values())


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
    few = (far & may).sum() <= math.ceil(MAY_DIFFER * (may & ~is_missing(stored)).sum())
    return np.asarray(far & ~may if few else far)


def _in_shape_of(
    array: NDArray[Any], dims: tuple[str, ...], trials: NDArray[Any], known: list[int], robots: int
) -> NDArray[Any]:
    """A variable in the shape of a dataset; `known` are the places of the dataset's checkpoints in it, or -1."""
    array = array.take(trials, dims.index("trial"))
    if "checkpoint" in dims:
        array = array[:, known]
        array[:, np.array(known) < 0] = np.nan
    if "robot" in dims:
        more = [(0, max(0, robots - n)) if d == "robot" else (0, 0) for d, n in zip(dims, array.shape, strict=True)]
        array = np.pad(array, more, constant_values=missing_value(array.dtype))[..., :robots]
    return array
