"""Edge lists: pairs of robots that hear each other, from a study file or a table."""

import operator
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from swarmcensus.support.errors import InputError, TableError
from swarmcensus.support.tables import ReadTable, is_number, plain, read_table
from swarmcensus.worlds.generators import WEIGHTS
from swarmcensus.worlds.graph_files import FileEdges

DIRECTED = (("sender", "receiver"), ("source", "target"), ("from", "to"), ("src", "dst"), ("fromnodeid", "tonodeid"))
ENDS = (*DIRECTED, ("i", "j"), ("u", "v"), ("a", "b"), ("node1", "node2"), ("v1", "v2"))  # names of both columns
STEP, WEIGHT, TYPE = "step", "weight", "type"
SILENT = ("id", "edgeid", "label")  # columns of Gephi and igraph without information on links
KNOWN = {*(name for pair in ENDS for name in pair), STEP, WEIGHT, TYPE, *SILENT}
MESSAGES = "step,sender,receiver"
LINKS = f"i,j for edges, or {MESSAGES} for messages"
IGNORE = 'weights = "ignore" reads the file without them'
MOST_NAMED = 8  # robots in a warning


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


def read_edges(path: Path, directed: bool, ignore_weights: bool, renumber: bool) -> FileEdges:
    """Read pairs of robots from a table; of a directed pair, the second robot hears the first.

    Robots have the numbers in the table. With `renumber` they are numbered from 0 in the order of these, and texts, in
    columns with names, in the order in which the table first names them. Raises InputError.
    """
    table = read_table(path, KNOWN.__contains__, ignore_attributes=ignore_weights)
    if not table.rows:
        raise InputError(f"{path} has no edges: write edges = [] for robots without links", file=path)
    links = links_of(table, "source,target", directed, ignore_weights=ignore_weights, renumber=renumber)
    return FileEdges([(i, j) for i, j in links.tolist()], directed)


def links_of(
    table: ReadTable, right: str, directed: bool = False, messages: bool = False, *,
    ignore_weights: bool = False, renumber: bool = False,
) -> np.ndarray:  # fmt: skip
    """Edges (edge, 2) of a table, or with `messages` also messages (message, 3) of step, sender and receiver.

    `right` are the names of the columns that there should be, for messages. Without `messages`, robots may
    have texts in place of numbers (see `read_edges`). Raises InputError.
    """
    table = table.without(*(k for k in range(table.width) if table.rows and table.is_empty(k)))
    if table.names is None:
        if table.width == 3 and not messages:
            if not ignore_weights:
                raise table.error(0, f"{' '.join(table.rows[0])!r} has a third column: {WEIGHTS}; {IGNORE}")
            table = table.without(2)
        if table.width != 2:
            table.refuse((), right)
        links = _ordered(table, [0, 1]) if renumber else np.stack([table.whole(0), table.whole(1)], axis=1)
        again = (links[1:] == links[0]).all(axis=1).any()  # names or not, the links are the same
        if not again and table.separator != " ":  # networkx and igraph write links with spaces and without names
            table.check_heading("source,target", "a link")
        return links
    names = [plain(name) for name in table.names]
    has_steps = messages and STEP in names
    pairs = [pair for pair in (DIRECTED if has_steps else ENDS) if pair[0] in names and pair[1] in names]
    chosen = ([STEP] if has_steps else []) + list(pairs[0] if pairs else ())
    unknown = [k for k, name in enumerate(names) if name not in (*chosen, WEIGHT, TYPE, *SILENT)]
    if unknown or not pairs or (messages and not has_steps and pairs[0] == DIRECTED[0]):
        table.refuse(unknown or range(len(names)), right)
    if WEIGHT in names and not ignore_weights:
        weights = table.column(names.index(WEIGHT))
        if (weights[~np.isnan(weights)] != 1.0).any():
            remedy = "leave it out if it says nothing of them" if messages else IGNORE
            raise TableError.of(table.source, f"column {WEIGHT!r}: {WEIGHTS}; {remedy}")
    if TYPE in names:
        _check_types(table, names.index(TYPE), directed or has_steps, messages)
    columns = [names.index(name) for name in chosen]
    if renumber or (not messages and not any(is_number(str(row[k])) for row in table.rows for k in columns)):
        return _ordered(table, columns)
    return np.stack([table.whole(k) for k in columns], axis=1)


def _ordered(table: ReadTable, columns: list[int]) -> np.ndarray:
    """Numbers from 0 in place of robots: in the order of their numbers, or of texts as they come."""
    cells = [str(row[k]).strip() for row in table.rows for k in columns]
    numbers: dict[str, Any] = {}
    if all(map(str.isdigit, cells)):
        numbers = {one: k for k, one in enumerate(sorted({*cells}, key=int))}
    elif "" in cells:
        raise table.wrong(cells.index("") // len(columns), columns[cells.index("") % len(columns)], "a robot")
    else:
        numbers = {one: k for k, one in enumerate(dict.fromkeys(cells))}
    return np.array([numbers[cell] for cell in cells]).reshape(-1, len(columns))


def _check_types(table: ReadTable, k: int, directed: bool, messages: bool) -> None:
    """Raise InputError for edges that are of another kind than they will be."""
    right = "directed" if directed else "undirected"
    for n, row in enumerate(table.rows):
        if plain(str(row[k])) != right:
            if messages:
                remedy = "give a message for each direction" if directed else f"give messages, as {MESSAGES}"
            else:
                remedy = "see directed = true"
            raise table.error(n, f"{row[k]!r}: all links are {right} here: {remedy}", TYPE, row[k])


def unlinked(robots: int, pairs: np.ndarray) -> str:
    """A sentence on robots without links, or nothing if there are none; `pairs` are the robots of all links."""
    alone = np.setdiff1d(np.arange(robots), pairs)
    if not alone.size:
        return ""
    named = ", ".join(map(str, alone[:MOST_NAMED])) + (", ..." if alone.size > MOST_NAMED else "")
    several = alone.size > 1
    return f"robot{'s' * several} {named} {'have' if several else 'has'} no links{from_one(pairs)}"


def from_one(numbers: np.ndarray) -> str:
    """A note on robot numbers that seem to start at 1."""
    return "; robots are numbered from 0, and these numbers seem to start at 1" if numbers.min() == 1 else ""
