"""What results were made from: their studies and brains, read from what the results carry themselves.

The text of a study in a results file may name files, and may be somebody else's. No edge list and no image is opened
but those in the results, and no brain file is run but one that was given, or that lies below the folder in which one
works, where the study says, with the very source that the results hold.
"""

import contextlib
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import xarray as xr

from swarmcensus import brains, metrics
from swarmcensus.basics.errors import InputError
from swarmcensus.basics.options import option
from swarmcensus.basics.times import Time, in_ticks
from swarmcensus.brains import adversary
from swarmcensus.results.structure import adversaries_in, made_from
from swarmcensus.results.values import additions_in, edited, metrics_in
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study
from swarmcensus.worlds.networks import MOVING

Brains = str | Path | Iterable[str | Path] | None  # brain files, given for those that results name


def setting_of(data: xr.Dataset, number: int, brain: Brains = (), *, run: bool = True) -> tuple[Study, Setting]:
    """The setting of this number in a dataset, and the study that it is of: see `studies_of`. Raises InputError."""
    if number not in data["setting"].values:
        known = data["setting"].values
        raise InputError(f"setting {number}: these results hold setting {known.min()} to {known.max()}")
    mark = str(data["fingerprint"].sel(setting=number).values)
    for study in studies_of(data, brain, run=run):
        settings = study.settings()
        # its place in the grid, but for merged studies
        order = [settings[number], *settings] if 0 <= number < len(settings) else settings
        for setting in order:
            if setting.fingerprint(study.seed) == mark:
                if run:
                    must_be_read(setting)
                return study, setting
    why = next(filter(None, (edited(data, study) for study in studies_of(data, brain))), "")
    raise InputError(f"setting {number}: it is not of the study that these results name{': ' * bool(why)}{why}")


def origins_of(data: xr.Dataset, numbers: Iterable[int]) -> dict[int, tuple[Study, Setting]]:
    """The settings of these numbers and their studies, with no brain run: as `setting_of`, reading studies once. Raises
    InputError."""
    known = {
        setting.fingerprint(study.seed): (study, setting)
        for study in studies_of(data, run=False)
        for setting in study.settings()
    }
    marks = {number: str(data["fingerprint"].sel(setting=number).values) for number in map(int, numbers)}
    return {n: known[mark] if mark in known else setting_of(data, n, run=False) for n, mark in marks.items()}


def studies_of(data: xr.Dataset, brain: Brains = (), *, run: bool = True) -> list[Study]:
    """The studies that a dataset holds, as they were run: one, but for merged results.

    Brains that are not shipped are given as files, or lie below the current folder where the study says; they must
    have the sources that the results were made with, and are not run before that is known. Others of the studies'
    brains stay unread (see `must_be_read`), with run=False all of them. Raises InputError.
    """
    (sources, texts), lying = made_from(data), adversaries_in(data)
    known: dict[str, brains.Brain] = {}
    liars: dict[str, brains.Adversary] = {}
    for path in [brain] if isinstance(brain, str | Path) else brain or ():
        place = adversary.find(path) if adversary.is_meant(str(path), None) else brains.find(path)
        given = brains.read_source("brain", place)
        names, theirs = (
            [n for n, s in some.items() if s["sha256"] == brains.digest(given)] for some in (sources, lying)
        )
        if any(one["sha256"] == brains.digest(given) for one in metrics_in(data).values()):
            continue
        if not names and not theirs:
            made_with = ", ".join([*sources, *lying])
            raise InputError(f"brain {path}: not the source that these results were made with ({made_with})")
        known |= {n: brains.parse(given, n, place) for n in names}
        liars |= {n: adversary.parse(given, n, place) for n in theirs}
    for name, source in sources.items():
        if name not in known and not (run and name in brains.DOOR):
            known[name] = (run and _found(name, source["source"])) or brains.unread(name, source["source"])
    for name, source in lying.items():
        if name not in liars and not (run and name in adversary.DOOR):
            here = run and _lies_here("adversary", name, source["source"])
            liars[name] = (adversary.parse if here else adversary.unread)(source["source"], name, Path(name))
    edges = {v.attrs["source"]: v.values.tolist() for n, v in data.data_vars.items() if str(n).startswith("edges_")}
    images = {v.attrs["source"]: v.values for n, v in data.data_vars.items() if str(n).startswith("floor_")}
    watched = [metrics.parse(one["source"], one["name"], Path(one["name"])) for one in metrics_in(data).values()]
    named = {metric.name: metric for metric in watched}  # read, and not run
    context = {"base": None, "edges": edges, "brains": known, "adversaries": liars, "images": images, "metrics": named,
               "kept": True}  # fmt: skip
    try:
        studies = [Study.parse(text, where="the study in these results", context=context) for text in texts]
    except InputError as error:
        raise InputError(f"{error}{_lacking(data)}") from None
    for study in studies:
        for before, now in ((sources, study.brains), (lying, study.adversaries)):
            for used in now:
                if used.sha256 != before.get(used.name, {}).get("sha256"):
                    raise InputError(f"{used.what} {used.name!r}: its source has changed since these results were made")
    return studies


