"""A trial that is simulated while it is watched, and what each robot reads and hears in it."""

import functools
from typing import Any

import numpy as np

from swarmcensus.brains import slots
from swarmcensus.engine import compiler, works
from swarmcensus.engine.constants import LISTED, NOISE, SAID, TALKING
from swarmcensus.simulation import LiveTrial, Stretch
from swarmcensus.support.documents import json_value

MOST_READINGS = 4_000_000  # readings of a fixed network that are shown


class Simulated(LiveTrial):
    """One trial of a setting."""

    @property
    def rounds(self) -> int:
        """How many rounds the trial has."""
        return self.setting.rounds

    @property
    def adds(self) -> bool:
        """Whether messages are stored as what they add to the sums of their receivers."""
        return bool(self.swarm.additive)

    def read(self, tick: int, robot: int) -> tuple[float, int] | None:
        """How many black readings a robot of a fixed network made in a round, and how many in all; None if unknown."""
        if tick <= 0 or not self._blacks.size:
            return None
        return float(self._blacks[tick - 1, robot]), self.setting.observations_per_round

    def heard(self, stretch: Stretch, row: int, robot: int) -> list[dict[str, Any]]:
        """The messages that a robot heard in a round: the sender, and the contents or what they add to the sums."""
        senders, carried = self.hears(stretch, row, robot)
        brain = self.setting.brain
        said = stretch.said[row].view(compiler.array_layout(brain).number)
        names = slots({name: brain.lengths[name] for name in brain.sums} if self.adds else brain.message)
        return [
            {"from": int(sender), "said": dict(zip(names, map(json_value, said[sender].tolist()), strict=False))}
            for sender in senders[carried > 0]
        ]

    def hears(self, stretch: Stretch, row: int, robot: int) -> tuple[np.ndarray, np.ndarray]:
        """The robots that a robot can hear in a round, and whether each link carried a message, 0 or 1."""
        senders = self._neighbours(stretch, row, robot)
        return senders, self.carried(stretch, row, np.full(senders.size, robot), senders)

    def carried(self, stretch: Stretch, row: int, receivers: np.ndarray, senders: np.ndarray) -> np.ndarray:
        """Whether each link carried a message in a round (link), 0 or 1; all links of each receiver are needed."""
        given, setting, tick = self.given, self.setting, stretch.first + row
        out = np.zeros(receivers.size, np.uint8)
        delay = setting.message_delay
        if tick - delay < (1 if setting.body is None else 0):
            return out
        compiler.compile_world("living").carried(
            given.radio, given.first, tick, receivers.astype(np.int64), senders.astype(np.int64), out
        )
        works_now = np.ones(setting.robots, np.bool_)
        if given.stops[0].shape[1]:
            works_now &= [works(given.stops[0], TALKING, i, tick - delay) for i in range(setting.robots)]
        signals = stretch.signals[row]
        talks = works_now & (signals == SAID) if signals.size else works_now
        out *= talks[senders]
        if self.swarm.jams:
            noisy = (signals == NOISE) & works_now
            out[np.isin(receivers, receivers[noisy[senders]])] = 0
        return out

    @functools.cached_property
    def _blacks(self) -> np.ndarray:
        """Number of black readings per round on a fixed network (round, robot); empty for a large swarm."""
        setting = self.setting
        if setting.rounds * setting.robots > MOST_READINGS:
            return np.zeros((0, 0))
        out = np.zeros((setting.rounds, setting.robots))
        compiler.compile_world().round_readings(self.given.sensors.of_trial(0), self.given.first, out)
        return out

    def _neighbours(self, stretch: Stretch, row: int, robot: int) -> np.ndarray:
        """The robots that a robot can hear in a round, in order."""
        everyone = np.delete(np.arange(self.setting.robots), robot)
        links = self.given.links
        if self.setting.body is None:
            return np.sort(links.senders[links.receivers == robot]) if links.mode == LISTED else everyone
        if self.setting.brain.is_oracle:
            return everyone
        pairs = stretch.links[stretch.links[:, 0] == stretch.first + row, 1:]
        return np.sort(np.concatenate([pairs[pairs[:, 0] == robot, 1], pairs[pairs[:, 1] == robot, 0]]))
