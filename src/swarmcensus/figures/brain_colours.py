"""The colour and the marker of each brain, the same in every figure and on the live page."""

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from typing import Any

from swarmcensus.brains.library import TITLES

MARKERS = "s^vPXD*"  # of spread accuracies after the first; triangles to a side are signs of infinity
SHAPES = f"o{MARKERS}"  # of names
# Of names. The first eleven brains have one each. Without green (deuteranopia) any two, those of files of one's own
# included, are 26 or more apart in CIELAB.
NAMED = (
    "#0072b2", "#d55e00", "#114433", "#cc2266", "#662266", "#55aaaa", "#0000dd", "#eebb00", "#664400", "#ddaaff",
    "#55dd99",
)  # fmt: skip
OWN = ("#000018", "#4488ff", "#ccdd77", "#3333bb")  # of files of one's own alone
HOURGLASS = ((-1, -1), (1, -1), (-1, 1), (1, 1), (-1, -1))
OWN_SHAPES = (HOURGLASS, (4, 1, 0), "d", "p")  # an hourglass, a star with four points, a thin rhomb and a pentagon
PARAMETERS = re.compile(r"( \w+=\S+)+$")  # behind a brain's name


def pairs_of_brains(contenders: Sequence[str]) -> dict[str, tuple[str, Any]]:
    """The colour and the marker of each brain.

    A shipped brain has its own pair, whichever others there are. With parameters it has its colour, and a marker that
    no shipped brain of this colour has. Files of one's own have colours and markers that no shipped brain has, in the
    order of their names; all contenders of one file have its colour.
    """
    known, variants = [*TITLES], Counter[str]()
    bases = {name: PARAMETERS.sub("", name) for name in sorted({*contenders})}
    own = list(dict.fromkeys(base for base in bases.values() if base not in TITLES))
    shapes, pairs = itertools.cycle([*OWN_SHAPES, *SHAPES]), dict[str, tuple[str, Any]]()
    for name, base in bases.items():
        if base in own:
            pairs[name] = OWN[own.index(base) % len(OWN)], next(shapes)
            continue
        place = known.index(base)
        if name != base:
            place = place % len(NAMED) + len(NAMED) * (-(-len(known) // len(NAMED)) + variants[base])
            variants[base] += 1
        pairs[name] = NAMED[place % len(NAMED)], SHAPES[place % len(SHAPES)]
    return pairs


def colours_of_brains(labels: Sequence[str]) -> list[str]:
    """The colours of one brain, or of two that are shown next to each other, as #rrggbb.

    Where both have the same one, as variants of one brain do, the second one has that of a file of one's own.
    """
    pairs = pairs_of_brains(labels)
    first, *others = (pairs[label][0] for label in labels)
    other = next(colour for colour in OWN if colour != first)
    return [first, *(other if colour == first else colour for colour in others)]
