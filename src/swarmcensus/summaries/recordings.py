"""Recorded observations, links and accuracies are read from tables; traces are written."""

import csv
import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.simulation import Readings, known, readings_of
from swarmcensus.studies import read_value
from swarmcensus.support.control_characters import write_csv
from swarmcensus.support.errors import ResultsError, TableError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.options import wrong_option
from swarmcensus.support.read_table import Table, read_table
from swarmcensus.worlds import parse_accuracy

ACCURACY = "accuracy, or black,white, with a row for each robot, and robot if robots have names"
NUMBERED = Readings(np.zeros((0, 0)))  # of robots that are numbered


def read_observations(
    path: str | Path, decimal: str | None = None, *, time: str | None = None, robot: str | None = None,
    reading: str | None = None, period: float | None = None,
) -> Readings:  # fmt: skip
    """Read observations from a table (see `readings_of`). Raises InputError."""
    return readings_of(read_table(path, known, decimal), time, robot, reading, period)


def read_accuracy(text: str, readings: Readings = NUMBERED, decimal: str | None = None) -> Any:
    """Read accuracies: "0.8", "{black = 0.9, white = 0.6}", or a table with a row per robot. Raises InputError."""
    if os.path.isfile(text):
        return _accuracies(read_table(text, ("black", "white", "accuracy", "robot").__contains__, decimal), readings)
    try:
        accuracy = parse_accuracy(read_value(text))
        return {"black": accuracy.side("black"), "white": accuracy.side("white")}
    except ValueError as error:
        should = "should be 0.8, {black = 0.9, white = 0.6} or a CSV file with a row for each robot"
        raise wrong_option("accuracy", text, f"there is no such file, and {error}: {should}") from None


def _accuracies(table: Table, readings: Readings) -> dict[str, np.ndarray]:
    if not len(table.frame):
        raise TableError.of(table.source, f"no accuracies: there should be {ACCURACY}")
    names = table.plain_names()
    has_robots = "robot" in names or not readings.is_labelled
    if not has_robots or names.keys() - {"robot"} not in ({"black", "white"}, {"accuracy"}, {"black"}):
        raise table.refused(f"there should be {ACCURACY}")
    order = np.arange(len(table.frame))
    if "robot" in names:
        order = readings.robots(table, names.pop("robot"))
        if sorted(order) != list(range(len(order))):
            raise table.refused("column 'robot': there should be a row for each robot")
    columns = {name: table.values(names[name], "a number") for name in sorted(names)}  # black comes before white
    for name, values in columns.items():
        if np.isnan(values).any():
            raise table.wrong(int(np.argmax(np.isnan(values))), names[name], "a number")
    black, *white = (values[np.argsort(order)] for values in columns.values())
    return {"black": black, "white": white[0] if white else black}


def write_rows(path: str | Path, header: list[str], rows: np.ndarray) -> None:
    """Write whole numbers as a CSV file, NaN as an empty cell. Raises InputError."""
    with atomic_write(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(["" if np.isnan(v) else int(v) for v in row] for row in rows)


def write_trace(trace: xr.Dataset, path: str | Path) -> None:
    """Write a trace as netCDF-4 (.nc), or as CSV with a row per round and robot. Raises InputError."""
    from swarmcensus.results import save

    suffix = Path(path).suffix.lower()
    if suffix == ".nc":
        save(trace, path)
        return
    if suffix != ".csv":
        raise ResultsError.of(path, "a trace is written as .csv or .nc")
    flat = trace.drop_vars([n for n, v in trace.data_vars.items() if v.dims != ("round", "robot")])
    for name, values in trace.data_vars.items():
        if values.dims in (("robot",), ("round",)):  # who is who; a truth that changes
            flat[name] = values.broadcast_like(trace["estimate"])
        if values.dims[:2] == ("round", "robot") and values.ndim == 3 and str(values.dims[2]).startswith("item_"):
            flat = flat.assign({f"{name}[{k}]": values[:, :, k] for k in range(values.shape[2])})
    for axis in ("x", "y") if "position" in trace else ():
        flat[f"position_{axis}"] = trace["position"].sel(axis=axis, drop=True)
    with atomic_write(path) as temporary:
        frame = flat.drop_vars(["axis", "part"], errors="ignore").to_dataframe(dim_order=["round", "robot"])
        write_csv(frame.reset_index(), temporary)
