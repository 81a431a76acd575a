"""Lets three robots live 200 ticks on this board and prints all their numbers: `swarmcensus deploy --check` compares.

Readings, losses and luck come from a formula, so that they are the same everywhere. Nothing is measured or sent.
"""

import gc
import struct
import time
from binascii import hexlify

import brain
import settings
from runtime import Messages, Robot

TICKS = 200
STOPS = (1, 2, 3, 5, 10, 20, 50, 100, 200)


class Chance:
    """Numbers in (0, 1) from a formula."""

    def __init__(self, state):
        """Begin at a whole number."""
        self.state = state

    def __call__(self):
        """The next number, one of 65,536; 4-byte floats have it exactly."""
        self.state = (self.state * 75 + 74) % 65537
        return (self.state % 65536 + 0.5) / 65536.0


class Sensor:
    """Says black in 45 % of readings, and nothing in 10 %."""

    def __init__(self, chance):
        """Take the chance."""
        self.chance = chance

    def start(self):
        """Nothing to do."""

    def read(self):
        """One reading."""
        x = self.chance()
        return None if x < 0.125 else x < 0.5625


class Radio:
    """Gives datagrams to the other robots of this board; a fifth is lost."""

    def __init__(self, chance):
        """Take the chance."""
        self.chance = chance
        self.others = []
        self.box = []
        self.last = b""

    def send(self, datagram):
        """Give it to all others."""
        self.last = datagram
        for other in self.others:
            if self.chance() >= 0.1875:
                other.box.append(datagram)

    def receive(self):
        """The next datagram, or None."""
        return self.box.pop(0) if self.box else None


def bits():
    """The binary digits of this board's numbers: 53 for 8-byte floats, 24 for 4-byte ones."""
    x, count = 1.0, 0
    while 1.0 + x != 1.0:
        x /= 2.0
        count += 1
    return count


def coded(x):
    """A number as text, to the bit."""
    return hexlify(struct.pack(">d", x)).decode()


def ticks_us():
    """Microseconds."""
    return time.ticks_us() if hasattr(time, "ticks_us") else int(time.time() * 1e6)


def robots():
    """Three robots that hear each other."""
    s = settings
    radios = [Radio(Chance(100 + k)) for k in range(3)]
    out = []
    for k, radio in enumerate(radios):
        radio.others = [other for other in radios if other is not radio]
        messages = Messages(s.LENGTHS, s.PLAN, s.MARK, s.CHECKED, True, getattr(s, "ROUNDED", float))
        luck = Chance(200 + k) if s.LUCK else None
        sensor = Sensor(Chance(300 + k))
        out.append(
            Robot(brain, messages, sensor, radio, lambda: 0, s.B, s.W, k, s.PERIOD, s.READINGS, s.PARAMETERS, luck)
        )
    return out


def main():
    """Print what the robots become."""
    gc.collect()
    free = gc.mem_free() if hasattr(gc, "mem_free") else 0
    swarm = robots()
    gc.collect()
    free -= gc.mem_free() if hasattr(gc, "mem_free") else 0
    print("selftest 1", settings.BRAIN, settings.MARK, "bits", bits())
    spent = 0
    for tick in range(1, TICKS + 1):
        begun = ticks_us()
        for robot in swarm:
            robot.tick()
        spent += ticks_us() - begun
        if tick in STOPS:
            for k, robot in enumerate(swarm):
                numbers = " ".join([coded(x) for x in robot.numbers() + [robot.estimate]])
                print("tick", tick, k, hexlify(robot.radio.last).decode() or "-", numbers)
    print("counts", " ".join([f"{robot.heard} {robot.refused} {robot.undone}" for robot in swarm]))
    print("heap", free // 3, "bytes a robot;", spent // (3 * TICKS), "microseconds a tick")
    print("selftest ends")


main()
