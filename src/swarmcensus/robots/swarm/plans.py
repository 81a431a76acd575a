"""What a swarm of processes is to be: one setting of a study, one trial, and clocks and radios of real time."""

import hashlib
import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from swarmcensus.brains import FORMATS, Adversary, Brain, Format
from swarmcensus.checks import caution
from swarmcensus.engine import Inputs
from swarmcensus.engine.constants import LISTED
from swarmcensus.robots.swarm.faults import Event, events_of
from swarmcensus.robots.target import check_hz, check_is_no_bound, datagram_bytes, mark_of
from swarmcensus.simulation import inputs_of, record_readings
from swarmcensus.studies import Setting, Study, addresses
from swarmcensus.support.errors import InputError, StudyError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import wrong_option

PLAIN_FORMAT: Format = "float32"  # in place of "double", which no datagram holds
MOST_ROBOTS = 1000
NO_READING = 2.0
MOST_LOOKS = 0xFFFF  # observations a tick
MOST_BYTES = 65507  # of a datagram of UDP
HIGHEST_HZ = 500.0  # two milliseconds a tick: the clocks of robots count whole ones


@dataclass(frozen=True)
class Air:
    """What becomes of messages, and how uneven clocks are."""

    hz: float = 10.0
    delay: int = 0  # milliseconds, in addition to the rounds of a study
    duplicate: float = 0.0  # share of messages that are heard twice
    jitter: float = 0.1  # a tick comes late by up to this share of a period
    host: str = "127.0.0.1"


@dataclass(frozen=True)
class PlannedRobot:
    """One robot."""

    number: int
    brain: Brain
    file: str  # of its brain's source
    honest: bool
    b: float  # what it believes of its sensor
    w: float
    adversary: str | None = None  # the name of what it lies by


@dataclass(frozen=True)
class SwarmPlan:
    """A swarm to be started."""

    study: Study
    setting: Setting
    number: int  # of the setting in the study
    seed: int
    trial: int
    air: Air
    members: tuple[PlannedRobot, ...]
    events: tuple[Event, ...]  # in the order of time
    links: tuple[tuple[int, int], ...]  # receiver, sender
    readings: np.ndarray  # (observation, robot), 1 black, 2 none
    chance: int  # 32 bits, the seed of what happens to messages
    draws: int | None  # the same for brains, if any uses luck

    @property
    def title(self) -> str:
        """The study, the brain and the setting."""
        return f"{self.study.name}: {self.setting.brain.name}, {self.setting}"

    @property
    def period(self) -> int:
        """Milliseconds a tick."""
        return round(1000.0 / self.air.hz)

    @property
    def delay(self) -> int:
        """Milliseconds from a message to its hearing."""
        return self.air.delay + self.setting.message_delay * self.period

    @property
    def loss(self) -> float:
        """The share of messages that are lost."""
        return 0.0 if self.setting.brain.is_oracle else round(1.0 - self.setting.link_success, 12)

    @property
    def seconds(self) -> float:
        """From the first tick to the last."""
        return self.setting.rounds * self.period / 1000.0

    @property
    def mark(self) -> int:
        """Of the datagrams of this swarm, also those of its members with other brains."""
        return mark_of(self.setting.brain)


def plan_of(study: Study, number: int, seed: int, trial: int, air: Air) -> SwarmPlan:
    """The plan of one trial of a setting. Raises InputError if it cannot be run as processes."""
    settings = study.settings()
    if not 0 <= number < len(settings):
        raise wrong_option("setting", number, f"{study.name} has {counted(len(settings), 'setting')}, numbered from 0")
    setting = addresses.in_trial(settings[number], seed, trial)
    if (numbers := setting.brain.numbers).message == FORMATS[0]:  # which has no bytes
        setting = replace(setting, brain=setting.brain.with_numbers(numbers._replace(message=PLAIN_FORMAT)))
    _check(setting, study, air)
    caution(study.brains)
    given = inputs_of(setting, seed, trial)
    members = _members(setting, given)
    links = tuple(itertools.permutations(range(setting.robots), 2))
    if given.links.mode == LISTED:
        links = tuple(zip(given.links.receivers.tolist(), given.links.senders.tolist(), strict=True))
    readings = record_readings(setting, seed, trial)
    for n, fault in enumerate(setting.faults):
        if "sensing" in fault.stop:
            rounds = slice(fault.at - 1, None if fault.until is None else fault.until - 1)
            by_round = readings.reshape(setting.rounds, -1, setting.robots)  # a view
            by_round[rounds, :, fault.failing(n, seed, trial, setting.robots)] = NO_READING
    draws = _words("luck", given.draws, trial) if given.draws.size else None
    chance = _words("messages", given.radio.key, trial, seed)
    events = tuple(events_of(setting, seed, trial))
    return SwarmPlan(study, setting, number, seed, trial, air, members, events, links, readings, chance, draws)


