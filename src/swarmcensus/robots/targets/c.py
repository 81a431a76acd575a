"""The files of a brain in C: its header, a self-test, what the test should print, and a Makefile."""

from swarmcensus.brains import Brain
from swarmcensus.robots.board_tests import CLOSE, DOUBLE, SINGLE
from swarmcensus.robots.target import Target
from swarmcensus.translation import header, piece, selftest, unit_of

FILES = ("brain.h", "selftest.c", "expected.txt", "Makefile", "close.c")
MADE = ("selftest", "found.txt", "close")  # by make in the same folder
FLAGS = "-O2 -std=c99 -Wall -Wextra -ffp-contract=off"
MAKEFILE = """\
# make check: whether the brain computes on this machine what it does in Python
CFLAGS = {flags}
LDLIBS = -lm

check: selftest{close}
\t./selftest > found.txt
\tcmp expected.txt found.txt && echo "same bits as in Python"{otherwise}

selftest: selftest.c brain.h
\t$(CC) $(CFLAGS) -o selftest selftest.c $(LDLIBS)

clean:
\trm -f selftest found.txt{close}

.PHONY: check clean
"""


def translated(brain: Brain) -> dict[str, str]:
    """The files of a brain in C, by name, in its number formats. Raises InputError if C has no such thing."""
    files = {
        "brain.h": header(brain),
        "selftest.c": selftest.in_c(brain, unit_of(brain)),
        "expected.txt": selftest.expected(brain),
        "Makefile": MAKEFILE.format(flags=FLAGS, close="", otherwise=""),
    }
    if not selftest.is_exact(brain):
        most = CLOSE[SINGLE if brain.numbers.precision == "single" else DOUBLE]
        otherwise = f" || ./close expected.txt found.txt {most:g}"
        files["Makefile"] = MAKEFILE.format(flags=FLAGS, close=" close", otherwise=otherwise)
        files["close.c"] = piece("close.c")
    return files


OF_PROGRAMS = "the program around brain.h decides that"
TARGET = Target(
    "C", lambda order: translated(order.brain) | order.counting, precisions=("single", "double"),
    refuses=dict.fromkeys(("accuracy", "hz", "robot", "log"), OF_PROGRAMS),
    may_replace=(*FILES, *MADE), counts={"calibrate.c": "calibrate.c", "counts.h": "counts.h"},
)  # fmt: skip
