"""What an output holds already: its finished trials are taken over, and none of them is ever lost by a run."""

import contextlib
import warnings
from collections.abc import Callable, Container, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.files import check_writable
from swarmcensus.basics.formatting import counted
from swarmcensus.basics.options import option
from swarmcensus.basics.version import __version__
from swarmcensus.results import store
from swarmcensus.results.shards import Identity, Parts, listed
from swarmcensus.results.values import (
    ESTIMATES,
    INTERVALS,
    LOCAL,
    MISSING,
    Columns,
    Values,
    edited,
    kinds_in,
    metrics_in,
    sources_of,
    told,
)
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study


def hint() -> str:
    """What to do about results that are in the way."""
    return f"Run with {option('fresh', True)} to begin anew, or write elsewhere with {option('out')}"


def identity_of(study: Study) -> Identity:
    """What work of a study must have in common with its other work."""
    measure = study.measure
    watched = told(sources_of(measure.metrics))
    return Identity(study.name, study.seed, __version__, measure.delta, measure.bins, measure.truth, watched)


@dataclass
class Holding:
    """An output that is held against other runs, and what is to be taken over from it."""

    out: Path
    study: Study
    settings: Sequence[Setting]
    parts: Parts
    say: Callable[[str], None]
    old: xr.Dataset | None  # the output as it was, if it was there, until it is taken over
    share: str = ""  # which part of the trials is run, as "1/4"; empty for all
    seconds: tuple[float, float] = (0.0, 0.0)  # wall and processor, of what is taken over
    about: dict[str, Any] | None = None  # what the old output said of itself
    _numbers: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Know settings by what they are."""
        self._numbers = {print_: number for number, print_ in enumerate(self.parts.fingerprints)}

    def fill(self, values: Values) -> None:
        """Put what is there into `values`, and say how much it is. Raises InputError where it does not belong here."""
        if self.old is not None:
            self.about = self.old.attrs
            self._take_file(values, self.old)
            self.old = None  # it may be large
        before = int(values.done().sum())
        shards = 0
        for path, shard in self.parts.found():
            if shard is None:
                warnings.warn(f"{path} is damaged: what it held is run again", stacklevel=2)
                path.unlink()
                continue
            shards += 1
            self.seconds = (
                self.seconds[0] + shard.about["wall_seconds"],
                self.seconds[1] + shard.about["cpu_seconds"],
            )
            for one in shard.found:
                place = self._place(one.setting, path)
                self._check_trials(_end(one.first, one.columns))
                self._check_names(one.columns, values, path)
                values.grow(_end(one.first, one.columns))
                values.put(place, one.first, self._of_shard(one.columns, shard.about["checkpoints"], place, path))
        done = int(values.done().sum())
        if done:
            known = f"{done:,} of " * (not self.study.until)
            total = done if self.study.until else self.study.trials * len(self.settings)
            where = (
                f"; {done - before:,} of them in {counted(shards, 'shard')} of a run that was cut off" if shards else ""
            )
            self.say(f"{self.out}: found {known}{counted(total, 'trial')}{where}")

    def announce(self, found: int, total: int, work: float) -> None:
        """Say for `status` what is going to be run."""
        self.parts.flush()  # what is counted as found is not counted again as a shard
        self.parts.announce(
            settings=len(self.settings), found=found, total=total, work=work,
            rule=self.study.until.until if self.study.until else "", share=self.share,
            shards=[path.name for path in listed(self.parts.folder)],
        )  # fmt: skip

    def finish(self, data: xr.Dataset) -> None:
        """Write the output whole, if there is anything new; then the shards are no longer needed."""
        old = self.about
        if not data.attrs["trials_done"] and self.out.exists():
            return  # begun anew, and stopped at once
        nothing = old is not None and not self.parts.added and not listed(self.parts.folder)
        if nothing and all(old.get(key) == data.attrs.get(key) for key in ("study", "failed")):  # type: ignore[union-attr]
            return
        self.parts.flush()
        store.save(data, self.out)
        self.parts.clear()

    def _place(self, fingerprint: str, path: Path) -> int:
        if fingerprint not in self._numbers:
            raise InputError(
                f"{path} holds a setting that is not in this study: has a value been taken out of the study file, or "
                f"a brain, body, fault, edge list, image or file of another package been changed? {hint()}"
            )
        return self._numbers[fingerprint]

    def _check_trials(self, trials: int) -> None:
        if trials > self.study.trials:
            raise InputError(
                f"{self.out} holds {counted(trials, 'trial')} a setting, this study asks for "
                f"{self.study.trials:,}. {hint()}"
            )

    def _take_file(self, values: Values, old: xr.Dataset) -> None:
        about = {
            "study": old.attrs.get("title"), "seed": old.attrs.get("seed"), "delta": old.attrs.get("delta"),
            "version": old.attrs.get("swarmcensus_version"), "bins": old.attrs.get("bins"),
            "truth": old.attrs.get("truth"), "metrics": told(metrics_in(old)),
        }  # fmt: skip
        self.parts.identity.check(about, str(self.out), hint())
        if said := edited(old, self.study):
            raise InputError(f"{self.out}: {said}. {hint()}")
        self.seconds = float(old.attrs.get("wall_seconds", 0.0)), float(old.attrs.get("cpu_seconds", 0.0))
        ran = _has_any(old)
        rows = np.array([self._place(str(mark), self.out) for mark in old["fingerprint"].values[ran]], np.intp)
        trials = old["trial"].values
        if trials.size == 0:
            return
        self._check_trials(int(trials.max()) + 1)
        values.grow(int(trials.max()) + 1)
        if old.sizes["robot"] > max(values.robots):
            raise InputError(f"{self.out} holds larger swarms than this study. {hint()}")
        self._check_names(list(old), values, self.out)
        done = old["convergence_round"].values[ran, :, 0] != MISSING
        for name, (dims, *_) in kinds_in(old).items():
            taken = old[name].values[ran]
            if "checkpoint" in dims:
                looked, rounds = old["checkpoint"].values, old["rounds"].values[ran]
                taken = self._at_our_checkpoints(taken, looked, rounds, done & (name not in INTERVALS), self.out)
            places = {"setting": rows, "trial": trials}
            where = (places.get(d, np.arange(n)) for d, n in zip(dims, taken.shape, strict=True))
            values.arrays[name][np.ix_(*where)] = taken

    def _check_names(self, names: Container[Hashable], values: Values, path: Path) -> None:
        for name in LOCAL | ESTIMATES:
            if name in names and name not in values.arrays:
                raise InputError(f"{path} holds {name}, which this study does not ask for. {hint()}")
        for name in ESTIMATES:
            if name not in names and name in values.arrays and "correct" in names:
                raise InputError(f"{path} has no {name}, which this study asks for. {hint()}")

    def _of_shard(self, taken: Columns, known: list[int], place: int, path: Path) -> Columns:
        if "correct" not in taken or known == self.study.checkpoints:
            return taken
        rounds, done = np.array([self.settings[place].rounds]), np.ones((1, taken["correct"].shape[1]), np.bool_)
        looked = [name for name in taken if name == "correct" or name in ESTIMATES | INTERVALS]
        due = {name: done & (name not in INTERVALS) for name in looked}  # which a setting's brain may not have
        return taken | {
            name: self._at_our_checkpoints(taken[name][np.newaxis], np.array(known), rounds, due[name], path)[0]
            for name in looked
        }

    def _at_our_checkpoints(
        self, looked: NDArray[Any], known: NDArray[Any], rounds: NDArray[Any], done: NDArray[np.bool_], path: Path
    ) -> NDArray[Any]:
        """What was `looked` at, (setting, checkpoint, trial ...), at this study's checkpoints.

        It is missing after a setting's last round.

        Raises InputError where one was not looked at in a trial that is `done`.
        """
        ours = np.array(self.study.checkpoints)
        taken = np.full((len(looked), ours.size, *looked.shape[2:]), np.nan)
        taken[:, np.isin(ours, known)] = looked[:, np.isin(known, ours)]
        reached = (ours <= rounds[:, np.newaxis])[:, :, np.newaxis]
        first = taken if taken.ndim == 3 else taken[..., 0]  # of the robots, if it is of each
        lacking = np.flatnonzero((np.isnan(first) & reached & done[:, np.newaxis]).any(axis=(0, 2)))
        if lacking.size:
            raise InputError(
                f"{path} has no decisions at round {ours[lacking[0]]}, which is a checkpoint of this study: name in "
                f"measure.checkpoints those that it has ({', '.join(map(str, known.tolist()))}). {hint()}"
            )
        return taken


def _has_any(data: xr.Dataset) -> NDArray[np.bool_]:
    """Settings of which any trial is done: the others hold nothing, as those of a brain that failed and was mended."""
    names = ("convergence_round", "local_convergence_step")
    return np.asarray(np.any([(data[n].values[:, :, 0] != MISSING).any(axis=1) for n in names if n in data], axis=0))


def _end(first: int, taken: Columns) -> int:
    name = "local_convergence_step" if "local_convergence_step" in taken else "convergence_round"
    return first + len(taken[name])


@contextlib.contextmanager
def hold(
    out: Path,
    study: Study,
    settings: Sequence[Setting],
    fingerprints: Sequence[str],
    fresh: bool,
    say: Callable[[str], None],
) -> Iterator[Holding]:
    """Hold an output as long as the block lasts; where that fails, what was finished stays in its shards.

    Raises InputError where another run holds it, or where it is damaged or of another study; with `fresh`, what is
    there is left aside, also by the runs that go on after this one was cut off.
    """
    check_writable(out)
    with Parts(out, identity_of(study), study.checkpoints, fingerprints) as parts:
        if fresh:
            parts.begin_anew()
        old: xr.Dataset | None = None
        if out.exists() and not parts.replaces:
            try:
                old = store.load(out)
            except InputError as error:
                raise InputError(f"{error}. {hint()}") from None
        holding = Holding(out, study, settings, parts, say, old)
        del old
        try:
            yield holding
        except BaseException:
            with contextlib.suppress(InputError):
                parts.flush()
            raise
