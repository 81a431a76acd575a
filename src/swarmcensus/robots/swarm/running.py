"""Running a swarm: processes are started, learn who hears them, are disturbed, watched and ended."""

import contextlib
import logging
import secrets
import select
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from swarmcensus.robots.swarm.children import Children, check_system, seconds_of_children
from swarmcensus.robots.swarm.faults import Event, late_starters
from swarmcensus.robots.swarm.folder import clear, complete, forget, write_folder
from swarmcensus.robots.swarm.links import Network
from swarmcensus.robots.swarm.outcomes import outcome_of
from swarmcensus.robots.swarm.plans import SwarmPlan, hearers
from swarmcensus.robots.swarm.reports import RobotState, read_report
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError, Interrupted
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command as shell_line

LOG = logging.getLogger(__name__)
LOOPBACK = "127."
AHEAD = 0.3  # seconds from the last robot's first report to the start
PATIENCE = 30.0  # seconds in which robots must report for the first time, and more for each of them
A_ROBOT = 0.2
AFTER = 2.0  # seconds that robots may take longer than their rounds should
LOOK = 0.05  # seconds from one look at processes and faults to the next
TELL_AGAIN = 0.2  # seconds until an order that a robot has not confirmed is sent again


@dataclass
class RunningSwarm:
    """A swarm that runs."""

    plan: SwarmPlan
    folder: Path
    command: Network
    children: Children
    robots: list[RobotState]
    started: float = 0.0  # of the clock `time.monotonic`
    cuts: list[frozenset[int]] = field(default_factory=list)
    silent: set[int] = field(default_factory=set)
    version: int = 0
    sent_at: dict[int, float] = field(default_factory=dict)  # when each robot was last sent orders
    happened: list[str] = field(default_factory=list)
    ports: dict[int, int] = field(default_factory=dict)
    token: str = field(
        default_factory=lambda: secrets.token_hex(16)
    )  # with which reports begin, so that nobody else can report

    @property
    def seconds(self) -> float:
        """Since the start."""
        return time.monotonic() - self.started

    @property
    def has_ticks(self) -> bool:
        """Whether a robot has written a tick into its log."""
        return any(known.last and known.last.ticks for known in self.robots)

    def say(self, event: str) -> None:
        """Note and print what happens."""
        self.happened.append(event)
        LOG.info("%s", event)


def run(plan: SwarmPlan, folder: Path, show: Callable[[RunningSwarm], None] = lambda _: None) -> Answer:
    """Run a swarm to its end and write its folder; `show` is called some times a second.

    Raises InputError if robots cannot be started, and Interrupted after Ctrl-C, with the outcome, when all of
    them have ended.
    """
    check_system()
    command = Network((plan.air.host, 0))
    address, port = command.socket.getsockname()
    if not address.startswith(LOOPBACK):  # a name such as localhost is its address here
        LOG.info("Anyone who can reach %s can send messages in the name of any robot.", plan.air.host)
    before = seconds_of_children()
    began = time.monotonic()
    stopped = False
    with contextlib.closing(command):
        children, robots = Children(folder), [RobotState() for _ in plan.members]
        swarm = RunningSwarm(plan, folder, command, children, robots)
        write_folder(plan, folder, port, swarm.token)
        at = round(time.time() * 1000)
        try:
            _start(swarm)
            at = round((time.time() + AHEAD) * 1000)
            _go_on(swarm, show)
        except KeyboardInterrupt:
            stopped = True
        finally:
            last = time.monotonic()
            swarm.children.end()
            used = seconds_of_children() - before
            outcome = outcome_of(plan, swarm.robots, used, last - began, last)
            clear(folder)
            happened = {"started": at, "happened": swarm.happened, "result": outcome.fields}
            complete(plan, folder, round(time.time() * 1000), happened)
    logs = len([*folder.glob("robot-*.log")])  # fewer if it was stopped before all had begun
    outcome.files = {folder: counted(logs, "log")}
    outcome.next = shell_line("swarmcensus", "relive", folder) if logs else ""
    if stopped:
        rounds = max((known.last.round for known in swarm.robots if known.last), default=0)
        raise Interrupted(outcome, max(0, min(rounds, plan.setting.rounds)), plan.setting.rounds, "round")
    return outcome


def _start(swarm: RunningSwarm) -> None:
    """Start all robots but late ones, and wait until each has reported."""
    late = late_starters(swarm.plan.events)
    first = [number for number in range(len(swarm.robots)) if number not in late]
    for number in first:
        _begin_life(swarm, number)
    until = time.monotonic() + PATIENCE + A_ROBOT * len(first)
    while missing := [number for number in first if swarm.robots[number].address is None]:
        _listen(swarm, LOOK)
        for number, why in swarm.children.dead():
            raise InputError(f"robot {number} cannot be started: {why}", key="robot", value=number)
        if time.monotonic() > until:
            busy = "the machine may be too busy for so many processes"
            raise InputError(f"robot {missing[0]} does not report: {busy}", key="robot", value=missing[0])
    swarm.started = time.monotonic() + AHEAD
    LOG.info("%s run for %g s", counted(len(first), "robot"), swarm.plan.seconds)
    _tell_all(swarm)


