"""Resuming: a run takes over the finished trials of its output, and never loses any of them."""

import contextlib
import json
import warnings
from collections.abc import Callable, Container, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import (
    ESTIMATES,
    INTERVALS,
    LOCAL,
    MARKS,
    MISSING,
    Columns,
    Identity,
    Parts,
    Values,
    changed_plugin,
    kinds_in,
    metrics_label,
    missing_value,
    provenance,
    shard_files,
    shards,
    sources_of,
    store,
)
from swarmcensus.studies import Setting, Study
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.files import check_writable
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import continuing, option
from swarmcensus.support.toml_text import read_toml
from swarmcensus.support.version import __version__

UNCOMPARED = ("name", "trials", "seed", "labels", "groups", "measure")  # keys in no fingerprint, and seed


def hint() -> str:
    """What to do about existing results that a run cannot continue."""
    return f"{option('fresh', True)} runs everything again, {option('out', 'another.nc')} keeps these results"


def identity_of(study: Study) -> Identity:
    """What results must agree in to belong to the same run of a study."""
    measure = study.measure
    metrics = metrics_label(sources_of(measure.metrics))
    return Identity(study.name, study.seed, __version__, measure.delta, measure.bins, measure.truth, metrics)


@dataclass
class HeldOutput:
    """An output that is locked against other runs, and the results to be taken over from it."""

    out: Path
    study: Study
    settings: Sequence[Setting]
    parts: Parts
    say: Callable[[str], None]
    old: xr.Dataset | None  # the existing output, until it is taken over
    numbers: dict[str, int]  # of settings, by their fingerprints
    share: str = ""  # which part of the trials is run, such as "1/4"; empty for all
    seconds: tuple[float, float] = (0.0, 0.0)  # wall and processor time of the results taken over
    old_attributes: dict[str, Any] | None = None  # attributes of the existing output
    devices: set[str] = field(default_factory=set)  # cards that made some of it

    def fill(self, values: Values) -> None:
        """Put finished results into `values`, and say how many. Raises InputError if they are of another study."""
        if self.old is not None:
            self.old_attributes = self.old.attrs
            self._take_over_file(values, self.old)
            self.old = None  # releases its memory
        before = int(values.done().sum())
        shards = 0
        for path, shard in self.parts.every_shard():
            if shard is None:
                warnings.warn(f"{path} is damaged: what it held is run again", stacklevel=2)
                path.unlink()
                continue
            shards += 1
            wall, cpu = self.seconds
            self.seconds = wall + shard.about["wall_seconds"], cpu + shard.about["cpu_seconds"]
            self.devices.update(filter(None, [shard.about.get("device")]))
            for piece in shard.found:
                self._take_over(values, piece.setting, piece.first, piece.columns, shard.about["checkpoints"], path)
        done = int(values.done().sum())
        if done:
            known = f"{done:,} of " * (not self.study.until)
            total = done if self.study.until else self.study.trials * len(self.settings)
            in_shards = f"; {done - before:,} of them in {counted(shards, 'shard')} of a run that was cut off"
            where = in_shards if shards else ""
            self.say(f"{self.out}: found {known}{counted(total, 'trial')}{where}")

    def announce(self, found: int, total: int, work: float) -> None:
        """Write down for `status` what is going to be run."""
        self.parts.flush()  # so that no trial is counted both as found and in a shard
        self.parts.announce(
            settings=len(self.settings), found=found, total=total, work=work,
            rule=self.study.until.until if self.study.until else "", share=self.share, command=continuing(),
            shards=[path.name for path in shard_files(self.parts.folder)],
        )  # fmt: skip

    def finish(self, data: xr.Dataset) -> None:
        """Write the whole output, if there is anything new, and remove the shards."""
        old = self.old_attributes
        if not data.attrs["trials_done"] and self.out.exists():
            return  # a fresh run was stopped before its first trial: the old output stays
        nothing = old is not None and not self.parts.added and not shard_files(self.parts.folder)
        if nothing and all(old.get(key) == data.attrs.get(key) for key in ("study", "failed")):  # type: ignore[union-attr]
            return
        self.parts.flush()
        store.save(data, self.out)
        self.parts.clear()

    def _setting_number(self, fingerprint: str, path: Path) -> int:
        if fingerprint not in self.numbers:
            sketch = self.parts.folder / shards.SKETCH
            old = self.old if path == self.out else store.load_packed(sketch) if sketch.is_file() else None
            why = what_changed(old, self.study) if old is not None else ""
            why = why or "it holds a setting that is not in this study: a key or a file has changed since"
            raise InputError.of(path, f"{why}. {hint()}")
        return self.numbers[fingerprint]

    def _check_trials(self, trials: int) -> None:
        if trials > self.study.trials:
            raise InputError(
                f"{self.out} holds {counted(trials, 'trial')} a setting, this study asks for "
                f"{self.study.trials:,}. {hint()}",
                file=self.out,
            )

    def _take_over_file(self, values: Values, old: xr.Dataset) -> None:
        self.parts.identity.check(vars(Identity.of(old)), str(self.out), hint())
        if problem := changed_plugin(old, self.study):
            raise InputError.of(self.out, f"{problem}. {hint()}")
        self.devices.update(filter(None, old.attrs.get("device", "").split(", ")))
        self.seconds = float(old.attrs.get("wall_seconds", 0.0)), float(old.attrs.get("cpu_seconds", 0.0))
        last = int(old["trial"].values.max(initial=-1))
        if last >= old.sizes["trial"]:  # some trials were left out
            fill = {name: missing_value(old[name].dtype) for name in kinds_in(old)}
            old = old.reindex(trial=np.arange(last + 1), fill_value=fill)
        arrays = {name: old[name].values for name in kinds_in(old)}
        self._check_names(arrays, values, self.out)
        for place, mark in enumerate(old["fingerprint"].values):
            # only settings with any finished trial: others may be of a brain that failed and has been changed since
            if any((arrays[name][place, :, 0] != MISSING).any() for name in MARKS if name in arrays):
                columns = {name: array[place] for name, array in arrays.items()}
                self._take_over(values, str(mark), 0, columns, old["checkpoint"].values.tolist(), self.out)

    def _take_over(
        self, values: Values, mark: str, first: int, taken: Columns, checkpoints: list[int], path: Path
    ) -> None:
        """Put the trials of a setting, from the `first` on, into `values`. Raises InputError."""
        number, trials = self._setting_number(mark, path), len(next(taken[name] for name in MARKS if name in taken))
        self._check_trials(first + trials)
        self._check_names(taken, values, path)
        values.grow(first + trials)
        per_checkpoint = [name for name in taken if "checkpoint" in values.kinds[name][0]]
        if per_checkpoint:  # of merged files, a setting may lack some though the file has all
            done, rounds = taken["convergence_round"][:, 0] != MISSING, self.settings[number].rounds
            for name in per_checkpoint:
                needed = done & (name not in INTERVALS)  # which brains may lack
                taken = taken | {name: self._select_checkpoints(taken[name], checkpoints, rounds, needed, path)}
        robots = values.robots[number]
        of_robots = {name for name in taken if "robot" in values.kinds[name][0]}
        values.put(number, first, {n: v[..., :robots] if n in of_robots else v for n, v in taken.items()})

    def _check_names(self, names: Container[Hashable], values: Values, path: Path) -> None:
        for name in LOCAL | ESTIMATES:
            if name in names and name not in values.arrays:
                raise InputError(f"{path} holds {name}, which this study does not ask for. {hint()}", file=path)
        for name in ESTIMATES:
            if name not in names and name in values.arrays and "correct" in names:
                raise InputError(f"{path} has no {name}, which this study asks for. {hint()}", file=path)

    def _select_checkpoints(
        self, stored: NDArray[Any], known: list[int], rounds: int, done: NDArray[np.bool_], path: Path
    ) -> NDArray[Any]:
        """The `stored` values (checkpoint, trial ...) at this study's checkpoints, which `known` are stored.

        Values are missing after the last round. Raises InputError if a trial that is `done` lacks a checkpoint.
        """
        wanted = np.array(self.study.checkpoints)
        taken = np.full((wanted.size, *stored.shape[1:]), np.nan)
        taken[np.isin(wanted, known)] = stored[np.isin(known, wanted)]
        first = taken if taken.ndim == 2 else taken[..., 0]  # the first robot's, if there is one value per robot
        lacking = wanted[(np.isnan(first) & done).any(axis=1) & (wanted <= rounds)]
        if lacking.size:
            raise InputError(
                f"{path} has no decisions at round {lacking[0]}, which is a checkpoint of this study: name in "
                f"measure.checkpoints those that it has ({', '.join(map(str, known))}). {hint()}",
                file=path,
            )
        return taken


