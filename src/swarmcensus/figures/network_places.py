"""Where the robots of a fixed network are drawn, and which of its links: on the live page, in pictures and in films."""

from __future__ import annotations

import numpy as np

from swarmcensus.engine import Links
from swarmcensus.engine.constants import LISTED
from swarmcensus.studies import Setting
from swarmcensus.worlds import rows_and_columns

MOST_LAID_OUT = 400  # robots arranged by a spring layout; more stand in rows
MOST_LINKS = 20_000  # that are drawn


def edges_drawn(links: Links, robots: int) -> np.ndarray:
    """The links that are drawn as receiver and sender (link, 2); none if there are too many."""
    listed = links.mode == LISTED
    if (len(links.senders) if listed else robots * (robots - 1)) > MOST_LINKS:
        return np.zeros((0, 2), np.int64)
    if listed:
        return np.stack([links.receivers, links.senders], axis=1).astype(np.int64)
    return np.argwhere(~np.eye(robots, dtype=np.bool_))


def places_of_robots(setting: Setting, links: Links) -> np.ndarray:
    """The place of each robot of a fixed network (robot, 2), in [0, 1] from the upper left corner."""
    robots, topology = setting.robots, setting.topology
    columns, name = in_a_row(robots), topology.named
    row, column = np.divmod(np.arange(robots), columns)
    if robots > MOST_LAID_OUT:  # in rows: of so many, only colours can be seen
        return (np.stack([column, row], axis=1) + 0.5) / columns
    degrees = np.bincount(links.receivers, minlength=robots) if links.mode == LISTED else np.full(robots, robots - 1)
    if name == "ring" or degrees.min(initial=robots) == robots - 1:
        angle = 2 * np.pi * np.arange(robots) / robots - np.pi / 2
        return 0.5 + 0.46 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if name == "line":  # in rows, alternately from left to right and from right to left
        return (np.stack([np.where(row % 2 == 0, column, columns - 1 - column), row], axis=1) + 0.5) / columns
    if name in ("grid", "torus"):
        rows, columns = rows_and_columns(robots, dict(topology.keys).get("columns"), 2)
        middles = np.stack([np.arange(robots) % columns, np.arange(robots) // columns], axis=1) + 0.5
        return 0.5 + (middles - np.array([columns, rows]) / 2) / max(rows, columns)
    import networkx

    graph = networkx.empty_graph(robots)
    graph.add_edges_from(edges_drawn(links, robots).tolist())
    layout = networkx.spring_layout(graph, seed=1, iterations=200 if robots <= 100 else 60)
    places = np.array([layout[i] for i in range(robots)])
    span = np.ptp(places, axis=0).max() or 1.0
    return np.asarray(0.5 + 0.92 * (places - (places.max(axis=0) + places.min(axis=0)) / 2) / span)


def in_a_row(robots: int) -> int:
    """How many robots stand in a row of a square of them."""
    return int(np.ceil(np.sqrt(robots)))
