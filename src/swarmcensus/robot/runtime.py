"""A robot: a brain between a sensor, a radio and a clock. Plain Python and MicroPython alike; beside it lies codec.py.

Whoever builds the robot gives two objects, with two methods each.

Sensor: `start()` makes it ready; it is called before the first reading, and again after `read` has raised. `read()`
returns True or 1 for black, False or 0 for white, and None for no reading.

Radio: `send(datagram)` broadcasts bytes, once, without waiting for anybody. `receive()` returns the next datagram that
has arrived, as bytes, or None. It must not wait for one: a method that never returns stops the robot, and only a
watchdog helps then.

Both may raise anything: what they raise is counted, and the robot goes on. In each tick the order of calls is that of
the simulator: observe, broadcast, receive for each message that has arrived, fuse, estimate.

A datagram is a header of 6 bytes, the message, and 2 bytes of checksum unless the radio has its own. The header is one
byte of the mark (of brain and format), one of the boot count, two of the sender, two of the tick; the low byte is
first. The checksum begins with the mark, so that messages of other brains and formats fail it.
"""

import os
import struct

try:
    from . import codec
except ImportError:  # on a board
    import codec

HEADER = 6
CHECKSUM = 2
STEPS = {"ratio16": 32768.0, "ratio8": 128.0, "share16": 32768.0, "share8": 128.0}
SIZES = {"float32": 4, "float16": 2, "ratio16": 3, "ratio8": 2, "share16": 2, "share8": 1, "log8": 1, "whole16": 2}
MOST = {"whole16": 65535.0}
WRAP = 0x3FFFFFFF  # after so many milliseconds MicroPython's clock begins again
SENDERS = 20  # of whom the last message is known
FORGET = 1000  # ticks after which a sender is as good as new
PATIENCE = 10  # ticks in a row that cannot be ended, after which the mind starts blank


def checksum(data, start):
    """CRC-16 (CCITT) of bytes, begun at `start`, 0 to 65535."""
    crc = start
    for byte in data:
        crc = ((crc >> 8) | (crc << 8)) & 0xFFFF
        crc ^= byte
        crc ^= (crc & 0xFF) >> 4
        crc ^= (crc << 12) & 0xFFFF
        crc ^= (crc & 0xFF) << 5
    return crc


