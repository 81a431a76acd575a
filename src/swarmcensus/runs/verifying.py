"""Verifies results: makes them again from their study, in full or in part, and compares the two bit for bit."""

import math
import secrets
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.brains.library import TITLES
from swarmcensus.results import (
    MAY_DIFFER,
    Brains,
    Values,
    dataset,
    differences,
    failed_in,
    failed_trials,
    finished_trials,
    is_missing,
    kinds_in,
    laid_out,
    load_packed,
    metrics_may_run,
    most_trials,
    must_be_read,
    others,
    outline,
    packed,
    positions,
    same_bits,
    schema,
    settings_of,
    studies_of,
)
from swarmcensus.runs.collect import Report
from swarmcensus.runs.devices import Device, Hardware, placing_of
from swarmcensus.runs.progress import showing
from swarmcensus.runs.running import half_width, recompute
from swarmcensus.studies import Setting, Study
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option, wrong_option
from swarmcensus.support.quantities import PER_TRIAL, QUANTITIES
from swarmcensus.support.version import __version__
from swarmcensus.translation import selftest

CLOSE = {"double": 1e-12, "single": 1e-4}  # what exp, log and lgamma may make estimates differ by, relative above 1
ESTIMATED = ("final_estimate", "estimates")
DIFFER = 1  # exit code if results differ
SHARE_APART = 0.01  # of other values, such as times, that may then differ
# what does not follow from estimates
EXACT = {name for name, one in QUANTITIES.items() if one.group in ("messages", "networks", "drawn")}


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
    known, `cautions` about what somebody may have chosen; `unchecked` are phrases about what could not be compared.
    """

    checked: int
    stored: int
    differences: list[Difference]
    labels: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    unchecked: list[str] = field(default_factory=list)
    cautions: list[str] = field(default_factory=list)  # type: ignore[assignment]
    excused: int = 0  # values that differ by no more than cards and processors may
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
        if self.excused:
            equal = f"the same, but for {counted(self.excused, 'value')} that cards and processors compute differently"
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
            "differences": self.differences, "excused": self.excused, "labels": self.labels, "notes": self.notes,
            "unchecked": self.unchecked, "cautions": self.cautions,
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
    such as exp may differ as they do between machines: estimates by `CLOSE`, and times, errors and decisions in
    a hundredth of their values, errors by twice delta. Raises InputError.
    """
    if not 0.0 < sample <= 1.0:
        raise wrong_option("sample", sample, "should be a share above 0, and at most 1")
    if seed is None and sample < 1.0:
        seed = secrets.randbelow(2**31)
    data = packed(results) if isinstance(results, xr.Dataset) else load_packed(results)
    schema.check_dataset(data)
    studies = studies_of(data, brain_file)
    held = {*data["fingerprint"].values.tolist()}
    for study in studies:  # before the first trial, and of all settings: the sample must not decide what is missing
        ours = [one for mark, one in settings_of(study).items() if mark in held]
        for setting in ours:
            must_be_read(setting)
        if ours:
            metrics_may_run(study, brain_file)
    trials = min(max(study.trials for study in studies), int(data["trial"].values.max(initial=-1)) + 1)
    again = outline(studies, "merged" in data.attrs, trials)
    stored = laid_out(data, again)
    labels = [*differences(data, again, studies), *_wrong_counts(data, stored, studies)]
    if not Values.of(data).done().any():
        raise InputError("these results hold no finished trial")
    tried = Values.of(stored).done() | failed_trials(stored)  # failed ones should fail again
    every = np.argwhere(tried)
    count = min(len(every), max(1, math.ceil(sample * len(every))))
    chosen = every[np.sort(np.random.default_rng(seed).permutation(len(every))[:count])]
    wanted = np.zeros_like(tried)
    wanted[chosen[:, 0], chosen[:, 1]] = True
    with showing(progress, "verify") as report:
        close, lacking = _run_again(again, stored, studies, wanted, Hardware(jobs, device), report)
    # trials that never ran left nothing
    found, excused = _differences_of_trials(stored, again, wanted | ~tried, close, float(data.attrs["delta"]))
    of = {} if isinstance(results, xr.Dataset) else {"of": str(results)}
    notes = list(_notes(data))
    if lacking:
        notes.append(f"{counted(lacking, 'trial')} of merged studies lack what another of these measures")
    cautions = list(_cautions(data, studies))
    return Verification(count, len(every), found, labels, notes, list(_unchecked(data)), cautions, excused, seed, **of)


