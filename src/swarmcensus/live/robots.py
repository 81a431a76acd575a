"""One robot in full: its memory after a round, the messages that it heard, its reading and its tile."""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from swarmcensus.brains import slots
from swarmcensus.live.frames import Show, quarters_of
from swarmcensus.simulation import Trace
from swarmcensus.studies import Setting
from swarmcensus.support.documents import json_value

LOOK_BACK = 200  # rounds that are searched for the latest messages


def robot_of(show: Show, tick: int, robot: int) -> dict[str, Any]:
    """A robot after a round: its fields as in `sc.replay`, the messages it heard, its reading and its tile."""
    trace = show.trace
    stretch, row = trace.find(tick)
    fields = stretch.decode(slice(row, row + 1))
    brain = show.setting.brains[trace.group[robot]]
    b, w, believed_b, believed_w = (
        float(side[0][robot if side.shape[1] > 1 else 0]) for side in (*trace.given.sensors[:2], *trace.given.beliefs)
    )
    robot_data: dict[str, Any] = {
        "robot": robot,
        "tick": tick,
        "brain": brain.label,
        "honest": bool(show.honest[robot]),
        "estimate": json_value(stretch.estimates[row, robot]),
        "truth": json_value(show.truths(np.array([tick]))[0]),
        "sensor": {"b": b, "w": w, "believed_b": believed_b, "believed_w": believed_w},
        "fields": {name: json_value(value[0, robot]) for name, value in fields.items()},
        "adds": trace.adds,
        **last_heard(trace, tick, robot),
    }
    if not show.draws_links(stretch, row):
        senders, carried = trace.hears(tick, robot)
        robot_data |= {"hears": senders.tolist(), "carried": carried.tolist()}
    ended = bool(trace.ended(stretch)[row, robot])
    if show.moves:
        robot_data |= zip(("x", "y", "heading"), map(float, stretch.poses[row, robot]), strict=True)
        robot_data["tile"] = json_value(stretch.colours[row, robot])
        robot_data["reading"] = None if ended else json_value(stretch.readings[row, robot])
    elif (read := trace.read(tick, robot)) is not None:
        robot_data |= {"looks": read[1], "blacks": 0.0 if ended else read[0]}
    return robot_data


def memory_names(setting: Setting) -> list[str]:
    """The numbers in the memory of a setting's robots, such as "t" or "beliefs[3]"."""
    return [*dict.fromkeys(name for brain in setting.brains for name in slots(brain.lengths))]


def memory_of(show: Show, ticks: Sequence[int], name: str, robot: int) -> list[list[float | None]]:
    """A field of memories after some rounds: the round, the robot's value, and QUARTERS of the honest robots."""
    field, _, at = name.removesuffix("]").partition("[")
    found = []
    for _, group in itertools.groupby(ticks, show.trace.stretch_of):
        some = list(group)
        stretch, first = show.trace.find(some[0])
        rows = np.array(some) - stretch.first
        values = stretch.decode(slice(first, int(rows[-1]) + 1))[field][rows - first]
        values = (values[..., int(at)] if at else values).astype(np.float64)
        honest = values[:, show.honest]
        found.append(np.column_stack([some, values[:, robot], *quarters_of(honest, ~np.isnan(honest))]))
    return [json_value(row) for row in np.concatenate(found)]


def last_heard(trace: Trace, tick: int, robot: int) -> dict[str, Any]:
    """The messages of this round, or of the last earlier round with messages, if it is still stored."""
    for at in range(tick, max(tick - LOOK_BACK, 0), -1):
        if trace.stretch(trace.stretch_of(at)) is None:
            break
        if heard := trace.heard(at, robot):
            return {"heard": heard, "heard_at": at}
    return {"heard": [], "heard_at": None}
