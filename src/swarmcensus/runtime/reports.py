"""What a robot reports to whoever watches its swarm, and its orders: to start, to stop, and to say its state.

Runs in CPython and in MicroPython. A report is a block of the robot's log (see log.py), cut into datagrams of MAGIC,
the robot's number (2 bytes, the low one first), the part's number (1 byte, counted from 0, 128 more in the last), and
the part. Without a block the robot waits to be started. An order is MAGIC and words: what is to be done, the robot's
number, and with START milliseconds since 1970. It has no byte 3, which would end a program of MicroPython at a serial
port. Nobody signs these datagrams. A link has `send(datagram)` and `receive()`, which returns a datagram or None.
"""

import struct

try:
    from .runtime import since
except ImportError:  # on a board
    from runtime import since

MAGIC, START, STOP, STATE = b"\xa7swm", b"start", b"stop", b"state"
HEAD, LAST = "<HB", 128  # what follows MAGIC in a report, and what its last part has more
OWN = len(MAGIC) + 3  # bytes of a part that are not the block's
LARGEST = 250  # bytes of a datagram, unless a link has another number
KNOCK = 200  # milliseconds from one time that a robot says that it waits to the next
GATEWAY, USB = "gateway", "usb"  # links that are no network


class Network:
    """A link over UDP."""

    largest = 1400

    def __init__(self, address):
        """The socket is opened when it is first needed, because Wi-Fi may be away."""
        self.address = address
        self.socket = None

    def send(self, datagram):
        """Send to those who watch."""
        if self.socket is None:
            import socket  # not on every board

            self.to = socket.getaddrinfo(*self.address)[0][-1]
            self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.socket.setblocking(False)
        self.socket.sendto(datagram, self.to)

    def receive(self):
        """The next order; raises where none has come."""
        return self.socket.recvfrom(64)[0]


def link_of(where, robot):
    """The robot's own radio for a gateway, its serial port, or an address and port."""
    if where == GATEWAY:
        return robot.air()
    if where == USB:
        from lines import Console

        return Console()
    return Network(where)


class Reports:
    """The reports of a robot. Nothing here raises: a report that cannot be sent is lost.

    where: the address and port of those who watch, GATEWAY or USB.
    """

    def __init__(self, where, robot):
        """The robot waits."""
        self.where = where
        self.link = None
        self.robot = robot
        self.lives = False  # whether the robot was started
        self.knocked = robot.clock() - KNOCK
        robot.log.sends = self.send
        robot.others = self.hear

    def send(self, block=b""):
        """Report a block."""
        try:
            if self.link is None:
                self.link = link_of(self.where, self.robot)
            room = getattr(self.link, "largest", LARGEST) - OWN
            answer = getattr(self.link, "answer", self.link.send)  # to a gateway alone
            for at in range(0, max(1, len(block)), room):
                part = at // room | (LAST if at + room >= len(block) else 0)
                head = struct.pack(HEAD, self.robot.number, part)
                answer(MAGIC + head + block[at : at + room])
        except Exception:
            pass

    def obey(self):
        """Do what was ordered; returns whether the robot lives, and says now and then that it waits if it does not."""
        try:
            while not (self.lives and self.link is self.robot.radio):  # of its own radio the robot reads messages, too
                order = self.link.receive()
                if order is None:
                    break
                self.hear(order)
        except Exception:  # nothing has come, or there is no link yet
            pass
        now = self.robot.clock()
        if not self.lives and not 0 <= since(now, self.knocked) < KNOCK:
            self.knocked = now
            self.send()
        return self.lives

    def hear(self, datagram):
        """Do what a datagram orders this robot; returns whether it is one of those who watch or report."""
        if datagram[: len(MAGIC)] != MAGIC:
            return False
        words, robot = datagram[len(MAGIC) :].split(), self.robot
        if len(words) < 2 or words[1] != str(robot.number).encode():
            return True
        if hasattr(self.link, "sender"):
            self.link.watcher = self.link.sender
        if words[0] == START and len(words) == 3 and words[2].isdigit() and not self.lives:
            robot.log.now = int(words[2])
            self.lives = True
            robot.due = robot.clock()
            robot.log.state(robot, True)
        elif words[0] == STOP:
            self.lives = False
        elif words[0] == STATE:
            robot.log.state(robot, False)
        return True
