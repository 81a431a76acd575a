"""A ring: robots i and i + 1 hear each other, and so do the last and the first (paper, Sec. IV-B)."""

import numpy as np


def edges(robots: int) -> np.ndarray:
    """Neighbours, (edge, 2); fewer than three robots form a line."""
    first = np.arange(robots if robots > 2 else robots - 1)
    return np.stack([first, (first + 1) % robots], axis=1)