def _notes(data: xr.Dataset) -> Iterator[str]:
    version = data.attrs["swarmcensus_version"]
    if version != __version__:
        yield f"the file is of version {version}, and this is {__version__}"


def _cautions(data: xr.Dataset, studies: Sequence[Study]) -> Iterator[str]:
    """What fits the study, and yet could mislead."""
    done, total, failed = int(data.attrs["trials_done"]), int(data.attrs["trials_total"]), failed_trials(data).sum()
    if done < total:
        why = f", {failed:,} failed" * bool(failed)
        why += "; the run was cut off, or somebody took out trials for their numbers" * bool(done + failed < total)
        yield f"{total - done:,} of {counted(total, 'trial')} are not in the file{why}"
    called = {name: label for study in studies for name, label in study.labels.items()}
    for (name, label), (other, title) in product(called.items(), TITLES.items()):
        if other != name and label.casefold() in (other, title.casefold()):
            yield f"labels call {name} {label!r}, which is what {other} is called elsewhere"


def _unchecked(data: xr.Dataset) -> Iterator[str]:
    """What of a dataset may differ, and why, as phrases."""
    for one in MAY_DIFFER:
        if names := [name for name in one.names if name in data.attrs or one.only_with in data.attrs]:
            yield f"{', '.join(names)}: {one.why}"


def _wrong_counts(data: xr.Dataset, stored: xr.Dataset, studies: Sequence[Study]) -> Iterator[str]:
    """Sentences about numbers of trials, and half-widths of rules, that do not fit the trials that are there."""
    done, failed, numbers = finished_trials(stored), failed_trials(stored), data.variables["trial"].values
    total, tried = int(data.attrs["trials_total"]), int(done.sum() + failed.sum())
    ruled, most = any(study.until for study in studies), max(study.trials for study in studies)
    if data.attrs["trials_done"] != done.sum():
        yield f"the attribute trials_done is {data.attrs['trials_done']}, and {done.sum()} trials are in the file"
    if (done & failed).any() or failed.sum() != len(failed_in(data)):
        yield "the attribute failed should name trials that are not in the file, each once"
    planned = sum(most_trials(studies).values())
    if total != planned and not (ruled and tried <= total <= planned):
        yield f"the attribute trials_total is {total} in the file and {planned} by its study"
    fits = numbers.size <= most if ruled else numbers.size == most
    if not fits or not np.array_equal(numbers, np.arange(numbers.size)):
        yield f"trial should number the {counted(most, 'trial')} of each setting"
    for study in studies:
        values = Values.of(stored.sel(checkpoint=study.checkpoints))
        marks = settings_of(study)
        for k in (k for k, mark in enumerate(stored["fingerprint"].values.tolist()) if mark in marks):
            widths, lacking = _rule_widths(study, values, k, failed[k])
            if tried == total and lacking:
                yield f"setting {k}: of its {counted(lacking, 'trial')} some are missing, and none is said to be"
            if "half_width" in stored and study.until is not None:
                width = stored["half_width"].values[k].item()
                possible = widths[-1:] if tried == total and not failed[k].any() else widths
                if not same_bits(np.array(width), np.array(possible)).any():
                    yield f"setting {k}: half_width is {width!r} in the file, and {widths[-1]!r} of its trials"


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


