"""Every shipped brain on six machines: python benchmarks/machines.py [--write] [BRAIN ...].

The same six robots live the same 300 rounds in CPython, as machine code (Numba), on MicroPython, as C on this machine,
on a simulated ATmega328P (17 rounds) and on a simulated Cortex-M4F. A first table tells where numbers differ from those
of CPython, a second one what a brain costs on each. With --write they go into docs/six-machines.md. A machine whose
tools are absent is not tried: tools/install-chips.sh installs those of chips, MICROPYTHON_MODULES names the folder of
MicroPython's package. Four minutes on two cores.
"""

import argparse
import multiprocessing
import tempfile
import time
import types
from pathlib import Path

import micropython
import numba
import numpy as np

from swarmcensus.brains import load
from swarmcensus.brains.brain import shipped
from swarmcensus.brains.contract import FUNCTIONS, MAY_HAVE
from swarmcensus.brains.packing import Numbers
from swarmcensus.conformance.machine import blank_mind, exchange, machine_code
from swarmcensus.deployment import chips, on_node, selftest
from swarmcensus.deployment.costs import LUCKY, NUMBERS, TICKS, cost
from swarmcensus.deployment.folders import write_texts
from swarmcensus.deployment.header import header
from swarmcensus.deployment.messages import codec
from swarmcensus.deployment.targets.c import translated
from swarmcensus.robot import codec as codec_file
from swarmcensus.robot import history, runtime

PAGE = Path(__file__).parents[1] / "docs" / "six-machines.md"
BITS = ("machine code", "MicroPython", "C, `double`", "C, `float`", "ATmega328P", "Cortex-M4F")
COSTS = (
    "memory, bytes", "message, bytes", "flash, bytes", "RAM, bytes", "MicroPython, bytes", "CPython, µs",
    "machine code, µs", "C, µs", "ATmega328P, cycles",
)  # fmt: skip
ON_AVR = 17  # rounds in an ATmega, which is slow to simulate
LIVES = 5  # of which the fastest counts
NOT_TRIED = "not tried"


def needed():
    """What each machine lacks here, as text; empty if it lacks nothing."""
    node = "" if on_node.micropython() else on_node.NEEDED
    return {
        "MicroPython": node,
        "C": ", ".join(chips.missing(("gcc",))),
        "ATmega328P": ", ".join(chips.missing(chips.AVR)),
        "Cortex-M4F": ", ".join(chips.missing(chips.CORTEX)),
    }


def in_numbers(brain, precision):
    """The brain with small messages; with float32 if functions such as exp may change a last digit, so a code too."""
    return brain.with_numbers(Numbers(precision, NUMBERS.message if selftest.is_exact(brain) else "float32"))


class Mind:
    """A mind of machine code, with its fields as attributes: those of NumPy's records have other meanings for some."""

    def __init__(self, record):
        self.__dict__["record"] = record

    def __getattr__(self, name):
        return self.record[name]

    def __setattr__(self, name, value):
        self.record[name] = value


def on_minds(function):
    """A function of machine code that takes a `Mind`; vectors that it returns are tuples, as in CPython."""

    def call(me, *given):
        made = function(me.record, *given)
        is_tuple = isinstance(made, tuple)
        return tuple(tuple(x.tolist()) if isinstance(x, np.ndarray) else x for x in made) if is_tuple else made

    return call


def in_machine_code(brain):
    minds = [Mind(blank_mind(brain, b, w, float(i))[0]) for i, (b, w) in enumerate(history.ACCURACIES)]
    space = machine_code(brain.functions)
    functions = {name: on_minds(space[name]) for name in (*FUNCTIONS, *MAY_HAVE) if name in space}
    codes = types.SimpleNamespace(**machine_code(codec(False)[3]))
    return selftest.lived(brain, types.SimpleNamespace(**functions), minds, codes)


BOARD = """
import brain
from history import ACCURACIES, live
from runtime import Messages


class Me:
    pass


minds = []
for i, (b, w) in enumerate(ACCURACIES):
    me = Me()
    for fields in (brain.MEMORY, getattr(brain, "PARAMETERS", {{}})):
        for name, value in fields.items():
            setattr(me, name, list(value) if isinstance(value, tuple) else 1.0 * value)
    me.b, me.w, me.name = b, w, 1.0 * i
    minds.append(me)
radios = [Messages({lengths}, {plan}, 0, False) for _ in minds]
for line in live(brain, minds, radios, {fields}, {owed}, {lucky}, False):
    print(line)
"""


def on_micropython(brain):
    main = BOARD.format(
        lengths=list(brain.message.values()),
        plan=[tuple(part) for part in brain.parts],
        fields=list(brain.memory),
        owed=selftest.owed_places(brain),
        lucky=brain.uses.luck,
    )
    files = {f"{module.__name__.split('.')[-1]}.py": Path(module.__file__) for module in (codec_file, history, runtime)}
    texts = {name: path.read_text(encoding="utf-8") for name, path in files.items()}
    with tempfile.TemporaryDirectory() as folder:
        return on_node.on_board(Path(folder), texts | {"brain.py": brain.source, "main.py": main})


