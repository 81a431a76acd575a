"""A swarm in memory: the robots' runtime, given the readings, losses and luck of a simulated trial tick by tick."""

import numpy as np

from swarmcensus.brains.float32 import rounded_to_single
from swarmcensus.engine.constants import DRAW_FUSE, DRAW_OBSERVE
from swarmcensus.runtime.log import Log
from swarmcensus.runtime.runtime import Robot
from swarmcensus.simulation import sampling
from swarmcensus.simulation.trials import record_readings
from swarmcensus.studies import addresses
from swarmcensus.translation.messages import messages_of
from tests.reference import rounds as reference
from tests.support.boards import ByHand

FORMS = {"float32": 1, "float16": 2, "ratio16": 3, "ratio8": 4}
BEGUN, PERIOD = 1_700_000_000_000, 100


class Swarm:
    """Robots of a setting whose messages have a format; `saves` is after how many ticks a memory is saved."""

    def __init__(self, folder, setting, seed=0, trial=0, saves=0, now=True, first=0, lies=None, brains=None,
                 waits=0):  # fmt: skip
        self.folder, self.setting, self.trial, self.saves, self.now = folder, setting, trial, saves, now
        self.lies = lies or (lambda robot, tick: False)
        self.first = first  # ticks that the robots have behind them
        self.waits = waits  # ms from their start to the common beginning, after which each has a phase of its own
        folder.mkdir(exist_ok=True)
        self.links = reference.hearers(setting, None, trial)
        self.keys = addresses.losses_key(setting, seed), addresses.draw_keys(setting, seed)
        sides = sampling.accuracies(setting, seed, trial, 1)
        _, _, self.b, self.w = (np.broadcast_to(side[0], setting.robots) for side in sides)
        looks = setting.observations_per_round
        self.readings = record_readings(setting, seed, trial).reshape(setting.rounds, looks, setting.robots)
        crew = [
            setting.brain,
            *(m.brain_in(setting.brain).with_numbers(setting.brain.numbers) for m in setting.members),
        ]
        groups = sampling.groups(setting, seed, trial, 1)[0] if setting.members else [0] * setting.robots
        self.brains = brains or [crew[k] for k in groups]
        self.bodies = [ByHand() for _ in range(setting.robots)]
        self.lots = [[] for _ in range(setting.robots)]
        self.robots = [None] * setting.robots
        self.tick = 0
        self.estimates = []
        for i in range(setting.robots):
            self.start(i)
        self.estimates.append([robot.estimate for robot in self.robots])

    def start(self, i):
        """Start a robot, from what it has saved if it saves."""
        brain, single = self.brains[i], self.setting.precision == "single"
        given = rounded_to_single if single else float
        parameters = {k: tuple(map(given, v)) if isinstance(v, tuple) else given(v) for k, v in brain.overrides}
        body = self.bodies[i] = ByHand()
        self.robots[i] = robot = Robot(
            brain.functions, messages_of(brain), body, body, lambda: self._passed(i) % 2**30, given(self.b[i]),
            given(self.w[i]), i, PERIOD, self.setting.observations_per_round, parameters,
            (lambda: self.lots[i].pop(0)) if brain.uses.luck else None,
        )  # fmt: skip
        robot.ticks = self.first
        if self.saves:
            robot.keep(str(self.folder / f"memory-{i}"), self.saves)
        now = BEGUN + self._passed(i) if self.now else 0
        form = FORMS[brain.numbers.message]
        log = Log(str(self.folder / f"robot-{i}.log"), bytes.fromhex(brain.sha256)[:8], form, now, single=single)
        robot.record(log)

    def _passed(self, i):
        """Milliseconds since the robots were made."""
        phase = i * (PERIOD - 1) // self.setting.robots if self.waits else 0
        return self.tick * PERIOD + (self.waits + phase if self.tick else 0)

    def kill(self, i):
        """A robot vanishes, as in a power cut."""
        self.robots[i].log.close()
        self.robots[i] = None

    def run(self, ticks=None):
        """So many ticks, or all that are left."""
        for _ in range(ticks or self.setting.rounds - self.tick):
            self._tick()

    def close(self):
        """Close all logs."""
        for robot in self.robots:
            if robot is not None:
                robot.log.close()
        return np.array(self.estimates)

    def _tick(self):
        self.tick += 1
        alive = [i for i, robot in enumerate(self.robots) if robot is not None]
        for i in alive:
            robot, body = self.robots[i], self.bodies[i]
            body.looks, body.sent = [bool(x) for x in self.readings[self.tick - 1, :, i] if not np.isnan(x)], []
            self.lots[i][:] = self._own(i, DRAW_OBSERVE)
            robot.speak()
            if robot.log.read[1] and self.lies(i, self.tick):
                blacks, count = robot.log.read
                robot.log.read = (count - blacks, count)
        for i in alive:
            robot, body = self.robots[i], self.bodies[i]
            for j in self.links[i]:
                said = self.bodies[j].sent if self.robots[j] is not None else ()
                if said and reference.arrives(self.setting, self.keys[0], self.trial, self.tick, i, j):
                    self.lots[i][:] = self._of_message(i, j)
                    body.waiting += said
                    robot._hear()
        for i in alive:
            robot = self.robots[i]
            self.lots[i][:] = self._own(i, DRAW_FUSE)
            robot.think()
            robot.log.tick(robot, robot.clock())
            if robot.every and robot.ticks % robot.every == 0:
                robot.save()
        self.estimates.append([np.nan if robot is None else robot.estimate for robot in self.robots])

    def _own(self, i, part):
        if not self.keys[1].size:
            return []
        return [self._chance(reference.robots_word(self.keys[1][:2], self.trial, self.tick, i, part))]

    def _of_message(self, i, j):
        if not self.keys[1].size:
            return []
        key = reference.key_of(self.keys[1][2:])
        return [self._chance(reference.threefry(key, (self.trial, self.tick), (i, j))[0])]

    def _chance(self, word):
        return (reference.single_chance if self.setting.precision == "single" else reference.chance)(word)
