"""Real robots: started and stopped over UDP, while their reports grow into logs of a folder."""

import json
import logging
import select
import socket
import struct
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from swarmcensus.brains import Brain
from swarmcensus.robots.folders import new_folder, write_texts
from swarmcensus.robots.logs.folders import ABOUT, OWN
from swarmcensus.robots.logs.logs import block_at
from swarmcensus.runtime import log
from swarmcensus.runtime.reports import START, STATE, STOP
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError, Interrupted
from swarmcensus.support.files import atomic_write
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command as shell_line, wrong_option
from swarmcensus.worlds import KnownRobot

LOG = logging.getLogger(__name__)
LOOK = 0.05  # seconds from one look at robots to the next
FAREWELL = 1.0  # seconds in which robots are told to stop
SILENT = 3.0  # seconds without a report after which a robot counts as silent


@dataclass
class Reporting:
    """What is known of a robot."""

    address: tuple[str, int] | None = None  # from which it reports
    tick: int = -1  # the last one that it reported; -1: its state is not known, and ticks cannot be read
    boot: int = -1
    ticks: int = 0  # reports of ticks
    heard: int = 0  # messages
    lost: int = 0  # ticks of which no report came
    starts: int = 0
    estimate: float = float("nan")
    seen: float = 0.0  # when it last reported, by the clock `time.monotonic`
    code_bytes: int = 0


@dataclass
class Fleet:
    """Robots that report."""

    folder: Path
    brain: Brain
    command: socket.socket
    robots: dict[int, Reporting]
    began: float = 0.0  # by the clock `time.monotonic`; 0 until robots are started
    happened: list[str] = field(default_factory=list)

    @property
    def has_ticks(self) -> bool:
        """Whether a robot has reported a tick."""
        return any(robot.ticks for robot in self.robots.values())

    def say(self, what: str) -> None:
        """Note and print what happens."""
        after = time.monotonic() - self.began if self.began else 0.0
        self.happened.append(f"{after:.1f} s: {what}")
        LOG.info("%s", self.happened[-1])

    def tell(self, number: int, what: bytes) -> None:
        """Give a robot an order, which may be lost."""
        if (address := self.robots[number].address) is not None:
            self.command.sendto(what, address)

    def start(self, numbers: Sequence[int]) -> None:
        """Start robots; they take the time from the order."""
        for number in numbers:
            self.tell(number, START + str(round(time.time() * 1000)).encode())

    def listen(self) -> None:
        """Take all reports that have come, and write them into logs."""
        if not select.select([self.command], [], [], LOOK)[0]:
            return
        while True:
            try:
                datagram, address = self.command.recvfrom(65535)
            except BlockingIOError:
                return
            number = int.from_bytes(datagram[:2], "little")
            if len(datagram) >= 2 and (robot := self.robots.get(number)):
                robot.address, robot.seen = address, time.monotonic()
                self._take(number, robot, datagram[2:])

    def _take(self, number: int, robot: Reporting, block: bytes) -> None:
        """Append a block to a robot's log; where ticks are lost, ask for its state, from which its log goes on."""
        if not block:  # it waits, as after it was switched on
            if self.began:
                self.start([number])
            return
        kind, body, _ = block_at(block, 0)
        if body is None:
            return
        if kind == log.STATE:
            _, _, flags, _, boot, _, _, code_bytes, tick, *_ = struct.unpack_from(log.HEAD, body)
            starts = bool(flags & log.STARTS)
            if starts and robot.starts and boot != robot.boot:
                self.say(f"robot {number} starts again, with tick {tick:,}")
            robot.tick, robot.boot, robot.code_bytes, robot.starts = tick, boot, code_bytes, robot.starts + starts
        else:
            tick, _, _, _, _, heard = struct.unpack_from(log.OPENING, body)
            if robot.tick < 0 or tick <= robot.tick:
                self.tell(number, STATE)
                return
            if tick > robot.tick + 1:
                robot.lost += tick - robot.tick - 1
                self.tell(number, STATE)
            robot.tick, robot.ticks, robot.heard = tick, robot.ticks + 1, robot.heard + heard
            robot.estimate = struct.unpack(log.ENDING, body[-struct.calcsize(log.ENDING) :])[0]
        with open(self.folder / f"robot-{number}.log", "ab") as file:
            file.write(block)


