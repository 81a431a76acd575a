"""The runtime of robots lives as the simulator's reference does, and bears what radios, sensors and power do to it."""

import gc
import itertools
import math
import os
import random
import struct
import tracemalloc
from binascii import crc32

import numpy as np
import pytest

from swarmcensus import brains
from swarmcensus.brains.packing import Numbers
from swarmcensus.runtime import runtime
from tests.reference.formats import Formats
from tests.support.boards import Air, Clock, Readings, messages_of
from tests.support.small import FAMILIES

COMMONS = brains.load("commons")
NOTHING = itertools.repeat(None)


def robot_of(brain=COMMONS, number=1, readings=NOTHING, radio=None, clock=None, message="ratio16", **more):
    of_brain = (brain.functions, messages_of(brain, message))
    devices = (Readings(readings), radio or Air().radio(), clock or Clock())
    return runtime.Robot(*of_brain, *devices, 0.9, 0.8, number, **more)


@pytest.mark.parametrize("name", FAMILIES)
def test_a_swarm_of_robots_is_one_of_the_reference(name):
    """Calls come in the reference's order: states are those that it has by hand, of messages that were packed."""
    brain, random_, air = brains.load(name), random.Random(4), Air()
    seen = [[random_.random() < 0.6 for _ in range(40)] for _ in range(3)]
    robots = [robot_of(brain, k, seen[k], air.radio(), message="float16", draws=lambda: 0.25) for k in range(3)]
    states = [brain.robot(0.9, 0.8, float(k)) for k in range(3)]
    lines = [messages_of(brain, "float16") for _ in states]
    waiting = [[], [], []]
    for tick in range(1, 41):
        for k, me in enumerate(states):
            if brain.uses.luck:
                me.luck = 0.25
            if not (brain.ends and brain.functions.done(me)):
                brain.functions.observe(me, 1.0 * seen[k][tick - 1], 1.0)
            said = brain.functions.broadcast(me)
            if said is not None:
                heard = lines[k].unpack(lines[k].pack(said, 0, k, tick))[3]
                for other in {0, 1, 2} - {k}:
                    waiting[other].append(heard)
            for message in waiting[k]:
                brain.functions.receive(me, message)
            waiting[k].clear()
            brain.functions.fuse(me)
            robots[k].tick()
            due = [x for field in sorted(brain.memory) for x in np.atleast_1d(getattr(me, field))]
            assert robots[k].numbers() == due
            assert robots[k].estimate == brain.functions.estimate(me)
    assert not any(robot.undone or robot.refused or robot.stale for robot in robots)
    assert all(robot.heard == 78 + k for k, robot in enumerate(robots)) or brain.uses.silence


@pytest.mark.parametrize("format_", ["float32", "float16", "ratio16", "ratio8"])
@pytest.mark.parametrize("name", FAMILIES)
def test_messages_are_read_as_in_the_reference(name, format_):
    """Packed and unpacked, with what is owed: large, small, negative and plain numbers."""
    brain = brains.load(name).with_numbers(Numbers(message=format_))
    ours, theirs, random_ = messages_of(brain, format_), Formats(brain, 1), random.Random(5)
    for tick in range(60):
        size = 10.0 ** random_.randint(-8, 20) if tick % 3 else 1.0
        counts = brain.message.values()
        drawn = [[random_.gauss(0.5, 1.0) * size for _ in range(items or 1)] for items in counts]
        said = [numbers if items else numbers[0] for numbers, items in zip(drawn, counts, strict=True)]
        assert ours.unpack(ours.pack(tuple(said), 0, 1, tick))[3] == theirs.sent(0, tuple(said))


@pytest.mark.parametrize("format_", ["float32", "float16"])
def test_infinite_numbers_and_nan_are_refused(format_):
    messages = messages_of(COMMONS, format_, checked=False)
    good = messages.pack((1.0, 2.0), 0, 1, 1)
    code = struct.pack("<f" if format_ == "float32" else "<e", math.nan)
    assert messages.unpack(good[:6] + code + good[6 + len(code) :]) is None
    assert messages.unpack(good) is not None


