"""The output of a brain's self-test on another machine, compared with that of CPython."""

import struct
from typing import NamedTuple


class BitDifference(NamedTuple):
    """How the output of a self-test differs from what is expected."""

    line: int  # the first line that differs, counted from 1; 0 if none does
    largest: float  # the largest difference of numbers, relative to those above 1; infinite if other things differ


def compare(wanted, found):
    """Compare the output of a self-test with the expected one."""
    rows = list(zip(wanted.splitlines(), found.splitlines(), strict=False))
    first = next((k for k, (one, other) in enumerate(rows, 1) if one != other), 0)
    if len(wanted.splitlines()) != len(found.splitlines()):
        return BitDifference(first or len(rows) + 1, float("inf"))
    largest = max((_distance(one, other) for one, other in rows if one != other), default=0.0)
    return BitDifference(first, largest)


def _distance(one, other):
    mine, yours = one.split(), other.split()
    if len(mine) != len(yours) or mine[:2] != yours[:2]:
        return float("inf")
    last = len(mine) if mine[2] == "memory" else len(mine) - 1  # a message's bytes may change with a number's last bit
    if "silent" in (mine[-1], yours[-1]) and mine[-1] != yours[-1]:
        return float("inf")
    return max(map(_apart, mine[2:last], yours[2:last]), default=0.0)


def _apart(one, other):
    if one == other:
        return 0.0
    if "nan" in (one, other):
        return float("inf")
    x, y = (struct.unpack(">f" if len(text) == 8 else ">d", bytes.fromhex(text))[0] for text in (one, other))
    return float(abs(x - y) / max(1.0, abs(x)))
