"""Independent tiles: each is black with the same probability, as in the paper (Sec. IV-C)."""

import numpy as np

from swarmcensus.engine import compile_world, not_compiled
from swarmcensus.worlds.arena import Arena, Paint, Score, Tiles
from swarmcensus.worlds.chance import Chance


def paint(arena: Arena, chance: Chance, share: float) -> Paint:
    """Black if the tile's own uniform number is below the share."""

    def colours(tiles: Tiles) -> np.ndarray:
        if not_compiled():
            return chance.noise(tiles) < share
        black = np.empty(tiles.shape[:2], np.bool_)
        compile_world().paint_tiles(tiles, chance.key, chance.trial, share, black)
        return black

    return colours


def level(arena: Arena, chance: Chance) -> Score:
    """The tile's own uniform number."""
    return chance.noise