def test_checksum_finds_changed_bytes():
    messages = messages_of(COMMONS)
    good = messages.pack((1.0, 2.0), 3, 500, 70000)
    assert messages.unpack(good)[:3] == (3, 500, 70000 & 0xFFFF)
    for at, bit in itertools.product(range(len(good)), range(8)):
        assert messages.unpack(good[:at] + bytes([good[at] ^ (1 << bit)]) + good[at + 1 :]) is None
    for length in range(len(good)):
        assert messages.unpack(good[:length]) is None
    assert messages.unpack(good + b"\0") is None
    for mark in (0x12EF, 0x1BEEF, 0xFF00BEEF):  # the same low byte
        assert messages_of(COMMONS, mark=mark).unpack(good) is None
    assert messages_of(COMMONS, "float32").unpack(good) is None


def test_doubled_reordered_and_own_messages_are_left_out():
    air, other = Air(), messages_of(COMMONS)
    robot = robot_of(radio=air.radio())

    def says(tick, boot=0, sender=2):
        air.boxes[0].append(other.pack((1.0, 2.0), boot, sender, tick))

    for tick, boot in ((5, 0), (5, 0), (4, 0), (6, 0), (1, 1), (7, 0), (2, 1)):  # it starts again; 7 was under way
        says(tick, boot)
    says(9, sender=1)  # its own
    robot.tick()
    assert (robot.heard, robot.stale, robot.refused) == (4, 3, 0)
    says(65535, boot=1)  # older by three: the count begins again at 65536
    robot.tick()
    assert robot.stale == 4
    robot.ticks += runtime.FORGET
    says(65535, boot=1)  # after so long a silence nobody knows
    robot.tick()
    assert robot.heard == 5
    for sender in range(100, 200):
        says(1, sender=sender)
    for _ in range(4):
        robot.tick()
    assert robot.heard == 105
    assert len(robot.senders) == runtime.SENDERS


class Bad:
    """A sensor and a radio whose methods raise, or give what they should not."""

    def __init__(self, *answers):
        self.answers = itertools.cycle(answers)
        self.starts = 0

    def start(self):
        self.starts += 1

    def read(self):
        answer = next(self.answers)
        if isinstance(answer, type):
            raise answer("a loose wire")
        return answer

    receive = read

    def send(self, datagram):
        self.read()


def test_a_sensor_that_raises_is_started_again():
    robot = robot_of()
    robot.sensor = Bad(True, OSError, ValueError, None, False)
    for _ in range(50):
        robot.tick()
    assert (robot.sensor_faults, robot.sensor.starts) == (20, 21)
    assert robot.me.v == pytest.approx(0.7**2 * 20)  # the other twenty readings


def test_a_radio_that_raises_or_gives_rubbish_stops_nothing():
    robot = robot_of(readings=itertools.repeat(True))
    robot.radio = Bad(OSError, "text", 5, b"", bytes(11), None, [1.5] * 11, MemoryError, bytearray(12))
    for _ in range(90):
        robot.tick()
    assert robot.ticks == 90
    assert robot.radio_faults > 20
    assert robot.refused > 20
    assert robot.me.v == pytest.approx(0.7**2 * 90)


def test_a_slow_radio_costs_ticks_but_no_more():
    clock = Clock()

    class Slow(Bad):
        def receive(self):
            clock.now += 30
            return messages_of(COMMONS).pack((1.0, 2.0), 0, 2, clock.now)

    robot = robot_of(clock=clock, period=100)  # messages are read for 50 ms
    robot.radio = Slow(None)
    waits = []
    for _ in range(10):
        waits.append(robot.poll())
        clock.now += waits[-1]
    assert waits == [40] * 10
    assert (robot.heard, robot.missed, robot.ticks) == (20, 0, 10)
    clock.now += 1050  # somebody else's work
    robot.poll()
    assert (robot.missed, robot.ticks) == (10, 11)
    clock.now = runtime.WRAP - 120 - clock.now % 100
    robot.poll()
    for _ in range(5):  # the clock begins again
        before = robot.ticks
        clock.now = (clock.now + robot.poll()) & runtime.WRAP
        assert robot.ticks <= before + 1
    clock.now = 0
    assert robot.poll() <= 100


POISON = """
MEMORY = {"x": 0.5, "v": (0.0, 0.0)}
MESSAGE = ("x",)
def observe(me, blacks, looks):
    me.v[0] += looks
def broadcast(me):
    return (me.x,)
def receive(me, message):
    me.v[1] += 1.0
    me.x = 1.0 / message[0]
    me.v[0] = message[0] * 1e300 * 1e300 if message[0] == 2.0 else me.v[0]
def fuse(me):
    me.v[1] = 0.0
def estimate(me):
    return me.x
"""


def test_a_call_that_fails_is_undone_whole(tmp_path):
    brain, air = brains.parse(POISON, "poison", tmp_path / "poison.py"), Air()
    robot = robot_of(brain, readings=itertools.repeat(True), radio=air.radio(), message="float32")
    other = messages_of(brain, "float32")
    for tick, x in enumerate((4.0, 0.0, 2.0), 1):
        air.boxes[0].append(other.pack((x,), 0, 2, tick))
    robot.tick()
    assert (robot.undone, robot.heard, robot.numbers()) == (1, 3, [math.inf, 0.0, 0.5]), "infinity stays, as in C"


@pytest.mark.parametrize("name", ["commons", "sure", "bayes-cpf"])
def test_memory_and_debts_survive_the_power(tmp_path, name):
    brain, file = brains.load(name), str(tmp_path / "memory")
    readings = [random.Random(1).random() < 0.4 for _ in range(60)]
    robot, lives = (robot_of(brain, readings=list(readings)) for _ in range(2))
    robot.keep(file, 10)
    for _ in range(30):
        robot.tick()
    again = robot_of(brain, readings=readings[30:])
    again.keep(file, 10)
    assert (robot.boot, again.boot, again.ticks) == (0, 1, 30)
    for boot, lost in enumerate((".boot", ".boot2"), 2):  # one of the two files is enough
        os.remove(file + lost)
        once_more = robot_of(brain)
        once_more.keep(file, 10)
        assert once_more.boot == boot
    for _ in range(30):
        again.tick()
    for _ in range(60):
        lives.tick()
    assert again.numbers() == lives.numbers()
    assert again.messages.owed == lives.messages.owed


def test_a_file_cut_anywhere_is_found_out(tmp_path):
    file = tmp_path / "memory"
    robot = robot_of(readings=itertools.repeat(True))
    robot.keep(str(file), 1)
    robot.tick()
    whole = file.read_bytes()
    for boot, cut in enumerate([*range(0, len(whole), 5), len(whole) - 1, None], 1):
        file.write_bytes(whole[:cut] if cut is not None else whole[:9] + b"?" + whole[10:])
        again = robot_of()
        again.keep(str(file), 1)
        assert (again.boot, again.ticks, again.me.v) == (boot, 0, 0.0)
    file.write_bytes(whole)
    foreign = runtime.Robot(COMMONS.functions, messages_of(COMMONS, mark=1), None, None, Clock(), 0.9, 0.8, 1)
    foreign.keep(str(file), 1)
    assert foreign.ticks == 0  # the memory of another brain


def test_power_cuts_between_writing_and_renaming(tmp_path, monkeypatch):
    file = str(tmp_path / "memory")
    robot = robot_of(readings=itertools.repeat(True))
    robot.keep(file, 1)
    robot.tick()
    with monkeypatch.context() as patch:
        patch.setattr(os, "rename", lambda *_: (_ for _ in ()).throw(OSError("the power is cut")))
        robot.tick()
    assert robot.file_faults == 1
    again = robot_of()
    again.keep(file, 1)
    assert (again.ticks, again.boot) == (2, 1)  # the newer of two whole files
    again.file = str(tmp_path / "missing" / "memory")
    again.save()
    assert again.file_faults == 1


