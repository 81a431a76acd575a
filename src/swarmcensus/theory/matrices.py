"""Mixing matrices: the weights with which each robot averages its own number and those that it hears in a round."""

import functools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from swarmcensus.support.errors import InputError
from swarmcensus.support.intervals import Floats
from swarmcensus.theory.checks import misshapen, numbers
from swarmcensus.worlds import network

MOST = 4096  # robots of a matrix: 128 MB
SMALL = 100  # robots of the largest matrix with a cached decomposition: 512 of them take 80 MB


def mixing_matrix(graph: Any, robots: int | None = None, *, directed: bool = False) -> Floats:
    """The matrix W (robot, robot) of equal-neighbour means: the rows of A + I over their sums, A the adjacency matrix.

    `graph` is a networkx graph, any topology of a study file ("ring", with `robots`), or pairs of robot numbers from 0;
    in a directed pair (u, v), v hears u. Raises InputError if it is none of these, differs from trial to trial, or has
    more than 4,096 robots.
    """
    try:
        found = network(graph, robots, directed, MOST, "as a matrix has a row and a column for each robot")
    except ValueError as error:
        raise InputError(str(error), key="graph") from None
    return from_links(found.robots, found.receivers, found.senders)


def from_links(robots: int, receivers: np.ndarray, senders: np.ndarray) -> Floats:
    """`mixing_matrix` from links: `receivers[k]` hears `senders[k]`."""
    matrix = np.eye(robots)
    matrix[receivers, senders] = 1.0
    return np.asarray(matrix / matrix.sum(axis=1, keepdims=True))


def checked(matrix: ArrayLike) -> Floats:
    """A mixing matrix, checked: square, nothing negative, rows that sum to 1. Raises InputError."""
    found = numbers("matrix", matrix)
    if found.ndim != 2 or found.shape[0] != found.shape[1] or not found.size:
        raise misshapen("matrix", found, "a square, a row and a column a robot")
    if (found < 0.0).any():
        raise InputError("matrix has a negative weight: should be 0 or above", key="matrix")
    wrong = np.flatnonzero(np.abs(found.sum(axis=1) - 1.0) > 1e-9)
    if wrong.size:
        total = found[wrong[0]].sum()
        raise InputError(f"matrix: the weights of row {wrong[0]} sum to {total:g}: should be 1", key="matrix")
    return found


class Spectrum(NamedTuple):
    """W = diag(1 / root) U diag(values) U' diag(root), which makes all powers of a reversible W cheap."""

    values: Floats
    vectors: Floats
    root: Floats


def balance(matrix: Floats) -> Floats | None:
    """Numbers d (robot,) for which d_i W_ij is symmetric: all 1, or 1 / W_ii; None if neither works.

    1 / W_ii works for equal-neighbour means on undirected graphs, where W_ij = 1 / d_i for a robot and its neighbours.
    """
    own = np.diag(matrix)
    for d in (np.ones(len(matrix)), 1.0 / np.where(own > 0.0, own, np.inf)):
        flow = d[:, np.newaxis] * matrix
        if (d > 0.0).all() and np.allclose(flow, flow.T, rtol=1e-12, atol=1e-14):
            return d
    return None


def spectrum_of(matrix: Floats) -> Spectrum | None:
    """The decomposition of a W with a `balance` d, for which D^(1/2) W D^(-1/2) is symmetric; None without one.

    Decompositions of small matrices are cached, as the settings of a study share their graphs.
    """
    decompose = _decompose if len(matrix) <= SMALL else _decompose.__wrapped__
    return decompose(np.ascontiguousarray(matrix).tobytes(), len(matrix))


@functools.lru_cache(maxsize=512)
def _decompose(raw: bytes, robots: int) -> Spectrum | None:
    matrix = np.frombuffer(raw).reshape(robots, robots)
    d = balance(matrix)
    if d is None:
        return None
    root = np.sqrt(d)
    values, vectors = np.linalg.eigh(root[:, np.newaxis] * matrix / root)
    return Spectrum(values, vectors, root)


def geometric(x: Floats, terms: int) -> Floats:
    """x + x^2 + ... + x^terms, for |x| up to 1, without loss of precision near 1."""
    near = (x > 0.5) & (x != 1.0)
    gap = np.where(near, 1.0 - x, 0.5)
    close = -(1.0 - gap) * np.expm1(terms * np.log1p(-gap)) / gap
    far = np.where(x > 0.5, 0.0, x)
    return np.where(near, close, np.where(x == 1.0, float(terms), far * (1.0 - far**terms) / (1.0 - far)))
