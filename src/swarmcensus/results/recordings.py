"""Recorded observations, links and accuracies are read from tables; traces are written."""

import csv
import os
from pathlib import Path

import numpy as np
import xarray as xr

from swarmcensus.simulation import known, readings_of
from swarmcensus.support.errors import InputError, ResultsError, TableError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.tables import ReadTable, plain, read_table
from swarmcensus.worlds import KNOWN, LINKS, links_of

ACCURACIES = ("b", "w", "accuracy")  # names of columns
ACCURACY = "accuracy (b = w), or b,w"


def read_observations(path: str | Path) -> np.ndarray:
    """Read observations (step, robot) from a table: 0 white, 1 black, NaN none. Raises InputError."""
    return readings_of(read_table(path, known))


def read_links(path: str | Path) -> np.ndarray:
    """Read edges (edge, 2), or messages (message, 3) as step, sender, receiver, from a table. Raises InputError."""
    return links_of(read_table(path, KNOWN.__contains__), LINKS, messages=True)


def read_accuracy(text: str) -> float | tuple[float, float] | tuple[np.ndarray, np.ndarray]:
    """Read accuracies: "0.8" (b = w), "0.9,0.6" (b, w), or a table with a row per robot. Raises InputError."""
    if os.path.isfile(text):
        return _accuracies(read_table(text, ACCURACIES.__contains__))
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in (1, 2):
        should = "0.8 (b = w), 0.9,0.6 (b, w) or a CSV file with a row for each robot"
        raise InputError.named("accuracy", text, f"there is no such file: should be {should}")
    return values[0] if len(values) == 1 else (values[0], values[1])


def _accuracies(table: ReadTable) -> tuple[np.ndarray, np.ndarray]:
    if not table.rows:
        raise TableError.of(table.source, f"no accuracies: there should be {ACCURACY}, and a row for each robot")
    names = [plain(name) for name in table.names] if table.names else ["b", "w"][: table.width]
    if "robot" in names:
        if not table.counts(names.index("robot")):
            raise TableError.of(table.source, "column 'robot': should be 0, 1, 2, ...")
        table = table.without(names.index("robot"))
        names.remove("robot")
    if len(names) != table.width or (set(names) != {"b", "w"} and names not in (["accuracy"], ["b"])):
        table.refuse(range(table.width), ACCURACY)
    if table.names is None:
        table.check_heading("b,w"[: 2 * table.width - 1], "accuracies")
        if table.width == 2 and table.counts(0):
            raise TableError.of(
                table.source,
                "the first column may be b or the numbers of robots: add a line b,w or robot,accuracy above it",
            )
    columns = [table.column(k) for k in np.argsort(names)]  # b comes before w
    for k, values in enumerate(columns):
        if np.isnan(values).any():
            raise table.wrong(int(np.argmax(np.isnan(values))), k, "a number")
    return columns[0], columns[-1]


def write_rows(path: str | Path, header: list[str], rows: np.ndarray) -> None:
    """Write whole numbers as a CSV file, NaN as an empty cell. Raises InputError."""
    with atomic_write(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(["" if np.isnan(v) else int(v) for v in row] for row in rows)


def write_trace(trace: xr.Dataset, path: str | Path) -> None:
    """Write a trace as netCDF-4 (.nc), or as CSV with a row per round and robot. Raises InputError."""
    from swarmcensus.results.store import save

    if Path(path).suffix == ".nc":
        save(trace, path)
    elif Path(path).suffix == ".csv":
        flat = trace.drop_vars([n for n, v in trace.data_vars.items() if v.dims != ("round", "robot")])
        for name, values in trace.data_vars.items():
            if values.dims == ("robot",):  # who is who
                flat[name] = values.expand_dims(round=trace.sizes["round"])
            if values.dims == ("round",):  # a truth that changes
                flat[name] = values.expand_dims(robot=trace.sizes["robot"]).transpose("round", "robot")
            if values.dims[:2] == ("round", "robot") and values.ndim == 3 and str(values.dims[2]).startswith("item_"):
                for k in range(values.shape[2]):
                    flat[f"{name}[{k}]"] = values[:, :, k]
        if "position" in trace:
            for axis in ("x", "y"):
                flat[f"position_{axis}"] = trace["position"].sel(axis=axis, drop=True)
        with atomic_write(path) as temporary:
            frame = flat.drop_vars(["axis", "part"], errors="ignore").to_dataframe(dim_order=["round", "robot"])
            frame.to_csv(temporary)
    else:
        raise ResultsError.of(path, "a trace is written as .csv or .nc")
