"""Translated brains for a chip: an AVR's compiler."""

import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

from swarmcensus.support.errors import InputError

STRICT = ("-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
KILOBOT = "atmega328p"  # 32 KB of flash, 2 KB of RAM
CLOCK = 8_000_000  # of a Kilobot, in Hz
SECONDS = 300.0  # before a simulation is given up


class NoRoom(InputError):
    """A program is larger than its chip."""


class Size(NamedTuple):
    """What a program takes of a chip, in bytes."""

    flash: int
    ram: int  # without the stack


def missing(tools: tuple[str, ...]) -> list[str]:
    """Those of these programs that are not installed."""
    return [tool for tool in tools if shutil.which(tool) is None]


def for_avr(source: Path, chip: str, *more: str) -> Path:
    """Compile a program for an AVR, and return its file."""
    program = source.with_suffix(f".{chip}.elf")
    options = ("-Os", "-std=gnu99", f"-mmcu={chip}", f"-DF_CPU={CLOCK}UL", "-ffunction-sections", "-Wl,--gc-sections")
    run("avr-gcc", *options, *STRICT, *more, "-o", str(program), str(source), "-lm")
    return program


def avr_size(program: Path) -> Size:
    """The size of a program for an AVR."""
    rows = [line.split() for line in run("avr-size", "-A", str(program)).stdout.splitlines()]
    sizes = {row[0]: int(row[1]) for row in rows if len(row) == 3 and row[1].isdigit()}
    text, data = sizes.get(".text", 0), sizes.get(".data", 0)
    return Size(text + data, data + sizes.get(".bss", 0) + sizes.get(".noinit", 0))


def run(*command: str) -> "subprocess.CompletedProcess[str]":
    """Run a program. Raises InputError if it fails, with its first line of errors."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    except FileNotFoundError:
        raise InputError(f"{command[0]} is not installed: tools/install-chips.sh installs it") from None
    except subprocess.TimeoutExpired:
        raise InputError(f"{command[0]} {command[-1]} did not end within {SECONDS:g} s") from None
    if done.returncode:
        if any(word in done.stderr for word in ("overflowed by", "will not fit", "is not within region")):
            raise NoRoom(f"{command[-2]} is larger than its chip")
        errors = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines()
        raise InputError(f"{command[0]} failed: {errors[0] if errors else f'exit code {done.returncode}'}")
    return done
