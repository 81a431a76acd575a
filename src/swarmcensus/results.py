"""The dataset's schema: how results are laid out, stored, opened and exported."""

import dataclasses
import importlib.metadata
import json
import platform
import types
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import xarray as xr

from swarmcensus import __version__, brains
from swarmcensus.errors import InputError
from swarmcensus.files import whole
from swarmcensus.settings import Setting
from swarmcensus.studies import Study
from swarmcensus.values import EVERY, MISSING, PER_ROBOT, VARIABLES, Values

Brains = str | Path | Iterable[str | Path] | None  # brain files, given for those that results name
FORMAT = "swarmcensus results 1"
TEXTS = ("brain", "topology", "accuracy", "assumed_accuracy", "floor")  # coordinates of settings
MAYBE = ("side",)  # older files lack it
NUMBERS = ("robots", "density", "fill_ratio", "link_success", "rounds", "observations_per_round")
ATTRIBUTES: dict[str, Any] = {
    "title": str, "study": str, "brains": str, "swarmcensus_version": str, "truth": str, "delta": float | np.floating,
    **dict.fromkeys(("seed", "bins", "trials_done", "trials_total"), int | np.integer),
}  # fmt: skip
LIBRARIES = ("numpy", "numba", "xarray", "h5netcdf")


def dataset(study: Study, settings: list[Setting], fingerprints: list[str], values: Values) -> xr.Dataset:
    """A study's dataset: its numbers as far as they are there, with what they are of and how they came to be."""
    checkpoints = study.checkpoints
    robots = values.arrays["final_estimate"].shape[2]
    sizes = {"setting": len(settings), "trial": values.trials, "robot": robots, "checkpoint": len(checkpoints)}
    coordinates: dict[str, Any] = {k: np.arange(n) for k, n in sizes.items()} | {"checkpoint": checkpoints}
    columns = [s.coordinates for s in settings]
    for key in columns[0]:
        column = [c[key] for c in columns]
        coordinates[key] = ("setting", np.array(column, dtype=object if isinstance(column[0], str) else None))
    variables: dict[str, Any] = {}
    for name, array in values.arrays.items():
        dims, _, units, meaning = EVERY[name]
        comment = {"comment": f"{MISSING}: no such robot, or not run"} if array.dtype.kind == "i" else {}
        variables[name] = (dims, array, {"units": units, "long_name": meaning, **comment})
    variables["fingerprint"] = (
        "setting", np.array(fingerprints, dtype=object),
        {"long_name": "the address of all that a setting's numbers depend on"},
    )  # fmt: skip
    for topology in study.topologies:
        if topology.source:
            says = {"long_name": "directed links: sender, receiver", "directed": 1} if topology.directed else {
                "long_name": "undirected edges"}  # fmt: skip
            variables[f"edges_{topology.name}"] = (
                (f"edge_{topology.name}", "end"), np.array(topology.edges, np.int32).reshape(-1, 2),
                says | {"source": topology.source},
            )  # fmt: skip
    for picture in study.pictures:
        variables[f"floor_{picture.name}"] = (
            (f"row_{picture.name}", f"column_{picture.name}"), picture.grey,
            {"long_name": "grey levels of an image, 0 black to 65535 white", "source": picture.source},
        )  # fmt: skip
    data = xr.Dataset(variables, coordinates, provenance(study))
    data["checkpoint"].attrs["units"] = "rounds"
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
        "brains": json.dumps({b.name: {"sha256": b.sha256, "source": b.source} for b in study.brains}, sort_keys=True),
        "swarmcensus_version": __version__,
        "python_version": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "library_versions": ", ".join(f"{n} {importlib.metadata.version(n)}" for n in LIBRARIES),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or "unknown"


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
        with h5py.File(path) as file:
            file["/"]  # h5netcdf would complain twice of a root that cannot be read, once past all handlers
        with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as data:
            data = data.load()
    except Exception as error:  # whatever a damaged HDF5 file provokes
        raise InputError(
            f"results file {path}: not a readable netCDF-4 file (cut short or damaged?): "
            f"{str(error).splitlines()[0] if str(error) else type(error).__name__}"
        ) from error
    if data.attrs.get("format") != FORMAT or not {*VARIABLES, "fingerprint"} <= set(data.data_vars):
        raise InputError(f"results file {path}: not a results file of swarmcensus")
    wrong = _wrong(data)
    try:
        _made_from(data)
    except InputError as error:
        wrong = wrong or str(error)
    if wrong:
        raise InputError(f"results file {path}: damaged or changed: {wrong}")
    return data


