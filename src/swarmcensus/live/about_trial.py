"""What stays the same during a trial: its title, the floor or the network, and which robots lie."""

import base64
from typing import Any

import numpy as np

from swarmcensus.engine.constants import LISTED
from swarmcensus.live.frames import COLUMNS, Show
from swarmcensus.live.robots import memory_names
from swarmcensus.worlds import rows_and_columns, tiles_across

MOST_TILES = 1024  # along a side that a page draws; a larger floor is an even grey
MOST_LAID_OUT = 400  # robots arranged by a spring layout; more stand in rows


def scene_of(show: Show) -> dict[str, Any]:
    """The scene for JSON; arrays of numbers are base64."""
    setting, brain, body = show.setting, show.setting.brain, show.setting.body
    scene: dict[str, Any] = {
        "title": setting.brief, "brain": brain.label, "robots": setting.robots, "rounds": show.rounds,
        "moves": show.moves, "dishonest": np.flatnonzero(~show.honest).tolist(),
        "bins": show.bins, "on_edges": show.on_edges, "opinions": show.opinions,
        "options": max((one.options for one in setting.brains if one.decides), default=0),
        "ends": any(one.ends for one in setting.brains), "columns": COLUMNS, "layers": show.layers,
        "fields": memory_names(setting), "memory": brain.memory_bytes, "message": brain.message_bytes,
    }  # fmt: skip
    if body is None:
        places, is_crowd = places_of(show), setting.robots > MOST_LAID_OUT
        scene |= {"unit": "round", "places": _numbers(places, "<f4"), "edges": _numbers(show.edges, "<u2")}
        scene |= {"crowd": _columns(setting.robots) if is_crowd else 0, "room": _room(places)}
        return scene | {"wraps": setting.topology.named == "torus" and not is_crowd}
    scene |= {"unit": "tick", "seconds": body.tick, "side": setting.arena_side, "range": body.radio_range}
    scene |= {"radius": body.radius, "tile": body.tile, "sensor": body.sensor}
    across = tiles_across(setting.arena_side, body.tile)
    if across <= MOST_TILES:
        tiles, turns = show.trace.floor()
        scene |= {"across": across, "floor": _numbers(np.packbits(tiles), "u1")}
        if turns.size:
            scene["turns"] = _numbers(turns, "<i4")
    return scene


def places_of(show: Show) -> np.ndarray:
    """Where a page draws the robots of a fixed network (robot, 2), in [0, 1]."""
    robots, topology, links = show.setting.robots, show.setting.topology, show.trace.given.links
    columns, name = _columns(robots), topology.named
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
    graph.add_edges_from(show.edges.tolist())
    layout = networkx.spring_layout(graph, seed=1, iterations=200 if robots <= 100 else 60)
    places = np.array([layout[i] for i in range(robots)])
    span = np.ptp(places, axis=0).max() or 1.0
    return np.asarray(0.5 + 0.92 * (places - (places.max(axis=0) + places.min(axis=0)) / 2) / span)


def _columns(robots: int) -> int:
    """How many robots stand in a row of a square of them."""
    return int(np.ceil(np.sqrt(robots)))


def _room(places: np.ndarray) -> float:
    """The median distance between nearest neighbours; 1 for robots in rows, which do not need it."""
    if not 2 <= len(places) <= MOST_LAID_OUT:
        return 1.0
    distances = np.linalg.norm(places[:, np.newaxis] - places, axis=2)
    np.fill_diagonal(distances, np.inf)
    return float(np.median(distances.min(axis=1)))


def _numbers(values: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode()
