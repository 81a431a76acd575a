"""What stays the same during a trial: its title, the floor or the network, and which robots lie."""

import base64
from typing import Any

import numpy as np

from swarmcensus.figures import MOST_LAID_OUT, in_a_row, places_of_robots
from swarmcensus.live.frames import COLUMNS, Show
from swarmcensus.live.robots import memory_names
from swarmcensus.worlds import tiles_across

MOST_TILES = {False: 4096, True: 1024}  # along a side that a page draws, by whether they change; else an even grey


def scene_of(show: Show) -> dict[str, Any]:
    """The scene for JSON; arrays of numbers are base64."""
    setting, brain, body = show.setting, show.setting.brain, show.setting.body
    scene: dict[str, Any] = {
        "title": setting.brief, "brain": brain.label, "robots": setting.robots, "rounds": show.rounds,
        "moves": show.moves, "dishonest": np.flatnonzero(~show.honest).tolist(),
        "bins": show.bins, "on_edges": show.on_edges, "opinions": show.opinions,
        "knows": not np.isnan(setting.fill_ratio),
        "options": max((one.options for one in setting.brains if one.decides), default=0),
        "ends": any(one.ends for one in setting.brains), "columns": COLUMNS, "layers": show.layers,
        "fields": memory_names(setting), "memory": brain.memory_bytes, "message": brain.message_bytes,
    }  # fmt: skip
    if body is None:
        places, is_crowd = places_of_robots(setting, show.trace.given.links), setting.robots > MOST_LAID_OUT
        scene |= {"unit": "round", "places": _numbers(places, "<f4"), "edges": _numbers(show.edges, "<u2")}
        scene |= {"crowd": in_a_row(setting.robots) if is_crowd else 0, "room": _apart(places)}
        return scene | {"wraps": setting.topology.named == "torus" and not is_crowd}
    scene |= {"unit": "tick", "seconds": body.tick, "side": setting.arena_side, "range": body.radio_range}
    scene |= {"radius": body.radius, "tile": body.tile, "sensor": body.sensor}
    across = tiles_across(setting.arena_side, body.tile)
    if across <= MOST_TILES[setting.change is not None]:
        tiles, turns = show.trace.floor()
        scene |= {"across": across, "floor": _numbers(np.packbits(tiles), "u1")}
        if turns.size:
            scene["turns"] = _numbers(turns, "<i4")
    return scene


def _apart(places: np.ndarray) -> float:
    """The median distance between nearest neighbours; 1 for robots in rows, which do not need it."""
    if not 2 <= len(places) <= MOST_LAID_OUT:
        return 1.0
    distances = np.linalg.norm(places[:, np.newaxis] - places, axis=2)
    np.fill_diagonal(distances, np.inf)
    return float(np.median(distances.min(axis=1)))


def _numbers(values: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode()
