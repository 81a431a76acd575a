"""A recording under another brain: what each robot would have believed, from the readings that it made.

A tick has two halves: a robot observes and broadcasts, then it receives and fuses. So a message of a robot's tick is
known once that robot's first half is done. Robots are taken in any order that keeps to this.
"""

from collections import Counter, defaultdict, deque
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from swarmcensus import brains
from swarmcensus.brains import Brain, Format, Numbers, adversary, returning
from swarmcensus.robots.logs.clocks import Clock
from swarmcensus.robots.logs.draws import Draws, of_calls
from swarmcensus.robots.logs.folders import LoggedRobot, Recording
from swarmcensus.robots.logs.lives import Lived, Start, starts_of
from swarmcensus.robots.logs.logs import State, Tick
from swarmcensus.robots.logs.replicas import Replica, format_of, logged_values, other_replica
from swarmcensus.robots.logs.senders import Place, Senders
from swarmcensus.support.errors import BrainError, InputError, ResultsError

UNKNOWN = {
    "missing": "messages whose sender's log lacks the tick",
    "forged": "messages that the sender's log does not have so",
    "liar": "messages of robots that are not honest, whose adversary is not known",
    "unheard": "broadcasts where the robot was silent: nobody is taken to have heard them",
    "unread": "ticks without readings, because the robot's own brain was done",
    "lost": "ticks that the log lacks",
    "starts": "starts with a memory of unknown origin: the state goes on from its last known tick",
}  # what is not known of a recording under another brain
CHANGED = {
    "silent": "messages that the robot sent, and this brain does not",
    "lots": "random numbers that are drawn again",
}  # what is known, and differs


@dataclass
class Relived:
    """What came of a brain, by robot and block of its log, and what is not known."""

    brain: Brain
    lived: dict[int, dict[int, Lived]]
    counts: Counter[str] = field(default_factory=Counter)

    @property
    def unknown(self) -> int:
        """How many messages, broadcasts, readings, ticks and starts are not known."""
        return sum(self.counts[name] for name in UNKNOWN)

    def messages(self, robots: Iterable[int]) -> np.ndarray:
        """How many messages each of these robots sent and heard (what, robot)."""
        lived = [self.lived.get(robot, {}).values() for robot in robots]
        sent = [sum(one.said is not None for one in blocks) for blocks in lived]
        return np.array([sent, [sum(len(one.heard) for one in blocks) for blocks in lived]])


def relive_with(
    recording: Recording, brain: Brain, message: Format | None = None, clock: Clock | None = None, keep: bool = False
) -> Relived:
    """Run another brain on a recording; `keep` keeps the memory after each tick. Raises InputError."""
    if brain.is_oracle:
        bound = f"the brain {brain.name!r} is a bound: it hears all robots, and no log says so"
        raise BrainError(bound, key="brain", value=brain.name)
    with returning([brain]):
        return _OneBrain(recording, brain, message, clock or Clock(recording.members), keep).live()


class _Robot:
    """A robot on its way through its log."""

    def __init__(self, member: LoggedRobot, brain: Brain, keeps: set[int], starts: dict[int, Start]) -> None:
        self.member, self.brain, self.keeps, self.starts = member, brain, keeps, starts
        self.at = 0
        self.spoke = False  # whether the first half of the tick at `at` is done
        self.said: bytes | None = None  # in that tick
        self.heard: list[tuple[int, bytes]] = []
        self.replica: Replica | None = None
        self.boot = -1
        self.saved: dict[int, list[float]] = {}  # memories that are resumed later, by block


