"""The colour, the marker and the line of each brain, the same in every figure and on the live page."""

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from typing import Any

from swarmcensus.brains.library import TITLES

MARKERS = "s^vPXD*"  # of spread accuracies after the first; triangles to a side are signs of infinity
SHAPES = f"o{MARKERS}"  # of names
# Of names. The first eleven brains have one each. Without green (deuteranopia) any two, those of files of one's own
# included, are 23 or more apart in CIELAB.
NAMED = (
    "#0072b2", "#d55e00", "#114433", "#cc2266", "#662266", "#55aaaa", "#0000dd", "#888844", "#664400", "#ddaaff",
    "#55dd99",
)  # fmt: skip
# Of brains that share a colour, from the first.
LINES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1.5, 1.2)), (0, (5, 1.5, 1, 1.5)))
SWAPPED = {"voter": "w-msr", "w-msr": "voter"}  # so that the voter model and the oracle differ in colour
OWN = ("#000018", "#4488ff", "#ccdd77", "#3333bb")  # of files of one's own alone
HOURGLASS = ((-1, -1), (1, -1), (-1, 1), (1, 1), (-1, -1))
OWN_SHAPES = (HOURGLASS, (4, 1, 0), "d", "p")  # an hourglass, a star with four points, a thin rhomb and a pentagon
PARAMETERS = re.compile(r"( \w+=\S+)+$")  # behind a brain's name


def marks_of_brains(contenders: Sequence[str]) -> dict[str, tuple[str, Any, Any]]:
    """The colour, the marker and the line of each brain.

    No two have all three in common. A shipped brain has its own ones, whichever others there are. With parameters it
    has its colour, and a marker that no shipped brain of this colour has, as long as there are some. Files of one's own
    have colours and markers that no shipped brain has, in the order of their names; all contenders of one file have its
    colour.
    """
    known, variants = [SWAPPED.get(name, name) for name in TITLES], Counter[int]()
    bases = {name: PARAMETERS.sub("", name) for name in sorted({*contenders})}
    own = list(dict.fromkeys(base for base in bases.values() if base not in TITLES))
    shapes, marks = itertools.cycle([*OWN_SHAPES, *SHAPES]), dict[str, tuple[str, Any, Any]]()
    for name, base in bases.items():
        if base in own:
            dashes, of_file, shape = own.index(base) // len(OWN), OWN[own.index(base) % len(OWN)], next(shapes)
            free = [(of_file, shape, LINES[(dashes + k) % len(LINES)]) for k in range(len(LINES))]
            marks[name] = next((mark for mark in free if mark not in marks.values()), free[0])
            continue
        row, colour = divmod(known.index(base), len(NAMED))
        if name != base:
            row = -(-len(known) // len(NAMED)) + variants[colour]
            variants[colour] += 1
        line = LINES[(row + row // len(SHAPES)) % len(LINES)]  # 32 rows differ in marker or line
        marks[name] = NAMED[colour], SHAPES[(colour + len(NAMED) * row) % len(SHAPES)], line
    return marks


def colours_of_brains(labels: Sequence[str]) -> list[str]:
    """The colours of one brain, or of two that are shown next to each other, as #rrggbb.

    Where both have the same one, as variants of one brain do, the second one has that of a file of one's own.
    """
    marks = marks_of_brains(labels)
    first, *others = (marks[label][0] for label in labels)
    other = next(colour for colour in OWN if colour != first)
    return [first, *(other if colour == first else colour for colour in others)]
