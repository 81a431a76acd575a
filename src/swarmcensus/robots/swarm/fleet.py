"""Real robots: started and stopped over links, while their reports grow into logs of a folder."""

import json
import logging
import select
import struct
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from swarmcensus.brains import FORMATS, Brain
from swarmcensus.robots.folders import new_folder, write_texts
from swarmcensus.robots.logs.folders import ABOUT, OWN
from swarmcensus.robots.logs.logs import AROUND, block_at
from swarmcensus.robots.swarm.links import Link
from swarmcensus.runtime import log
from swarmcensus.runtime.reports import HEAD, LAST, MAGIC, OWN as HEADER, START, STATE, STOP
from swarmcensus.studies import Study
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError, Interrupted, ResultsError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command as shell_line
from swarmcensus.worlds import KnownRobot

LOG = logging.getLogger(__name__)
FAR = 1 << 20  # bytes, more than a block has
LOOK = 0.05  # seconds from one look at robots to the next
FAREWELL = 1.0  # seconds in which robots are asked to stop
SAY_AGAIN = 0.2  # seconds until a robot that has not stopped is asked again
USUAL = 0.55  # the fill ratio of the study where none is known: a study has one, and a page shows none then
LEAST = {log.STATE: struct.calcsize(log.HEAD), log.TICK: sum(map(struct.calcsize, (log.OPENING, log.ENDING)))}  # bytes
BEGINS = log.MAGIC + bytes([log.VERSION])  # a state
SILENT = 3.0  # seconds without a report after which a robot counts as silent


@dataclass
class Reporting:
    """What is known of a robot."""

    answer: Callable[[bytes], None] | None = None  # sends to it; None: it was not heard yet
    waits: bool = False  # whether it said last that it waits
    is_known: bool = False  # whether its state came, and is of this swarm
    other: str = ""  # why a state that came is of no robot of this swarm
    parts: bytearray = field(default_factory=bytearray)  # of a report that has not come whole
    part: int = 0  # that is to come next
    tick: int = -1  # the last one that it reported; -1: its state is not known, and ticks cannot be read
    lacks: bool = False  # whether ticks were lost, and no state has come since: later ticks are of no use
    boot: int = -1
    ticks: int = 0  # reports of ticks
    heard: int = 0  # messages
    lost: int = 0  # ticks of which no report came
    refused: int = 0  # reports that are damaged, or of another format
    starts: int = 0
    estimate: float = float("nan")
    seen: float = 0.0  # when it last reported between start and stop, by the clock `time.monotonic`
    place: tuple[int, Any] | None = None  # the link and the address that it last reported from
    places: set[tuple[int, Any]] = field(default_factory=set)  # all of them
    is_twice: bool = False  # whether it reported from an earlier one again