def told(wanted, found, rounds=history.ROUNDS):
    """What a cell says of a machine's output."""
    difference = selftest.compare(selftest.first_rounds(wanted, rounds), found)
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
            cells["C, `double`"] = told(wanted, chips.on_host(Path(folder) / "selftest.c"))
    with tempfile.TemporaryDirectory() as folder:
        write_texts(Path(folder), translated(single))
        source = Path(folder) / "selftest.c"
        if not absent["C"]:
            cells["C, `float`"] = told(wanted_single, chips.on_host(source))
        if not absent["ATmega328P"]:
            cells["ATmega328P"] = told(wanted_single, chips.selftest_on_avr(source, ON_AVR), ON_AVR)
        if not absent["Cortex-M4F"]:
            cells["Cortex-M4F"] = told(wanted_single, chips.on_cortex(source))
    return [cells[column] for column in BITS]


def in_cpython(brain):
    """Microseconds a tick in CPython."""
    call, lucky = brain.functions, brain.uses.luck

    def life():
        me = brain.robot(0.9, 0.8, 1.0)
        begun = time.perf_counter()
        for tick in range(TICKS):
            if lucky:
                me.luck = (tick % LUCKY + 0.5) / LUCKY
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
    hear, lucky = exchange(brain, space, 2)

    @numba.njit
    def live(minds):
        total = 0.0
        for k in range(minds.size):
            me = minds[k]
            for tick in range(TICKS):
                lucky(me, (tick % LUCKY + 0.5) / LUCKY)
                observe(me, 1.0 if tick * 5 % 8 < 3 else 0.0, 1.0)
                hear(me)
                fuse(me)
                total += estimate(me)
        return total

    def life():
        minds = np.repeat(blank_mind(brain, 0.9, 0.8, 1.0), 50)
        begun = time.perf_counter()
        live(minds)
        return (time.perf_counter() - begun) / minds.size

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
    {luck}
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
        luck=f"me->luck = (tick % {LUCKY} + 0.5) / {LUCKY};" if brain.uses.luck else "",
    )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "brain.h").write_text(header(brain))
        (Path(folder) / "timed.c").write_text(text)
        return 1e6 / TICKS * float(chips.on_host(Path(folder) / "timed.c"))


def two_digits(x):
    return f"{x:.0f}" if x >= 10.0 else f"{x:.2g}"


def costs(name):
    """A row of the second table."""
    brain, absent = load(name), needed()
    cells = dict.fromkeys(COSTS, NOT_TRIED)
    small = brain.with_numbers(NUMBERS)
    cells["memory, bytes"] = f"{small.memory_bytes:,}"
    whole = brain.with_numbers(NUMBERS._replace(message="float32"))
    cells["message, bytes"] = f"{small.message_bytes} of {whole.message_bytes}"
    cells["CPython, µs"] = two_digits(in_cpython(brain))
    cells["machine code, µs"] = two_digits(as_machine_code(brain))
    if not absent["MicroPython"]:
        cells["MicroPython, bytes"] = f"{micropython.measured(brain)[0]:,}"
    if not absent["C"]:
        cells["C, µs"] = two_digits(in_c(brain.with_numbers(Numbers("double", "float32"))))
    if not absent["ATmega328P"]:
        one = cost(brain)
        cells["flash, bytes"], cells["RAM, bytes"] = f"{one.coded_flash:,}", f"{one.ram:,}"
        cells["ATmega328P, cycles"] = f"{one.cycles:,}"
    return [cells[column] for column in COSTS]


def row(name):
    begun = time.perf_counter()
    both = bits(name), costs(name)
    print(f"{name}: {time.perf_counter() - begun:.0f} s", flush=True)
    return both


def table(columns, names, rows, align):
    head = f"| brain | {' | '.join(columns)} |\n|---|{align * len(columns)}"
    return "\n".join([head, *(f"| `{name}` | {' | '.join(one)} |" for name, one in zip(names, rows, strict=True))])


def page_with(text, what, new):
    """The page with another table between the comments that name `what`."""
    begin, end = f"<!-- {what}: python benchmarks/machines.py --write -->", f"<!-- end of {what} -->"
    before, _, rest = text.partition(begin)
    return f"{before}{begin}\n\n{new}\n\n{end}{rest.partition(end)[2]}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="put the tables into docs/six-machines.md")
    parser.add_argument("brains", nargs="*", metavar="BRAIN", help="a name or a file (default: all shipped brains)")
    options = parser.parse_args()
    names = options.brains or shipped()
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        rows = pool.map(row, names, chunksize=1)
    same = table(BITS, names, [one for one, _ in rows], "---|")
    spent = table(COSTS, names, [one for _, one in rows], "--:|")
    absent = "".join(f"\n\nNot tried: {machine}, which needs {what}." for machine, what in needed().items() if what)
    print(f"{same}{absent}\n\n{spent}")
    if options.write:
        text = page_with(PAGE.read_text(encoding="utf-8"), "bits", same + absent)
        PAGE.write_text(page_with(text, "costs", spent), encoding="utf-8")


if __name__ == "__main__":
    main()
