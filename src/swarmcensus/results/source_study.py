"""The studies and brains that results were made from, read from the results themselves.

A study in a results file may name files and may come from somebody else. Edge lists and images are read only from the
results. Only what makes trials again runs a file of a brain, topology, floor or spread, and only if the user gives it,
or if it lies below the current folder, where the study says, with exactly the source in the results.
"""

import contextlib
from collections.abc import Iterable, Sequence
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import xarray as xr

from swarmcensus import brains
from swarmcensus.brains import adversary, metrics
from swarmcensus.results.outlines import settings_of
from swarmcensus.results.plugin_files import may_run, plugin_files_of
from swarmcensus.results.schema import attributes_of
from swarmcensus.results.values import additions_in, changed_plugin, metric_of
from swarmcensus.studies import Setting, Study
from swarmcensus.support.errors import BrainError, InputError, ResultsError
from swarmcensus.support.options import wrong_option
from swarmcensus.support.plugins import digest, not_run, read_source
from swarmcensus.support.times import Time, in_ticks
from swarmcensus.worlds import MOVING, FileEdges

CHANGED = "its source has changed since these results were made"
Brains = str | Path | Sequence[str | Path] | None  # brain files, given for those that results name


def check_held(data: xr.Dataset, **numbers: int) -> None:
    """Raise InputError unless `data` has these numbers, such as setting=3 and trial=0."""
    for name, number in numbers.items():
        known = data[name].values
        if number not in known:
            raise wrong_option(name, number, f"these results hold {name} {known.min()} to {known.max()}")


def setting_of(data: xr.Dataset, number: int, brain: Brains = (), *, run: bool = True) -> tuple[Study, Setting]:
    """The setting with this number and its study (see `studies_of`). Raises InputError."""
    check_held(data, setting=number)
    mark = str(data["fingerprint"].sel(setting=number).values)
    studies = studies_of(data, brain, run=run)
    for study in studies:
        if setting := settings_of(study).get(mark):
            if run:
                must_be_read(setting)
            return study, setting
    why = next(filter(None, (changed_plugin(data, study) for study in studies)), "")
    why = f"it is not of the study that these results name{': ' * bool(why)}{why}"
    raise ResultsError.named("setting", number, why)


def origins_of(data: xr.Dataset, numbers: Iterable[int]) -> dict[int, tuple[Study, Setting]]:
    """The studies and settings by number, as `setting_of`, but without running any brain. Raises InputError."""
    studies = studies_of(data, run=False)
    known = {mark: (study, setting) for study in studies for mark, setting in settings_of(study).items()}
    marks = {number: str(data["fingerprint"].sel(setting=number).values) for number in map(int, numbers)}
    return {n: known[mark] if mark in known else setting_of(data, n, run=False) for n, mark in marks.items()}