@dataclass
class Fleet:
    """Robots that report."""

    folder: Path
    brain: Brain
    links: Sequence[Link]
    robots: dict[int, Reporting]
    gathers: bool = False  # whether robots are waited for, and nothing is written
    began: float = 0.0  # by the clock `time.monotonic`; 0 until robots are started
    first: tuple[int, int, int] | None = None  # of the first state: message format, mark, and the robot
    happened: list[str] = field(default_factory=list)
    is_over: bool = False

    @property
    def has_ticks(self) -> bool:
        """Whether a robot has reported a tick."""
        return any(robot.ticks for robot in self.robots.values())

    def say(self, what: str) -> None:
        """Note and print what happens."""
        after = time.monotonic() - self.began if self.began else 0.0
        self.happened.append(f"{after:.1f} s: {what}")
        LOG.info("%s", self.happened[-1])

    def tell(self, number: int, *words: bytes) -> None:
        """Give a robot an order, which may be lost."""
        if (answer := self.robots[number].answer) is not None:
            answer(MAGIC + b" ".join([words[0], str(number).encode(), *words[1:]]))

    def start(self, numbers: Sequence[int]) -> None:
        """Start robots; they take the time from the order."""
        for number in numbers:
            self.tell(number, START, str(round(time.time() * 1000)).encode())

    def stop(self) -> float:
        """Ask robots to stop until all wait, or for a time; returns when that began, by the clock `time.monotonic`."""
        last, self.began = time.monotonic(), 0.0  # robots that say that they wait are not started again
        live = [*self.robots]  # also one that waits: an order to start may be on its way
        while live and time.monotonic() < last + FAREWELL:
            for number in live:
                self.tell(number, STOP)
            time.sleep(SAY_AGAIN)
            live = [number for number, robot in self.robots.items() if robot.answer and not robot.waits]
        self.is_over = True
        return last

    def listen_on(self) -> None:
        """Take reports until the end."""
        while not self.is_over:
            self.listen()

    def listen(self) -> None:
        """Take all reports that have come, and write them into logs."""
        for link in select.select([link for link in self.links if link.is_open], [], [], LOOK)[0]:
            while (got := link.receive()) is not None:
                self._hear(*got, link)

    def _hear(self, datagram: bytes, address: Any, link: Link) -> None:
        """Take a part of a report; a report of which one is lost is lost."""
        if len(datagram) < HEADER or not datagram.startswith(MAGIC):
            return
        number, part = struct.unpack_from(HEAD, datagram, len(MAGIC))
        if (robot := self.robots.get(number)) is None:
            return
        if part % LAST == 0:
            robot.parts, robot.part = bytearray(), 0
        if part % LAST == robot.part:
            robot.parts += datagram[HEADER:]
            robot.part += 1
            if part >= LAST:
                block, robot.part = bytes(robot.parts), LAST  # no part is taken until another report begins
                if block and not is_whole(block):
                    robot.refused += 1
                    return
                self._meet(robot, link, address)
                self._take(number, robot, block)

    def _meet(self, robot: Reporting, link: Link, address: Any) -> None:
        """Note where a robot answers, and when it was there; one that starts again may come from another port."""
        robot.answer, where = partial(link.send, address=address), (id(link), address)
        if self.began:
            robot.seen = time.monotonic()
        if where != robot.place:
            robot.is_twice |= where in robot.places
            robot.place = where
            robot.places.add(where)

    def _take(self, number: int, robot: Reporting, block: bytes) -> None:
        """Append a block to a robot's log; where ticks are lost, ask for its state, from which its log goes on."""
        robot.waits = not block  # as after it was switched on
        if robot.waits:
            if self.began:
                self.start([number])
            elif self.gathers and not robot.is_known:
                self.tell(number, STATE)
            return
        kind, body = block[0], block[AROUND[0] : -AROUND[1]]
        if kind == log.STATE:
            _, _, flags, form, boot, mark, _, _, tick, _, _, brain, *_ = struct.unpack_from(log.HEAD, body)
            if other := self._other(number, form, mark, brain):
                if not robot.other and not self.gathers:
                    self.say(f"{other}; its reports are left out")
                robot.other, robot.is_known = other, False  # its own state may still come
                return
            robot.is_known = True
            if self.gathers:
                return
            starts = bool(flags & log.STARTS)
            if starts and robot.starts and boot != robot.boot:
                self.say(f"robot {number} starts again, with tick {tick:,}")
            if boot == robot.boot:
                robot.lost += max(0, tick - robot.tick)
            robot.tick, robot.boot, robot.starts, robot.lacks = tick, boot, robot.starts + starts, False
        else:
            tick, _, _, _, _, heard = struct.unpack_from(log.OPENING, body)
            if not robot.is_known or robot.tick < 0 or tick <= robot.tick:
                self.tell(number, STATE)
                return
            if tick > robot.tick + 1:
                robot.lost += tick - robot.tick - 1
                robot.lacks = True
            if robot.lacks:  # an order or its answer may be lost, too
                self.tell(number, STATE)
            robot.tick, robot.ticks, robot.heard = tick, robot.ticks + 1, robot.heard + heard
            robot.estimate = struct.unpack(log.ENDING, body[-struct.calcsize(log.ENDING) :])[0]
        path = self.folder / f"robot-{number}.log"
        try:
            with path.open("ab") as file:
                file.write(block)
        except OSError as error:  # the disk is full, or the folder is gone
            raise ResultsError.of(path, f"{error.strerror}; the robots were stopped") from None

    def _other(self, number: int, form: int, mark: int, brain: bytes) -> str:
        """Why a state is of no robot of this swarm; empty if it is of one."""
        if brain != bytes.fromhex(self.brain.sha256)[:8]:
            return f"robot {number} runs another brain than {self.brain.label}: its hash begins with {brain.hex()}"
        self.first = self.first or (form, mark, number)
        if self.first[:2] == (form, mark):
            return ""
        own, usual = (f"{dict(enumerate(FORMATS)).get(one, one)}" for one in (form, self.first[0]))
        return f"robot {number} has another message format than robot {self.first[2]}: {own}, and not {usual}"


def is_whole(block: bytes) -> bool:
    """Whether bytes are one block of a log, and no more, with all that is read of it here."""
    kind, body, end = block_at(block, 0)
    if body is None or end != len(block) or len(body) < LEAST.get(kind, FAR):
        return False
    return kind != log.STATE or body.startswith(BEGINS)


