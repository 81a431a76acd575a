"""Brains and the runtime on a real MicroPython, beside CPython: the same bits, or 1e-12 where exp or log is used.

The board is MicroPython's WebAssembly package on Node, with 8-byte floats.
"""

import ast
import contextlib
import io
import math
import struct

import pytest

from swarmcensus import brains
from swarmcensus.runtime import runtime
from tests.support.boards import messages_of, needs_micropython, on_board, robot_files

pytestmark = needs_micropython
EXACT = {"sqrt", "floor", "ceil", "trunc", "frexp", "ldexp", "fabs", "isnan", "isinf", "isfinite", "copysign", "fmod"}
CLOSE = 1e-12

LIFE = '''
"""A swarm of six: losses, luck, all functions of a brain; all numbers of chosen rounds are printed."""

import struct
from binascii import hexlify

PAIRS = ((0.9, 0.8), (0.3, 0.6), (1.0, 1.0), (0.5, 0.5), (0.0, 0.75), (0.75, 0.6))
STOPS = (1, 2, 3, 5, 9, 17, 33, 65, 129, 200, 300)
LOOKS = (1, 10, 0, 3, 1, 2)


class Me:
    pass


class Chance:
    state = 1

    def __call__(self):
        self.state = (self.state * 75 + 74) % 65537
        return (self.state + 0.5) / 65537.0


def told(x):
    if isinstance(x, (tuple, list)):
        return " ".join([told(item) for item in x])
    return "none" if x is None else hexlify(struct.pack(">d", 1.0 * x)).decode()


def state(brain, k):
    me = Me()
    for fields in (brain.MEMORY, getattr(brain, "PARAMETERS", {})):
        for name, value in fields.items():
            setattr(me, name, list(value) if isinstance(value, tuple) else value)
    me.b, me.w = PAIRS[k]
    me.name, me.luck = 1.0 * k, 0.5
    return me


def live(name, brain, rounds):
    chance = Chance()
    chance.state = 1
    states = [state(brain, k) for k in range(6)]
    for number in range(1, rounds + 1):
        said = []
        for k, me in enumerate(states):
            looks = 1000 if number == 100 else LOOKS[(number + k) % 6]
            blacks = 0.0
            for _ in range(min(looks, 10)):
                blacks += chance() < 0.43
            blacks = 0.43 * looks if looks > 10 else blacks
            me.luck = chance()
            if looks and not (hasattr(brain, "done") and brain.done(me)):
                brain.observe(me, blacks, 1.0 * looks)
        for k, me in enumerate(states):
            message = brain.broadcast(me)
            jams = hasattr(brain, "jam") and brain.jam(me)
            if message is None or jams:
                said.append(None)
            else:
                said.append(tuple([tuple(part) if isinstance(part, list) else part for part in message]))
        for k, me in enumerate(states):
            for other in range(6):
                lost = chance() < 0.3
                if other != k and said[other] is not None and not lost:
                    me.luck = chance()
                    brain.receive(me, said[other])
        for k, me in enumerate(states):
            me.luck = chance()
            brain.fuse(me)
            answers = [brain.estimate(me)]
            for function in ("decide", "done", "interval", "steer"):
                if hasattr(brain, function):
                    me.luck = chance()
                    answers.append(getattr(brain, function)(me))
            if number in STOPS:
                fields = sorted(brain.MEMORY)
                print(name, number, k, "said", told(said[k]))
                for field in fields:
                    print(name, number, k, field, told(getattr(me, field)))
                print(name, number, k, "answers", told(answers))
'''


def is_exact(brain):
    """Whether only operations are used whose results IEEE 754 fixes."""
    tree = ast.parse(brain.source)
    called = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute) and node.attr in dir(math)}
    called &= {name for name in dir(math) if callable(getattr(math, name))}
    return called <= EXACT and not any(isinstance(node, ast.Pow) for node in ast.walk(tree))


def numbers(texts):
    return [math.nan if text == "none" else struct.unpack(">d", bytes.fromhex(text))[0] for text in texts]


def compare(names, tmp_path, rounds):
    """Run brains in both places; returns the largest difference of each, relative above 1."""
    files = {"life.py": LIFE} | {f"b_{name.replace('-', '_')}.py": brains.load(name).source for name in names}
    main = "from life import live\n" + "".join(
        f"import {file[:-3]}\nlive({name!r}, {file[:-3]}, {rounds})\n"
        for name, file in zip(names, list(files)[1:], strict=True)
    )
    printed = on_board(tmp_path, files | {"main.py": main}).splitlines()
    space = {}
    exec(LIFE, space)
    with contextlib.redirect_stdout(io.StringIO()) as here:
        for name in names:
            space["live"](name, brains.load(name).functions, rounds)
    expected = here.getvalue().splitlines()
    assert len(printed) == len(expected) > 60 * len(names)
    worst = dict.fromkeys(names, 0.0)
    for there, line in zip(printed, expected, strict=True):
        if there != line:
            name, number, k, field, *values = line.split()
            assert there.split()[:4] == [name, number, k, field]
            for x, y in zip(numbers(there.split()[4:]), numbers(values), strict=True):
                if not (math.isnan(x) and math.isnan(y)):
                    worst[name] = max(worst[name], abs(x - y) / max(1.0, abs(y)))
    return worst


@pytest.mark.long(but=["quick"])
@pytest.mark.parametrize("names", [["commons", "sure"], brains.shipped()], ids=["quick", "all"])
def test_brains_are_the_same_to_the_bit(tmp_path, names):
    worst = compare(names, tmp_path, 300)
    assert {name for name in names if worst[name] > 0.0 and is_exact(brains.load(name))} == set()
    assert {name: x for name, x in worst.items() if x > CLOSE} == {}


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
@pytest.mark.parametrize("format_", ["float32", "float16", "ratio16", "ratio8"])
@pytest.mark.parametrize("name", ["commons", "sure", "bayes-cpf"])
def test_two_runtimes_hear_each_other_through_noise(tmp_path, name, format_):
    """Datagrams, states and counts of a board are those of CPython; its heap is flat, and its file is read again."""
    brain = brains.load(name)
    messages = messages_of(brain, format_)
    plan = tuple(tuple(part) for part in messages.plan)
    settings = repr((messages.lengths, plan, True))
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
    if is_exact(brain):
        assert there == expected
