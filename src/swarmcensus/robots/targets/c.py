"""The files of a brain in C: its header, a self-test, what the test should print, and a Makefile."""

from swarmcensus.brains import Brain
from swarmcensus.robots.target import Order, Target
from swarmcensus.translation import header, selftest, unit_of

FILES = ("brain.h", "selftest.c", "expected.txt", "Makefile")
MADE = ("selftest", "found.txt")  # by make in the same folder
FLAGS = "-O2 -std=c99 -Wall -Wextra -ffp-contract=off"
MAKEFILE = f"""\
# make check: whether the brain computes on this machine what it does in Python, bit for bit
CFLAGS = {FLAGS}

check: selftest
\t./selftest > found.txt
\tcmp expected.txt found.txt && echo "same bits as in Python"

selftest: selftest.c brain.h
\t$(CC) $(CFLAGS) -o selftest selftest.c -lm

clean:
\trm -f selftest found.txt

.PHONY: check clean
"""


def c_files(order: Order) -> dict[str, str]:
    """The texts of all files by name. Raises InputError if C has no such thing."""
    return translated(order.brain)


def translated(brain: Brain) -> dict[str, str]:
    """The files of a brain in C, by name, in its number formats. Raises InputError if C has no such thing."""
    return {
        "brain.h": header(brain),
        "selftest.c": selftest.in_c(brain, unit_of(brain)),
        "expected.txt": selftest.expected(brain),
        "Makefile": MAKEFILE,
    }


OF_PROGRAMS = "the program around brain.h decides that"
TARGET = Target(
    "C", c_files, precisions=("single", "double"), refuses=dict.fromkeys(("b", "w", "hz", "robot", "log"), OF_PROGRAMS),
    may_replace=(*FILES, *MADE),
)  # fmt: skip
