"""Machines of robots, run here: C on this machine and on simulated chips, MicroPython on Node."""

import json
import re
import subprocess
import textwrap
from pathlib import Path

from swarmcensus.robots.chips import CLOCK, KILOBOT, STRICT, NoRoom, avr_size, for_avr, run
from swarmcensus.support.errors import InputError
from tests.support import on_node

HERE = Path(__file__).parent
HEAP = 64 * 1024 * 1024
SECONDS = 600.0  # before a board is given up
SELFTEST_STACK = 400  # bytes of RAM that a self-test needs besides its robots
AVR = ("avr-gcc", "avr-size", "simavr")
LARGE = "atmega1284p"  # the same core with more of both
FLASH = {KILOBOT: 32768, LARGE: 131072}
RAM = {KILOBOT: 2048, LARGE: 16384}
GREEN = "\x1b[32m"  # what simavr prints before what a chip sends
COLOURS = re.compile(r"\x1b\[[0-9;]*m")
CORTEX = ("arm-none-eabi-gcc", "qemu-system-arm")
CORTEX_FLAGS = (
    "-O2", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "--specs=rdimon.specs",
    "-Wl,--section-start=.vectors=0", "-Wl,-Ttext=0x400", "-Wl,-Tdata=0x20000000",
)  # fmt: skip


def on_host(source):
    """Compile a program, run it here, and return what it prints."""
    program = source.with_suffix("")
    run("gcc", "-O2", "-std=c99", *STRICT, "-o", str(program), str(source), "-lm")
    return run(str(program)).stdout


def on_avr(source, chip=KILOBOT, *more):
    """Compile a program for an AVR, run it in simavr, and return what it prints; `more` are options of the compiler."""
    return in_simavr(for_avr(source, chip, *more), chip)


def in_simavr(program: Path, chip: str) -> str:
    """Run a compiled program in simavr, and return what it prints."""
    printed = run("simavr", "-m", chip, "-f", str(CLOCK), str(program)).stderr
    # simavr prints what the chip sends in colours, cuts long lines, and has a full stop in the place of a line's end
    pieces = (COLOURS.sub("", line) for line in printed.splitlines() if GREEN in line)
    return "".join(pieces).replace(".", "\n")


def selftest_on_avr(source, rounds):
    """What the first rounds of a self-test print on the smallest of two AVRs that has room for its swarm."""
    option = f"-DROUNDS={rounds}"
    return on_avr(source, avr_for(source, SELFTEST_STACK, option), option)


def avr_for(source, stack, *more):
    """The smallest of two AVRs that has room for a program and a stack of so many bytes."""
    try:
        fits = avr_size(for_avr(source, KILOBOT, *more)).ram + stack <= RAM[KILOBOT]
    except NoRoom:
        fits = False
    return KILOBOT if fits else LARGE


def on_cortex(source):
    """Compile a program for a Cortex-M4F, run it in QEMU, and return what it prints."""
    start, program = source.with_name("start.c"), source.with_suffix(".cortex.elf")
    start.write_text((HERE / "cortex.c").read_text())
    run("arm-none-eabi-gcc", "-std=c99", *CORTEX_FLAGS, *STRICT, "-o", str(program), str(start), str(source), "-lm")
    machine = ("-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none")
    simulator = ("qemu-system-arm", *machine, "-semihosting-config", "enable=on,target=native")
    return run(*simulator, "-kernel", str(program)).stdout


def on_board(folder, files, heap=HEAP, module=None):
    """What a board prints that has these files, texts by name, and runs main.py and its `step`, as often as STEPS says.

    Raises InputError with the board's last lines.
    """
    texts = folder / "files.json"
    texts.write_text(json.dumps({name: textwrap.dedent(text) for name, text in files.items()}), encoding="utf-8")
    command = ["node", str(HERE / "node.mjs"), str(module or on_node.micropython()), str(heap), str(texts)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    if done.returncode:
        raise InputError(f"MicroPython stopped: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout
