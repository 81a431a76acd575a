"""How many observations of a round are black, drawn from random words.

The R coin flips of a round are exchangeable, so one binomial draw stands for them. It is made with
Walker's alias method (Walker 1977; Vose 1991): one 64-bit word, one table look-up, one comparison. More
than `PART` observations are drawn as several binomials that add up.
"""

import numpy as np

from swarmcensus.engine.calling import blank_state
from swarmcensus.engine.compiling import loop
from swarmcensus.engine.constants import COLUMNS, PART
from swarmcensus.engine.random import unit, words
from swarmcensus.engine.records import record_type

LOW = np.uint64(COLUMNS - 1)
SHIFT = np.uint64(60)
BITS = np.uint64(4)

KINDS = {"weights": "f8", "share": "f8", "alias": "i8", "small": "i8", "large": "i8"}
ROOM = record_type([(name, kind, (COLUMNS,)) for name, kind in KINDS.items()])  # on the stack


@loop()
def alias_row(weights, row):
    """Fill `row`, a uint64 for each column: a 60-bit threshold, and in the low 4 bits the alias."""
    columns = weights.size
    room = blank_state(ROOM)
    share, alias, small, large = room.share, room.alias, room.small, room.large
    total = 0.0
    for c in range(columns):
        total += weights[c]
    smalls = larges = 0
    for c in range(columns):
        share[c], alias[c] = weights[c] / total * columns, c
        if share[c] < 1.0:
            small[smalls] = c
            smalls += 1
        else:
            large[larges] = c
            larges += 1
    while smalls > 0 and larges > 0:
        s, g = small[smalls - 1], large[larges - 1]
        smalls -= 1
        alias[s] = g
        share[g] -= 1.0 - share[s]
        if share[g] < 1.0:
            larges -= 1
            small[smalls] = g
            smalls += 1
    for c in range(columns):
        # a column left over is full but for rounding: it is its own alias
        threshold = np.uint64(min(max(share[c], 0.0), 0.9999999999999999) * 18446744073709551616.0)
        row[c] = (threshold & ~LOW) | np.uint64(alias[c])


@loop()
def binomial_row(looks, p, row):
    """The alias row of Binomial(looks, p), looks <= PART."""
    weights = blank_state(ROOM).weights
    weights[0] = 1.0
    for _ in range(looks):  # Pascal's triangle: sums and products alone give the same bits on any machine
        for k in range(looks, 0, -1):
            weights[k] = (1.0 - p) * weights[k] + p * weights[k - 1]
        weights[0] *= 1.0 - p
    alias_row(weights, row)


@loop(forceinline=True)
def pick(row, word):
    """The column that a word picks from an alias row."""
    column = word >> SHIFT
    entry = row[column]
    return np.int64(column) if (word << BITS) < (entry & ~LOW) else np.int64(entry & LOW)


@loop(forceinline=True)
def count_blacks(blacks, bits, tables, looks, key, trial, tick, first, last):
    """Draw how many of a round's observations are black, for robots first (even) ... last - 1."""
    parts = (looks + PART - 1) // PART
    stride = np.uint64(1 if tables.shape[1] > 1 else 0)
    for part in range(parts):
        words(key, trial, tick, part, first, last - first, bits)
        kind = 0 if (part + 1) * PART <= looks else tables.shape[0] - 1
        for i in range(np.uint64(0), last - first):
            drawn = float(pick(tables[kind, (first + i) * stride], bits[i]))
            blacks[i] = drawn if part == 0 else blacks[i] + drawn


@loop()
def arrange(reading, blacks, bits, left, key, trial, step, first):
    """Draw the next single reading of a round with `left` readings to go, `blacks` of them black, in random order.

    `first` (even) is the number of the first of these robots.
    """
    words(key, trial, step, np.int64(0), first, np.uint64(bits.size), bits)
    for i in range(reading.size):
        black = unit(bits[i]) * left < blacks[i]
        reading[i] = 1.0 if black else 0.0
        blacks[i] -= reading[i]
