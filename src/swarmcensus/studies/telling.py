"""What is said of a `Setting`, which all these take: a line for messages, and the coordinates of the dataset."""

from typing import Any

import numpy as np

from swarmcensus.basics.counting import counted
from swarmcensus.brains import Value
from swarmcensus.worlds.patterns import Floor


def line(of: Any) -> str:
    """A setting in a line, for messages."""
    where = f"{of.topology}, N = {of.robots:,}"
    assumed = "" if of.assumed_accuracy is None else f", assumed accuracy {of.assumed_accuracy}"
    lossy = "" if of.link_success == 1.0 else f", link success {of.link_success}"
    mixed = "".join(f", of them {member}" for member in of.members)
    late = "" if not of.delay else f", messages {counted(of.delay, 'round')} late"
    told = "".join(f", {name} = {_shown(value)}" for name, value in _parameters(of))
    what = f"accuracy {of.accuracy}{assumed}, f = {of.change or of.fill_ratio}{lossy}{late}{told}{mixed}"
    if of.body is not None:
        floor = f", floor {of.floor}" if of.floor not in (None, Floor()) else ""
        return f"{where}, {_room(of)}, {what}{floor}, {counted(of.rounds, 'tick')}"
    return f"{where}, {what}, C = {of.rounds:,}, R = {of.observations_per_round:,}"


def _parameters(of: Any) -> list[tuple[str, Value]]:
    """What a title tells of its brain: all numbers, for others may vary what this one leaves, and given vectors."""
    given = dict(of.brain.given)
    return [(n, v) for n, v in of.brain.parameters.items() if n in given or not isinstance(v, tuple)]


def _room(of: Any) -> str:
    """Density or side of the arena: which has fewer digits is what the study gave."""
    density, side = float(f"{of.density:.12g}"), of.side
    return f"L = {side} m" if len(str(side)) < len(str(density)) else f"D = {density}"


def coordinates(of: Any) -> dict[str, object]:
    """What the dataset says of a setting."""
    return {
        "brain": of.brain.name,
        "topology": str(of.topology),
        "robots": of.robots,
        "density": np.nan if of.density is None else of.density,
        "side": of.side,
        "accuracy": str(of.accuracy),
        "assumed_accuracy": str(of.assumed_accuracy or of.accuracy.start),
        "fill_ratio": of.fill_ratio,
        "floor": "" if of.body is None else str(of.floor or Floor()),
        "link_success": of.link_success,
        "rounds": of.rounds,
        "observations_per_round": of.observations_per_round,
        **{name: _shown(value) for name, value in of.brain.parameters.items()},
        **_mixed(of),
        **({"fill_ratio_change": str(of.change)} if of.change else {}),
        **({"message_delay": of.delay} if of.delay else {}),
    }


def _mixed(of: Any) -> dict[str, object]:
    """What the dataset says of members: who they are, how many of them lie, and who these are."""
    if not of.members:
        return {}
    lying = dict.fromkeys(", ".join(m.traits) for m in of.members if not m.honest)
    return {
        "members": "; ".join(map(str, of.members)),
        "liars": of.robots - of.honest,
        "adversary": "; ".join(lying),
    }


def _shown(value: Value) -> float | str:
    """A parameter as a coordinate: a vector as text."""
    return f"({', '.join(f'{one:g}' for one in value)})" if isinstance(value, tuple) else value
