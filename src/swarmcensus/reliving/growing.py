"""A swarm's folder while its logs grow: robots' minds and the clock go on from what was appended."""

import time
from pathlib import Path

from swarmcensus.basics.errors import InputError
from swarmcensus.reliving.clocks import Clock
from swarmcensus.reliving.folders import ABOUT, Day, Folder, about_of, without_logs
from swarmcensus.reliving.lives import Life, Reliving
from swarmcensus.reliving.logs import LogReader
from swarmcensus.reliving.others import OtherDay
from swarmcensus.reliving.traces import note_logged

RECENT = 60.0  # seconds without a new block after which a swarm without an end counts as killed
GONE = 3.0  # seconds without a new block after which a robot counts as gone
FEWEST = 3.0  # periods, if that is longer


def may_grow(path: Path) -> bool:
    """Whether a swarm runs that writes into a folder. Raises InputError."""
    about = about_of(path)
    logs = [_changed(log) for log in path.glob("*.log")]
    return "ended" in about and about["ended"] is None and time.time() - max(logs, default=0.0) < RECENT


class GrowingDay:
    """What is known of a day so far; `go_on` reads and lives what was appended to the logs."""

    day: Day

    def __init__(self, path: Path) -> None:
        """Read and live what there is. Raises InputError."""
        self.path = path
        self.clock = Clock()
        self.moved = False  # whether blocks that were known before have other times since the last `go_on`
        self._folder = Folder(path)
        self._about_of = _changed(path / ABOUT)
        self._readers: dict[str, LogReader] = {}
        self._minds: dict[int, Reliving] = {}
        self._lived: dict[int, int] = {}  # how many blocks of a robot's log
        self._grew: dict[int, float] = {}  # when a robot's log did, in seconds since 1970
        self._start()
        self.go_on()

    @property
    def lives(self) -> list[Life]:
        """The lives of the day's members, so far."""
        return [self._minds[member.number].life for member in self.day.members]

    @property
    def has_ended(self) -> bool:
        """Whether the swarm has ended, and all of its logs are read."""
        return self._folder.about.get("ended") is not None

    def at_work(self) -> frozenset[int]:
        """The robots whose logs grew lately."""
        now, patience = time.time(), max(GONE, FEWEST * float(self._folder.about.get("period", 0)) / 1000.0)
        return frozenset(number for number, grew in self._grew.items() if now - grew < patience)

    def go_on(self) -> dict[int, int]:
        """Read and live what was appended; returns the first new block by robot. Raises InputError."""
        self._read()
        new = {}
        for member in self.day.members:
            number, count, first = member.number, len(member.log.blocks), self._lived.get(member.number, 0)
            if count == first:
                continue
            if number not in self._minds:
                self._minds[number] = Reliving(member, keep=True)
            note_logged(self.lived, member, self._minds[number].go_on(), first)
            self._grew[number] = time.time() if first else _changed(member.log.path)
            self._lived[number], new[number] = count, first
        self.moved = self.clock.go_on(self.day.members)
        return new

    def _start(self) -> None:
        self._read()
        self.lived = OtherDay(self.day.brain, {}, {})

    def _read(self) -> None:
        """Read what was appended, and note members whose logs have begun."""
        if (changed := _changed(self.path / ABOUT)) != self._about_of:  # before the logs: after its end none grows
            self._folder, self._about_of = Folder(self.path), changed
        for name in self._folder.names():
            if name not in self._readers:
                self._readers[name] = LogReader(self.path / name)
            self._readers[name].more()
        logs = [reader.log for reader in self._readers.values() if reader.log is not None]
        if not logs:
            raise InputError(without_logs(self.path))
        if not hasattr(self, "day") or len(logs) != len(self.day.members) or self.day.about != self._folder.about:
            self.day = self._folder.day(logs)


def _changed(path: Path) -> float:
    """When a file was changed, in seconds since 1970; 0 if it is not there."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
