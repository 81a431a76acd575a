"""What robots report, and what is known of each of them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

COUNTED = ("heard", "stale", "refused", "missed", "undone", "blanked", "sent", "lost", "late", "unwritten")
MOST = 1 << 53  # no count of a robot gets there


class Report(NamedTuple):
    """One datagram of a robot; `round` is -1 until its swarm has started."""

    number: int
    life: int
    port: int  # of its radio
    version: int  # of the last orders that it got
    round: int = -1  # the round that comes next, counted from 0
    ticks: int = 0
    estimate: float = 0.5
    decision: float = -1.0
    heard: int = 0
    stale: int = 0
    refused: int = 0
    missed: int = 0
    undone: int = 0
    blanked: int = 0
    sent: int = 0  # messages, each counted for each robot that should hear it
    lost: int = 0
    late: int = 0  # came after its last tick
    resumed: int = 0  # the tick whose memory it began this life with; 0: with none
    unwritten: int = 0  # parts of its log and savings of its memory that the disk did not take


def read_report(datagram: bytes, token: str) -> Report | None:
    """A report of a run's robot, which begins with the run's token; None if the datagram is something else."""
    first, *words = datagram.split(b" ")
    if first != token.encode():
        return None
    kinds = (*(int,) * 6, float, float, *(int,) * 11)
    if len(words) not in (4, len(kinds)):
        return None
    try:
        report = Report(*(kind(word) for kind, word in zip(kinds, words, strict=False)))  # type: ignore[arg-type]
    except ValueError:
        return None
    counts = (getattr(report, name) for name in ("number", "life", "version", "ticks", "resumed", *COUNTED))
    are_possible = -1 <= report.round < MOST and all(0 <= count < MOST for count in counts)
    are_finite = math.isfinite(report.estimate) and math.isfinite(report.decision)
    return report if 1 <= report.port <= 65535 and are_possible and are_finite else None


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