def studies_of(data: xr.Dataset, brain: Brains = (), *, run: bool = True) -> list[Study]:
    """The studies of a dataset, as they were run: one, or several in merged results.

    Brains that are not shipped are given as files, or lie below the current folder where the study says. They must have
    the sources that the results were made with; this is checked before they are run. Other brains stay unread (see
    `must_be_read`), and with run=False all do. Raises InputError.
    """
    about = attributes_of(data.attrs)
    sources, lying = about.brains, about.adversaries
    known: dict[str, brains.Brain] = {}
    liars: dict[str, brains.Adversary] = {}
    given = _paths(brain)
    others = {other["sha256"] for other in (*about.metrics.values(), *about.plugin_files.values())}
    for path in given:
        place = adversary.find(path) if adversary.exists(str(path), None) else brains.find(path)
        source = read_source("brain", place)
        mark = digest(source)
        names, theirs = ([n for n, s in stored.items() if s["sha256"] == mark] for stored in (sources, lying))
        if mark in others:
            continue
        if not names and not theirs:
            why = f"not the source that these results were made with ({', '.join([*sources, *lying])})"
            raise BrainError.of(path, why, where=f"brain {path}")
        known |= {n: brains.parse(source, n, place) for n in names}
        liars |= {n: adversary.parse(source, n, place) for n in theirs}
    for name, stored in sources.items():
        if name not in known and not (run and name in brains.PLUGINS):
            known[name] = brains.unloaded(name, stored["source"])
            with contextlib.suppress(InputError):
                if run and may_run("brain", name, stored["source"]):
                    known[name] = brains.parse(stored["source"], name, Path(name))
    for name, stored in lying.items():
        if name not in liars and not (run and name in adversary.PLUGINS):
            here = run and may_run("adversary", name, stored["source"])
            liars[name] = (adversary.parse if here else adversary.unloaded)(stored["source"], name, Path(name))
    tables = [(str(name), one.attrs.get("source", ""), one) for name, one in data.data_vars.items()]
    lists = [(of, one) for name, of, one in tables if name.startswith("edges_")]
    edges = {of: FileEdges(one.values.tolist(), "directed" in one.attrs) for of, one in lists}
    images = {of: one.values for name, of, one in tables if name.startswith("floor_")}
    named = {metric.name: metric for metric in (metric_of(data, variable) for variable in about.metrics)}  # not run
    context = {"base": None, "edges": edges, "brains": known, "adversaries": liars, "images": images, "metrics": named,
               "plugins": plugin_files_of(data, given, run=run), "kept": True}  # fmt: skip
    try:
        studies = [Study.parse(text, where="the study in these results", context=context) for text in about.texts]
    except InputError as error:
        raise InputError(f"{error}{_lacking(data)}", key=error.key, value=error.value, hint=error.hint) from None
    for study in studies:
        for before, now in ((sources, study.brains), (lying, study.adversaries)):
            for used in now:
                if used.name not in before or used.sha256 != before[used.name]["sha256"]:
                    raise BrainError.named(used.kind, used.name, CHANGED)
    return studies


def _paths(given: Brains) -> list[Path]:
    return list(map(Path, [given] if isinstance(given, str | Path) else given or ()))


def _lacking(data: xr.Dataset) -> str:
    """A phrase with the packages that the results need and that are not installed here."""
    absent = set()
    for addition in additions_in(data).values():
        try:
            distribution(addition["package"])
        except PackageNotFoundError:
            absent.add(f"{addition['package']} {addition['version']}".strip())
    return f": these results were made with {', '.join(sorted(absent))}, not installed here" if absent else ""


def round_of(data: xr.Dataset, value: int | Time | None, key: str) -> int | None:
    """Convert a time to ticks; a round stays as it is. Raises InputError if the settings have no common clock."""
    if not isinstance(value, Time):
        return value
    moving = bool((data["topology"].values == MOVING).all())
    clocks = {study.world.body.tick for study in studies_of(data, run=False)} if moving else set()
    if len(clocks) > 1:
        several = f"{key} {value}: these results have several clocks: should be a number of ticks"
        raise InputError(several, key=key, value=value)
    try:
        return in_ticks(value, clocks.pop() if clocks else None, key)
    except ValueError as error:
        raise InputError(str(error), key=key, value=value) from None


def must_be_read(setting: Setting) -> None:
    """Raise InputError for a brain or adversary file that was neither given nor found."""
    of_members = (member.brain for member in setting.members if member.brain)
    for brain in (brain for brain in (setting.brain, *of_members) if not brain.is_loaded):
        raise not_run(brain.kind, brain.name)


def metrics_may_run(study: Study, given: Brains = ()) -> None:
    """Raise InputError for a metric with a source that is neither shipped, nor given, nor found."""
    known = {digest(read_source("metric", path)) for path in _paths(given) if path.is_file()}
    for metric in study.measure.metrics:
        name, is_known = metric.name, metric.name in metrics.PLUGINS
        same = is_known and read_source("metric", metrics.PLUGINS.path(name)) == metric.source
        if not (metric.sha256 in known or same or may_run("metric", name, metric.source)):
            raise BrainError.named("metric", name, CHANGED) if is_known else not_run("metric", name)
