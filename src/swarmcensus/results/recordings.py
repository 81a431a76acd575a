"""Recorded observations, links and accuracies are read from CSV files; traces are written."""

import csv
import os
from pathlib import Path

import numpy as np
import xarray as xr

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.files import atomic_write
from swarmcensus.basics.formatting import counted
from swarmcensus.worlds.edge_lists import is_header, read_edges

ACCURACY_HEADERS = ("b,w", "b", "accuracy")
CELLS = {"0": 0.0, "1": 1.0, "": np.nan, "nan": np.nan, "0.0": 0.0, "1.0": 1.0}


def read_observations(path: str | Path) -> np.ndarray:
    """Read observations (step, robot) from a CSV file: a row per step, a column per robot, 0 white, 1 black.

    A first row of names is skipped. Raises InputError with file, line and value.
    """
    path = Path(path)
    rows: list[list[float]] = []
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            for number, row in enumerate(csv.reader(file), start=1):
                cells = [CELLS.get(cell.strip().lower()) for cell in row]
                if number == 1 and row and is_header(row) and None in cells:
                    continue
                if not row:
                    cells = [np.nan]  # a lone robot that saw nothing leaves an empty line
                if None in cells:
                    wrong = row[cells.index(None)]
                    raise InputError(f"{path}, line {number}: {wrong!r}: should be 0 (white), 1 (black) or empty")
                if rows and len(cells) != len(rows[0]):
                    raise InputError(
                        f"{path}, line {number}: {counted(len(cells), 'value')} where there were {len(rows[0])}"
                    )
                rows.append([float(c) for c in cells if c is not None])
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read as CSV: {error}") from error
    if not rows:
        raise InputError(f"{path}: no observations: should be a row a step, a column a robot")
    return np.array(rows)


def read_links(path: str | Path) -> np.ndarray:
    """Read edges (edge, 2), or messages (message, 3) as step, sender, receiver, from a CSV file. Raises InputError."""
    rows = np.array(read_edges(Path(path)), np.int64)
    if not rows.size:  # no links: of which kind, the header says
        with Path(path).open(encoding="utf-8-sig") as file:
            return np.zeros((0, 3 if file.readline().count(",") == 2 else 2), np.int64)
    if rows.shape[1] not in (2, 3):
        raise InputError(
            f"{path}: {counted(rows.shape[1], 'column')}: should be two (robots) or three (step, sender, receiver)"
        )
    return rows


def read_accuracy(text: str) -> float | tuple[float, float] | tuple[np.ndarray, np.ndarray]:
    """Read accuracies: "0.8" (b = w), "0.9,0.6" (b, w), or a CSV file with a row per robot."""
    if os.path.isfile(text):
        rows = np.array(_accuracy_rows(Path(text)))
        return rows[:, 0], rows[:, -1]
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in (1, 2):
        raise InputError(f"accuracy {text!r}: should be 0.8 (b = w), 0.9,0.6 (b, w) or a CSV file with a row a robot")
    return values[0] if len(values) == 1 else (values[0], values[1])


def _accuracy_rows(path: Path) -> list[list[float]]:
    rows: list[list[float]] = []
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            for number, row in enumerate(csv.reader(file), start=1):
                if not row or (number == 1 and ",".join(row).replace(" ", "").lower() in ACCURACY_HEADERS):
                    continue
                try:
                    rows.append([float(cell) for cell in row])
                except ValueError:
                    heads = " or ".join(repr(head) for head in ACCURACY_HEADERS)
                    raise InputError(
                        f"{path}, line {number}: {','.join(row)!r}: should be a row a robot: b = w, or b and w "
                        f"(a first row of names is {heads})"
                    ) from None
                if len(row) > 2 or len(row) != len(rows[0]):
                    raise InputError(
                        f"{path}, line {number}: {counted(len(row), 'column')}: should be one (b = w) or two (b and w) "
                        "in each row"
                    )
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read as CSV: {error}") from error
    if not rows:
        raise InputError(f"{path}: should hold a row a robot: b = w, or b and w")
    return rows


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
        raise InputError(f"{path}: a trace is written as .csv or .nc")
