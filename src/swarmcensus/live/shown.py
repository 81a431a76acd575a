"""The trials that a page shows: their scenes, frames and robots, computed a piece at a time."""

import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from swarmcensus.live.about_trial import scene_of
from swarmcensus.live.frames import Show
from swarmcensus.live.robots import memory_of, robot_of
from swarmcensus.simulation import Trace
from swarmcensus.studies import Measure, Setting
from swarmcensus.support.errors import InputError

MOST_BYTES = 3_000_000  # of frames in one answer
PATIENCE = 0.2  # seconds of computation before a page learns that it takes longer
Answer = bytes | dict[str, Any]
Makes = Callable[[Setting, int, int], Trace]  # a setting's trial, by seed and number


class Shown:
    """One trial, or two of them side by side in the same world."""

    def __init__(self, settings: Sequence[Setting], seed: int, trial: int, measure: Measure, make: Makes) -> None:
        """Start the trials. Raises InputError if a brain does not compile."""
        self.shows = tuple(Show(make(setting, seed, trial), measure) for setting in settings)

    @property
    def rounds(self) -> int:
        """How many rounds can be shown."""
        return min(show.rounds for show in self.shows)

    @property
    def is_compiled(self) -> bool:
        """Whether this process computes all of them."""
        return all(show.trace.is_compiled for show in self.shows)

    def approach(self, tick: int, seconds: float) -> None:
        """Compute towards a round, for about so many seconds. Raises InputError if a brain fails before it."""
        began = time.monotonic()
        for show in self.shows:
            while time.monotonic() - began < seconds and not _reached(show, min(tick, show.rounds), time.monotonic()):
                pass

    def scenes(self) -> list[dict[str, Any]]:
        """What stays the same during the trials."""
        return [scene_of(show) for show in self.shows]

    def frames(self, ticks: range) -> list[Answer]:
        """Frames of all sides, or a note that they take longer. Raises InputError if a brain fails."""
        most = max(1, MOST_BYTES // (16 * self.shows[0].setting.robots * len(self.shows)))
        if not (done := _some(self.shows, ticks[:most])):
            return [{"going": True}]
        answers = [show.frames(done, side) for side, show in enumerate(self.shows)]
        return [*answers, {"frames": len(done)}]

    def robot(self, side: int, tick: int, robot: int) -> list[Answer]:
        """A robot in full, or a note that it takes longer. Raises InputError if a brain fails."""
        if not _reached(self.shows[side], tick, time.monotonic()):
            return [{"going": True, "to": tick}]
        return [{"told": robot_of(self.shows[side], tick, robot), "side": side}]

    def memory(self, side: int, robot: int, name: str, ticks: range) -> list[Answer]:
        """A field of a robot's memory over time, and of the swarm's. Raises InputError if a brain fails."""
        show = self.shows[side]
        done = _some([show], ticks)
        return [{"memory": memory_of(show, done, name, robot)} if done else {"going": True}]


def _some(shows: Sequence[Show], ticks: Iterable[int]) -> list[int]:
    """Compute towards some rounds; returns those that were reached soon. Raises InputError if a brain fails."""
    began = time.monotonic()
    done: list[int] = []
    for tick in ticks:
        try:
            there = all(_reached(show, tick, began) for show in shows)
        except InputError:
            if done:  # show what came before a brain failed
                break
            raise
        if not there:
            break
        done.append(tick)
        if time.monotonic() - began > PATIENCE:
            break
    return done


def _reached(show: Show, tick: int, began: float) -> bool:
    """Compute towards a round until PATIENCE seconds after `began`; whether it is reached."""
    while not show.trace.reach(tick):
        if time.monotonic() - began > PATIENCE:
            return False
    return True