def _lacking(data: xr.Dataset) -> str:
    """Which packages that results were made with are not installed here."""
    absent = set()
    for one in additions_in(data).values():
        try:
            distribution(one["package"])
        except PackageNotFoundError:
            absent.add(f"{one['package']} {one['version']}".strip())
    return f": these results were made with {', '.join(sorted(absent))}, not installed here" if absent else ""


def round_of(data: xr.Dataset, value: int | Time | None, key: str) -> int | None:
    """A round as it is, a time in ticks, where all settings have robots that move, by one clock. Raises InputError."""
    if not isinstance(value, Time):
        return value
    moving = bool((data["topology"].values == MOVING).all())
    clocks = {study.world.body.tick for study in studies_of(data, run=False)} if moving else set()
    if len(clocks) > 1:
        raise InputError(f"{key} {value}: these results have several clocks: should be a number of ticks")
    try:
        return in_ticks(value, clocks.pop() if clocks else None, key)
    except ValueError as error:
        raise InputError(str(error)) from None


def must_be_read(setting: Setting) -> None:
    """Raise InputError for a brain's or adversary's file that results name, and that was neither given nor found."""
    theirs = (member.brain for member in setting.members if member.brain)
    for one in (one for one in (setting.brain, *theirs) if not one.is_read):
        raise InputError(
            f"the {one.what} {one.name!r} is a file, and a file named in results is not run unasked, but where it lies "
            f"below the current folder, unchanged: give it yourself as it was, with {option('brain')}"
        )


def metrics_may_run(study: Study, given: Brains = ()) -> None:
    """Raise InputError for a metric that is not here, or given as a file, with the very source that results hold."""
    paths = [given] if isinstance(given, str | Path) else given or ()
    known = {brains.digest(brains.read_source("metric", Path(path))) for path in paths if Path(path).is_file()}
    for metric in study.measure.metrics:
        name, here = metric.name, False
        if metric.sha256 in known:
            continue
        known_here = name in metrics.DOOR
        if known_here:
            here = brains.read_source("metric", metrics.DOOR.path(name)) == metric.source
        if here or _lies_here("metric", name, metric.source):
            continue
        if known_here:
            raise InputError(f"metric {name!r}: its source has changed since these results were made")
        raise InputError(
            f"the metric {name!r} is a file, and a file named in results is not run unasked, but where it lies "
            f"below the current folder as it was: give it yourself, with {option('brain')}"
        )


def _found(name: str, source: str) -> brains.Brain | None:
    """The brain file of this name, where it lies below the current folder and has this source: no other is run."""
    with contextlib.suppress(InputError):
        if _lies_here("brain", name, source):
            return brains.parse(source, name, Path(name))
    return None


def _lies_here(kind: str, name: str, source: str) -> bool:
    """Whether a file of this name and source lies below the current folder."""
    with contextlib.suppress(OSError, ValueError, InputError):
        place = Path(name).resolve()
        small = place.is_file() and place.stat().st_size <= 2 * len(source.encode()) + 3  # line ends and a byte mark
        return small and place.is_relative_to(Path.cwd().resolve()) and brains.read_source(kind, place) == source
    return False