def what_changed(old: xr.Dataset, study: Study) -> str:
    """The files, else the keys, in which a study differs from that of results, as a sentence; empty if in none."""
    ours = provenance([study])
    files = [
        name
        for kind in ("brains", "adversaries")
        for name, file in json.loads(ours.get(kind, "{}")).items()
        if json.loads(old.attrs.get(kind, "{}")).get(name, file)["sha256"] != file["sha256"]
    ]
    tables: dict[str, tuple[str, Any]] = {f"floor_{one.name}": (one.source, one.grey) for one in study.pictures}
    tables |= {f"edges_{one.name}": (one.source, one.edges) for one in study.topologies if one.source}
    files += [file for name, (file, now) in tables.items() if name in old and not np.array_equal(old[name], now)]
    if files:
        return f"{' and '.join(files)} {'has' if len(files) == 1 else 'have'} changed since it was made"
    from pandas import json_normalize  # slow to import

    there, here = (
        json_normalize(read_toml(text, "study")).iloc[0].to_dict() for text in (old.attrs["study"], study.text)
    )
    keys = [key for key in here | there if not key.startswith(UNCOMPARED) and there.get(key) != here.get(key)]
    return "; ".join(f"{key} is {there.get(key, 'unset')} there and {here.get(key, 'unset')} here" for key in keys)


@contextlib.contextmanager
def hold_output(
    out: Path,
    study: Study,
    settings: Sequence[Setting],
    fingerprints: Sequence[str],
    fresh: bool,
    say: Callable[[str], None],
) -> Iterator[HeldOutput]:
    """Lock an output for the block; if the block fails, finished results stay in shards.

    With `fresh`, existing results are ignored, also by runs that continue this one after it was cut off. Raises
    InputError if another run has locked the output, or if it is damaged or of another study.
    """
    check_writable(out)
    with Parts(out, identity_of(study), study.checkpoints, fingerprints) as parts:
        if fresh:
            parts.begin_anew()
        old: xr.Dataset | None = None
        if out.exists() and not parts.replaces:
            try:
                old = store.load_packed(out)
            except InputError as error:
                raise ResultsError(f"{error}. {hint()}", file=out) from None
        numbers = {mark: number for number, mark in enumerate(fingerprints)}
        output = HeldOutput(out, study, settings, parts, say, old, numbers)
        del old
        try:
            yield output
        except BaseException:
            with contextlib.suppress(InputError):
                parts.flush()
            raise