class _OneBrain:
    def __init__(self, recording: Recording, brain: Brain, message: Format | None, clock: Clock, keep: bool) -> None:
        self.keep = keep
        self.senders = Senders(recording.members, clock)
        self.result = Relived(brain, defaultdict(dict))
        self.said: dict[Place, bytes | str | None] = {}  # str: why it is not known
        self.waiting: dict[Place, list[_Robot]] = defaultdict(list)
        self.places: dict[Place, list[Place | str]] = {}
        self.robots: dict[int, _Robot] = {}
        self.draws = Draws(recording, brain)
        for member in recording.members:
            first = member.log.states[0]
            form = message or format_of(member.brain, first)
            wrapped = brain_of(member, brain)
            if wrapped is None:
                continue
            own = wrapped.with_numbers(Numbers("single" if first.single else "double", form, first.feedback))
            starts = {start.at: start for start in starts_of(member)}
            self.robots[member.number] = _Robot(member, own, {start.source for start in starts.values()}, starts)
        formats = {robot.brain.numbers.message for robot in self.robots.values()}
        if not self.robots:
            raise ResultsError.of(recording.folder, "no robot of it is honest")
        if len(formats) > 1:
            raise ResultsError.of(
                recording.folder, "its logs have messages of several formats: give one with --message"
            )

    def live(self) -> Relived:
        work = deque(self.robots.values())
        while work:
            while work:
                self._run(work.popleft(), work)
            late = [robot for robot in self.robots.values() if robot.at < len(robot.member.log.blocks)]
            if late:  # logs that contradict each other: a message was heard before it was said
                place = next(place for place, robots in self.waiting.items() if robots)
                self.said[place] = "missing"
                work.extend(self.waiting.pop(place))
        return self.result

    def _run(self, robot: _Robot, work: deque[_Robot]) -> None:
        """Live on until the log ends or a message is not known yet."""
        blocks, number = robot.member.log.blocks, robot.member.number
        while robot.at < len(blocks):
            block = blocks[robot.at]
            place = number, robot.at
            if isinstance(block, State):
                self._state(robot, block)
            elif isinstance(block, Tick):
                if not robot.spoke:
                    self._speak(robot, block, place)
                    work.extend(self.waiting.pop(place, ()))
                missing = self._missing(robot, block, place)
                if missing is not None:
                    self.waiting[missing].append(robot)
                    return
                self._think(robot, block, place)
            if robot.at in robot.keeps and robot.replica is not None:
                robot.saved[robot.at] = robot.replica.saved_numbers()
            if robot.replica is not None and (isinstance(block, Tick) or (isinstance(block, State) and block.starts)):
                memory = robot.replica.remembered() if self.keep else None
                self.result.lived[number][robot.at] = Lived(robot.replica.estimate, memory, robot.said, robot.heard)
                robot.said, robot.heard = None, []
            robot.at += 1
            robot.spoke = False

    def _state(self, robot: _Robot, state: State) -> None:
        start = robot.starts.get(robot.at)
        replica, before = robot.replica, robot.replica
        if start is None and state.boot == robot.boot and replica is not None:
            self.result.counts["lost"] += max(0, state.tick - replica.ticks)
            replica.ticks = state.tick
            return
        robot.boot = state.boot
        robot.replica = replica = other_replica(robot.brain, state)
        if start is not None and start.kind == "blank":
            return
        if start is not None and start.source in robot.saved:
            replica.become(robot.saved[start.source], state.tick)
            return
        self.result.counts["starts"] += 1
        if before is not None:
            replica.become(before.saved_numbers(), state.tick)
        replica.ticks = state.tick

    def _speak(self, robot: _Robot, tick: Tick, place: Place) -> None:
        replica, counts = robot.replica, self.result.counts
        assert replica is not None
        counts["lost"] += max(0, tick.tick - 1 - replica.ticks)
        replica.ticks = tick.tick - 1
        if robot.brain.uses.luck:
            given = of_calls(robot.member.brain, tick)
            replica.lots = [given.observe or self._count_draw(self.draws.own(replica, robot.boot, tick.tick, 0))]
        if not tick.looks and not replica.done and robot.member.brain.ends:
            counts["unread"] += 1
        said = self.said[place] = robot.said = replica.first_half(tick)
        counts["unheard"] += said is not None and tick.said is None
        counts["silent"] += said is None and tick.said is not None
        robot.spoke = True

    def _missing(self, robot: _Robot, tick: Tick, place: Place) -> Place | None:
        """The place of a message that is not known yet."""
        if place not in self.places:
            places = [self.senders.of(*place, heard) for heard in tick.heard]
            self.places[place] = [one if isinstance(one, str) or one[0] in self.robots else "liar" for one in places]
        return next((one for one in self.places[place] if not isinstance(one, str) and one not in self.said), None)

    def _think(self, robot: _Robot, tick: Tick, place: Place) -> None:
        replica, counts = robot.replica, self.result.counts
        assert replica is not None
        is_random = robot.brain.uses.luck
        given = of_calls(robot.member.brain, tick)
        for k, one in enumerate(self.places.pop(place)):
            code = one if isinstance(one, str) else self.said[one]
            if isinstance(code, str):
                counts[code] += 1
            elif code is not None:
                if is_random:
                    drawn = given.receive[k] if given.receive else None
                    sender = tick.heard[k].sender
                    replica.lots = [
                        drawn or self._count_draw(self.draws.message(replica, robot.boot, tick.tick, sender))
                    ]
                replica.hear(code)
                robot.heard.append((tick.heard[k].sender, code))
        if is_random:
            replica.lots = [given.fuse or self._count_draw(self.draws.own(replica, robot.boot, tick.tick, 1))]
            if robot.brain.steers:
                replica.lots.append(given.steer or self._count_draw(self.draws.own(replica, robot.boot, tick.tick, 2)))
        replica.think()

    def _count_draw(self, lot: float) -> float:
        self.result.counts["lots"] += 1
        return lot


def brain_of(member: LoggedRobot, brain: Brain) -> Brain | None:
    """What a robot has if the swarm has this brain: an adversary puts it on; None if it is not known which."""
    if member.honest or (member.is_swarm and not member.adversary):
        return brain
    if not member.adversary:
        return None
    try:
        liar = adversary.load(member.adversary)
    except InputError:
        return None
    # fewer where the brain is not the log's: such values stay the usual ones
    known = logged_values(member.brain, member.log.states[0])[0].items()
    # its brain has the adversary's parameters with a prefix
    own = {name.removeprefix("liar").lstrip("_"): value for name, value in known if name.startswith("liar_")}
    own = {name: value for name, value in own.items() if name in liar.parameters}
    try:
        return brains.lying_brain(liar.with_parameters(own), brain)
    except ValueError as error:
        raise InputError.named("robot", member.number, error) from None