def _go_on(swarm: RunningSwarm, show: Callable[[RunningSwarm], None]) -> None:
    """Until all robots have lived their rounds."""
    waiting = [event for event in swarm.plan.events if (event.round, event.what) != (1, "kill")]
    looked = 0.0
    while not _is_over(swarm, waiting):
        _listen(swarm, LOOK)
        now = time.monotonic()
        while waiting and (waiting[0].round - 1) * swarm.plan.period <= 1000.0 * swarm.seconds:
            _apply(swarm, waiting.pop(0))
        if now - looked >= LOOK:
            looked = now
            _bury(swarm)
            _tell_again(swarm)
            show(swarm)
    show(swarm)


def _is_over(swarm: RunningSwarm, waiting: Sequence[Event]) -> bool:
    if not swarm.children.running and not waiting:
        return True
    if swarm.seconds < swarm.plan.seconds - swarm.plan.period / 1000:
        return False
    if swarm.seconds > swarm.plan.seconds * 1.01 + AFTER:
        return True
    at_work = [known for known in swarm.robots if known.state == "runs"]
    return all(known.last is not None and known.last.round >= swarm.plan.setting.rounds for known in at_work)


def _listen(swarm: RunningSwarm, wait: float) -> None:
    """Read all reports that have come; wait so many seconds if there is none."""
    if not select.select([swarm.command], [], [], wait)[0]:
        return
    while (got := swarm.command.receive()) is not None:
        datagram, address = got
        report = read_report(datagram, swarm.token)
        if report is None:
            continue
        known = swarm.robots[report.number]
        if report.life != swarm.children.lives.get(report.number) or report.number not in swarm.children.running:
            continue  # of a process that has ended
        known.last, known.seen = report, time.monotonic()
        if report.round >= 0 and report.life > known.began:  # the robot has begun again
            known.began = report.life
            how = f"goes on from its tick {report.resumed:,}" if report.resumed else "starts blank"
            swarm.say(f"{swarm.seconds:.1f} s: robot {report.number} {how}")
        if known.address is None:
            known.address = address
            swarm.ports[report.number] = report.port
            if swarm.started:
                _tell_all(swarm)


def _begin_life(swarm: RunningSwarm, number: int) -> None:
    swarm.robots[number].new_life()
    swarm.children.start(number)
    swarm.robots[number].state = "runs"


def _end_life(swarm: RunningSwarm, number: int, state: str, why: str = "") -> None:
    known = swarm.robots[number]
    known.address, known.state, known.why = None, state, why
    swarm.ports.pop(number, None)
    _tell_all(swarm)


def _tell_all(swarm: RunningSwarm) -> None:
    """Tell each robot when the swarm starts and who hears it."""
    swarm.version += 1
    _tell(swarm, range(len(swarm.robots)))


def _tell(swarm: RunningSwarm, numbers: Sequence[int]) -> None:
    heard_by = hearers(swarm.plan, swarm.cuts, swarm.silent)
    for number in numbers:
        if (address := swarm.robots[number].address) is not None:
            ports = ",".join(str(swarm.ports[other]) for other in heard_by[number] if other in swarm.ports)
            swarm.sent_at[number] = time.monotonic()
            swarm.command.send(f"{swarm.version} {swarm.started * 1000.0!r} {ports}".encode(), address)


def _tell_again(swarm: RunningSwarm) -> None:
    """Tell those again that have not heard it, as after they were stopped."""
    now = time.monotonic()
    deaf = [
        number
        for number, known in enumerate(swarm.robots)
        if known.address and known.last and known.last.version < swarm.version
        and known.state == "runs" and now - swarm.sent_at.get(number, 0.0) > TELL_AGAIN
    ]  # fmt: skip
    if deaf:
        _tell(swarm, deaf)


def _apply(swarm: RunningSwarm, event: Event) -> None:
    children, what = swarm.children, event.what
    swarm.say(f"{swarm.seconds:.1f} s: {event}")
    for number in event.robots:
        if what in ("kill", "restart"):
            children.kill(number)
            _end_life(swarm, number, "killed")
        if what in ("start", "restart"):
            if event.blank:
                forget(swarm.folder, number)
            _begin_life(swarm, number)
        if what == "stop" and swarm.robots[number].state == "runs":
            children.stop(number)
            swarm.robots[number].state = "stopped"
        if what == "continue" and swarm.robots[number].state == "stopped":
            children.resume(number)
            swarm.robots[number].state = "runs"
    if what == "cut":
        swarm.cuts.append(frozenset(event.robots))
    if what == "join":
        swarm.cuts.remove(frozenset(event.robots))
    if what == "mute":
        swarm.silent.update(event.robots)
    if what == "speak":
        swarm.silent.difference_update(event.robots)
    if what in ("cut", "join", "mute", "speak"):
        _tell_all(swarm)


def _bury(swarm: RunningSwarm) -> None:
    """Note which robots have died by themselves."""
    for number, why in swarm.children.dead():
        _end_life(swarm, number, "died", why)
        swarm.say(f"{swarm.seconds:.1f} s: robot {number} died by itself, {why}")
