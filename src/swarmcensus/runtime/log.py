"""What a robot does, in a file, so that it can be replayed. Runs in CPython and in MicroPython.

A log is a row of blocks. A block is its kind (1 byte), the length of its body (4), the body, and a checksum of all of
them (2: the lower half of CRC-32). Numbers have their low byte first. A log is only ever appended to, some blocks at a
time, so that a power cut costs at most what was held back for the next time. There are two kinds:

- STATE: what the robot is and what its state holds, written when it starts, and whenever it saves its memory.
- TICK: what it read, said and heard in one tick, in the order in which it happened, and what it then believed.

The order in a tick is fixed: the reading, what was said, each message heard, and the end. `swarmcensus relive` reads
these files.
"""

import os
import struct
from binascii import crc32

VERSION = 1
STATE, TICK = 0x53, 0x54
MAGIC = b"swarmlog"
HEAD = "<8sBBBIHHHIII8sQddHHH"  # of the body of STATE
STARTS, FEEDBACK, SINGLE = 1, 2, 4  # flags of STATE
SAID, DREW, LISTENED = 1, 2, 4  # flags of TICK
OPENING, ENDING, FROM = "<IIHHBB", "<dI", "<HBH"  # of the body of TICK: how it begins, how it ends, a message's origin
LONGEST = 0xFFFFFF  # bytes of a body


def block(kind, body):
    """The bytes of a block."""
    out = bytearray(struct.pack("<BI", kind, len(body)))
    out.extend(body)
    out.extend(struct.pack("<H", crc32(out) & 0xFFFF))
    return bytes(out)


def numbers_of(robot):
    """All numbers that a robot would save, as bytes: those of its memory, and what rounding took of its messages."""
    numbers = robot.numbers() + robot.messages.owed
    return struct.pack("<" + "d" * len(numbers), *numbers)


class Log:
    """Writes a robot's log.

    brain: the first 8 bytes of the SHA-256 of its file. form: the number of the message format, from 1: float32,
    float16, ratio16, ratio8. now: milliseconds since 1970, 0 if unknown. most: bytes of the file after which no more is
    written. single: whether the robot computes in single precision. hold: bytes of ticks that are collected before they
    are written together, because a flash memory erases a whole sector for each time; a state is written at once, and
    so is what was held before it. Nothing here raises: what fails is counted in `faults`.
    """

    def __init__(self, file, brain=bytes(8), form=0, now=0, most=None, single=False, hold=0):
        """Nothing is written yet."""
        self.path = file
        self.brain = brain
        self.form = form
        self.now = now
        self.most = most
        self.single = single
        self.hold = hold
        self.held = bytearray()  # blocks that are not written yet
        self.count = 0  # of them
        self.file = None
        self.size = 0  # of the file, with what is held
        self.faults = 0
        self.clear()

    def clear(self):
        """Forget what was collected of a tick."""
        self.said = None
        self.heard = []  # origin and code of each message
        self.draws = []
        self.read = (0.0, 0.0)

    def state(self, robot, starts):
        """Write what a robot is, and what its state holds."""
        parameters = []
        for name in sorted(getattr(robot.brain, "PARAMETERS", {})):
            value = getattr(robot.me, name)
            parameters.extend(value if isinstance(value, (list, tuple)) else [value])
        messages, me = robot.messages, robot.me
        flags = STARTS * starts | FEEDBACK * messages.feedback | SINGLE * self.single
        boot, mark = robot.boot & 0xFFFFFFFF, messages.mark & 0xFFFF
        what = (MAGIC, VERSION, flags, self.form, boot, mark, robot.number, messages.body)
        when = (robot.ticks & 0xFFFFFFFF, robot.period, robot.clock() & 0xFFFFFFFF, self.brain, self.now)
        counts = (len(parameters), len(robot.numbers()), len(messages.owed))
        body = bytearray(struct.pack(HEAD, *(what + when + (me.b, me.w) + counts)))
        for x in parameters:
            body.extend(struct.pack("<d", x))
        body.extend(numbers_of(robot))
        self.write(STATE, body, True)

    def tick(self, robot, begun):
        """Write what was collected of a tick, which began at this time of the clock."""
        blacks, looks = self.read
        flags = (SAID if self.said is not None else 0) | (DREW if self.draws else 0)
        when = (robot.ticks & 0xFFFFFFFF, begun & 0xFFFFFFFF)
        body = bytearray(struct.pack(OPENING, *(when + (int(blacks), int(looks), flags, len(self.heard)))))
        if self.said is not None:
            body.extend(self.said)
        for boot, sender, tick, code in self.heard:
            body.extend(struct.pack(FROM, sender, boot, tick))
            body.extend(code)
        if self.draws:
            body.extend(struct.pack("<H", len(self.draws)))
            for x in self.draws:
                body.extend(struct.pack("<d", x))
        body.extend(struct.pack(ENDING, robot.estimate, crc32(numbers_of(robot)) & 0xFFFFFFFF))
        self.clear()
        self.write(TICK, body, False)

    def write(self, kind, body, synced):
        """Append a block; `synced` also waits until it is on the disk, and all before it."""
        if len(body) > LONGEST or (self.most is not None and self.size + len(body) > self.most):
            self.faults += 1
            return
        try:
            more = block(kind, body)
            self.held.extend(more)
        except Exception:  # no memory
            self.faults += 1
            return
        self.size += len(more)
        self.count += 1
        if synced or len(self.held) >= self.hold:
            self.flush(synced)

    def flush(self, synced=True):
        """Write what is held. Raises nothing."""
        held, count = self.held, self.count
        self.held, self.count = bytearray(), 0
        try:
            if self.file is None:
                self.file = open(self.path, "ab")  # noqa: SIM115 - it stays open
                self.size = self.file.tell() + len(held)
            self.file.write(held)
            self.file.flush()
            if synced and hasattr(os, "fsync"):
                os.fsync(self.file.fileno())
        except Exception:
            self.faults += count
            self.file = None

    def close(self):
        """Write what is held and close the file; the next block opens it again. Raises nothing."""
        if self.held:
            self.flush()
        if self.file is not None:
            self.file.close()
            self.file = None