def run_fleet(
    brain: Brain, robots: Sequence[KnownRobot], folder: Path, links: Sequence[Link], *,
    seconds: float | None = None, patience: float = 30.0, fill_ratio: float | None = None,
    show: Callable[[Fleet], None] = lambda _: None,
) -> Answer:  # fmt: skip
    """Start robots that wait, take their reports for so many seconds or until Ctrl-C, and stop them.

    All robots must have come within `patience` seconds. `show` is called some times a second. Raises InputError if some
    have not, and Interrupted after Ctrl-C, with the answer.
    """
    with ExitStack() as stack, ThreadPoolExecutor(1) as pool:
        for link in links:
            stack.enter_context(closing(link))
        fleet = Fleet(folder, brain, links, {one.number: Reporting() for one in robots}, gathers=True)
        about, stopped = _about(brain, robots, fill_ratio), False
        listening = pool.submit(fleet.listen_on)  # so that reports wait for no page
        try:
            _gather(fleet, patience)
            with new_folder(folder) as made:
                write_texts(made, {OWN: brain.source, ABOUT: json.dumps(about, indent=1)})
            fleet.gathers, fleet.began = False, time.monotonic()
            fleet.start([*fleet.robots])
            fleet.say(f"{counted(len(fleet.robots), 'robot')} started")
            while not listening.done() and (seconds is None or time.monotonic() < fleet.began + seconds):
                time.sleep(LOOK)
                show(fleet)
        except KeyboardInterrupt:
            if not (stopped := bool(fleet.began)):
                raise
        finally:
            last = fleet.stop()
        listening.result()
    about |= {"ended": round(time.time() * 1000), "happened": fleet.happened}
    with atomic_write(folder / ABOUT) as path:
        path.write_text(json.dumps(about, indent=1), encoding="utf-8")
    answer = _answer(fleet, last)
    if stopped:
        raise Interrupted(answer, fleet.has_ticks, 1, "run")
    return answer


def _gather(fleet: Fleet, patience: float) -> None:
    """Wait until all robots have said their states. Raises InputError, also for one of another swarm."""
    until, named, said = time.monotonic() + patience, time.monotonic() + SILENT, ""
    while missing := {number: robot.other for number, robot in fleet.robots.items() if not robot.is_known}:
        names, now = ", ".join(str(number) for number, other in missing.items() if not other), time.monotonic()
        if now > named and names not in ("", said):
            LOG.info("waiting for robots %s", said := names)
        if now > until or (now > named and not names):  # those of another swarm may be forged until then
            absent = f"robots that do not report: {names}; are they switched on, and deployed with --report?"
            raise InputError("; ".join(filter(None, [*missing.values(), names and absent])))
        time.sleep(LOOK)


def _about(brain: Brain, robots: Sequence[KnownRobot], fill_ratio: float | None) -> dict[str, Any]:
    """What the folder says of its recording; the study shows a page how many robots there are, by their numbers."""
    b, w = (round(sum(getattr(one, name) for one in robots) / len(robots), 3) for name in ("b", "w"))
    study = Study(
        name=brain.name, trials=1,
        swarm={"brain": brain, "robots": max(one.number for one in robots) + 1, "accuracy": {"black": b, "white": w}},
        world={"topology": "full", "fill_ratio": USUAL if fill_ratio is None else fill_ratio},
        schedule={"rounds": 1, "observations_per_round": 1},
    )  # fmt: skip
    return {
        "format": 1, "title": brain.label, "brain": {"file": OWN, "name": brain.name, "parameters": {}},
        "fill_ratio": fill_ratio, "started": round(time.time() * 1000), "ended": None, "study": study.text,
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
    refused = sum(robot.refused for robot in fleet.robots.values())
    twice = [str(number) for number, robot in fleet.robots.items() if robot.is_twice]
    others = [f"{robot.other}; its reports were left out" for robot in fleet.robots.values() if robot.other]
    some_heard = any(row["heard"] for row in rows)  # a brain may have no messages
    deaf = [str(row["robot"]) for row in rows if some_heard and row["ticks"] and not row["heard"]]
    return Answer(
        title=f"{fleet.brain.label}: {counted(len(rows), 'robot')}", rows=rows,
        sentences=[
            f"the mean estimate of {counted(len(known), 'robot')} that reported to the end is {mean:.4f}",
            f"{ticks:,} ticks were reported, {lost:,} reports were lost, and {refused:,} left out as damaged",
        ],
        cautions=[
            *[f"silent at the end: robots {', '.join(silent)}"] * bool(silent),
            *[f"robots that heard nobody: {', '.join(deaf)}"] * bool(deaf),
            *[f"reports from two addresses, as of two robots of one number: robots {', '.join(twice)}"] * bool(twice),
            *others,
        ],
        files={fleet.folder: counted(len([*fleet.folder.glob("robot-*.log")]), "log")},
        next=shell_line("swarmcensus", "relive", fleet.folder), code=int(bool(silent or others)),
    )  # fmt: skip
