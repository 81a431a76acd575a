"""The dataset is made, saved, loaded and exported."""

import functools
import importlib.metadata
import json
import platform
from collections.abc import Callable, Iterable, Iterator, Sequence
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


def dataset(studies: Sequence[Study], settings: list[Setting], fingerprints: list[str], values: Values) -> xr.Dataset:
    """The dataset of studies: their values so far, their coordinates, and how they were made.

    Raises InputError if one name stands for two brains, metrics, edge lists or images.
    """
    sizes = {"setting": len(settings), "trial": values.trials, "robot": values.arrays["final_estimate"].shape[2]}
    coordinates: dict[str, Any] = {k: np.arange(n) for k, n in sizes.items()} | {"checkpoint": values.checkpoints}
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
    for name, table in (item for study in studies for item in _tables(study)):
        if not variables.setdefault(name, table).identical(table):
            raise InputError(f"two of the studies have two different {name}", key=name)
    data = xr.Dataset(variables, coordinates, provenance(studies))
    data["checkpoint"].attrs["units"] = "rounds"
    return data


def _tables(study: Study) -> Iterator[tuple[str, xr.Variable]]:
    """The edge lists and images that a study reads from files, as variables."""
    for one in (topology for topology in study.topologies if topology.source):
        says = "directed links: sender, receiver" if one.directed else "undirected edges"
        about = {"long_name": says, "source": one.source, **({"directed": 1} if one.directed else {})}
        edges = np.array(one.edges, np.int32).reshape(-1, 2)
        yield f"edges_{one.name}", xr.Variable((f"edge_{one.name}", "end"), edges, about)
    for picture in study.pictures:
        about = {"long_name": "grey levels of an image, 0 black to 65535 white", "source": picture.source}
        dims = f"row_{picture.name}", f"column_{picture.name}"
        yield f"floor_{picture.name}", xr.Variable(dims, picture.grey, about)


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


def provenance(studies: Sequence[Study]) -> dict[str, Any]:
    """The attributes that say how a dataset was made, enough to make it again. Raises InputError as `dataset` does."""
    first = studies[0]
    files: dict[str, Callable[[Study], Iterable[tuple[str, Any]]]] = {
        "brains": lambda study: ((one.name, _source(one)) for one in study.brains),
        "adversaries": lambda study: ((one.name, _source(one)) for one in study.adversaries),
        "plugin_files": lambda study: ((f"{one.kind} {one.name}", _source(one)) for one in study.plugin_files),
        "metrics": lambda study: sources_of(study.measure.metrics).items(),
        "parameters": _parameters,
        "accuracies": _accuracies,
        "additions": lambda study: study.additions.items(),
    }
    used = {key: _each(key, studies, named) for key, named in files.items()}
    return {
        "format": schema.FORMAT,
        "title": " + ".join(dict.fromkeys(study.name for study in studies)),
        "study": first.text,
        "seed": first.seed,
        **{key: getattr(first.measure, key) for key in ("delta", "bins", "truth")},
        "swarmcensus_version": __version__,
        "python_version": platform.python_version(),
        # only what some studies have; metrics keep the order of the study, which is that of their variables
        **{key: json.dumps(value, sort_keys=key != "metrics") for key, value in used.items() if value},
        "machine": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "library_versions": _libraries(),
    }


def _each(key: str, studies: Sequence[Study], named: Callable[[Study], Iterable[tuple[str, Any]]]) -> dict[str, Any]:
    """What studies have under names. Raises InputError if one name stands for two things."""
    known: dict[str, Any] = {}
    for name, one in (item for study in studies for item in named(study)):
        if known.setdefault(name, one) != one:
            raise InputError(f"two of the studies name two different {key} {name!r}", key=key, value=name)
    return known


def _source(file: Any) -> dict[str, str]:
    return {"sha256": file.sha256, "source": file.source}


def _parameters(study: Study) -> Iterator[tuple[str, list[str]]]:
    named = {brain.name for grid in study.grids for brain in grid.swarm.brain}
    return ((brain.name, [*brain.parameters]) for brain in study.brains if brain.parameters and brain.name in named)


def _accuracies(study: Study) -> Iterator[tuple[str, tuple[float, float, float]]]:
    """The numbers of accuracies that files of spreads give, by their texts; without those that are not run."""
    for accuracy in (accuracy for grid in study.grids for accuracy in grid.swarm.accuracy):
        files = [one.kind for one in accuracy.distributions if isinstance(one.kind, PluginFile)]
        if files and not any(map(is_unread, files)):
            yield str(accuracy), accuracy.moments


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
        data = packed(data)
        schema.check_dataset(data)
        data = data.drop_attrs(deep=False).assign_attrs(selected(data))
    netcdf.write(data, path, hashed=is_results)


def load(path: str | Path) -> xr.Dataset:
    """Read a results file, as the dataset that its run returned.

    Times that are missing are NaN, and the coordinates `accuracy_black`, `accuracy_white` and `accuracy_spread` have
    the sensors as numbers (docs/data-format.md). Raises InputError if it is missing, not of swarmcensus, or was
    damaged or edited since it was saved: by hashes, which anybody can write again, so `verify` asks the study.
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
    """Why there is no results file, though there is the folder of its run."""
    from swarmcensus.results import shards

    status = command("swarmcensus", "status", path)
    if shards.owner(folder_of(path)):
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