def _run_again(
    again: xr.Dataset,
    stored: xr.Dataset,
    studies: Sequence[Study],
    wanted: NDArray[np.bool_],
    hardware: Hardware,
    progress: Report,
) -> tuple[NDArray[np.float64], int]:
    """Run trials that are `wanted`, (setting, trial), and put their values into `again`.

    Of a trial of several studies, it gets what those measure of which `stored` has all; if it has all of none, what all
    of them measure. Returns by how much numbers of each setting may differ, and how many trials have not what all
    studies measure.
    """
    parts, close, some = [], np.zeros(len(wanted)), np.zeros_like(wanted)
    marks = again["fingerprint"].values.tolist()
    for study in studies:
        settings = settings_of(study)
        rows = np.array([k for k, mark in enumerate(marks) if mark in settings and wanted[k].any()], np.intp)
        if not rows.size:
            continue
        chosen, columns, local = [settings[marks[k]] for k in rows], wanted[rows, : study.trials], study.measure.local
        placing = placing_of(hardware, study, chosen, columns.sum(axis=1))
        values, _ = recompute(study, chosen, columns, local, placing, progress)
        close[rows] = _closeness(stored, chosen, placing.on_card)
        made = dataset([study], chosen, [marks[k] for k in rows], values)
        at = positions(again, made, rows)
        has = np.ones_like(columns)
        for name, (dims, *_) in kinds_in(made).items():
            there = ~is_missing(stored[name].values[at(dims)]) if name in stored else np.bool_(True)
            has &= (is_missing(made[name].values) | there).all(axis=others(dims))
        some[at(PER_TRIAL)] |= has
        parts.append((made, at, has))
    lacking = np.zeros_like(wanted)
    for made, at, has in parts:
        taken = has | ~some[at(PER_TRIAL)]
        lacking[at(PER_TRIAL)] |= ~taken & wanted[at(PER_TRIAL)]
        for name, (dims, *_) in kinds_in(made).items():
            old, new = again[name].values[at(dims)], made[name].values
            use = np.expand_dims(taken, others(dims)) & ~is_missing(new)
            again[name].values[at(dims)] = np.where(use, new, old)
    return close, int(lacking.sum())


def _differences_of_trials(
    stored: xr.Dataset, again: xr.Dataset, compared: NDArray[np.bool_], close: NDArray[np.float64], delta: float
) -> tuple[list[Difference], int]:
    """The first difference of each trial that is `compared`, (setting, trial), and how many values are excused."""
    out: dict[tuple[int, int], Difference] = {}
    excused = 0
    for name, (dims, *_) in kinds_in(stored).items():
        old, new = stored[name].values, again[name].values
        differ = ~same_bits(old, new)
        if close.any() and name not in EXACT:
            unlike = differ & _apart(name, old, new, close.reshape(-1, *[1] * (differ.ndim - 1)), delta)
            excused += int((differ & ~unlike & np.expand_dims(compared, others(dims))).sum())
            differ = unlike
        for setting, trial in np.argwhere(differ.any(axis=others(dims)) & compared).tolist():
            at = tuple({"setting": setting, "trial": trial}.get(dim, slice(None)) for dim in dims)
            which = np.atleast_1d(differ[at])
            values = (np.atleast_1d(array[at])[which][0].item() for array in (old, new))
            out.setdefault((setting, trial), Difference(setting, trial, name, *values))
    return [out[key] for key in sorted(out)], excused


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


def _apart(
    name: str, stored: NDArray[Any], rerun: NDArray[Any], close: NDArray[np.float64], delta: float
) -> NDArray[np.bool_]:
    """Which values differ by more than they may, where two machines compute by `close` differently.

    A robot that settles in another round errs there by less than twice `delta` more or less.
    """
    far = (close == 0.0) | ~np.isclose(stored, rerun, rtol=close, atol=close, equal_nan=True)
    may = np.broadcast_to(close > 0, far.shape) & (name not in ESTIMATED)
    if name.endswith("_error"):
        may = may & (np.abs(stored - rerun) <= 2.0 * delta)
    few = (far & may).sum() <= math.ceil(SHARE_APART * (may & ~is_missing(stored)).sum())
    return np.asarray(far & ~may if few else far)
