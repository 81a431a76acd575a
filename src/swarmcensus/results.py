"""The dataset's schema: how results are laid out, stored, opened and exported."""

import importlib.metadata
import json
import platform
import types
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus import __version__
from swarmcensus.engine.trials import Batch
from swarmcensus.errors import InputError
from swarmcensus.files import whole
from swarmcensus.settings import Setting
from swarmcensus.studies import Study

PER_ROBOT = ("setting", "trial", "robot")
VARIABLES: dict[str, tuple[tuple[str, ...], Any, str, str]] = {
    "convergence_round": (PER_ROBOT, np.int32, "rounds", "K, the convergence of the informed estimate"),
    "convergence_error": (PER_ROBOT, np.float64, "1", "|x^K - f|, the informed estimate's error at convergence"),
    "final_estimate": (PER_ROBOT, np.float64, "1", "the informed estimate after the last round"),
    "correct": (("setting", "checkpoint", "trial"), np.float64, "1", "fraction of robots in the correct bin"),
    "true_fill_ratio": (("setting", "trial"), np.float64, "1", "black share of the floor that robots can reach"),
}
LOCAL: dict[str, tuple[tuple[str, ...], Any, str, str]] = {
    "local_convergence_step": (PER_ROBOT, np.int32, "observations", "convergence of the local estimate"),
    "local_convergence_error": (PER_ROBOT, np.float64, "1", "the local estimate's error at convergence"),
}
MISSING = -1  # for whole numbers; NaN for the others
FORMAT = "swarmcensus results 1"
LIBRARIES = ("numpy", "numba", "xarray", "h5netcdf")


def empty(study: Study, settings: list[Setting]) -> xr.Dataset:
    """A study's dataset before the first trial, all values missing."""
    checkpoints = study.checkpoints
    sizes = {
        "setting": len(settings),
        "trial": study.trials,
        "robot": max(s.robots for s in settings),
        "checkpoint": len(checkpoints),
    }
    data = xr.Dataset(coords={k: np.arange(n) for k, n in sizes.items()} | {"checkpoint": checkpoints})
    data["checkpoint"].attrs["units"] = "rounds"
    columns = [s.coordinates for s in settings]
    for key in columns[0]:
        values = [c[key] for c in columns]
        text = isinstance(values[0], str)
        data = data.assign_coords({key: ("setting", np.array(values, dtype=object if text else None))})
    for name, (dims, kind, units, meaning) in (VARIABLES | (LOCAL if study.measure.local else {})).items():
        shape = [sizes[d] for d in dims]
        blank = np.full(shape, MISSING, kind) if np.issubdtype(kind, np.integer) else np.full(shape, np.nan)
        comment = {"comment": f"{MISSING}: no such robot, or not run"} if blank.dtype.kind == "i" else {}
        data[name] = (dims, blank, {"units": units, "long_name": meaning, **comment})
    for topology in study.world.topology:
        if topology.source:
            data = data.assign({f"edges_{topology.name}": (
                (f"edge_{topology.name}", "end"), np.array(topology.edges, np.int32).reshape(-1, 2),
                {"long_name": "undirected edges", "source": topology.source},
            )})  # fmt: skip
    for picture in study.pictures:
        data = data.assign({f"floor_{picture.name}": (
            (f"row_{picture.name}", f"column_{picture.name}"), picture.grey,
            {"long_name": "grey levels of an image, 0 black to 65535 white", "source": picture.source},
        )})  # fmt: skip
    data.attrs = provenance(study)
    return data


def provenance(study: Study) -> dict[str, Any]:
    """How a dataset came to be: enough to make it again."""
    return {
        "format": FORMAT,
        "title": study.name,
        "study": study.text,
        "seed": study.seed,
        "delta": study.measure.delta,
        "bins": study.measure.bins,
        "truth": study.measure.truth,
        "brains": json.dumps(
            {b.name: {"sha256": b.sha256, "source": b.source} for b in study.swarm.brain}, sort_keys=True
        ),
        "swarmcensus_version": __version__,
        "python_version": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
        "library_versions": ", ".join(f"{n} {importlib.metadata.version(n)}" for n in LIBRARIES),
    }


def store(data: xr.Dataset, number: int, first: int, batch: Batch, local: bool) -> None:
    """Put a batch in its place: setting `number`, trials from `first`."""
    trials, robots = batch.final.shape
    place = (number, slice(first, first + trials), slice(robots))
    if local:
        data["local_convergence_step"].values[place] = batch.convergence
        data["local_convergence_error"].values[place] = batch.error
        return
    data["convergence_round"].values[place] = batch.convergence
    data["convergence_error"].values[place] = batch.error
    data["final_estimate"].values[place] = batch.final
    data["correct"].values[number, :, place[1]] = batch.correct
    if batch.true_fill_ratio is not None:
        data["true_fill_ratio"].values[place[:2]] = batch.true_fill_ratio


