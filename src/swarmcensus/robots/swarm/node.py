"""What one robot of a swarm of processes runs, with Python alone; its other files lie next to it.

It says who it is to the swarm's command, which answers with when the swarm starts and who hears the robot. From then on
it reads, talks and thinks by its own clock until its rounds are over, and goes on reporting until it is ended. It ends
itself when the command no longer takes its reports.
"""

import _socket as socket  # the small part of Python's, of which a process loads less
import errno
import select
import sys
import time

import air
from log import Log
from runtime import WRAP, Messages, Robot, since

REPORTED = 250  # milliseconds from one report to the next
KNOCKS = 100  # milliseconds from one report to the next until the swarm starts
DRIFT = 0.002  # a clock is at most this share too fast or too slow


class Sensor:
    """Readings from a file, a byte each: those of the round that it is by the robot's clock."""

    def __init__(self, file, looks):
        """No round has begun."""
        with open(file, "rb") as opened:
            self.readings = opened.read()
        self.looks = looks
        self.next = 0

    def start(self):
        """Nothing is to be made ready."""

    def turn(self, number):
        """The next reading is the first of this round, counted from 0."""
        self.next = number * self.looks

    def read(self):
        """The next reading; None after the last, and while the sensor fails."""
        self.next += 1
        reading = self.readings[self.next - 1] if self.next <= len(self.readings) else 2
        return None if reading == 2 else reading == 1


class Timed(Robot):
    """A robot that knows which round it is by its clock."""

    def tick(self):
        """Run a tick with the readings of this round."""
        self.sensor.turn(self.round())
        Robot.tick(self)

    def begin(self, phase, rounds):
        """Wait for the next round, at this phase of the period in milliseconds."""
        passed = since(self.clock(), phase)
        self.first = max(0, -(-passed // self.period))
        self.due = (phase + self.first * self.period) & WRAP
        self.rounds = rounds
        self.ticks_before = self.ticks

    def round(self):
        """The round that comes next, counted from 0."""
        return self.first + self.ticks - self.ticks_before + self.missed


class Node:
    """One life of a robot; `settings` is its module, `life` counts the starts of its process."""

    def __init__(self, settings, life):
        """Open the sockets; any free port will do."""
        self.settings = settings
        self.life = life
        self.robot = None
        self.reported = 0.0  # when it reported last
        self.lag = 0  # milliseconds that the next tick comes late
        self.ended = False
        self.version = 0  # of the command's last orders
        self.radio = self._open()
        self.command = self._open()
        self.command.connect((settings.HOST, settings.COMMAND))
        self.poll = select.poll()
        self.poll.register(self.command.fileno(), select.POLLIN)
        self.seed = settings.SEED
        s = settings
        messages = Messages(s.LENGTHS, s.PLAN, s.MARK, True, s.FEEDBACK)
        self.air = air.Air(self.radio, messages, self.now, s.NUMBER, s.SEED, s.LOSS, s.DUPLICATE, s.DELAY)
        self.start = 0.0
        self.pace = 1.0 + DRIFT * (2.0 * air.share(self.seed, air.DRIFT, settings.NUMBER) - 1.0)

    def _open(self):
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        made.bind((self.settings.HOST, 0))
        made.setblocking(False)
        return made

    def now(self):
        """Milliseconds of the machine."""
        return time.monotonic() * 1000.0

    def clock(self):
        """Milliseconds of this robot's own clock since the swarm's start."""
        return int((self.now() - self.start) * self.pace) & WRAP

    def run(self):
        """Live until the command ends it, or is gone."""
        while True:
            self.rest(self.step())

    def step(self):
        """Do what is due; returns the milliseconds until something is."""
        if self.robot is None:
            self.report()
            return KNOCKS
        robot, settings = self.robot, self.settings
        wait = since(robot.due, self.clock()) + self.lag
        if robot.round() >= settings.ROUNDS:
            self.air.end()
            wait = REPORTED if self.ended else 0
            self.ended = True
        elif wait <= 0:
            wait = robot.poll()
            drawn = air.share(self.seed, air.JITTER, settings.NUMBER, 0, robot.ticks)
            self.lag = int(settings.JITTER * robot.period * drawn)
            wait += self.lag
        if self.now() - self.reported >= REPORTED or self.ended:
            self.reported = self.now()
            self.report()
        return wait

    def rest(self, wait):
        """Sleep so many milliseconds, or until something is to be heard."""
        for ready in self.poll.poll(max(0, wait)):
            if ready[0] == self.command.fileno():
                self.obey()
            else:
                self.air.listen()

    def obey(self):
        """Take what the command tells: a version, when the swarm starts, and the ports of those who hear this robot."""
        while True:
            try:
                text = self.command.recv(65535).decode()
            except OSError as error:
                self.check(error)
                return
            version, start, ports = text.split(" ")
            if int(version) > self.version:
                self.version, self.start = int(version), float(start)
                self.air.hearers = [(self.settings.HOST, int(port)) for port in ports.split(",") if port]
                if self.robot is None:
                    self.begin()

    def check(self, error):
        """End if the command is gone."""
        if error.args and error.args[0] == errno.ECONNREFUSED:
            sys.exit(0)

    def begin(self):
        """Make the robot, with the memory of its last life."""
        s = self.settings
        sensor = Sensor(s.READINGS, s.LOOKS)
        brain = __import__(s.BRAIN)
        self.robot = robot = Timed(
            brain, self.air.messages, sensor, self.air, self.clock, s.B, s.W, s.NUMBER, s.PERIOD, s.LOOKS, s.PARAMETERS,
            None if s.LUCK is None else self.draws, None, 255,
        )  # fmt: skip
        self.drawn = 0
        robot.keep(s.MEMORY, s.SAVE_EVERY)
        robot.begin(int(s.PERIOD * air.share(self.seed, air.PHASE, s.NUMBER)), s.ROUNDS)
        robot.record(Log(s.LOG, s.HASH, s.FORM, int(time.time() * 1000), None, s.SINGLE))
        if s.DELAY:
            self.poll.register(self.radio.fileno(), select.POLLIN)

    def draws(self):
        """A random number in (0, 1), with 23 binary digits in single precision and 52 in double."""
        self.drawn += 2
        s = self.settings
        boot = self.robot.boot if self.robot else 0
        draws = [air.share(s.LUCK, air.LUCK, s.NUMBER, boot, self.drawn + k, self.drawn >> 16) for k in (0, 1)]
        if s.SINGLE:
            return (int(draws[0] * 8388608.0) * 2 + 1) / 16777216.0
        return (int(draws[0] * 4294967296.0) * 1048576 + int(draws[1] * 1048576.0) + 0.5) / 4503599627370496.0

    def report(self):
        """Tell the command how this robot is."""
        port = self.radio.getsockname()[1]
        words = [self.settings.TOKEN, self.settings.NUMBER, self.life, port, self.version]
        if self.robot is not None:
            r, a = self.robot, self.air
            words += [r.round(), r.ticks_before, r.estimate, r.ticks - r.ticks_before, r.heard, r.refused, r.missed]
            words += [r.undone, a.sent, a.lost, a.late, r.file_faults + (r.log.faults if r.log else 0)]
        try:
            self.command.send(" ".join([str(word) for word in words]).encode())
        except OSError as error:
            self.check(error)


def main(name, life):
    """Run the robot whose settings are in the module of this name."""
    Node(__import__(name), int(life)).run()
