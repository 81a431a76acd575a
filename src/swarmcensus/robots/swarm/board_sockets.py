"""Sockets, waiting and time for a robot on MicroPython inside Node; `desk` is what on_micropython.mjs gives.

MicroPython for Node has no sockets of its own. This module stands in the place of `socket`, `select` and `time`.
"""

import time as clock
from binascii import hexlify, unhexlify

import desk

AF_INET = SOCK_DGRAM = POLLIN = 1
EAGAIN = 11


class socket:
    """A datagram socket that Node has opened."""

    def __init__(self, *kind):
        """Take the next one that is open."""
        self.handle = desk.open()

    def bind(self, address):
        """It is bound."""

    def setblocking(self, flag):
        """It never waits."""

    def connect(self, address):
        """Send to this address from now on."""
        self.peer = address

    def fileno(self):
        """The number that `poll` knows it by."""
        return self.handle

    def getsockname(self):
        """Its host, which nobody asks for, and its port."""
        return "", desk.port(self.handle)

    def send(self, data):
        """Send to the address of `connect`."""
        self.sendto(data, self.peer)

    def sendto(self, data, address):
        """Send once."""
        desk.send(self.handle, hexlify(data).decode(), address[1], address[0])

    def recv(self, size):
        """What has arrived next. Raises OSError if nothing has."""
        return self.recvfrom(size)[0]

    def recvfrom(self, size):
        """What has arrived next, and from nobody in particular. Raises OSError if nothing has."""
        text = desk.take(self.handle)
        if not text:
            raise OSError(EAGAIN)
        return unhexlify(text), None


class poll:
    """Which sockets have something; it does not wait, because Node does."""

    def __init__(self):
        """Of no socket yet."""
        self.handles = []

    def register(self, handle, events):
        """Look at this socket too."""
        self.handles.append(handle)

    def poll(self, wait):
        """The sockets on which something has arrived."""
        return [(handle, POLLIN) for handle in self.handles if desk.waits(handle)]


def monotonic():
    """Seconds of the machine's clock, as CPython's."""
    return desk.now() / 1000.0


def time():
    """Seconds since 1970."""
    return clock.time()
