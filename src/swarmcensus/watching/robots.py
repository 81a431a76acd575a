"""One robot in full: its memory after a round, the messages that it heard, its reading and its tile."""

from typing import Any

import numpy as np

from swarmcensus.basics.documents import json_value
from swarmcensus.brains.fields import slots
from swarmcensus.engine.compiler import array_layout
from swarmcensus.engine.constants import LISTED
from swarmcensus.simulation.living import Stretch
from swarmcensus.watching.shows import Show

LOOK_BACK = 200  # rounds that are searched for the latest messages


def robot_of(show: Show, tick: int, robot: int) -> dict[str, Any]:
    """A robot after a round: its fields as in `sc.replay`, the messages it heard, its reading and its tile."""
    stretch, row = show.find(tick)
    fields = show.fields(stretch, slice(row, row + 1))
    brain = show.setting.brains[show.group[robot]]
    b, w, believed_b, believed_w = (
        float(side[0][robot if side.shape[1] > 1 else 0])
        for side in (*show.life.given.sensors[:2], *show.life.given.beliefs)
    )
    robot_data: dict[str, Any] = {
        "robot": robot,
        "tick": tick,
        "brain": brain.label,
        "honest": bool(show.honest[robot]),
        "estimate": json_value(stretch.estimates[row, robot]),
        "truth": float(show.truths(np.array([tick]))[0]),
        "sensor": {"b": b, "w": w, "believed_b": believed_b, "believed_w": believed_w},
        "fields": {name: json_value(value[0, robot]) for name, value in fields.items()},
        "adds": adds(show),
        **last_heard(show, stretch, row, robot),
    }
    ended = bool(show.ended(stretch)[row, robot])
    if show.moves:
        x, y, heading = map(float, stretch.poses[row, robot])
        robot_data |= {"x": x, "y": y, "heading": heading}
        robot_data |= {
            "tile": json_value(stretch.colours[row, robot]),
            "reading": None if ended else json_value(stretch.readings[row, robot]),
        }
    elif tick > 0 and show.blacks.size:
        robot_data |= {
            "looks": show.setting.observations_per_round,
            "blacks": 0.0 if ended else float(show.blacks[tick - 1, robot]),
        }
    return robot_data


def last_heard(show: Show, stretch: Stretch, row: int, robot: int) -> dict[str, Any]:
    """The messages of this round, or of the last earlier round with messages, if it is still stored."""
    tick = stretch.first + row
    for at in range(tick, max(tick - LOOK_BACK, 0), -1):
        kept = stretch if at >= stretch.first else show.life.kept(show.stretch_of(at))
        if kept is None:
            break
        heard = heard_in(show, kept, at - kept.first, robot)
        if heard:
            return {"heard": heard, "heard_at": at}
    return {"heard": [], "heard_at": None}


def heard_in(show: Show, stretch: Stretch, row: int, robot: int) -> list[dict[str, Any]]:
    """The messages that a robot heard in a round: the sender, and the contents or what they add to the sums."""
    senders = neighbours_of(show, stretch, row, robot)
    here = show.carried(stretch, row, np.full(senders.size, robot), senders) > 0
    brain = show.setting.brain
    said = array_layout(brain, len(show.setting.brains) > 1).said(stretch.said[row])
    names = slots({name: brain.lengths[name] for name in brain.sums} if adds(show) else brain.message)
    return [
        {"from": int(sender), "said": dict(zip(names, map(json_value, said[sender].tolist()), strict=False))}
        for sender in senders[here]
    ]


def neighbours_of(show: Show, stretch: Stretch, row: int, robot: int) -> np.ndarray:
    """The robots that a robot can hear in a round, in order."""
    everyone = np.delete(np.arange(show.setting.robots), robot)
    links = show.life.given.links
    if links is not None:
        return np.sort(links.senders[links.receivers == robot]) if links.mode == LISTED else everyone
    if show.setting.brain.is_oracle:
        return everyone
    pairs = stretch.links[stretch.links[:, 0] == stretch.first + row, 1:]
    return np.sort(np.concatenate([pairs[pairs[:, 0] == robot, 1], pairs[pairs[:, 1] == robot, 0]]))


def adds(show: Show) -> bool:
    """Whether messages are stored as what they add to the sums of their receivers."""
    return bool(show.life.swarm.additive)
