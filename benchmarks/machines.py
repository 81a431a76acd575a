"""Every shipped brain on six machines: python benchmarks/machines.py [QUESTION] [--quick].

CPython, machine code (Numba), MicroPython, C on this machine, a simulated ATmega328P and a simulated Cortex-M4F.
"""

import multiprocessing
import sys
import tempfile
import time
import types
from pathlib import Path

import harness
import numba
import numpy as np
from avr import DRAWS, NUMBERS
from single_lives import blank_state, exchange, machine_code

from swarmcensus.brains import load
from swarmcensus.brains.brain import shipped
from swarmcensus.brains.contract import FUNCTIONS, MAY_HAVE
from swarmcensus.brains.packing import Numbers
from swarmcensus.robots import chips
from swarmcensus.robots.folders import write_texts
from swarmcensus.robots.micropython_files import micropython_files
from swarmcensus.robots.target import Order, order_of
from swarmcensus.robots.targets import find
from swarmcensus.robots.targets.c import translated
from swarmcensus.runtime import history
from swarmcensus.translation import selftest
from swarmcensus.translation.headers import header
from swarmcensus.translation.messages import codec

sys.path.insert(0, str(harness.ROOT))
from tests.support import hosts, on_node
from tests.support.bit_differences import compare

BITS = ("machine code", "MicroPython", "C in double", "C in float", "ATmega328P", "Cortex-M4F")
COSTS = (
    "memory (bytes)", "message in ratio16 (bytes)", "message in float32 (bytes)", "code in MicroPython (bytes)",
    "CPython (µs)", "machine code (µs)", "C (µs)",
)  # fmt: skip
TICKS = 200  # on computers
ON_AVR = 17  # rounds in an ATmega, which is slow to simulate
LIVES = 5  # of which the fastest counts
NOT_TRIED = "not tried"


def first_rounds(text, rounds):
    """The part of a self-test's output that is about its first rounds."""
    return "".join(line for line in text.splitlines(keepends=True) if int(line.split()[0]) <= rounds)


def needed():
    """What each machine lacks here, as text; empty if it lacks nothing."""
    node = "" if on_node.micropython() else on_node.NEEDED
    return {
        "MicroPython": node,
        "C": ", ".join(chips.missing(("gcc",))),
        "ATmega328P": ", ".join(chips.missing(hosts.AVR)),
        "Cortex-M4F": ", ".join(chips.missing(hosts.CORTEX)),
    }


def in_numbers(brain, precision):
    """The brain with small messages; with float32 if functions such as exp may change a last digit, so a code too."""
    return brain.with_numbers(Numbers(precision, NUMBERS.message if selftest.is_exact(brain) else "float32"))


class State:
    """A state of machine code, with its fields as attributes: those of NumPy's records have other meanings for some."""

    def __init__(self, record):
        self.__dict__["record"] = record

    def __getattr__(self, name):
        return self.record[name]

    def __setattr__(self, name, value):
        self.record[name] = value


def on_states(function):
    """A function of machine code that takes a `State`; vectors that it returns are tuples, as in CPython."""

    def call(me, *given):
        made = function(me.record, *given)
        is_tuple = isinstance(made, tuple)
        return tuple(tuple(x.tolist()) if isinstance(x, np.ndarray) else x for x in made) if is_tuple else made

    return call


def in_machine_code(brain):
    states = [State(blank_state(brain, b, w, float(i))[0]) for i, (b, w) in enumerate(history.ACCURACIES)]
    space = machine_code(brain.functions)
    functions = {name: on_states(space[name]) for name in (*FUNCTIONS, *MAY_HAVE) if name in space}
    codes = types.SimpleNamespace(**machine_code(codec(False)[3]))
    return selftest.lived(brain, types.SimpleNamespace(**functions), states, codes)


def on_micropython(brain):
    """What the self-test of a board prints."""
    texts = micropython_files(Order(brain, find("udp"), "udp", 0.9, 0.9, 10.0, None))
    with tempfile.TemporaryDirectory() as folder:
        printed = hosts.on_board(Path(folder), texts | {"main.py": "import selftest"})
    return "".join(line for line in printed.splitlines(keepends=True) if line[0].isdigit())