def run_fleet(
    brain: Brain, robots: Sequence[KnownRobot], folder: Path, where: tuple[str, int], *,
    seconds: float | None = None, patience: float = 30.0,
    show: Callable[[Fleet], None] = lambda _: None,
) -> Answer:  # fmt: skip
    """Start robots that wait, take their reports for so many seconds or until Ctrl-C, and stop them.

    All robots must have come within `patience` seconds. `show` is called some times a second. Raises InputError if some
    have not, and Interrupted after Ctrl-C, with the answer.
    """
    command = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    with command:
        try:
            command.bind(where)
        except OSError as error:
            raise wrong_option("host", where[0], f"port {where[1]}: {error.strerror or error}") from None
        command.setblocking(False)
        fleet = Fleet(folder, brain, command, {one.number: Reporting() for one in robots})
        about = _about(brain, robots)
        with new_folder(folder) as made:
            write_texts(made, {OWN: brain.source, ABOUT: json.dumps(about, indent=1)})
        stopped = False
        try:
            _gather(fleet, patience)
            fleet.began = time.monotonic()
            fleet.start([*fleet.robots])
            fleet.say(f"{counted(len(fleet.robots), 'robot')} started")
            while seconds is None or time.monotonic() < fleet.began + seconds:
                fleet.listen()
                show(fleet)
        except KeyboardInterrupt:
            stopped = True
        last = time.monotonic()
        until = last + FAREWELL
        while fleet.began and time.monotonic() < until:
            for number in fleet.robots:
                fleet.tell(number, STOP)
            fleet.listen()
    about |= {"ended": round(time.time() * 1000), "happened": fleet.happened}
    with atomic_write(folder / ABOUT) as path:
        path.write_text(json.dumps(about, indent=1), encoding="utf-8")
    answer = _answer(fleet, last)
    if stopped:
        raise Interrupted(answer, fleet.has_ticks, 1, "run")
    return answer


def _gather(fleet: Fleet, patience: float) -> None:
    """Wait until all robots have reported that they are there. Raises InputError."""
    until = time.monotonic() + patience
    while missing := [number for number, robot in fleet.robots.items() if robot.address is None]:
        if time.monotonic() > until:
            names = ", ".join(map(str, missing))
            raise InputError(f"robots that do not report: {names}; are they switched on, and deployed with --report?")
        fleet.listen()


def _about(brain: Brain, robots: Sequence[KnownRobot]) -> dict[str, Any]:
    """What the folder says of its recording."""
    return {
        "format": 1, "title": brain.label, "brain": {"file": OWN, "name": brain.name, "parameters": {}},
        "period": 100, "started": round(time.time() * 1000), "ended": None,
        "robots": [{"number": one.number, "log": f"robot-{one.number}.log"} for one in robots],
    }  # fmt: skip


def _answer(fleet: Fleet, now: float) -> Answer:
    """What came of robots, a row for each."""
    rows: list[Mapping[str, Any]] = [
        {
            "robot": number, "estimate": robot.estimate, "ticks": robot.ticks, "heard": robot.heard,
            "lost": robot.lost, "starts": robot.starts, "silent": now - robot.seen > SILENT,
        }
        for number, robot in fleet.robots.items()
    ]  # fmt: skip
    silent = [str(row["robot"]) for row in rows if row["silent"]]
    known = [row["estimate"] for row in rows if not row["silent"] and row["ticks"]]
    mean = sum(known) / len(known) if known else float("nan")
    ticks, lost = (sum(row[name] for row in rows) for name in ("ticks", "lost"))
    return Answer(
        title=f"{fleet.brain.label}: {counted(len(rows), 'robot')}", rows=rows,
        sentences=[
            f"the mean estimate of {counted(len(known), 'robot')} that reported to the end is {mean:.4f}",
            f"{ticks:,} ticks were reported, and {lost:,} reports were lost",
        ],
        cautions=[f"silent at the end: robots {', '.join(silent)}"] * bool(silent),
        files={fleet.folder: counted(len([*fleet.folder.glob("robot-*.log")]), "log")},
        next=shell_line("swarmcensus", "relive", fleet.folder), code=int(bool(silent)),
    )  # fmt: skip
