"""A folder of robots that lived together, with their logs, for tests."""

import random

from swarmcensus import brains
from swarmcensus.brains.packing import Numbers
from swarmcensus.runtime.log import Log
from swarmcensus.runtime.runtime import Robot
from swarmcensus.translation.messages import messages_of
from tests.support.boards import ByHand


class Air(ByHand):
    """Readings by chance, datagrams put in by hand."""

    def __init__(self, seed):
        super().__init__()
        self.chance = random.Random(seed)

    def read(self):
        return self.chance.random() < 0.6


def made(folder, number, clock, name="commons", now=0, message="ratio16", boot=0):
    """A robot that logs, with what it hears and says."""
    brain = brains.load(name).with_numbers(Numbers(message=message))
    air = Air(number)
    robot = Robot(brain.functions, messages_of(brain), air, air, clock, 0.9, 0.8, number, period=100)
    robot.boot = boot
    form = {"float32": 1, "float16": 2, "ratio16": 3}[message]
    robot.record(Log(folder / f"robot-{number}.log", bytes.fromhex(brain.sha256)[:8], form=form, now=now))
    return robot, air


def live(robots, clock, ticks):
    """All robots of a fully connected swarm, tick by tick, until their logs are closed."""
    for _ in range(ticks):
        clock.now += 100
        for robot, air in robots:
            robot.tick()
            for _, other in robots:
                if other is not air:
                    other.waiting.extend(air.sent[-1:])
    for robot, _ in robots:
        robot.log.close()