def told(wanted, found, rounds=history.ROUNDS):
    """What a cell says of a machine's output."""
    difference = compare(first_rounds(wanted, rounds), found)
    if not difference.line:
        return "same bits"
    return f"{difference.largest:.0e}" if difference.largest else "messages differ"


def bits(name):
    """A row of the first table."""
    brain, absent = load(name), needed()
    cells = dict.fromkeys(BITS, NOT_TRIED)
    double, single = (in_numbers(brain, precision) for precision in ("double", "single"))
    wanted, wanted_single = selftest.expected(double), selftest.expected(single)
    cells["machine code"] = told(wanted, in_machine_code(double))
    if not absent["MicroPython"]:
        cells["MicroPython"] = told(wanted, on_micropython(double))
    with tempfile.TemporaryDirectory() as folder:
        write_texts(Path(folder), translated(double))
        if not absent["C"]:
            cells["C in double"] = told(wanted, hosts.on_host(Path(folder) / "selftest.c"))
    with tempfile.TemporaryDirectory() as folder:
        write_texts(Path(folder), translated(single))
        source = Path(folder) / "selftest.c"
        if not absent["C"]:
            cells["C in float"] = told(wanted_single, hosts.on_host(source))
        if not absent["ATmega328P"]:
            cells["ATmega328P"] = told(wanted_single, hosts.selftest_on_avr(source, ON_AVR), ON_AVR)
        if not absent["Cortex-M4F"]:
            cells["Cortex-M4F"] = told(wanted_single, hosts.on_cortex(source))
    return [cells[column] for column in BITS]


def in_cpython(brain):
    """Microseconds a tick in CPython."""
    call, is_random = brain.functions, brain.uses.luck

    def life():
        me = brain.robot(0.9, 0.8, 1.0)
        begun = time.perf_counter()
        for tick in range(TICKS):
            if is_random:
                me.luck = (tick % DRAWS + 0.5) / DRAWS
            call.observe(me, 1.0 if tick * 5 % 8 < 3 else 0.0, 1.0)
            said = call.broadcast(me)
            if said is not None:
                call.receive(me, said)
                call.receive(me, said)
            call.fuse(me)
            call.estimate(me)
        return time.perf_counter() - begun

    return 1e6 / TICKS * min(life() for _ in range(LIVES))


def as_machine_code(brain):
    """Microseconds a tick as machine code."""
    space = machine_code(brain.functions)
    observe, fuse, estimate = space["observe"], space["fuse"], space["estimate"]
    hear, draw = exchange(brain, space, 2)

    @numba.njit
    def live(states):
        total = 0.0
        for k in range(states.size):
            me = states[k]
            for tick in range(TICKS):
                draw(me, (tick % DRAWS + 0.5) / DRAWS)
                observe(me, 1.0 if tick * 5 % 8 < 3 else 0.0, 1.0)
                hear(me)
                fuse(me)
                total += estimate(me)
        return total

    def life():
        states = np.repeat(blank_state(brain, 0.9, 0.8, 1.0), 50)
        begun = time.perf_counter()
        live(states)
        return (time.perf_counter() - begun) / states.size

    life()  # compiles
    return 1e6 / TICKS * min(life() for _ in range(LIVES))


TIMED = """\
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <time.h>
#include "brain.h"

static volatile number timed_belief;

static double timed_seconds(void) {{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}}

static void __attribute__((noinline)) timed_live(struct brain *me, int tick) {{
    struct message said;
    {draws}
    observe(me, tick * 5 % 8 < 3 ? 1 : 0, 1);
    if (broadcast(me, &said)) {{
        receive(me, &said);
        receive(me, &said);
    }}
    fuse(me);
    timed_belief = estimate(me);
}}

int main(void) {{
    static struct brain me;
    double least = 1e9;
    for (int k = 0; k < 100; k++) {{
        brain_start(&me, 0.9, 0.8{name});
        const double begun = timed_seconds();
        for (int tick = 0; tick < {ticks}; tick++) {{
            timed_live(&me, tick);
        }}
        const double spent = timed_seconds() - begun;
        least = spent < least ? spent : least;
    }}
    printf("%.9g", least);
    return 0;
}}
"""


