"""Whether a board computes what it should: its self-test's output compared to that of CPython in the same precision."""

import ast
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np

from swarmcensus import brains
from swarmcensus.brains import Brain, Numbers, Precision, slots
from swarmcensus.robots.target import SENT, mark_of
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command
from swarmcensus.translation import selftest

DOUBLE, SINGLE = 53, 24  # binary digits of 8-byte and 4-byte floats
CLOSE = {DOUBLE: 1e-12, SINGLE: 1e-4}  # what exp, log and the reading of constants may differ by, relative above 1
ROUGH = 1e-2  # for boards with fewer digits
SHOWN = 8  # differences in words
FIRST, LAST = "selftest 2", "selftest ends"
HEAP = "heap"  # how the line begins that has what only a person reads


def compare(output: str, folder: Path) -> Answer:
    """Compare what a board printed with the reference for the files in `folder`. Raises InputError.

    The code is 2 if a number is too far off, or if a message differs although all numbers are equal: one that differs
    a little may change a message.
    """
    head, *found = _lines(output)
    name, mark, bits = _head(head)
    brain = _brain_of(folder, name, mark, "double" if bits >= DOUBLE else "single")
    wanted = selftest.expected(brain).splitlines()
    if [line.split()[:2] for line in found] != [line.split()[:2] for line in wanted]:
        raise InputError("the output is not whole: it lacks lines of the self-test")
    places, board, reference, messages, same = list[str](), list[float](), list[float](), 0, 0
    for line, ours in zip(found, wanted, strict=True):
        round_, robot, *words = line.split()
        expected = ours.split()[2:]
        if len(words) != len(expected):
            raise InputError(f"the output has a damaged line: {line[:60]!r}")
        if expected[0] == "memory":
            names = slots({name: brain.lengths[name] for name in brain.memory})
            words, expected = words[1:], expected[1:]
        else:
            names = ["estimate"]
            messages, same = messages + 1, same + (words.pop() == expected.pop())
        names += [f"number {k + 1}" for k in range(len(names), len(words))]
        places += [f"round {round_}, robot {robot}, {name}" for name in names]
        board += [_number(word, line) for word in words]
        reference += [_number(word, ours) for word in expected]
    x, y = np.array(board), np.array(reference)
    with np.errstate(invalid="ignore"):
        apart = np.nan_to_num(np.abs(x - y) / np.maximum(1.0, np.abs(y)), nan=np.inf)
    apart[(x == y) | (np.isnan(x) & np.isnan(y))] = 0.0
    allowed, equal, largest = CLOSE.get(bits, ROUGH), int((apart == 0.0).sum()), float(apart.max())
    wrong = [
        f"{places[k]}: {board[k]:.9g} on the board, {reference[k]:.9g} in the reference"
        for k in np.flatnonzero(apart > allowed)
    ]
    verdict = "the board computes what it should"
    if wrong:
        verdict = f"FAIL: more than {allowed:g} apart"
    elif equal == len(places) and same < messages:
        verdict = f"FAIL: {messages - same:,} messages differ, although all numbers are equal"
    return Answer(
        sentences=[
            verdict, f"{name}: {bits} binary digits on the board, and in the reference",
            f"largest difference {largest:.1e}, relative above 1",
            f"{counted(len(places), 'number')} compared, {equal:,} equal to the bit",
            f"{messages:,} messages compared, {same:,} equal",
            *wrong[:SHOWN], *[f"... and {len(wrong) - SHOWN:,} more"] * (len(wrong) > SHOWN),
        ],
        code=2 if verdict[:4] == "FAIL" else 0,
        fields={
            "brain": name, "bits": bits, "numbers": len(places), "equal": equal, "largest": largest,
            "allowed": allowed, "wrong": wrong, "messages": messages, "messages_equal": same,
            "passes": verdict[:4] != "FAIL",
        },
    )  # fmt: skip


def _lines(output: str) -> list[str]:
    """The self-test's lines; what a terminal printed around them is left out."""
    lines = [line.strip() for line in output.splitlines()]
    begins = [k for k, line in enumerate(lines) if line.startswith(FIRST)]
    if not begins:
        raise InputError(f"the output has no line that begins with {FIRST!r}: run selftest.py on the board")
    lines = lines[begins[-1] :]
    if LAST not in lines:
        raise InputError(f"the output is not whole: the line {LAST!r} is missing")
    return [line for line in lines[: lines.index(LAST)] if not line.startswith(HEAP)]


def _head(line: str) -> tuple[str, int, int]:
    words = line.removeprefix(FIRST).split()
    try:
        *name, mark, _, bits = words
        return " ".join(name), int(mark), int(bits)
    except ValueError:
        raise InputError(f"the output's first line is {line!r}: it should name a brain, a mark and bits") from None


def _number(word: str, line: str) -> float:
    try:
        return math.nan if word == "nan" else struct.unpack(">f" if len(word) == 8 else ">d", bytes.fromhex(word))[0]
    except (ValueError, struct.error):
        raise InputError(f"the output has a damaged line: {line[:60]!r}") from None


def _brain_of(folder: Path, name: str, mark: int, precision: Precision) -> Brain:
    """The brain of a folder, in the message format that a mark says. Raises InputError."""
    brain = brains.load(str(folder / "brain.py")).with_parameters(_parameters(folder / "settings.py"))
    of_formats = [brain.with_numbers(Numbers(precision, message)) for message in SENT]
    found = next((one for one in of_formats if mark_of(one) == mark), None)
    if found is None:
        both = f"the brain {name!r} with the mark {mark}, and the folder {folder} holds another one"
        raise InputError(f"the output is of {both}: give the folder whose files are on the board", file=folder)
    return found


def _parameters(path: Path) -> dict[str, Any]:
    """The brain's parameters in a settings file, which is not run. Raises InputError."""
    made = f"should be one made by `{command('swarmcensus', 'deploy')}`, for MicroPython"
    try:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "PARAMETERS":
                return dict(ast.literal_eval(node.value))
    except (OSError, SyntaxError, ValueError, TypeError) as error:
        raise InputError.of(path, f"{made}: {error}") from None
    raise InputError.of(path, f"{made}: PARAMETERS is missing")
