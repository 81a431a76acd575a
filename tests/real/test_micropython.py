"""Brains and the runtime on a real MicroPython, beside CPython: the same bits, or 1e-12 where exp or log is used.

The board is MicroPython's WebAssembly package on Node, with 8-byte floats.
"""

import contextlib
import io

import pytest

from swarmcensus import brains
from swarmcensus.runtime import runtime
from swarmcensus.translation import selftest
from tests.support.bit_differences import compare
from tests.support.boards import messages_of, needs_micropython, on_board, robot_files

pytestmark = needs_micropython
CLOSE = 1e-12


@pytest.mark.long(but=["commons", "sure"])
@pytest.mark.parametrize("name", brains.shipped())
def test_brains_are_the_same_to_the_bit(benchmark, name):
    machines = benchmark("machines")
    brain = machines.in_numbers(brains.load(name), "double")
    difference = compare(selftest.expected(brain), machines.on_micropython(brain))
    assert difference.line == 0 if selftest.is_exact(brain) else difference.largest < CLOSE


RUNTIME = """
import gc
from binascii import hexlify
import struct
import brain
import runtime

LENGTHS, PLAN, CHECKED = {settings}


class Ear:
    def __init__(self):
        self.box = []
        self.others = []

    def send(self, datagram):
        for other in self.others:
            other.box.append(datagram)

    def receive(self):
        return self.box.pop(0) if self.box else None


class Sensor:
    def __init__(self, state):
        self.state = state

    def start(self):
        pass

    def read(self):
        self.state = (self.state * 75 + 74) % 65537
        return None if self.state % 7 == 0 else self.state < 40000


ears = [Ear(), Ear()]
ears[0].others, ears[1].others = [ears[1]], [ears[0]]
robots = [
    runtime.Robot(
        brain, runtime.Messages(LENGTHS, PLAN, 0xBEEF, CHECKED), Sensor(k + 5), ears[k], lambda: 0, 0.9, 0.8, k
    )
    for k in (0, 1)
]
robots[0].keep(FOLDER + "memory", 50)
state = 1
good = None
STEPS = 6
steps = []


def step():
    # a hundred ticks; the last step tells
    global state, good
    steps.append(gc.mem_alloc() if hasattr(gc, "mem_alloc") else 0)
    if len(steps) == STEPS:
        return tell()
    for tick in range(100):
        for robot in robots:
            robot.tick()
        good = ears[0].box[-1]
        for k in range(NOISE):  # noise, changed and cut datagrams
            data = bytearray(good)
            state = (state * 75 + 74) % 65537
            data[state % len(data)] ^= 1 + state % 255
            ears[k % 2].box.append(bytes(data) if k % 3 else bytes(data[: state % len(data)]))
    gc.collect()


def tell():
    print("grown", steps[-1] - steps[-3])
    again = runtime.Robot(
        brain, runtime.Messages(LENGTHS, PLAN, 0xBEEF, CHECKED), Sensor(5), Ear(), lambda: 0, 0.9, 0.8, 0
    )
    again.keep(FOLDER + "memory", 50)
    for robot in robots + [again]:
        print(hexlify(struct.pack(">" + "d" * len(robot.numbers()), *robot.numbers())).decode())
        print(robot.status())
    print(hexlify(good).decode())
"""


@pytest.mark.long(but=["commons-ratio16"])
@pytest.mark.parametrize("format_", ["float32", "ratio16", "ratio8"])
@pytest.mark.parametrize("name", ["commons", "bayes-cpf"])
def test_two_runtimes_hear_each_other_through_noise(tmp_path, name, format_):
    """Datagrams, states and counts of a board are those of CPython; its heap is flat, and its file is read again."""
    brain = brains.load(name)
    messages = messages_of(brain, format_)
    settings = repr((messages.lengths, tuple(tuple(part) for part in messages.plan), True))
    main = RUNTIME.replace("{settings}", settings).replace("NOISE", "10")
    files = robot_files() | {"brain.py": brain.source, "main.py": main.replace("FOLDER", "'/'")}
    grown, *there = on_board(tmp_path, files).splitlines()
    assert abs(int(grown.split()[1])) < 4096
    modules = {"brain": brain.functions, "runtime": runtime}
    code = main.replace("FOLDER", repr(f"{tmp_path}/")).replace("import brain\nimport runtime\n", "")
    with contextlib.redirect_stdout(io.StringIO()) as here:
        exec(code + "for _ in range(STEPS):\n    step()\n", modules)
    _, *expected = here.getvalue().splitlines()
    assert there[1::2] == expected[1::2]
    assert "refused 2495" in there[1]
    if selftest.is_exact(brain):
        assert there == expected
