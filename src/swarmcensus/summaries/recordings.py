"""Recorded observations, links and accuracies are read from tables; traces are written."""

import contextlib
import csv
import os
from pathlib import Path

import numpy as np
import xarray as xr

from swarmcensus.simulation import Readings, known, readings_of
from swarmcensus.support.control_characters import write_csv
from swarmcensus.support.errors import InputError, ResultsError, TableError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.read_table import Table, read_table

ACCURACY = "accuracy (b = w), or b,w, with a row for each robot, and robot if robots have names"
NUMBERED = Readings(np.zeros((0, 0)))  # of robots that are numbered


def read_observations(
    path: str | Path, decimal: str | None = None, *, time: str | None = None, robot: str | None = None,
    reading: str | None = None, period: float | None = None,
) -> Readings:  # fmt: skip
    """Read observations from a table (see `readings_of`). Raises InputError."""
    return readings_of(read_table(path, known, decimal), time, robot, reading, period)


def read_accuracy(
    text: str, readings: Readings = NUMBERED, decimal: str | None = None
) -> float | tuple[float, float] | tuple[np.ndarray, np.ndarray]:
    """Read accuracies: "0.8" (b = w), "0.9,0.6" (b, w), or a table with a row per robot. Raises InputError."""
    if os.path.isfile(text):
        return _accuracies(read_table(text, ("b", "w", "accuracy", "robot").__contains__, decimal), readings)
    values = []
    with contextlib.suppress(ValueError):
        values = [float(part) for part in text.split(",")]
    if len(values) not in (1, 2):
        should = "0.8 (b = w), 0.9,0.6 (b, w) or a CSV file with a row for each robot"
        raise InputError.named("accuracy", text, f"there is no such file: should be {should}")
    return values[0] if len(values) == 1 else (values[0], values[1])


def _accuracies(table: Table, readings: Readings) -> tuple[np.ndarray, np.ndarray]:
    if not len(table.frame):
        raise TableError.of(table.source, f"no accuracies: there should be {ACCURACY}")
    names = table.plain_names()
    if not table.named:
        if len(names) == 2 and table.counts("0"):
            raise table.refused("the first column may be b or numbers of robots: add a line b,w or robot,accuracy")
        names = dict(zip(("b", "w"), names, strict=False)) if len(names) <= 2 else names
    has_robots = "robot" in names or not readings.is_labelled
    if not has_robots or names.keys() - {"robot"} not in ({"b", "w"}, {"accuracy"}, {"b"}):
        raise table.refused(f"there should be {ACCURACY}")
    order = np.arange(len(table.frame))
    if "robot" in names:
        order = readings.robots(table, names.pop("robot"))
        if sorted(order) != list(range(len(order))):
            raise table.refused("column 'robot': there should be a row for each robot")
    columns = {name: table.values(names[name], "a number") for name in sorted(names)}  # b comes before w
    for name, values in columns.items():
        if np.isnan(values).any():
            raise table.wrong(int(np.argmax(np.isnan(values))), names[name], "a number")
    b, *w = (values[np.argsort(order)] for values in columns.values())
    return b, w[0] if w else b


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
