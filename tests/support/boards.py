"""What tests of robots share: MicroPython on Node, and swarms of runtimes that hear each other in one process."""

import socket

import pytest

from swarmcensus.brains.packing import Numbers
from swarmcensus.runtime import runtime
from tests.support import hosts, on_node
from tests.support.places import ROOT

ROBOT = ROOT / "src" / "swarmcensus" / "runtime"
MICROPYTHON = on_node.micropython()  # before a test changes the working directory

needs_micropython = pytest.mark.skipif(MICROPYTHON is None, reason=f"needs {on_node.NEEDED}")


def on_board(tmp_path, files, heap=hosts.HEAP):
    """What a board prints that has these files, texts by name, and runs main.py."""
    return hosts.on_board(tmp_path, files, heap, MICROPYTHON)


def robot_files():
    """The files of every robot, without its brain."""
    return {name: (ROBOT / name).read_text() for name in ("codec.py", "runtime.py")}


def messages_of(brain, message="ratio16", mark=0xBEEF, checked=True, feedback=True):
    """The runtime's messages of a brain."""
    plan = brain.with_numbers(Numbers(message=message)).parts
    return runtime.Messages(tuple(brain.message.values()), plan, mark, checked, feedback)


class Air:
    """A radio of which each datagram reaches all others, unless `loses(sender, receiver)`."""

    def __init__(self, loses=lambda sender, receiver: False):
        self.loses = loses
        self.boxes = []

    def radio(self):
        self.boxes.append([])
        return Ear(self, len(self.boxes) - 1)


class Ear:
    def __init__(self, air, own):
        self.air, self.own = air, own

    def send(self, datagram):
        for k, box in enumerate(self.air.boxes):
            if k != self.own and not self.air.loses(self.own, k):
                box.append(datagram)

    def receive(self):
        box = self.air.boxes[self.own]
        return box.pop(0) if box else None


class Readings:
    """A sensor of given readings."""

    def __init__(self, readings):
        self.readings = iter(readings)
        self.started = 0

    def start(self):
        self.started += 1

    def read(self):
        return next(self.readings)


class Clock:
    """One that begins again at 2^30 ms."""

    def __init__(self, now=0):
        self.now = now

    def __call__(self):
        return self.now & runtime.WRAP


class ByHand:
    """A sensor and a radio: readings and datagrams are put in by hand, the next reading last."""

    def __init__(self):
        self.looks, self.waiting, self.sent = [], [], []

    def start(self):
        pass

    def read(self):
        return self.looks.pop() if self.looks else None

    def send(self, datagram):
        self.sent.append(datagram)

    def receive(self):
        return self.waiting.pop(0) if self.waiting else None


def free_port():
    """A port for UDP."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]
