"""The luck of another brain: the log's for calls that the robot's own brain made too, else drawn by addresses."""

from typing import Any, NamedTuple

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.engine import address, chance, single_chance, word_of, words
from swarmcensus.engine.constants import LUCK_FUSE, LUCK_OBSERVE, LUCK_STEER
from swarmcensus.robots.logs.folders import Day, study_of
from swarmcensus.robots.logs.logs import Tick
from swarmcensus.robots.logs.minds import Mind

PARTS = LUCK_OBSERVE, LUCK_FUSE, LUCK_STEER  # of `observe`, `fuse` and `steer`
BOOTS = 1 << 20  # between the addresses of two boots


class Calls(NamedTuple):
    """The luck of the calls of a tick; None where the log has none."""

    observe: float | None = None
    receive: tuple[float, ...] = ()
    fuse: float | None = None
    steer: float | None = None


NONE = Calls()


def of_calls(brain: Brain, tick: Tick) -> Calls:
    """Which call of the robot's own brain each logged number was for."""
    observes, hears = int(tick.looks > 0), len(tick.heard)
    if not tick.luck or len(tick.luck) != observes + hears + 1 + brain.steers:
        return NONE
    rest = tick.luck[observes + hears :]
    return Calls(
        tick.luck[0] if observes else None, tick.luck[observes : observes + hears], rest[0], rest[1] if brain.steers
        else None,
    )  # fmt: skip


class Luck:
    """Numbers that a simulation of the brain would draw, where swarm.json has the study; else others of its seed."""

    def __init__(self, day: Day, brain: Brain) -> None:
        """Make the keys."""
        self.trial = day.trial
        self.keys = _keys_of(day, brain) if brain.uses.luck else np.zeros(4, np.uint64)

    def own(self, mind: Mind, boot: int, tick: int, part: int) -> float:
        """The luck of a robot's own call: of `observe`, `fuse` or `steer`."""
        out = np.zeros(2, np.uint64)
        words(self.keys[:2], self._trial(boot), tick, PARTS[part], mind.number // 2 * 2, 2, out)
        return _lot(mind, out[mind.number % 2])

    def message(self, mind: Mind, boot: int, tick: int, sender: int) -> float:
        """The luck of receiving a message."""
        return _lot(mind, word_of(self.keys[2], self.keys[3], self._trial(boot), tick, mind.number, sender))

    def _trial(self, boot: int) -> int:
        return (self.trial + BOOTS * boot) & 0xFFFFFFFF


def _lot(mind: Mind, word: Any) -> float:
    return float((single_chance if mind.is_single else chance)(np.uint64(word)))


def _keys_of(day: Day, brain: Brain) -> np.ndarray:
    """The keys of a simulation of the day with this brain, if its study can be read."""
    if (study := study_of(day.about)) is not None:
        settings = study.settings()
        setting = settings[min(int(day.about.get("setting", 0)), len(settings) - 1)]
        content = {"robots": setting.robots, "topology": setting.topology.content}
    else:
        content = {"robots": len(day.members)}
    return np.concatenate([address(day.seed, purpose, **content) for purpose in ("luck", "luck of messages")])
