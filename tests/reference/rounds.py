"""A swarm's whole life by brute force: written from the docs, in plain Python, and slow. The engine is held against it.

Nothing here is shared with the engine but brains and settings; there is no chunk, no block and no sum.
"""

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from swarmcensus.simulation import sampling
from swarmcensus.studies import addresses
from swarmcensus.studies.settings import Setting
from tests.reference import formats as reference_formats

MASK = (1 << 64) - 1
ROTATIONS = (16, 42, 12, 31, 16, 32, 24, 21)
FOREVER = 10**9
Key = tuple[int, int]


# ---- random numbers: Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011
def threefry(key: Key, high: tuple[int, int], low: tuple[int, int]) -> Key:
    """Threefry-2x64-13 of a counter whose two words are made of two 32-bit numbers each."""
    keys = (*key, 0x1BD11BDAA9FC1A22 ^ key[0] ^ key[1])
    a, b = ((high[0] << 32 | high[1]) + keys[0]) & MASK, ((low[0] << 32 | low[1]) + keys[1]) & MASK
    for step in range(13):
        turn = ROTATIONS[step % 8]
        a = (a + b) & MASK
        b = (b << turn & MASK | b >> 64 - turn) ^ a
        if step % 4 == 3:
            more = step // 4 + 1
            a, b = (a + keys[more % 3]) & MASK, (b + keys[(more + 1) % 3] + more) & MASK
    return a, b


def unit(word: int) -> float:
    """The 53 uppermost bits as a number in [0, 1)."""
    return (word >> 11) / 2.0**53


def key_of(key: np.ndarray) -> Key:
    """Two whole numbers."""
    return int(key[0]), int(key[1])


def chance(word: int) -> float:
    """The 52 uppermost bits as a number in (0, 1)."""
    return (2 * (word >> 12) + 1) / 2.0**53


def single_chance(word: int) -> float:
    """The 23 uppermost bits as a number in (0, 1)."""
    return (2 * (word >> 41) + 1) / 2.0**24


