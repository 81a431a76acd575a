"""Rows and columns of robots, for grids and tori."""

import itertools
import math

import numpy as np

LONGEST = 2  # columns for each row, unless the study names them


def rows_and_columns(robots: int, columns: int | None, least: int) -> tuple[int, int]:
    """Whole rows, at least as many as `least`, of at least as many columns. Raises ValueError if there are none.

    Without `columns`, they are the nearest to a square, and no more than twice as many as the rows.
    """
    if columns is not None:
        if robots % columns or robots // columns < least:
            raise ValueError(f"columns = {columns} makes no {least} or more whole rows: should divide the robots")
        return robots // columns, columns

    def rows_of(robots: int) -> int:  # of the rectangle that is the nearest to a square
        return next(k for k in range(math.isqrt(robots), 0, -1) if robots % k == 0)

    def is_squarish(robots: int) -> bool:
        return least <= rows_of(robots) and robots <= LONGEST * rows_of(robots) ** 2

    rows = rows_of(robots)
    if not is_squarish(robots):
        above = next(filter(is_squarish, itertools.count(max(robots, least**2))))
        why = f"{rows} x {robots // rows} is too long, unless columns are named"
        raise ValueError(f"should fill rows and columns that make nearly a square, as {above} robots do: {why}")
    return rows, robots // rows


def lattice(rows: int, columns: int, closed: bool) -> np.ndarray:
    """Pairs of neighbours, (edge, 2), row by row; if `closed`, also of the first and last row, and column."""
    number = np.arange(rows * columns).reshape(rows, columns)
    pairs = [(number[:, :-1], number[:, 1:]), (number[:-1], number[1:])]
    if closed:
        pairs += [(number[:, -1], number[:, 0]), (number[-1], number[0])]
    return np.concatenate([np.stack([one.ravel(), other.ravel()], axis=1) for one, other in pairs])
