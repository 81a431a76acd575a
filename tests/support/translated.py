"""Brains as C for the tests of translations: which there are, with parameters that make much happen in a short test."""

import subprocess
from pathlib import Path

from swarmcensus.brains import load
from swarmcensus.brains.brain import shipped
from swarmcensus.brains.packing import Numbers
from swarmcensus.robots.folders import write_texts
from swarmcensus.robots.targets.c import translated
from swarmcensus.runtime.history import ROBOTS
from tests.support.bit_differences import compare
from tests.support.places import DATA, EXAMPLE

EXAMPLES = EXAMPLE
OWN = ("forgetful", "histogram", "leader", "liar", "my_brain", "pairwise", "prior", "quiet", "shy", "sprt")
BRAINS = [*shipped(), *(str(EXAMPLES / f"{name}.py") for name in OWN), str(DATA / "whole.py")]
BUSY = {
    "every": 7.0, "phase": 12.0, "explore": 20.0, "disseminate": 15.0, "uncommitted": 9.0, "listen": 5.0,
    "debiased": 1.0, "tell": 10.0, "detect": 1.0, "feedback": 2.0, "faulty": 1.0, "window": 30.0, "past": 9.0,
    "memory": 30.0, "miscommunication": 0.1, "asocial": 0.1, "patience": 4.0, "noise": 0.01, "truncated": 1.0,
}  # fmt: skip
CLOSE = 1e-4  # where a brain calls others


def named(name):
    return Path(name).stem


def load_busy(name, precision, message="float32", busy=True):
    """A brain in number formats; if `busy`, with parameters that let more happen."""
    brain = load(name)
    values = {key: value for key, value in BUSY.items() if busy and key in brain.parameters}
    return brain.with_parameters(values).with_numbers(Numbers(precision=precision, message=message))


def differs(brain, folder, run, rounds=None):
    """Write a brain as C, run its self-test, and compare; `rounds` if it runs fewer than are expected."""
    write_texts(folder, translated(brain))
    wanted = (folder / "expected.txt").read_text()
    found = run(folder / "selftest.c")
    if rounds:
        wanted = "".join(row for row in wanted.splitlines(keepends=True) if int(row.split()[0]) <= rounds)
        assert wanted.count("\n") > ROBOTS * rounds
    return compare(wanted, found)


def compiled(folder, program, *options):
    """Compile a program that uses brain.h on this machine, run it, and return what it prints."""
    (folder / "program.c").write_text(program)
    flags = ("-O2", "-std=c99", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
    out = folder / "program"
    words = ["gcc", *flags, *options, "-o", str(out), str(folder / "program.c"), "-lm"]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return subprocess.run([str(out)], capture_output=True, text=True, check=True).stdout
