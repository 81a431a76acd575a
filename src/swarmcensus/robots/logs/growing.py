"""A swarm's folder while its logs grow: robots' states and the clock go on from what was appended."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarmcensus.robots.logs.clocks import Clock
from swarmcensus.robots.logs.folders import ABOUT, Folder, about_of, logs_in, without_logs
from swarmcensus.robots.logs.lives import Reliving, RobotReplay
from swarmcensus.robots.logs.logs import LogReader, RobotLog

RECENT = 60.0  # seconds without a new block after which a swarm without an end counts as killed
GONE = 3.0  # seconds without a new block after which a robot counts as gone
FEWEST = 3.0  # periods, where these are longer


def may_grow(path: Path) -> bool:
    """Whether a swarm runs that writes into a folder. Raises InputError."""
    about = about_of(path) if path.is_dir() else {}
    newest = max((_changed(log) for log in logs_in(path)), default=0.0)
    return "ended" in about and about["ended"] is None and time.time() - newest < _patience(about, RECENT)


class GrowingRecording:
    """What is known of a recording so far; `go_on` reads and lives what was appended to the logs."""

    def __init__(self, path: Path) -> None:
        """Read and live the first part of what there is. Raises InputError."""
        self.path = path
        self.clock = Clock()
        self.moved = False  # whether blocks that were known before have other times since the last `go_on`
        self._readers: dict[str, LogReader] = {}
        self._replicas: dict[int, Reliving] = {}
        self._lived: dict[int, int] = {}  # how many blocks of a robot's log
        self._grew: dict[int, float] = {}  # when a robot's log did, in seconds since 1970
        self._about_of = _changed(path / ABOUT)
        self._folder = Folder(path)
        self.recording = self._folder.recording(self._read())
        self.go_on()

    @property
    def lives(self) -> list[RobotReplay]:
        """The lives of the recording's members, so far."""
        return [self._replicas[member.number].life for member in self.recording.members]

    @property
    def has_ended(self) -> bool:
        """Whether the swarm has ended, and all of its logs are read."""
        return self.recording.about.get("ended") is not None and not self.is_behind

    @property
    def is_behind(self) -> bool:
        """Whether logs hold more than was read: each `go_on` takes a part, so that nobody waits long for it."""
        return any(reader.is_behind for reader in self._readers.values())

    def at_work(self) -> frozenset[int]:
        """The robots whose logs grew lately."""
        now, patience = time.time(), _patience(self.recording.about, GONE)
        return frozenset(number for number, grew in self._grew.items() if now - grew < patience)

    def go_on(self) -> dict[int, int]:
        """Read and live what was appended; returns the first new block by robot. Raises InputError."""
        if (changed := _changed(self.path / ABOUT)) != self._about_of:  # before the logs: after its end none grows
            self._folder, self._about_of = Folder(self.path), changed
        logs = self._read()
        if len(logs) != len(self.recording.members) or self.recording.about is not self._folder.about:
            self.recording = self._folder.recording(logs)
        new = {}
        for member in self.recording.members:
            number, count, first = member.number, len(member.log.blocks), self._lived.get(member.number, 0)
            if count == first:
                continue
            if number not in self._replicas:
                self._replicas[number] = Reliving(member, keep=True)
            self._replicas[number].go_on()
            self._grew[number] = time.time() if first else _changed(member.log.path)
            self._lived[number], new[number] = count, first
        self.moved = self.clock.go_on(self.recording.members)
        return new

    def _read(self) -> list[RobotLog]:
        """Read what was appended; returns the logs that have begun, of which there is at least one."""
        for name in self._folder.names():
            if name not in self._readers:
                self._readers[name] = LogReader(self.path / name)
            self._readers[name].more()
        logs = [reader.log for reader in self._readers.values() if reader.log is not None]
        if not logs:
            raise without_logs(self.path)
        return logs


def _patience(about: Mapping[str, Any], least: float) -> float:
    """So many seconds, or as many as some periods take."""
    period = about.get("period")
    return max(least, FEWEST * period / 1000.0) if isinstance(period, int | float) else least


def _changed(path: Path) -> float:
    """When a file was changed, in seconds since 1970; 0 if it is not there."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