def robots_word(key: np.ndarray, trial: int, tick: int, robot: int, part: int = 0) -> int:
    """A robot's own 64 bits of a tick; robots 2 j and 2 j + 1 share a block."""
    return threefry(key_of(key), (trial, tick), (part, robot // 2))[robot % 2]


def tile_unit(key: np.ndarray, trial: int, purpose: int, column: int, row: int) -> tuple[float, float]:
    """Two uniform numbers of a tile or a node."""
    one, other = threefry(key_of(key), (trial, purpose), (2**30 + column, 2**30 + row))
    return unit(one), unit(other)


# ---- what changes while robots look
def fill_ratio_in(setting: Setting, tick: int) -> float:
    """The fill ratio of a round or tick: the last with the old one is at - 1, the first with the new one is until."""
    change = setting.change
    if change is None:
        return setting.fill_ratio
    steps = (change.until or change.at) - change.at + 1
    done = min(max(tick - change.at + 1, 0), steps)
    return change.last if done == steps else change.first + (change.last - change.first) * (done / steps)


def accuracy_in(setting: Setting, member: int, start: float, tick: int) -> float:
    """A robot's true accuracy of a round or tick, of the swarm (0) or of a member: it stays where its drift ends."""
    accuracy = (setting.members[member - 1].accuracy if member else None) or setting.accuracy
    if accuracy.drift is None:
        return start
    value = start + accuracy.drift.slope * (tick - 1)
    bound = accuracy.drift.bound
    return max(value, min(bound, start)) if accuracy.drift.slope < 0 else min(value, max(bound, start))


# ---- who hears whom on fixed networks
def hearers(setting: Setting, key: np.ndarray | None, trial: int) -> list[list[int]]:
    """Whom each robot hears, in order."""
    n, topology = setting.robots, setting.topology
    out: list[set[int]] = [set() for _ in range(n)]
    if topology.edges is not None:
        pairs = list(topology.edges)
    elif topology.name == "full":
        pairs = list(combinations(range(n), 2))
    elif topology.name == "scale-free":
        assert key is not None
        pairs = [(0, 1)] if n > 1 else []
        for i in range(2, n):  # an end of a link, each as likely: so robots are met in proportion to their links
            ends = [end for child, parent in ((c, p) for p, c in pairs) for end in (child, parent)]
            pairs.append((ends[int(unit(robots_word(key, trial, 0, i)) * len(ends))], i))
    else:
        pairs = [(i, i + 1) for i in range(n - 1)] + ([(0, n - 1)] if topology.name == "ring" and n > 2 else [])
    for i, j in pairs:  # of a directed edge, the second hears the first
        out[j].add(i)
        out[i] |= set() if topology.directed else {j}
    return [sorted(heard) for heard in out]


def arrives(setting: Setting, key: np.ndarray, trial: int, tick: int, receiver: int, sender: int) -> bool:
    """Whether a message is not lost."""
    if setting.link_success == 1.0:
        return True
    return threefry(key_of(key), (trial, tick), (receiver, sender))[0] < setting.link_success * 2.0**64


@dataclass
class Failures:
    """From which round or tick on, and until which, parts of robots do not work: a list of such pairs a robot."""

    moving: list[list[tuple[int, int]]]
    sensing: list[list[tuple[int, int]]]
    talking: list[list[tuple[int, int]]]


def works(spells: list[tuple[int, int]], tick: int) -> bool:
    """Whether a part with these spells works."""
    return not any(since <= tick < until for since, until in spells)


def failures(setting: Setting, keys: list[np.ndarray], trial: int) -> Failures:
    """Those of all faults, given the key of each one's lots: the robots with the smallest lots fail."""
    out = Failures(*([[] for _ in range(setting.robots)] for _ in range(3)))
    for fault, key in zip(setting.faults, keys, strict=True):
        lots = [unit(robots_word(key, trial, 0, i)) for i in range(setting.robots)]
        for i in sorted(range(setting.robots), key=lots.__getitem__)[: fault.count(setting.robots)]:
            for part in fault.stop:
                getattr(out, part)[i].append((fault.at, fault.until or FOREVER))
    return out


# ---- states
class States:
    """The states of a swarm, what they said in each tick, their estimates, their messages and what they decided."""

    def __init__(self, setting: Setting, seed: int, trial: int, failed: Failures, alone: bool = False) -> None:
        _, _, b, w = (accuracy[0] for accuracy in sampling.accuracies(setting, seed, trial, 1))
        self.setting, self.trial, self.failed = setting, trial, failed
        self.losses, self.draws = addresses.losses_key(setting, seed), addresses.draw_keys(setting, seed, alone)
        self.parts = (3, 4) if alone else (0, 1)
        n = setting.robots
        others = (member.brain_in(setting.brain).with_numbers(setting.brain.numbers) for member in setting.members)
        crew = [setting.brain, *others]
        self.brains = [crew[k] for k in (sampling.groups(setting, seed, trial, 1)[0] if setting.members else [0] * n)]
        every = zip(self.brains, np.broadcast_to(b, n).tolist(), np.broadcast_to(w, n).tolist(), strict=True)
        single = [brain.numbers.precision == "single" for brain in self.brains]
        self.round = [reference_formats.single if one else float for one in single]
        self.chance = [single_chance if one else chance for one in single]
        given = enumerate(every)
        self.states = [brain.robot(self.round[i](b), self.round[i](w), float(i)) for i, (brain, b, w) in given]
        self.formats = {brain: reference_formats.Formats(brain, n) for brain in self.brains}
        moves = setting.body is not None  # robots on fixed networks say nothing before round 1
        self.said = [[self.sends(i) if moves else None for i in range(n)]]
        self.noise = [[self.jams(i) for i in range(n)]]
        self.estimates = [[self.call("estimate", i) for i in range(n)]]
        self.sent, self.heard = [0] * n, [0] * n
        self.decisions, self.done = [], []  # of each tick, by robot
        self.intervals: list[list[tuple[float, float]]] = [[self.interval(i) for i in range(n)]]

    def call(self, name: str, i: int, *given: object) -> object:
        """A function of robot i's brain."""
        return getattr(self.brains[i].functions, name)(self.states[i], *given)

    def says(self, i: int) -> object:
        """Its message, or None: a vector as it is now."""
        message = None if self.jams(i) else self.call("broadcast", i)
        return message and tuple(tuple(part) if isinstance(part, list) else part for part in message)

    def sends(self, i: int) -> object:
        """Its message as it is read, after its number format."""
        return self.formats[self.brains[i]].sent(i, self.says(i))

    def jams(self, i: int) -> bool:
        """Whether it makes noise, and so says nothing."""
        return self.brains[i].jams and bool(self.call("jam", i))

    def is_done(self, i: int) -> bool:
        """Whether it makes no more readings."""
        return self.brains[i].ends and bool(self.call("done", i))

    def interval(self, i: int) -> tuple[float, float]:
        """Between which numbers it believes the fill ratio to lie; NaN of a brain that does not say."""
        found: tuple[float, float] = self.call("interval", i) if self.brains[i].has_interval else (math.nan, math.nan)
        return found

    def cast(self, i: int, tick: int, part: int) -> None:
        """Give luck for a call of its own: 0 of `observe`, 1 of `fuse`, 2 of `steer`."""
        if self.brains[i].uses.luck:
            self.states[i].luck = self.chance[i](robots_word(self.draws[:2], self.trial, tick, i, part))

    def live(
        self, tick: int, blacks: list[float], looks: int, heard: list[list[int]], delay: int = 0, since: int = 0
    ) -> None:
        """Observe (NaN: no observation), talk, hear what was said `delay` ticks ago but not before `since`, fuse."""
        n = len(self.states)
        for i in range(n):
            if not math.isnan(blacks[i]) and works(self.failed.sensing[i], tick) and not self.is_done(i):
                self.cast(i, tick, self.parts[0])
                self.call("observe", i, float(blacks[i]), float(looks))
        self.said.append([self.sends(i) for i in range(n)])
        self.noise.append([self.jams(i) for i in range(n)])
        for i in range(n):
            self.sent[i] += self.said[-1][i] is not None and works(self.failed.talking[i], tick)
            before = tick - delay
            noisy = (self.noise[before][j] and works(self.failed.talking[j], before) for j in heard[i])
            drowned = before >= since and any(noisy)
            for j in heard[i] if before >= since and not drowned else ():
                spoke = works(self.failed.talking[j], before) and self.said[before][j] is not None
                if spoke and arrives(self.setting, self.losses, self.trial, tick, i, j):
                    if self.brains[i].uses.luck:
                        word = threefry(key_of(self.draws[2:]), (self.trial, tick), (i, j))[0]
                        self.states[i].luck = self.chance[i](word)
                    self.heard[i] += 1
                    self.call("receive", i, self.said[before][j])
        for i in range(n):
            self.cast(i, tick, self.parts[1])
            self.call("fuse", i)
        self.estimates.append([self.call("estimate", i) for i in range(n)])
        self.decisions.append([float(self.call("decide", i)) if self.brains[i].decides else -1.0 for i in range(n)])
        self.done.append([self.is_done(i) for i in range(n)])
        self.intervals.append([self.interval(i) for i in range(n)])


def fixed(
    setting: Setting, seed: int, trial: int, failed: Failures, heard: list[list[int]], blacks: np.ndarray
) -> States:
    """One trial on a fixed network, given how many of each round's readings said black (round, robot)."""
    states = States(setting, seed, trial, failed)
    for tick in range(1, setting.rounds + 1):
        states.live(tick, blacks[tick].tolist(), setting.observations_per_round, heard, setting.message_delay, 1)
    return states
