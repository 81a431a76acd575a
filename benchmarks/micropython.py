"""What brains cost on MicroPython: python benchmarks/micropython.py [BRAIN ...].

Prints, for each brain, the bytes of heap of its code and of a mind, the garbage of a tick, and the microseconds of a
tick (observe, broadcast, two messages, fuse, estimate), on MicroPython's WebAssembly package with Node: 4-byte pointers
and 8-byte floats. Bytes are about those of a 32-bit board; times are this machine's, and say nothing of a board's. The
last lines are of the runtime and the codec. MICROPYTHON_MODULES names the folder with the package.
"""

import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Column, Table

from swarmcensus import brains
from swarmcensus.deployment.micropython_files import micropython_files
from swarmcensus.deployment.on_node import NEEDED, micropython, on_board
from swarmcensus.deployment.target import order_of
from swarmcensus.deployment.targets import find

BRAIN = """
import gc
import time

STEPS = 5
sizes = []


class Me:
    pass


def tick():
    for name in LUCKY:
        me.luck = 0.5
    brain.observe(me, 1.0, 1.0)
    said = brain.broadcast(me)
    if said is not None:
        brain.receive(me, said)
        brain.receive(me, said)
    brain.fuse(me)
    brain.estimate(me)


def step():
    global brain, me
    number = len(sizes)
    sizes.append(gc.mem_alloc())  # garbage was collected before
    if number == 1:
        import brain
    elif number == 2:
        me = Me()
        for fields in (brain.MEMORY, getattr(brain, "PARAMETERS", {})):
            for name, value in fields.items():
                setattr(me, name, list(value) if isinstance(value, tuple) else value + 0.0)
        me.b, me.w, me.name, me.luck = 0.9, 0.8, 1.0, 0.5
    elif number == 3:
        tick()
    elif number == 4:
        begun = gc.mem_alloc()
        tick()
        garbage = gc.mem_alloc() - begun
        begun = time.ticks_us()
        for _ in range(300):
            tick()
        spent = time.ticks_diff(time.ticks_us(), begun) / 300
        print(sizes[2] - sizes[1], sizes[3] - sizes[2], garbage, spent)
    gc.collect()
"""
RUNTIME = """
import gc

STEPS = 5
sizes = []


def step():
    number = len(sizes)
    sizes.append(gc.mem_alloc())
    if number == 1:
        import codec
    elif number == 2:
        import runtime
    elif number == 3:
        import brain
        import settings as s
        from runtime import Messages, Robot

        global robot
        messages = Messages(s.LENGTHS, s.PLAN, s.MARK, s.CHECKED)
        robot = Robot(brain, messages, None, None, lambda: 0, s.B, s.W, 1)
    elif number == 4:
        print(*[after - before for before, after in zip(sizes, sizes[1:])])
    gc.collect()
"""


def run(files):
    with tempfile.TemporaryDirectory() as folder:
        return on_board(Path(folder), files).split()


def measured(brain):
    """The bytes of code and of a mind, the garbage of a tick, and its microseconds."""
    source = BRAIN.replace("LUCKY", "(1,)" if brain.uses.luck else "()")
    code, mind, garbage, spent = run({"brain.py": brain.source, "main.py": source})
    return int(code), int(mind), int(garbage), float(spent)


def main(names):
    if micropython() is None:
        sys.exit(f"needs {NEEDED}")
    heads = ("brain", "code, bytes", "a mind, bytes", "garbage a tick, bytes", "a tick, us")
    table = Table(*heads[:1], *(Column(head, justify="right") for head in heads[1:]))
    for name in names or brains.shipped():
        brain = brains.load(name)
        if brain.is_oracle:
            continue
        *sizes, spent = measured(brain)
        table.add_row(name, *(f"{x:,}" for x in sizes), f"{spent:.0f}")
    order = order_of(brains.load("commons"), "udp", find("udp"), b=0.9, w=0.8, message="ratio16")
    files = micropython_files(order)
    _, codec, runtime, robot = run(files | {"main.py": RUNTIME})
    for name, size in (("codec.py", codec), ("runtime.py", runtime), ("a robot of commons", robot)):
        table.add_row(name, f"{int(size):,}")
    Console().print(table)


if __name__ == "__main__":
    main(sys.argv[1:])
