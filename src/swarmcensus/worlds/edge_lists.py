"""Edge lists: pairs of robots that hear each other, from a study file, a table or an adjacency matrix."""

import operator
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from swarmcensus.support.errors import InputError, TableError
from swarmcensus.support.read_table import NUMBER, Table, in_order, plain, read_table
from swarmcensus.worlds.generators import WEIGHTS
from swarmcensus.worlds.graph_files import FileEdges

DIRECTED = (("sender", "receiver"), ("source", "target"), ("from", "to"), ("src", "dst"), ("fromnodeid", "tonodeid"))
ENDS = (*DIRECTED, ("i", "j"), ("u", "v"), ("a", "b"), ("node1", "node2"), ("v1", "v2"))  # names of both columns
STEPS = ("step", "tick", "round")  # names of a column that numbers steps
TIMES = (*STEPS, "time", "t", "timestamp", "times", "seconds")
WEIGHT, TYPE = "weight", "type"
SILENT = ("id", "edgeid", "label")  # columns of Gephi and igraph without information on links
KNOWN = {*(name for pair in ENDS for name in pair), *TIMES, WEIGHT}
MESSAGES = "step,sender,receiver"
MATRIX = "or a matrix with the robots' names in its first row and column"
IGNORE = 'weights = "ignore" reads the file without them'
TRUTH = {"true": 1.0, "false": 0.0}
MOST_NAMED = 8  # robots in a warning


class Links(NamedTuple):
    """A table of links: the names of its columns."""

    table: Table
    ends: tuple[str, str]  # of the robots; of messages the sender and the receiver
    step: str | None = None  # of the times of messages


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


def read_links(path: str | Path, ignore_weights: bool = False, decimal: str | None = None) -> Table:
    """Read a table of links; lines may end with a dictionary of attributes, as of networkx. Raises InputError."""

    def edge(line: str) -> str:
        pair, opened, attributes = line.partition("{") if line.endswith("}") else (line, "", "")
        if attributes.strip("} ") and not ignore_weights:
            raise TableError.of(path, f"{line!r}: links have no attributes: write it with data=False")
        return pair.rstrip() if opened else line

    return read_table(path, KNOWN.__contains__, decimal, edge)


def read_edges(path: Path, directed: bool, ignore_weights: bool, renumber: bool) -> FileEdges:
    """Read pairs of robots from a table or an adjacency matrix; of a directed pair, the second robot hears the first.

    Robots have the numbers in the table. With `renumber` they are numbered from 0 in the order of these, and texts, in
    columns with names, in the order in which the table first names them. Raises InputError.
    """
    table = read_links(path, ignore_weights)
    if not len(table.frame):
        raise InputError(f"{path} has no edges: write edges = [] for robots without links", file=path)
    table, names = edges_of_matrix(table, directed, ignore_weights)
    links = links_of(table, directed, ignore_weights=ignore_weights)
    texts = np.stack([table.texts(name) for name in links.ends], axis=1)
    if not (names or renumber) and (not table.named or any(map(NUMBER.fullmatch, texts.flat))):
        pairs = np.stack([table.whole(name) for name in links.ends], axis=1)
    else:
        if "" in texts:
            row, column = np.argwhere(texts == "")[0].tolist()
            raise table.wrong(row, links.ends[column], "a robot")
        order = list(dict.fromkeys(names or texts.flat))
        if (renumber and all(map(str.isdecimal, order))) or {*order} == {*map(str, range(len(order)))}:
            order.sort(key=in_order)
        numbers = {name: k for k, name in enumerate(order)}
        pairs = np.array([numbers[text] for text in texts.flat], np.int64).reshape(-1, 2)
    return FileEdges(list(map(tuple, pairs.tolist())), directed, len(names) or None)


