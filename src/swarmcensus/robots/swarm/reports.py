"""What robots report, and what is known of each of them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

COUNTED = ("ticks", "heard", "refused", "missed", "undone", "sent", "lost", "late", "unwritten")
KINDS = (*(int,) * 6, float, *(int,) * len(COUNTED))


class Report(NamedTuple):
    """One datagram of a robot; `round` is -1 until its swarm has started."""

    number: int
    life: int
    port: int  # of its radio
    version: int  # of the last orders that it got
    round: int = -1  # the round that comes next, counted from 0
    resumed: int = 0  # the tick of the memory that it started with; 0: with none
    estimate: float = 0.5
    ticks: int = 0  # that it has lived since
    heard: int = 0
    refused: int = 0
    missed: int = 0
    undone: int = 0
    sent: int = 0  # messages, each counted for each robot that should hear it
    lost: int = 0
    late: int = 0  # came after its last tick
    unwritten: int = 0  # parts of its log and savings of its memory that the disk did not take


def read_report(datagram: bytes, token: str) -> Report | None:
    """A report of a run's robot, which begins with the run's token; None if the datagram is something else."""
    first, *words = datagram.split(b" ")
    if first != token.encode():
        return None
    return Report(*(kind(word) for kind, word in zip(KINDS, words, strict=False)))  # type: ignore[arg-type]


@dataclass
class RobotState:
    """What is known of a robot."""

    last: Report | None = None  # of this life, or of the one that has ended
    address: tuple[str, int] | None = None  # of the socket that it reports from; None while it does not run
    before: dict[str, int] = field(default_factory=lambda: dict.fromkeys(COUNTED, 0))  # sums of earlier lives
    seen: float = 0.0  # when the last report came, by the clock `time.monotonic`
    state: str = "waits"  # waits, runs, stopped, killed, died
    why: str = ""  # it died
    began: int = 1  # the life that was last said to have begun; the first needs no word

    def count(self, name: str) -> int:
        """A sum over all its lives."""
        return self.before[name] + (getattr(self.last, name) if self.last else 0)

    def new_life(self) -> None:
        """Keep the sums of the life that ends."""
        self.before = {name: self.count(name) for name in COUNTED}
        self.last, self.address = None, None


def total(robots: Sequence[RobotState], name: str) -> int:
    """A sum over all robots."""
    return sum(known.count(name) for known in robots)


def share_heard(robots: Sequence[RobotState]) -> float:
    """The share of messages that were heard, of those that neither were lost in the air nor came after the end."""
    due = total(robots, "sent") - total(robots, "lost") - total(robots, "late")
    return min(1.0, total(robots, "heard") / due) if due > 0 else float("nan")