def save(data: xr.Dataset, path: str | Path) -> None:
    """Write a dataset or a trace as netCDF-4, whole or not at all. Raises InputError."""
    packed = {"zlib": True, "complevel": 1, "shuffle": True}
    integers = [n for n, v in data.data_vars.items() if v.dtype.kind in "iu" and v.size > 1000]
    with whole(path) as beside:
        data.to_netcdf(beside, engine="h5netcdf", encoding=dict.fromkeys(integers, packed))


def load(path: str | Path) -> xr.Dataset:
    """Read a results file. Raises InputError where it is not there, cut short, or not of swarmcensus."""
    path = Path(path)
    if not path.is_file():
        raise InputError(f"results file {path}: there is no such file")
    try:
        with xr.open_dataset(path, engine="h5netcdf") as data:
            data = data.load()
    except Exception as error:  # whatever a damaged HDF5 file provokes
        raise InputError(
            f"results file {path}: not a readable netCDF-4 file (cut short or damaged?): "
            f"{str(error).splitlines()[0] if str(error) else type(error).__name__}"
        ) from error
    if data.attrs.get("format") != FORMAT or not set(VARIABLES) <= set(data.data_vars):
        raise InputError(f"results file {path}: not a results file of swarmcensus")
    return data


def study_of(data: xr.Dataset, brain: str | Path | None = None) -> Study:
    """The study that a dataset holds, as it was run.

    A brain that is not shipped is given as a file, and must have the source that the results were made with; a
    file named in results is not run unasked. Others of the study's brains stay unread: see `must_be_read`.
    Raises InputError.
    """
    from swarmcensus import brains

    try:
        sources = {
            str(n): {"sha256": s["sha256"], "source": s["source"]} for n, s in json.loads(data.attrs["brains"]).items()
        }
        text = str(data.attrs["study"])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(
            f"these results do not say how they were made (attributes study and brains): {error!r}"
        ) from None
    known = {}
    if brain is not None:
        given = brains.load(brain)
        names = [n for n, s in sources.items() if s["sha256"] == given.sha256]
        if not names:
            raise InputError(f"brain {brain}: not the source that these results were made with ({', '.join(sources)})")
        known = {n: replace_name(given, n) for n in names}
    for name, source in sources.items():
        if name not in known and name not in brains.shipped():
            known[name] = brains.Brain(name, Path(name), source["source"], {}, (), (), types.ModuleType("unread"))
    edges = {v.attrs["source"]: v.values.tolist() for n, v in data.data_vars.items() if str(n).startswith("edges_")}
    images = {v.attrs["source"]: v.values for n, v in data.data_vars.items() if str(n).startswith("floor_")}
    context = {"edges": edges, "brains": known, "images": images}
    study = Study.parse(text, where="the study in these results", context=context)
    for used in study.swarm.brain:
        if used.sha256 != sources.get(used.name, {}).get("sha256"):
            raise InputError(f"brain {used.name!r}: its source has changed since these results were made")
    return study


def must_be_read(brain: Any) -> None:
    """Raise InputError for a brain file that results name and that nobody gave."""
    if not brain.message:
        raise InputError(
            f"the brain {brain.name!r} is a file, and a file named in results is not run unasked: "
            "give it yourself (--brain FILE, or brain=...)"
        )


def replace_name(brain: Any, name: str) -> Any:
    """The same brain under the name that a study knows it by."""
    import dataclasses

    return dataclasses.replace(brain, name=name)


def to_frame(data: xr.Dataset) -> Any:
    """Results in long form: a pandas table with one row a robot and trial."""
    per_robot = [n for n in (*VARIABLES, *LOCAL) if n in data and data[n].dims == PER_ROBOT]
    size = data["robots"].values
    mask = np.arange(data.sizes["robot"]) < size[:, np.newaxis]
    mask = np.broadcast_to(mask[:, np.newaxis, :], data["final_estimate"].shape)
    mask = mask & np.isfinite(data["final_estimate"].values)
    setting, trial, robot = np.nonzero(mask)
    import pandas as pd

    columns: dict[str, Any] = {"setting": data["setting"].values[setting]}
    columns |= {str(k): c.values[setting] for k, c in data.coords.items() if c.dims == ("setting",) and k != "setting"}
    columns |= {"trial": data["trial"].values[trial], "robot": data["robot"].values[robot]}
    columns |= {n: data[n].values[mask] for n in per_robot}
    return pd.DataFrame(columns)


def export(data: xr.Dataset, path: str | Path, kind: str) -> int:
    """Write results in long form as "csv" or "parquet"; returns the number of rows. Raises InputError."""
    frame = to_frame(data)
    with whole(path) as beside:
        if kind == "csv":
            frame.to_csv(beside, index=False)
        else:
            try:
                frame.to_parquet(beside, index=False)
            except ImportError:
                raise InputError("parquet needs pyarrow: pip install 'swarmcensus[parquet]'") from None
    return len(frame)
