"""The dataset is made, saved, loaded and exported."""

import functools
import importlib.metadata
import json
import platform
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from swarmcensus.results import netcdf, schema
from swarmcensus.results.existing_files import check_there, folder_of
from swarmcensus.results.reading import NOT_RUN, packed, readable
from swarmcensus.results.values import MISSING, Values, kinds_in, robots_in, selected, sources_of
from swarmcensus.studies import COORDINATES, Setting, Study, coordinates_of
from swarmcensus.support.control_characters import write_csv
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.options import command
from swarmcensus.support.plugins import PluginFile, is_unread
from swarmcensus.support.quantities import PER_ROBOT, PER_TRIAL, QUANTITIES
from swarmcensus.support.version import __version__

if TYPE_CHECKING:
    import pandas as pd

LIBRARIES = ("numpy", "numba", "xarray", "h5netcdf")


def dataset(study: Study, settings: list[Setting], fingerprints: list[str], values: Values) -> xr.Dataset:
    """The dataset of a study: its values so far, its coordinates, and how it was made."""
    checkpoints = study.checkpoints
    robots = values.arrays["final_estimate"].shape[2]
    sizes = {"setting": len(settings), "trial": values.trials, "robot": robots, "checkpoint": len(checkpoints)}
    coordinates: dict[str, Any] = {k: np.arange(n) for k, n in sizes.items()} | {"checkpoint": checkpoints}
    columns = [coordinates_of(s) for s in settings]
    for key in dict.fromkeys(key for column in columns for key in column):
        coordinates[key] = ("setting", column_of(filled([c.get(key) for c in columns], key)))
    variables: dict[str, Any] = {}
    for name, array in values.arrays.items():
        dims, _, units, meaning = values.kinds[name]
        comment = {"comment": NOT_RUN.format(MISSING)} if array.dtype.kind == "i" else {}
        variables[name] = (dims, array, {"units": units, "long_name": meaning, **comment})
    honest = [s.honest for s in settings]  # stored where some lie
    about: dict[str, list[Any]] = {"honest": honest} if any(s.honest < s.robots for s in settings) else {}
    about["memory_bytes"] = [s.brain.memory_bytes for s in settings]
    about["message_bytes"] = [s.brain.message_bytes for s in settings]
    about["anonymous"] = [int(not any(b.uses.name for b in s.brains)) for s in settings]
    about["fingerprint"] = fingerprints
    variables |= {name: ("setting", column_of(values), attributes_of(name)) for name, values in about.items()}
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


def filled(column: list[Any], key: str) -> list[Any]:
    """The values of a coordinate, with the blank value for settings that have none."""
    known = COORDINATES.get(key)
    if known and known.blank is not None:
        return [value or known.blank for value in column]
    if any(isinstance(value, str) for value in column):
        return ["" if value is None else str(value) for value in column]
    return [np.nan if value is None else value for value in column]


def column_of(values: list[Any]) -> NDArray[Any]:
    """One value per setting, as an array with the dataset's type."""
    return np.array(values, dtype=object if isinstance(values[0], str) else None)


def attributes_of(name: str) -> dict[str, str]:
    """The attributes of a quantity of settings."""
    quantity = QUANTITIES[name]
    return ({"units": quantity.unit} if quantity.unit else {}) | {"long_name": quantity.meaning}


def widths_of_rule(study: Study, widths: NDArray[np.float64]) -> tuple[str, NDArray[np.float64], dict[str, str]]:
    """The variable `half_width` of a study with a rule, (setting,)."""
    assert study.until is not None
    return "setting", widths, {**attributes_of("half_width"), "rule": study.until.until}


def provenance(study: Study) -> dict[str, Any]:
    """The attributes that say how a dataset was made, enough to make it again."""
    named = {brain.name for grid in study.grids for brain in grid.swarm.brain}
    used = {  # attributes in JSON, which only some studies have
        "adversaries": {one.name: {"sha256": one.sha256, "source": one.source} for one in study.adversaries},
        "metrics": sources_of(study.measure.metrics),
        "parameters": {b.name: list(b.parameters) for b in study.brains if b.parameters and b.name in named},
        "accuracies": _accuracies(study),
        "plugin_files": {f"{f.kind} {f.name}": {"sha256": f.sha256, "source": f.source} for f in study.plugin_files},
        "additions": study.additions,
    }
    return {
        "format": schema.FORMAT,
        "title": study.name,
        "study": study.text,
        "seed": study.seed,
        "delta": study.measure.delta,
        "bins": study.measure.bins,
        "truth": study.measure.truth,
        "brains": json.dumps({b.name: {"sha256": b.sha256, "source": b.source} for b in study.brains}, sort_keys=True),
        "swarmcensus_version": __version__,
        "python_version": platform.python_version(),
        # metrics keep the order of the study, which is that of their variables
        **{key: json.dumps(value, sort_keys=key != "metrics") for key, value in used.items() if value},
        "machine": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "library_versions": _libraries(),
    }


