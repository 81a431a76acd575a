"""A recording under another brain: what each robot would have believed, from the readings that it made.

A tick has two halves: a robot observes and broadcasts, then it receives and fuses. So a message of a robot's tick is
known once that robot's first half is done. Robots are taken in any order that keeps to this.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from swarmcensus import brains
from swarmcensus.brains import Brain, Format, Numbers, adversary
from swarmcensus.engine import address, chance, single_chance, word_of, words
from swarmcensus.engine.constants import DRAW_FUSE, DRAW_OBSERVE, DRAW_STEER
from swarmcensus.robots.logs.clocks import Clock
from swarmcensus.robots.logs.folders import LoggedRobot, Recording, study_of
from swarmcensus.robots.logs.lives import Lived
from swarmcensus.robots.logs.logs import Gap, State, Tick
from swarmcensus.robots.logs.replicas import Replica, format_of, logged_values, other_replica
from swarmcensus.support.errors import BrainError, InputError, ResultsError

Place = tuple[int, int]  # a robot's number, and the block of its tick
BOOTS = 20  # bits between the addresses of two boots' random numbers
UNKNOWN = {
    "missing": "messages that no log of their sender has, or of a liar with an unknown adversary",
    "unheard": "broadcasts where the robot was silent: nobody is taken to have heard them",
    "unread": "ticks without readings, because the robot's own brain was done",
    "lost": "ticks and saved memories that the log lacks: the state goes on from its last known tick",
}  # what is not known of a recording under another brain


@dataclass
class Relived:
    """What came of a brain, by robot and block of its log, and what is not known."""

    brain: Brain
    lived: dict[int, dict[int, Lived]]
    counts: Counter[str] = field(default_factory=Counter)

    @property
    def unknown(self) -> int:
        """How many messages, broadcasts, readings, ticks and memories are not known."""
        return self.counts.total()

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
    return _OneBrain(recording, brain, message, clock or Clock(recording.members), keep).live()


class _OneBrain:
    def __init__(self, recording: Recording, brain: Brain, message: Format | None, clock: Clock, keep: bool) -> None:
        self.clock, self.keep = clock, keep
        self.result = Relived(brain, defaultdict(dict))
        self.said: dict[Place, bytes | None] = {}
        self.origins = _origins(recording.members)
        self.draws = _Draws(recording)
        self.robots: dict[int, Iterator[Place]] = {}
        formats = set()
        for member in recording.members:
            if (own := brain_of(member, brain)) is not None:
                first = member.log.states[0]
                formats.add(form := message or format_of(member.brain, first))
                numbers = Numbers("single" if first.single else "double", form, first.feedback)
                self.robots[member.number] = self._lives(member, own.with_numbers(numbers))
        if not self.robots:
            raise ResultsError.of(recording.folder, "no robot of it is honest")
        if len(formats) > 1:
            raise ResultsError.of(
                recording.folder, "its logs have messages of several formats: give one with --message"
            )

    def live(self) -> Relived:
        """Let each robot live until it waits for a message, again and again."""
        running = dict(self.robots)
        while running:
            known, waits = len(self.said), {}
            for number, life in [*running.items()]:
                waits[number] = next(life, None)
                if waits[number] is None:
                    del running[number]
            if running and known == len(self.said):  # logs that contradict each other: heard before it was said
                first = next(place for place in waits.values() if place is not None)
                self.said[first] = None
                self.result.counts["missing"] += 1
        return self.result

    def _lives(self, member: LoggedRobot, brain: Brain) -> Iterator[Place]:
        """Live through a log; yields the places of messages that are not said yet."""
        number, counts = member.number, self.result.counts
        replica, boot, saved = other_replica(brain, member.log.states[0]), -1, dict[int, list[float]]()
        for at, block in enumerate(member.log.blocks):
            said, heard = None, list[tuple[int, bytes]]()
            if isinstance(block, Gap):
                continue
            if isinstance(block, State) and (block.starts or block.boot != boot):
                before, boot = replica.saved_numbers(), block.boot
                replica = other_replica(brain, block)
                if block.tick or not block.starts:
                    counts["lost"] += not (block.starts and block.tick in saved)
                    replica.become(saved.get(block.tick, before), block.tick)
            elif isinstance(block, State):
                counts["lost"] += max(0, block.tick - replica.ticks)
                replica.ticks = block.tick
                saved[block.tick] = replica.saved_numbers()
                continue
            else:
                counts["lost"] += max(0, block.tick - 1 - replica.ticks)
                said = self.said[number, at] = self._speak(member, replica, boot, block)
                places = [self._origin(number, at, one) for one in block.heard]
                for place in places:
                    while place is not None and place not in self.said:
                        yield place
                heard = self._think(replica, boot, block, [place and self.said[place] for place in places])
            memory = replica.remembered() if self.keep else None
            self.result.lived[number][at] = Lived(replica.estimate, memory, said, heard)

    def _origin(self, receiver: int, at: int, heard: Any) -> Place | None:
        """The tick in which a message was said: of those with its low bytes the nearest in time. None: not known."""
        known = self.origins.get(heard, ()) if heard.sender in self.robots else ()  # its parts are those of a key
        here = self.clock.time(receiver, at)
        chosen = min(known, key=lambda one: abs(self.clock.time(heard.sender, one) - here), default=None)
        self.result.counts["missing"] += chosen is None
        return None if chosen is None else (heard.sender, chosen)

    def _speak(self, member: LoggedRobot, replica: Replica, boot: int, tick: Tick) -> bytes | None:
        counts = self.result.counts
        replica.lots = [self.draws.own(replica, boot, tick.tick, DRAW_OBSERVE)]
        counts["unread"] += not tick.looks and not replica.done and member.brain.ends
        said = replica.first_half(tick)
        counts["unheard"] += said is not None and tick.said is None
        return said

    def _think(self, replica: Replica, boot: int, tick: Tick, codes: Sequence[bytes | None]) -> list[tuple[int, bytes]]:
        """The second half of a tick; returns what was heard."""
        heard = []
        for one, code in zip(tick.heard, codes, strict=True):
            if code is not None:
                replica.lots = [self.draws.message(replica, boot, tick.tick, one.sender)]
                replica.hear(code)
                heard.append((one.sender, code))
        replica.lots = [self.draws.own(replica, boot, tick.tick, part) for part in (DRAW_FUSE, DRAW_STEER)]
        replica.think()
        return heard


def _origins(members: Sequence[LoggedRobot]) -> dict[tuple[int, int, int, bytes], list[int]]:
    """The blocks of ticks by what others hear of them: the sender, low bytes of boot and tick, and the message."""
    found = defaultdict(list)
    for member in members:
        boot = 0
        for at, block in enumerate(member.log.blocks):
            if isinstance(block, State):
                boot = block.boot
            elif isinstance(block, Tick) and block.said is not None:
                found[member.number, boot & 0xFF, block.tick & 0xFFFF, block.said].append(at)
    return found


class _Draws:
    """Numbers that a simulation of the brain would draw, where swarm.json has the study; else others of its seed."""

    def __init__(self, recording: Recording) -> None:
        self.trial = recording.trial
        content: dict[str, Any] = {"robots": len(recording.members)}
        if (study := study_of(recording.about)) is not None:
            settings = study.settings()
            setting = settings[min(int(recording.about.get("setting", 0)), len(settings) - 1)]
            content = {"robots": setting.robots, "topology": setting.topology.content}
        keys = [address(recording.seed, purpose, **content) for purpose in ("luck", "luck of messages")]
        self.keys = np.concatenate(keys)

    def own(self, replica: Replica, boot: int, tick: int, part: int) -> float:
        """The random number of a robot's own call: of `observe`, `fuse` or `steer`."""
        if replica.draws is None:
            return 0.5
        out = np.zeros(2, np.uint64)
        words(self.keys[:2], self._trial(boot), tick, part, replica.number // 2 * 2, 2, out)
        return _lot(replica, out[replica.number % 2])

    def message(self, replica: Replica, boot: int, tick: int, sender: int) -> float:
        """The random number for receiving a message."""
        if replica.draws is None:
            return 0.5
        return _lot(replica, word_of(self.keys[2], self.keys[3], self._trial(boot), tick, replica.number, sender))

    def _trial(self, boot: int) -> int:
        return (self.trial + (boot << BOOTS)) & 0xFFFFFFFF


def _lot(replica: Replica, word: Any) -> float:
    return float((single_chance if replica.is_single else chance)(np.uint64(word)))


def brain_of(member: LoggedRobot, brain: Brain) -> Brain | None:
    """What a robot has if the swarm has this brain: an adversary puts it on; None if it is not known which."""
    if member.honest or (member.is_swarm and not member.adversary):
        return brain
    try:
        liar = adversary.load(member.adversary or "")
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