def links_of(table: Table, directed: bool = False, messages: bool = False, ignore_weights: bool = False) -> Links:
    """The columns of a table of edges, or with `messages` also of messages. Raises InputError."""
    right = f"columns {f'i,j for edges, {MESSAGES} for messages' if messages else 'source,target'}, {MATRIX}"
    table = table.without(*(name for name in table.names if len(table.frame) and not any(table.texts(name))))
    names = table.plain_names()
    if not table.named:
        if table.names == ["0", "1", "2"] and not messages:
            if not ignore_weights:
                row = " ".join(map(str, table.frame.iloc[0]))
                raise table.error(0, f"{row!r} has a third column: {WEIGHTS}; {IGNORE}")
            table = table.without("2")
        if table.names != ["0", "1"]:
            raise table.refused(f"{len(names)} columns without names: there should be {right}")
        first, *others = table.frame.to_numpy().tolist()  # names or not, the links are the same if it is there again
        if first == ["0", "1"] and first not in others and table.separator != " ":  # as networkx and igraph
            raise table.ambiguous("source,target", "a link")
        return Links(table, ("0", "1"))
    step = next((name for name in names if name in TIMES), None) if messages else None
    pairs = [pair for pair in (DIRECTED if step else ENDS) if names.keys() >= {*pair}]
    chosen = (step, *(pairs[0] if pairs else ()))
    if len(names) == 2 and pairs and table.unit == "line" and table.frame.isin(table.names).any(axis=None):
        raise table.ambiguous("source,target", "a link")
    unknown = [names[name] for name in names if name not in (*chosen, WEIGHT, TYPE, *SILENT)]
    if unknown or not pairs or (messages and not step and pairs[0] == DIRECTED[0]):
        wrong = unknown or table.names
        shown = f"column{'s' * (len(wrong) > 1)} {', '.join(map(repr, wrong)) or 'without a name'}"
        raise table.refused(f"{shown}: there should be {right}")
    if WEIGHT in names and not ignore_weights:
        weights = table.values(names[WEIGHT], "a number")
        if (weights[~np.isnan(weights)] != 1.0).any():
            remedy = "leave it out if it says nothing of them" if messages else IGNORE
            raise TableError.of(table.source, f"column {WEIGHT!r}: {WEIGHTS}; {remedy}")
    if TYPE in names:
        _check_types(table, names[TYPE], directed or step is not None)
    return Links(table, (names[pairs[0][0]], names[pairs[0][1]]), step and names[step])


def edges_of_matrix(table: Table, directed: bool, ignore_weights: bool = False) -> tuple[Table, list[str]]:
    """The edges of an adjacency matrix as a table, and its names; another table as it is, and none. Raises InputError.

    The first column of a matrix has the names of the others, unless these are numbers from 0. The robot of a column
    hears that of the row.
    """
    import pandas as pd

    names, size = table.names, len(table.frame)
    if table.named and size > 1 and names[1:] == table.texts(names[0]).tolist():
        table, names = table.without(names[0]), names[1:]
    elif names != [*map(str, range(size))] or size < (3 if table.named else 4):
        return table, []
    weights = np.nan_to_num(np.stack([table.values(name, "0 or 1", TRUTH) for name in names], axis=1))
    if not ignore_weights and (wrong := np.argwhere(~np.isin(weights, (0.0, 1.0)))).size:
        row, column = wrong[0].tolist()
        raise table.error(row, f"{WEIGHTS}; {IGNORE}", names[column], table.frame.iloc[row, column])
    links = weights != 0.0
    if not directed and (one_way := np.argwhere(links & ~links.T)).size:
        i, j = one_way[0].tolist()
        remedy = f"directed = true in a study, and messages {MESSAGES} for infer"
        raise table.refused(f"the matrix is not symmetric: robot {i} has a link to {j}, and not back: see {remedy}")
    ends = np.array(names, object)[np.argwhere(links)]
    return Table(table.source, pd.DataFrame(ends, columns=["source", "target"], dtype=object)), names


def _check_types(table: Table, name: str, directed: bool) -> None:
    """Raise InputError for edges that are of another kind than they will be."""
    right = "directed" if directed else "undirected"
    for row, text in enumerate(table.texts(name)):
        if plain(text) != right:
            remedy = f"see directed = true, or give messages, as {MESSAGES}"
            raise table.error(row, f"{text!r}: all links are {right} here: {remedy}", name, text)


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
