"""What a robot reports to whoever watches its swarm, and what it is told: to start, to stop, and to say its state.

Runs in CPython and in MicroPython. A report is a datagram over UDP: the robot's number (2 bytes, the low one first) and
a block of its log (see log.py). Without a block the robot waits to be started. Nobody signs these datagrams.
"""

import socket
import struct

START, STOP, STATE = b"start", b"stop", b"state"  # START is followed by milliseconds since 1970


class Reports:
    """The reports of a robot to an address and a port. Nothing here raises: a report that cannot be sent is lost."""

    def __init__(self, address, robot):
        """The robot waits."""
        self.address = address
        self.robot = robot
        self.socket = None
        self.lives = False  # whether the robot was started
        robot.log.sends = self.send

    def send(self, block=b""):
        """Report a block."""
        try:
            if self.socket is None:
                self.to = socket.getaddrinfo(*self.address)[0][-1]
                self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                self.socket.setblocking(False)
            self.socket.sendto(struct.pack("<H", self.robot.number) + block, self.to)
        except Exception:
            pass

    def obey(self):
        """Do what was told; returns whether the robot lives, and reports that it waits if it does not."""
        told = self.told()
        robot = self.robot
        if told[:5] == START and not self.lives:
            try:
                robot.log.now = int(told[5:])
            except ValueError:
                return False
            self.lives = True
            robot.due = robot.clock()
            robot.log.state(robot, True)
        elif told == STOP:
            self.lives = False
        elif told == STATE:
            robot.log.state(robot, False)
        if not self.lives:
            self.send()
        return self.lives

    def told(self):
        """The next order, or nothing."""
        try:
            return self.socket.recvfrom(64)[0]
        except Exception:  # nothing has come, or there is no socket yet
            return b""
