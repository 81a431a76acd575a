"""Edge lists: pairs of robots that hear each other, from a study file or a CSV file."""

import csv
import operator
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from swarmcensus.basics.errors import InputError
from swarmcensus.worlds.generators import WEIGHTS

DIGITS = 18  # of a number in an edge list: more may not fit 64 bits


def edges_of(pairs: Iterable[Any], directed: bool) -> tuple[tuple[int, int], ...]:
    """Each edge once, sorted. Raises ValueError for what is not a pair of robots, or joins a robot to itself."""
    try:
        if isinstance(pairs, str | Mapping):  # an empty one would count as an empty list
            raise TypeError
        rows = [_pair(row) for row in pairs]
    except TypeError:
        raise ValueError("edges are pairs of robot numbers, from 0: [[0, 1], [1, 2]]") from None
    loops = [i for i, j in rows if i == j]
    if loops:
        raise ValueError(f"edge ({loops[0]}, {loops[0]}) joins a robot to itself")
    return tuple(sorted(set(rows if directed else [(min(row), max(row)) for row in rows])))


def _pair(row: Any) -> tuple[int, int]:
    if len(row) == 3:
        raise ValueError(f"edge {list(row)} has three numbers: {WEIGHTS}")
    i, j = row if len(row) == 2 else (-1, -1)
    if isinstance(i, bool) or isinstance(j, bool):
        raise TypeError
    i, j = operator.index(i), operator.index(j)
    if min(i, j) < 0:
        raise TypeError
    return i, j


def read_edges(path: Path, weights: bool = True) -> list[tuple[int, ...]]:
    """Read rows of whole numbers from a CSV file, with or without a header. Raises InputError.

    Without `weights`, a third column is an error.
    """
    rows: list[tuple[int, ...]] = []
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            for number, row in enumerate(csv.reader(file), start=1):
                if not row or (number == 1 and is_header(row)):
                    continue
                if len(row) == 3 and not weights:
                    raise InputError(f"{path}, line {number}: {','.join(row)!r} has a third column: {WEIGHTS}")
                if not all(_is_whole(cell) for cell in row) or (rows and len(row) != len(rows[0])):
                    raise InputError(f"{path}, line {number}: {','.join(row)!r}: not a row of whole numbers >= 0")
                rows.append(tuple(int(cell) for cell in row))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read as CSV: {error}") from error
    return rows


def is_header(row: list[str]) -> bool:
    """Whether a first row is a header: each cell begins with a letter."""
    return all(cell.strip()[:1].isalpha() for cell in row)


def _is_whole(cell: str) -> bool:
    return cell.strip().isascii() and cell.strip().isdigit() and len(cell.strip()) <= DIGITS
