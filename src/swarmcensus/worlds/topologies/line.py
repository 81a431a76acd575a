"""A line: robots i and i + 1 hear each other (paper, Sec. IV-B)."""

import numpy as np


def edges(robots: int) -> np.ndarray:
    """Neighbours, (edge, 2)."""
    return np.stack([np.arange(robots - 1), np.arange(1, robots)], axis=1)