def _check(setting: Setting, study: Study, air: Air) -> None:
    if setting.body is not None:
        needs = 'a swarm of processes needs a fixed network, such as topology = "ring"'
        raise StudyError.within(study.name, f"robots that move have no fixed neighbours: {needs}", "topology")
    check_is_no_bound(setting.brain)
    if any(brain.jams for brain in setting.brains):
        raise StudyError.within(study.name, "a robot jams others' messages, which no robot does over sockets", "brain")
    if setting.robots > MOST_ROBOTS:
        most = f"{setting.robots:,} robots: {MOST_ROBOTS:,} processes are the most on one machine"
        raise InputError(most, key="robots", value=setting.robots)
    if (observations := setting.observations_per_round) > MOST_LOOKS:
        most = f"{observations:,} observations a round: a robot's log holds up to {MOST_LOOKS:,} a tick"
        raise InputError(most, key="observations_per_round", value=observations)
    size = max(map(datagram_bytes, setting.brains))
    if size > MOST_BYTES:
        most = f"a message of {size:,} bytes: UDP carries up to {MOST_BYTES:,} in a datagram"
        raise InputError(most, key="message", value=size)
    check_hz(air.hz, HIGHEST_HZ)
    for name, value in (("duplicate", air.duplicate), ("jitter", air.jitter)):
        if not 0.0 <= value <= 0.9:
            raise wrong_option(name, value, "should be a share, from 0 to 0.9")


def _members(setting: Setting, given: Inputs) -> tuple[PlannedRobot, ...]:
    group = given.group[0] if given.group.size else np.zeros(setting.robots, np.int64)
    honest = given.honest[0] if given.honest.size else np.ones(setting.robots, np.bool_)
    b, w = (np.broadcast_to(side[0], (setting.robots,)) for side in given.beliefs)
    # liars, whom metrics do not count, have files with a name of their own
    lies = [not honest[group == k].any() for k in range(1, len(setting.brains))]
    names = ["brain.py", *(f"{'liar' if lie else 'brain'}-{k}.py" for k, lie in enumerate(lies, 1))]
    wrapped = {
        liar.brain_in(setting.brain).with_numbers(setting.brain.numbers): liar.brain.name
        for liar in setting.members
        if isinstance(liar.brain, Adversary)
    }
    return tuple(
        PlannedRobot(
            k, setting.brains[group[k]], names[group[k]], bool(honest[k]), float(b[k]), float(w[k]),
            wrapped.get(setting.brains[group[k]]),
        )
        for k in range(setting.robots)
    )  # fmt: skip


def _words(purpose: str, *content: object) -> int:
    """32 bits from a key of random numbers."""
    text = " ".join([purpose, *(str(np.asarray(part).tolist()) for part in content)])
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=4).digest())


def hearers(plan: SwarmPlan, cuts: Sequence[frozenset[int]], silent: Collection[int]) -> list[list[int]]:
    """For each robot, who hears it while groups are cut off from the rest, and some robots do not talk."""
    heard_by: list[list[int]] = [[] for _ in plan.members]
    for receiver, sender in plan.links:
        if sender not in silent and all((receiver in group) == (sender in group) for group in cuts):
            heard_by[sender].append(receiver)
    return heard_by
