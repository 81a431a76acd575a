"""The colour and the marker of each brain, the same in every figure and on the live page."""

from collections.abc import Sequence
from zlib import crc32

from swarmcensus.brains.library import TITLES

MARKERS = "s^vPXD*"  # of spread accuracies after the first; triangles to a side are signs of infinity
SHAPES = f"o{MARKERS}"  # of names
# Of names. The first eleven brains have one each. Without green (deuteranopia) any two are 27 or more apart in CIELAB.
NAMED = (
    "#0072b2", "#d55e00", "#114433", "#cc2266", "#662266", "#55aaaa", "#0000dd", "#eebb00", "#664400", "#ddaaff",
    "#55dd99",
)  # fmt: skip


def places_of_brains(contenders: Sequence[str]) -> dict[str, int]:
    """The place of each brain among all pairs of a colour and a marker, in the order of `contenders`.

    A shipped brain has its own. A brain with parameters has the colour of its brain, and another marker. Other brains
    have a pair that no shipped brain has. Both follow from their names; of two with the same pair, the later one in the
    alphabet has the next pair that is free.
    """
    known, pairs = [*TITLES], len(NAMED) * len(SHAPES)
    own = range(len(known), pairs)  # pairs that no shipped brain has
    places = {name: known.index(name) for name in contenders if name in known}
    for name in sorted({*contenders} - {*known}):
        base, mixed = name.partition(" ")[0], crc32(name.encode())
        start = known.index(base) if base in known else own[crc32(base.encode()) % len(own)]
        wanted = [own[(start - len(known) + k) % len(own)] for k in range(len(own))]
        if base != name:  # the same colour, with each other marker
            markers = range(1, len(SHAPES))
            wanted = [(start + len(NAMED) * (1 + (mixed + k) % len(markers))) % pairs for k in markers] + wanted
        places[name] = next((k for k in wanted if k not in places.values()), wanted[0])
    return {name: places[name] for name in contenders}


def colours_of_brains(labels: Sequence[str]) -> list[str]:
    """The colours of one brain, or of two that are shown next to each other, as #rrggbb.

    Where both have the same one, as variants of one brain do, the second one has that of another brain.
    """
    places = places_of_brains(labels)
    first, *others = (places[label] % len(NAMED) for label in labels)
    return [NAMED[first], *(NAMED[(k + len(NAMED) // 2) % len(NAMED) if k == first else k] for k in others)]