def in_c(brain):
    """Microseconds a tick as C in double precision on this machine."""
    text = TIMED.format(
        name=", 1" if brain.uses.name else "",
        ticks=TICKS,
        draws=f"me->luck = (tick % {DRAWS} + 0.5) / {DRAWS};" if brain.uses.luck else "",
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "brain.h").write_text(header(brain))
        (Path(folder) / "timed.c").write_text(text)
        return 1e6 / TICKS * float(hosts.on_host(Path(folder) / "timed.c"))


def two_digits(x):
    return f"{x:.0f}" if x >= 10.0 else f"{x:.2g}"


def costs(name):
    """A row of the second table."""
    brain, absent = load(name), needed()
    cells = dict.fromkeys(COSTS, NOT_TRIED)
    small = brain.with_numbers(NUMBERS)
    cells["memory (bytes)"] = str(small.memory_bytes)
    cells["message in ratio16 (bytes)"] = str(small.message_bytes)
    cells["message in float32 (bytes)"] = str(brain.with_numbers(NUMBERS._replace(message="float32")).message_bytes)
    cells["CPython (µs)"] = two_digits(in_cpython(brain))
    cells["machine code (µs)"] = two_digits(as_machine_code(brain))
    if not absent["MicroPython"]:
        cells["code in MicroPython (bytes)"] = str(measured(brain)[0])
    if not absent["C"]:
        cells["C (µs)"] = two_digits(in_c(brain.with_numbers(Numbers("double", "float32"))))
    return [cells[column] for column in COSTS]


def row(name):
    begun = time.perf_counter()
    both = bits(name), costs(name)
    print(f"{name}: {time.perf_counter() - begun:.0f} s", flush=True)
    return both


@harness.question
def machines(*brains, write=False, quick=False):
    """The same six robots for 300 rounds on each: where numbers differ from CPython's, and what a brain costs.

    A machine without its tools is not tried: tools/install-chips.sh installs those of chips, MICROPYTHON_MODULES names
    the folder of MicroPython's package. Four minutes on two cores.
    """
    names = brains or (["commons"] if quick else shipped())
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        found = pool.map(row, names, chunksize=1)
    for k, (table, heads) in enumerate((("machines-bits", BITS), ("machines-costs", COSTS))):
        rows = [[name, *both[k]] for name, both in zip(names, found, strict=True)]
        print(harness.markdown(["brain", *heads], rows))
        if write:
            harness.write_csv(table, ["brain", *heads], rows)
    print("\n".join(f"Not tried: {machine}, which needs {what}." for machine, what in needed().items() if what))


# ---- MicroPython


BRAIN = """
import gc
import time

STEPS = 5
sizes = []


class Me:
    pass


def tick():
    for name in DRAWS:
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
        return hosts.on_board(Path(folder), files).split()


def measured(brain):
    """The bytes of code and of a state, the garbage of a tick, and its microseconds."""
    source = BRAIN.replace("DRAWS", "(1,)" if brain.uses.luck else "()")
    code, state, garbage, spent = run({"brain.py": brain.source, "main.py": source})
    return int(code), int(state), int(garbage), float(spent)


@harness.question(unasked=False)
def micropython(*names, quick=False):
    """On MicroPython: bytes of a brain's code and of a robot's memory, the garbage of a tick, and its microseconds.

    On its WebAssembly package with Node, which has 4-byte pointers and 8-byte floats: bytes are about those of a 32-bit
    board, times are this machine's. The last lines are of the runtime and the codec.
    """
    if on_node.micropython() is None:
        sys.exit(f"needs {on_node.NEEDED}")
    heads = ("brain", "code, bytes", "memory, bytes", "garbage a tick, bytes", "a tick, us")
    table = harness.table(None, *heads)
    for name in names or (["commons"] if quick else shipped()):
        brain = load(name)
        if brain.is_oracle:
            continue
        *sizes, spent = measured(brain)
        table.add_row(name, *(f"{x:,}" for x in sizes), f"{spent:.0f}")
    order = order_of(load("commons"), "udp", find("udp"), accuracy={"black": 0.9, "white": 0.8}, message="ratio16")
    files = micropython_files(order)
    _, codec, runtime, robot = run(files | {"main.py": RUNTIME})
    for name, size in (("codec.py", codec), ("runtime.py", runtime), ("a robot of commons", robot)):
        table.add_row(name, f"{int(size):,}")
    harness.show(table)


if __name__ == "__main__":
    harness.answer(globals())
