"""The reference: a brain file as CPython runs it, robot by robot and step by step. Slow, and trusted."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from swarmcensus.brains import Brain


def follow(
    brain: Brain,
    b: np.ndarray,
    w: np.ndarray,
    blacks: np.ndarray,
    looks: int,
    every: int,
    periodic: bool,
    messages: Iterable[np.ndarray],
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Minds that make recorded observations and hear recorded messages.

    `blacks` (step, robot) counts the black ones of `looks` readings, NaN where a robot made none. A round ends
    every `every` steps and at the last. `messages` has (receiver, sender) rows for each step; with `periodic`
    they are heard at the end of whole rounds only. Returns each field of the memory, and the estimates, as
    arrays (round, robot), index 0 before any observation.
    """
    functions = brain.functions
    minds = [brain.robot(float(b[i]), float(w[i])) for i in range(blacks.shape[1])]
    memories: list[list[dict[str, float]]] = []
    estimates: list[list[float]] = []

    def keep() -> None:
        memories.append([{name: getattr(me, name) for name in brain.memory} for me in minds])
        estimates.append([functions.estimate(me) for me in minds])

    keep()
    for step, pairs in zip(range(len(blacks)), messages, strict=True):
        whole = (step + 1) % every == 0
        for me, count in zip(minds, blacks[step], strict=True):
            if not np.isnan(count):
                functions.observe(me, float(count), float(looks))
        said: list[Any] = [functions.broadcast(me) for me in minds]
        if whole or not periodic:
            for receiver, sender in pairs:
                functions.receive(minds[receiver], said[sender])
        if whole or step == len(blacks) - 1:
            for me in minds:
                functions.fuse(me)
            keep()
    fields = {name: np.array([[m[name] for m in row] for row in memories]) for name in brain.memory}
    return fields, np.array(estimates)