def _accuracies(study: Study) -> dict[str, tuple[float, float, float]]:
    """The numbers of accuracies that files of spreads give, by their texts; without those that are not run."""
    kinds = {accuracy: [d.kind for d in accuracy.distributions] for g in study.grids for accuracy in g.swarm.accuracy}
    files = {a: [kind for kind in of if isinstance(kind, PluginFile)] for a, of in kinds.items()}
    return {str(a): a.moments for a, of in files.items() if of and not any(map(is_unread, of))}


@functools.cache
def _libraries() -> str:
    return ", ".join(f"{n} {importlib.metadata.version(n)}" for n in LIBRARIES)


@functools.cache
def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or "unknown"


def save(data: xr.Dataset, path: str | Path) -> None:
    """Write a dataset or a trace as netCDF-4, whole or not at all, results with hashes. Raises InputError."""
    is_results = data.attrs.get("format") == schema.FORMAT
    if is_results:
        data = packed(data).drop_attrs(deep=False).assign_attrs(selected(data))
    netcdf.write(data, path, hashed=is_results)


def load(path: str | Path) -> xr.Dataset:
    """Read a results file, as the dataset that its run returned.

    Times that are missing are NaN, and the coordinates `accuracy_black`, `accuracy_white` and `accuracy_spread` have
    the sensors as numbers (docs/data-format.md). Raises InputError if it is missing, not of swarmcensus, or was
    damaged or edited since it was saved: by hashes, which anybody can write anew, so `verify` compares with the study.
    """
    return readable(load_packed(path))


def as_dataset(results: xr.Dataset | str | Path) -> xr.Dataset:
    """A dataset as it is, or that of a results file. Raises InputError as `load` does."""
    return results if isinstance(results, xr.Dataset) else load(results)


def load_packed(path: str | Path) -> xr.Dataset:
    """Read a results file as it is kept. Raises InputError as `load` does."""
    path = Path(path)
    check_there(path)
    try:
        if not path.is_file():
            raise ResultsError(_absent(path))
        return netcdf.read(path)
    except ResultsError as error:
        raise ResultsError.within(f"results file {path}", error) from error


def _absent(path: Path) -> str:
    """Why there is no results file."""
    from swarmcensus.results import shards

    folder = folder_of(path)
    if path.is_dir():
        return "it is a folder"
    if not (folder / "run.json").is_file():
        return "there is no such file"
    status = command("swarmcensus", "status", path)
    if shards.owner(folder):
        return f"not written yet, a run is at work on it: see {status}; Ctrl-C there writes what is done"
    return f"not written yet, its run was cut off: the same swarmcensus run goes on ({status})"


def frame(data: xr.Dataset) -> "pd.DataFrame":
    """Results in long form: a pandas table with one row per robot and trial, as `export` writes it.

    Missing robots and trials are left out. Columns are the coordinates of the setting, `trial`, `robot`, and the
    variables of each trial or robot, such as `true_fill_ratio` and `final_estimate`; `export` leaves out accuracies as
    numbers.
    """
    kinds, size = kinds_in(data), robots_in(data).values
    mask = np.arange(data.sizes["robot"]) < size[:, np.newaxis, np.newaxis]
    mask = mask & np.isfinite(data["final_estimate"].values)
    setting, trial, robot = np.nonzero(mask)
    import pandas as pd

    columns: dict[str, Any] = {"setting": data["setting"].values[setting]}
    columns |= {str(k): c.values[setting] for k, c in data.coords.items() if c.dims == ("setting",) and k != "setting"}
    columns |= {"trial": data["trial"].values[trial], "robot": data["robot"].values[robot]}
    columns |= {n: data[n].values[setting, trial] for n, (dims, *_) in kinds.items() if dims == PER_TRIAL}
    for name, (dims, kind, *_) in kinds.items():
        if dims == PER_ROBOT:
            values = data[name].values[mask]
            columns[name] = values if np.isnan(values).any() else values.astype(kind, copy=False)
    return pd.DataFrame(columns)


def export(data: xr.Dataset, path: str | Path, kind: str) -> int:
    """Write results in long form as "csv" or "parquet", and return the number of rows. Raises InputError."""
    table = frame(data)
    with atomic_write(path) as temporary:
        if kind == "csv":
            write_csv(table, temporary)
        else:
            try:
                table.to_parquet(temporary, index=False)
            except ImportError:
                raise InputError("parquet needs pyarrow: pip install 'swarmcensus[parquet]'") from None
    return len(table)