def _wrong(data: xr.Dataset) -> str | None:
    """What of a dataset is not as `dataset` makes it, in words; None where nothing is."""
    kinds = {"fingerprint": "UO", **dict.fromkeys(NUMBERS, "iuf"), **dict.fromkeys(TEXTS, "UO")}
    kinds |= {name: "iuf" for name in MAYBE if name in data}
    for name, (dims, kind, *_) in EVERY.items():
        if name in data and (data[name].dims != dims or data[name].dtype != kind):
            return f"{name} should be {np.dtype(kind)} ({', '.join(dims)})"
    for name, allowed in kinds.items():
        if name not in data or data[name].dims != ("setting",) or data[name].dtype.kind not in allowed:
            return f"{name} should have one {'text' if allowed == 'UO' else 'number'} a setting"
        if allowed == "UO" and not all(isinstance(value, str) for value in data[name].values.tolist()):
            return f"{name} should be text"
    for name in ("setting", "trial", "robot", "checkpoint"):
        numbers = data[name].values if name in data.coords else np.zeros(0)
        if numbers.dtype.kind not in "iu" or numbers.shape != (data.sizes[name],) or not numbers.size:
            return f"{name} should number what there is of it"
        if (np.diff(numbers) <= 0).any() or numbers[0] < 0 or numbers[-1] >= 2**31:
            return f"{name} should be numbers from 0 in rising order"
    if not (data["robots"].values == np.clip(data["robots"].values, 1, data.sizes["robot"])).all():
        return f"robots should be 1 to {data.sizes['robot']}"
    if len(set(data["fingerprint"].values.tolist())) < data.sizes["setting"]:
        return "two settings have one fingerprint"
    for name, kind in ATTRIBUTES.items():
        if not isinstance(data.attrs.get(name), kind):
            return f"the attribute {name} is missing or of another kind"
    for key, array in data.data_vars.items():
        inside = "iu" if str(key).startswith("edges_") else "u" if str(key).startswith("floor_") else ""
        if inside and (array.ndim != 2 or array.dtype.kind not in inside or "source" not in array.attrs):
            return f"{key} should be whole numbers in rows, with their source"
    try:
        for one in json.loads(data.attrs.get("failed", "[]")):
            if one["setting"] not in data["setting"].values or not isinstance(one["trial"], int):
                return "the attribute failed names a setting that is not there"
    except (ValueError, KeyError, TypeError):
        return "the attribute failed is no list of failures"
    return None


def setting_of(data: xr.Dataset, number: int, brain: Brains = ()) -> tuple[Study, Setting]:
    """The setting of this number in a dataset, and the study that it is of: see `studies_of`. Raises InputError."""
    if number not in data["setting"].values:
        known = data["setting"].values
        raise InputError(f"setting {number}: these results hold setting {known.min()} to {known.max()}")
    mark = str(data["fingerprint"].sel(setting=number).values)
    for study in studies_of(data, brain):
        settings = study.settings()
        # its place in the grid, but for merged studies
        order = [settings[number], *settings] if 0 <= number < len(settings) else settings
        for setting in order:
            if setting.fingerprint(study.seed) == mark:
                must_be_read(setting.brain)
                return study, setting
    raise InputError(f"setting {number}: it is not of the study that these results name")


def studies_of(data: xr.Dataset, brain: Brains = ()) -> list[Study]:
    """The studies that a dataset holds, as they were run: one, but for merged results.

    Brains that are not shipped are given as files, and must have the sources that the results were made with; a
    file named in results is not run unasked. Others of the studies' brains stay unread: see `must_be_read`.
    Raises InputError.
    """
    sources, texts = _made_from(data)
    known: dict[str, brains.Brain] = {}
    for path in [brain] if isinstance(brain, str | Path) else brain or ():
        given = brains.load(path)
        names = [n for n, s in sources.items() if s["sha256"] == given.sha256]
        if not names:
            raise InputError(f"brain {path}: not the source that these results were made with ({', '.join(sources)})")
        known |= {n: dataclasses.replace(given, name=n) for n in names}
    for name, source in sources.items():
        if name not in known and name not in brains.shipped():
            known[name] = brains.Brain(name, Path(name), source["source"], {}, (), (), types.ModuleType("unread"))
    edges = {v.attrs["source"]: v.values.tolist() for n, v in data.data_vars.items() if str(n).startswith("edges_")}
    images = {v.attrs["source"]: v.values for n, v in data.data_vars.items() if str(n).startswith("floor_")}
    context = {"edges": edges, "brains": known, "images": images, "kept": True}
    studies = [Study.parse(text, where="the study in these results", context=context) for text in texts]
    for used in (brain for study in studies for brain in study.brains):
        if used.sha256 != sources.get(used.name, {}).get("sha256"):
            raise InputError(f"brain {used.name!r}: its source has changed since these results were made")
    return studies


def _made_from(data: xr.Dataset) -> tuple[dict[str, dict[str, str]], list[str]]:
    """The brains of a dataset, by name, and the texts of its studies. Raises InputError."""
    try:
        sources = {
            str(n): {"sha256": str(s["sha256"]), "source": str(s["source"])}
            for n, s in json.loads(data.attrs["brains"]).items()
        }
        texts = [str(text) for text in json.loads(data.attrs["merged"])] if "merged" in data.attrs else []
        texts = texts or [str(data.attrs["study"])]
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise InputError(
            f"these results do not say how they were made (attributes study and brains): {error!r}"
        ) from None
    return sources, texts


def must_be_read(brain: Any) -> None:
    """Raise InputError for a brain file that results name and that nobody gave."""
    if not brain.message:
        raise InputError(
            f"the brain {brain.name!r} is a file, and a file named in results is not run unasked: "
            "give it yourself (--brain FILE, or brain=...)"
        )


def to_frame(data: xr.Dataset) -> Any:
    """Results in long form: a pandas table with one row a robot and trial."""
    per_robot = [n for n in EVERY if n in data and data[n].dims == PER_ROBOT]
    size = data["robots"].values
    mask = np.arange(data.sizes["robot"]) < size[:, np.newaxis]
    mask = np.broadcast_to(mask[:, np.newaxis, :], data["final_estimate"].shape)
    mask = mask & np.isfinite(data["final_estimate"].values)
    setting, trial, robot = np.nonzero(mask)
    import pandas as pd

    columns: dict[str, Any] = {"setting": data["setting"].values[setting]}
    columns |= {str(k): c.values[setting] for k, c in data.coords.items() if c.dims == ("setting",) and k != "setting"}
    columns |= {"trial": data["trial"].values[trial], "robot": data["robot"].values[robot]}
    columns |= {"true_fill_ratio": data["true_fill_ratio"].values[setting, trial]}
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
