"""Stripes of one period, a share of each black, along an axis and with a phase of each trial."""

from typing import Annotated

import numpy as np
from pydantic import Field

from swarmcensus.worlds.arena import Arena, Length, Paint, Tiles
from swarmcensus.worlds.chance import Chance


def paint(arena: Arena, chance: Chance, share: float, *, length: Annotated[Length, Field(examples=[0.5])]) -> Paint:
    """Black where the place within the period, `length` metres, is below the share."""
    which, phase = chance.uniform(2)
    axis = int(which < 0.5)

    def colours(tiles: Tiles) -> np.ndarray:
        # somewhere in the tile: where a stripe ends within it, it is black with the share that is covered
        place = (tiles[..., axis] + chance.noise(tiles)) * (arena.tile / length) + phase
        within = np.minimum(place - np.floor(place), 1.0 - 2.0**-53)
        return np.asarray(within < share)

    return colours