def fuzz(datagrams, seed):
    """A robot that hears random, changed, cut and repeated datagrams, and what it had before the last of them."""
    air, random_ = Air(), random.Random(seed)
    robot = robot_of(radio=air.radio(), readings=itertools.cycle([True, False, True, None]))
    other = messages_of(COMMONS)
    good = [other.pack((random_.random() * k, 1.0 * k), 1, 2 + k % 30, k) for k in range(1, 200)]
    for k in range(datagrams):
        kind = k % 4
        if kind == 0:
            data = random_.randbytes(random_.randrange(0, 30))
        elif kind == 1:
            data = random_.randbytes(other.size)
        else:
            data = bytearray(random_.choice(good))
            data[random_.randrange(len(data))] ^= random_.randrange(1, 256)
            data = bytes(data[: random_.randrange(len(data))] if kind == 2 else data)
        air.boxes[0].append(data)
        if k % 30 == 29:
            robot.tick()
    return robot


@pytest.mark.long(but=["2000"])
@pytest.mark.parametrize("datagrams", [2000, 100_000])
def test_noise_changes_nothing(untraced, datagrams):
    """No exception leaves, memory is flat, and the state is as if nothing had been heard."""
    fuzz(1000, 0)
    gc.collect()
    tracemalloc.start()
    begun = tracemalloc.get_traced_memory()[0]
    robot = fuzz(datagrams, 1)
    gc.collect()
    assert tracemalloc.get_traced_memory()[0] - begun < 20_000
    tracemalloc.stop()
    quiet = robot_of(readings=itertools.cycle([True, False, True, None]))
    for _ in range(robot.ticks):
        quiet.tick()
    assert robot.heard == 0, "one in 4 billion random datagrams has the right checksum"
    assert robot.refused > 0.999 * datagrams - 32
    assert robot.numbers() == quiet.numbers()
    assert robot.estimate == quiet.estimate
    assert robot.undone == 0


@pytest.mark.parametrize("format_", ["float32", "ratio8"])
@pytest.mark.parametrize("name", [name for name in brains.shipped() if name != "oracle"])
def test_forged_messages_leave_a_robot_that_works(name, format_):
    """Whoever knows the format can say anything: the estimate stays one, and the robot goes on or starts again.

    Of every brain, because each could be brought out of its numbers in a way of its own.
    """
    brain, air, random_ = brains.load(name), Air(), random.Random(2)
    readings = (random_.random() < 0.8 for _ in itertools.count())
    robot = robot_of(brain, radio=air.radio(), message=format_, readings=readings, draws=random_.random)
    forged = messages_of(brain, format_)
    for tick in range(1, 61):
        for sender in range(2, 5):
            body = random_.randbytes(forged.body)
            data = struct.pack("<BBHH", forged.mark & 0xFF, 0, sender, tick) + body
            air.boxes[0].append(data + struct.pack("<I", crc32(data, forged.mark)))
        robot.tick()
        assert 0.0 <= robot.estimate <= 1.0
        assert all(map(math.isfinite, robot.numbers()))
    assert robot.heard > 100
    assert robot.stuck < runtime.PATIENCE


def test_a_state_that_no_round_can_end_starts_blank(tmp_path):
    brain = brains.parse(POISON.replace("me.v[1] = 0.0", "me.v[0] /= me.v[0] - 3.0"), "poison", tmp_path / "poison.py")
    robot = robot_of(brain, readings=itertools.chain([True], NOTHING), message="float32")
    robot.me.v[0] = 2.0
    for tick in range(1, runtime.PATIENCE + 2):
        assert robot.blanked == (tick > runtime.PATIENCE)
        robot.tick()
    assert robot.numbers() == [0.0, 0.0, 0.5]


@pytest.mark.parametrize("wrong", ["2.0", "float('nan')", "1.0 / (me.v[0] - 1.0)", "(me.v[0] - 2.0) ** 0.5"])
def test_a_state_without_an_estimate_in_0_to_1_starts_blank(wrong, tmp_path):
    source = POISON.replace("    return me.x\n", f"    return {wrong} if me.v[0] == 1.0 else me.x\n")
    brain = brains.parse(source, "poison", tmp_path / "poison.py")
    robot = robot_of(brain, readings=itertools.repeat(True), message="float32")
    robot.me.x = 0.75
    robot.tick()
    assert (robot.estimate, robot.blanked, robot.undone, robot.numbers()) == (0.5, 1, 0, [0.0, 0.0, 0.5])
