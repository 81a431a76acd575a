"""A grid: robots in rows and columns, each of which hears the up to four next to it.

Without `columns` it is as square as the number of robots allows: of 30 robots, 5 rows of 6.
"""

from typing import Annotated

import numpy as np
from pydantic import Field

from swarmcensus.worlds.lattices import lattice, rows_and_columns

Columns = Annotated[int, Field(ge=2)]


def check(robots: int, *, columns: Columns | None = None) -> None:
    """Refuse numbers of robots that fill no rows."""
    rows_and_columns(robots, columns, 2)


def edges(robots: int, *, columns: Columns | None = None) -> np.ndarray:
    """Neighbours, (edge, 2)."""
    return lattice(*rows_and_columns(robots, columns, 2), closed=False)
