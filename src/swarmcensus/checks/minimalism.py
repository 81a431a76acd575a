"""What a brain needs of a robot, counted while CPython runs the file: numbers kept, numbers sent, lines run."""

import sys
from collections.abc import Callable
from typing import Any

from swarmcensus.brains import Brain, Lines

AGES = (10.0, 100.0, 1_000.0, 1_000_000.0)  # observations before the counted round
SWARMS = (10, 100, 1_000)  # robots, of which each hears all others
SHARES = (0.0, 0.01, 0.3, 0.6, 0.99, 1.0)  # of black readings, for all cases of the paper's Eqs. 4 and 5
ACCURACIES = ((0.525, 0.525), (0.975, 0.975), (0.9, 0.6), (1.0, 1.0))


def footprints(brain: Brain) -> dict[tuple[int, float], dict[str, int]]:
    """For each (robots, earlier observations): the most that a robot needs in the next round, over all histories.

    "memory" and "message" count numbers, without the sensor's two accuracies. "observe", "broadcast", "receive" (one
    message), "fuse" and "estimate" count the lines that one call runs, including helper functions.
    """
    table = {}
    for robots in SWARMS:
        for age in AGES:
            needs = [_round(brain, robots, age, share, b, w) for share in SHARES for b, w in ACCURACIES]
            table[robots, age] = {name: max(each[name] for each in needs) for name in needs[0]}
    return table


def _round(brain: Brain, robots: int, age: float, share: float, b: float, w: float) -> dict[str, int]:
    functions = brain.functions
    robot, neighbour = brain.robot(b, w), brain.robot(b, w)
    for state in (robot, neighbour):
        functions.observe(state, round(share * age), age)
    message = functions.broadcast(neighbour)
    for _ in range(robots - 2):
        functions.receive(robot, message)
    lines = {
        "observe": _lines(brain, functions.observe, robot, 1.0, 1.0),
        "broadcast": _lines(brain, functions.broadcast, robot),
        "receive": _lines(brain, functions.receive, robot, message),
        "fuse": _lines(brain, functions.fuse, robot),
        "estimate": _lines(brain, functions.estimate, robot),
    }
    kept = [getattr(robot, name) for name in brain.memory]
    return {"memory": _numbers(kept), "message": _numbers(functions.broadcast(robot)), **lines}


def _numbers(values: Any) -> int:
    """How many numbers these are; a huge count if one is not a plain number, which could grow."""
    return len(values) if all(isinstance(v, int | float) for v in values) else sys.maxsize


def _lines(brain: Brain, function: Callable[..., Any], *arguments: Any) -> int:
    with Lines(brain) as lines:
        function(*arguments)
    return lines.run