def since(now, then):
    """The milliseconds from one time of the clock to another; below 0 if `then` is later."""
    return ((now - then + (WRAP + 1) // 2) & WRAP) - (WRAP + 1) // 2


def finite(x):
    """Whether x is a number, and not infinite."""
    return x - x == 0.0


class Messages:
    """Makes bytes of a brain's messages, and messages of bytes.

    `lengths` has the length of each field, 0 for a number. `plan` has, for each part of the bytes, its coding, which
    numbers of the message are in it, and whether what rounding took is owed: it is then added to the next message.
    `codec` is the module; off a board it may be one in another precision.
    """

    def __init__(self, lengths, plan, mark, checked, feedback=True, codec=codec):
        """Owe nothing yet."""
        self.lengths = lengths
        self.plan = plan
        self.mark = mark
        self.checked = checked
        self.feedback = feedback
        self.codec = codec
        self.count = sum([length or 1 for length in lengths])
        self.owed = [0.0] * self.count
        self.body = sum([SIZES[coding] for coding, _, _ in plan])
        self.size = HEADER + self.body + (CHECKSUM if checked else 0)

    def pack(self, message, boot, sender, tick):
        """The datagram of a message, a tuple as `broadcast` returns it. Raises whatever a wrong message raises."""
        out = bytearray(struct.pack("<BBHH", self.mark & 0xFF, boot & 0xFF, sender & 0xFFFF, tick & 0xFFFF))
        out.extend(self.coded(message))
        if self.checked:
            out.extend(struct.pack("<H", checksum(out, self.mark)))
        return bytes(out)

    def coded(self, message):
        """The bytes of a message without header and checksum; keeps what rounding takes of it."""
        numbers = []
        for part, length in zip(message, self.lengths):
            if length:
                numbers.extend([1.0 * x for x in part])
            else:
                numbers.append(1.0 * part)
        out = bytearray()
        for coding, places, owes in self.plan:
            owes = owes and self.feedback
            sent = [self.codec.added(numbers[k], self.owed[k]) if owes else numbers[k] for k in places]
            code, heard, holds = self.part(coding, sent)
            out.extend(code)
            if owes:
                for k, x, y in zip(places, sent, heard):
                    self.owed[k] = self.codec.rest(numbers[k], self.owed[k], x, y) if holds else 0.0
        return bytes(out)

    def part(self, coding, sent):
        """The bytes of one part, the numbers that a receiver reads in them, and whether the format holds them."""
        codec, x = self.codec, sent[0]
        if coding in ("ratio16", "ratio8"):
            steps = STEPS[coding]
            ratio = int(codec.ratio_code(codec.ratio_of(x, sent[1]), steps))
            code = struct.pack("<HB" if coding == "ratio16" else "<BB", ratio, int(codec.log_code(sent[1])))
            return code, codec.read_pair(x, sent[1], steps), codec.holds_pair(x, sent[1], steps)
        if coding == "float32":
            code = struct.pack("<f", min(max(x, -codec.LARGEST_REAL), codec.LARGEST_REAL))
            return code, struct.unpack("<f", code), codec.holds_real(x)
        if coding == "float16":
            return struct.pack("<H", int(codec.half_code(x))), (codec.read_half(x),), codec.holds_half(x)
        if coding == "log8":
            return struct.pack("<B", int(codec.log_code(x))), (codec.read_log(x),), codec.holds_log(x)
        if coding in MOST:
            most = MOST[coding]
            code = struct.pack("<H", int(codec.whole_code(x, most)))
            return code, (codec.read_whole(x, most),), codec.holds_whole(x, most)
        steps = STEPS[coding]
        code = struct.pack("<H" if coding == "share16" else "<B", int(codec.ratio_code(x, steps)))
        return code, (codec.read_share(x, steps),), codec.holds_share(x, steps)

    def unpack(self, datagram):
        """The boot count, sender, tick and message of a datagram; None if it is not one of this brain and format."""
        if len(datagram) != self.size or datagram[0] != self.mark & 0xFF:
            return None
        if self.checked:
            end = self.size - CHECKSUM
            if struct.unpack("<H", datagram[end:])[0] != checksum(datagram[:end], self.mark):
                return None
        _, boot, sender, tick = struct.unpack("<BBHH", datagram[:HEADER])
        message = self.read(datagram[HEADER : HEADER + self.body])
        return None if message is None else (boot, sender, tick, message)

    def read(self, code):
        """The message in these bytes, without header and checksum; None if a number is not finite."""
        numbers = [0.0] * self.count
        at = 0
        for coding, places, _ in self.plan:
            heard = self.decoded(coding, code[at : at + SIZES[coding]])
            at += SIZES[coding]
            for k, x in zip(places, heard):
                if not finite(x):
                    return None
                numbers[k] = x
        message = []
        k = 0
        for length in self.lengths:
            message.append(tuple(numbers[k : k + length]) if length else numbers[k])
            k += length or 1
        return tuple(message)

    def decoded(self, coding, code):
        """The numbers of one part."""
        codec = self.codec
        if coding in ("ratio16", "ratio8"):
            of_ratio, of_size = struct.unpack("<HB" if coding == "ratio16" else "<BB", code)
            return codec.pair_value(1.0 * of_ratio, 1.0 * of_size, STEPS[coding])
        if coding == "float32":
            return struct.unpack("<f", code)
        number = 1.0 * struct.unpack("<H" if len(code) == 2 else "<B", code)[0]
        if coding == "float16":
            return (codec.half_value(number) if number % 32768.0 < 31744.0 else float("nan"),)
        if coding == "log8":
            return (codec.log_value(number),)
        if coding in MOST:
            return (number,)
        return (codec.ratio_value(number, STEPS[coding]),)


class Me:
    """A mind: its fields are those of MEMORY, the parameters, b, w, luck and name."""


class Robot:
    """A brain at work.

    brain: the module. messages: its `Messages`. clock: a function that returns milliseconds and may begin again at
    2^30, as MicroPython's time.ticks_ms does. b, w: the sensor's accuracies on black and on white. number: of this
    robot, 0 to 65535, which no other has. period: milliseconds a tick. readings: of the sensor, in a tick. luck: a
    function that returns a random number in (0, 1), for brains that use it. budget: milliseconds of a tick after which
    no more messages are read; they wait for the next one. most: messages a tick, at most 255.
    """

    def __init__(self, brain, messages, sensor, radio, clock, b, w, number, period=100, readings=1, parameters=None,
                 luck=None, budget=None, most=32):  # fmt: skip
        """Make a blank mind; nothing is read or sent yet."""
        self.brain = brain
        self.messages = messages
        self.sensor = sensor
        self.radio = radio
        self.clock = clock
        self.number = number
        self.period = period
        self.readings = min(readings, 0xFFFF)
        self.luck = luck
        self.budget = max(1, period // 2) if budget is None else budget
        self.most = min(most, 255)
        self.log = None
        self.me = me = Me()
        self.fields = sorted(brain.MEMORY)  # the dicts of MicroPython have no order
        given = dict(getattr(brain, "PARAMETERS", {}))
        given.update(parameters or {})
        self._give(brain.MEMORY)
        self._give(given)
        me.b, me.w, me.luck, me.name = 1.0 * b, 1.0 * w, 0.5, 1.0 * number
        self.senders = []  # of each: number, boot count, tick, and our tick when it was heard
        self.boot = 0
        self.ticks = 0
        self.file, self.every = None, 0
        self.due = clock()
        self.starts = True  # whether the sensor is to be started
        self.heard = 0  # messages that the brain received
        self.refused = 0  # datagrams that are not of this brain and format, or damaged
        self.stale = 0  # messages that came twice, or after a newer one of the same sender
        self.missed = 0  # ticks for which there was no time
        self.sensor_faults = 0
        self.radio_faults = 0
        self.file_faults = 0
        self.undone = 0  # calls of the brain that failed
        self.blanked = 0  # times that the mind started blank, because forged numbers had made it unusable
        self.stuck = 0  # ticks in a row that could not be ended
        self.estimate = 0.5
        self.decision = -1  # of brains that decide
        self.course = None  # of brains that steer: metres and radians a second, or None
        self.done = False
        self._ask()

    def poll(self):
        """Run a tick if its time has come; returns the milliseconds until the next one. Raises nothing.

        Ticks that were missed are counted and left out, so that a slow radio delays the robot, but never for long.
        """
        wait = since(self.due, self.clock())
        if wait > self.period:  # the clock was set back
            self.due, wait = self.clock(), 0
        if wait <= 0:
            missed = -wait // self.period
            self.missed += missed
            self.due = (self.due + (missed + 1) * self.period) & WRAP
            self.tick()
            wait = since(self.due, self.clock())
        return max(0, wait)

    def tick(self):
        """Read the sensor, talk, hear and think, once. Raises nothing."""
        begun = self.clock()
        self.speak()
        for _ in range(self.most):
            if since(self.clock(), begun) >= self.budget or not self._hear():
                break
        self.think()
        if self.log:
            self.log.tick(self, begun)
        if self.every and self.ticks % self.every == 0:
            self.save()

    def speak(self):
        """The first part of a tick: read the sensor and broadcast."""
        self.ticks += 1
        if not self.done:
            blacks, looks = self._look()
            if looks:
                if self.log:
                    self.log.read = blacks, looks
                self._do(self.brain.observe, blacks, looks)
        self._talk()

    def think(self):
        """The last part of a tick: fuse what was heard."""
        self.stuck = 0 if self._do(self.brain.fuse) else self.stuck + 1
        if self.stuck >= PATIENCE:
            self._give(self.brain.MEMORY)
            self.messages.owed[:] = [0.0] * self.messages.count
            self.blanked += 1
            self.stuck = 0
        self._ask()

    def _give(self, fields):
        """Set fields of the mind."""
        for name, value in fields.items():
            setattr(self.me, name, list(value) if isinstance(value, (tuple, list)) else 1.0 * value)

    def _look(self):
        """How many of the readings say black, and how many there are; a sensor that raises has no more of them."""
        blacks = looks = 0.0
        try:
            if self.starts:
                self.sensor.start()
                self.starts = False
            for _ in range(self.readings):
                seen = self.sensor.read()
                if seen is not None:
                    looks += 1.0
                    blacks += 1.0 if seen else 0.0
        except Exception:
            self.sensor_faults += 1
            self.starts = True
        return blacks, looks

    def _talk(self):
        try:
            if (said := self.brain.broadcast(self.me)) is None:
                return
            datagram = self.messages.pack(said, self.boot, self.number, self.ticks)
            if self.log:
                self.log.said = datagram[HEADER : HEADER + self.messages.body]
        except Exception:
            self.undone += 1
            return
        try:
            self.radio.send(datagram)
        except Exception:
            self.radio_faults += 1

    def _hear(self):
        """Take one datagram; returns whether there may be more."""
        try:
            datagram = self.radio.receive()
        except Exception:
            self.radio_faults += 1
            datagram = None
        if datagram is None:
            return False
        try:
            read = self.messages.unpack(datagram)
        except Exception:
            read = None
        if read is None:
            self.refused += 1
        elif read[1] != self.number:  # some radios hear themselves
            if self._is_new(read[0], read[1], read[2]):
                self.heard += 1
                if self.log:
                    self.log.heard.append(read[:3] + (datagram[HEADER : HEADER + self.messages.body],))
                self._do(self.brain.receive, read[3])
            else:
                self.stale += 1
        return True

    def _is_new(self, boot, sender, tick):
        """Whether a message is newer than the last one of its sender, which it then becomes."""
        longest = 0
        for k, known in enumerate(self.senders):
            if known[0] == sender:
                recent = self.ticks - known[3] < FORGET
                boots, ticks = (boot - known[1]) & 0xFF, (tick - known[2]) & 0xFFFF
                if recent and (boots >= 128 or (boots == 0 and not 0 < ticks < 32768)):
                    return False
                known[1], known[2], known[3] = boot, tick, self.ticks
                return True
            if known[3] < self.senders[longest][3]:
                longest = k
        known = [sender, boot, tick, self.ticks]
        if len(self.senders) < SENDERS:
            self.senders.append(known)
        else:
            self.senders[longest] = known  # in place of the one unheard for longest
        return True

    def _do(self, function, *given):
        """Call a function of the brain; returns whether that worked.

        If it raises, or a number becomes NaN or infinite, the mind is as before.
        """
        before = self.numbers()
        try:
            self._draw()
            function(self.me, *given)
            if all(finite(x) for x in self.numbers()):
                return True
        except Exception:
            pass
        self.undone += 1
        self._become(before)
        return False

    def _ask(self):
        """What the brain estimates, decides and wants."""
        brain, me = self.brain, self.me
        try:
            x = brain.estimate(me)
            if 0.0 <= x <= 1.0:
                self.estimate = x
            else:
                self.undone += 1
            if hasattr(brain, "decide"):
                self.decision = brain.decide(me)
            if hasattr(brain, "done"):
                self.done = bool(brain.done(me))
            if hasattr(brain, "steer"):
                self._draw()
                self.course = brain.steer(me)
        except Exception:
            self.undone += 1

    def _draw(self):
        """New luck, if the brain uses it."""
        if self.luck:
            self.me.luck = self.luck() or 0.5
            if self.log:
                self.log.luck.append(self.me.luck)

    def record(self, log):
        """From now on write what happens to this log, a `Log` of log.py."""
        self.log = log
        log.state(self, True)

    def numbers(self):
        """All numbers of the memory, by the names of its fields."""
        out = []
        for name in self.fields:
            value = getattr(self.me, name)
            out.extend(value if isinstance(value, list) else [value])
        return out

    def keep(self, file, every):
        """Continue from the memory in `file`, if it is whole, and save there after every so many ticks.

        The boot count, in `file`.boot and .boot2, is one higher after each start; a damaged memory is a blank one.
        """
        self.file, self.every = file, every
        known = [b for b in [_read(f"{file}.boot{new}", 0) for new in ("", ".new", "2", "2.new")] if b and len(b) == 4]
        kept = [b for b in [_read(file + new, self.messages.mark) for new in ("", ".new")] if b]
        size = 8 + 8 * (len(self.numbers()) + len(self.messages.owed))
        kept = [struct.unpack("<II", b[:8]) + (b,) for b in kept if len(b) == size]
        boots = [struct.unpack("<I", b)[0] for b in known] + [b[0] for b in kept]
        if kept:
            _, self.ticks, body = max(kept)
            self.restore([struct.unpack("<d", body[k : k + 8])[0] for k in range(8, size, 8)])
        self.boot = (max(boots) + 1) & 0xFFFFFFFF if boots else 0
        if False in [_write(file + copy, struct.pack("<I", self.boot), 0) for copy in (".boot", ".boot2")]:
            self.file_faults += 1
        self._ask()

    def restore(self, numbers):
        """Set the memory, and what is owed to messages, to numbers as they are saved."""
        self._become(numbers)
        self.messages.owed[:] = numbers[len(self.numbers()) :]

    def _become(self, numbers):
        at = 0
        for name in self.fields:
            value = getattr(self.me, name)
            length = len(value) if isinstance(value, list) else 0
            setattr(self.me, name, numbers[at : at + length] if length else numbers[at])
            at += length or 1

    def save(self):
        """Save the memory; a power cut leaves the old file or the new one. Raises nothing."""
        body = bytearray(struct.pack("<II", self.boot, self.ticks & 0xFFFFFFFF))
        for x in self.numbers() + self.messages.owed:
            body.extend(struct.pack("<d", x))
        if not _write(self.file, body, self.messages.mark):
            self.file_faults += 1
        if self.log:
            self.log.state(self, False)

    def status(self):
        """One line of what happened so far."""
        told = (
            "ticks", "boot", "heard", "stale", "refused", "missed", "undone", "blanked", "sensor_faults",
            "radio_faults", "file_faults",
        )  # fmt: skip
        return " ".join([f"estimate {self.estimate:.4f}"] + [f"{name} {getattr(self, name)}" for name in told])


def _read(file, mark):
    """The content of a file with a checksum; None if there is none, or it is damaged."""
    try:
        with open(file, "rb") as f:
            data = f.read()
        if len(data) > CHECKSUM and struct.unpack("<H", data[-CHECKSUM:])[0] == checksum(data[:-CHECKSUM], mark):
            return data[:-CHECKSUM]
    except Exception:
        pass
    return None


def _write(file, data, mark):
    """Write a file with a checksum beside the old one, and rename it; returns whether that worked."""
    try:
        with open(file + ".new", "wb") as f:
            f.write(bytes(data) + struct.pack("<H", checksum(data, mark)))
            f.flush()
            if hasattr(os, "fsync"):
                os.fsync(f.fileno())
        os.rename(file + ".new", file)
    except Exception:
        return False
    return True
