"""The files of a brain in C: its header, a self-test, what the test should print, and a Makefile."""

import contextlib
from pathlib import Path

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.files import atomic_write
from swarmcensus.brains import Brain
from swarmcensus.deployment import selftest
from swarmcensus.deployment.header import header, unit_of

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


def translate(brain: Brain) -> dict[str, str]:
    """The files of a brain in C, by name, in its number formats. Raises InputError if C has no such thing."""
    return {
        "brain.h": header(brain),
        "selftest.c": selftest.in_c(brain, unit_of(brain)),
        "expected.txt": selftest.expected(brain),
        "Makefile": MAKEFILE,
    }


def write(brain: Brain, folder: Path) -> list[Path]:
    """Write the files of a brain in C; older ones are replaced. Raises InputError if the folder holds other files."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file: a translation needs a folder", file=folder)
    others = (
        sorted(path.name for path in folder.iterdir() if path.name not in (*FILES, *MADE)) if folder.is_dir() else []
    )
    if others:
        raise InputError(f"{folder} holds {others[0]!r}, which is no part of a translation: name a new folder")
    texts = translate(brain)
    paths = [folder / name for name in texts]
    is_new = not folder.exists()
    try:
        with contextlib.ExitStack() as stack:  # all or none
            for path, text in zip(paths, texts.values(), strict=True):
                stack.enter_context(atomic_write(path)).write_text(text, encoding="utf-8", newline="\n")
    except InputError:
        if is_new:
            with contextlib.suppress(OSError):
                folder.rmdir()
        raise
    return paths
