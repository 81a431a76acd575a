"""The random numbers of another brain: the log's for calls that the robot's own brain made too, else by addresses."""

from typing import Any, NamedTuple

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.engine import address, chance, single_chance, word_of, words
from swarmcensus.engine.constants import DRAW_FUSE, DRAW_OBSERVE, DRAW_STEER
from swarmcensus.robots.logs.folders import Recording, study_of
from swarmcensus.robots.logs.logs import Tick
from swarmcensus.robots.logs.replicas import Replica

PARTS = DRAW_OBSERVE, DRAW_FUSE, DRAW_STEER  # of `observe`, `fuse` and `steer`
BOOTS = 1 << 20  # between the addresses of two boots


class Calls(NamedTuple):
    """The random numbers of the calls of a tick; None where the log has none."""

    observe: float | None = None
    receive: tuple[float, ...] = ()
    fuse: float | None = None
    steer: float | None = None


def of_calls(brain: Brain, tick: Tick) -> Calls:
    """Which call of the robot's own brain each logged number was for."""
    observes, hears = int(tick.looks > 0), len(tick.heard)
    if not tick.draws or len(tick.draws) != observes + hears + 1 + brain.steers:
        return Calls()
    rest = tick.draws[observes + hears :]
    return Calls(
        tick.draws[0] if observes else None, tick.draws[observes : observes + hears], rest[0], rest[1] if brain.steers
        else None,
    )  # fmt: skip


class Draws:
    """Numbers that a simulation of the brain would draw, where swarm.json has the study; else others of its seed."""

    def __init__(self, recording: Recording, brain: Brain) -> None:
        """Make the keys of a simulation of the recording with this brain, if its study can be read."""
        self.trial = recording.trial
        self.keys = np.zeros(4, np.uint64)
        if brain.uses.luck:
            content: dict[str, Any] = {"robots": len(recording.members)}
            if (study := study_of(recording.about)) is not None:
                settings = study.settings()
                setting = settings[min(int(recording.about.get("setting", 0)), len(settings) - 1)]
                content = {"robots": setting.robots, "topology": setting.topology.content}
            keys = [address(recording.seed, purpose, **content) for purpose in ("luck", "luck of messages")]
            self.keys = np.concatenate(keys)

    def own(self, replica: Replica, boot: int, tick: int, part: int) -> float:
        """The random number of a robot's own call: of `observe`, `fuse` or `steer`."""
        out = np.zeros(2, np.uint64)
        words(self.keys[:2], self._trial(boot), tick, PARTS[part], replica.number // 2 * 2, 2, out)
        return _lot(replica, out[replica.number % 2])

    def message(self, replica: Replica, boot: int, tick: int, sender: int) -> float:
        """The random number for receiving a message."""
        return _lot(replica, word_of(self.keys[2], self.keys[3], self._trial(boot), tick, replica.number, sender))

    def _trial(self, boot: int) -> int:
        return (self.trial + BOOTS * boot) & 0xFFFFFFFF


def _lot(replica: Replica, word: Any) -> float:
    return float((single_chance if replica.is_single else chance)(np.uint64(word)))
