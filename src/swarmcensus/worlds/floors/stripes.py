"""Stripes: a share of each period is black. Axis and phase are drawn for each trial."""

from typing import Annotated

import numpy as np
from pydantic import Field

from swarmcensus.worlds.arena import Arena, Length, Score, Scores, Tiles
from swarmcensus.worlds.chance import Chance

Period = Annotated[Length, Field(examples=[0.5])]


def level(arena: Arena, chance: Chance, *, length: Period) -> Score:
    """The position within a period of `length` metres, from 0 to 1."""
    which, phase = chance.uniform(2)
    axis = int(which < 0.5)

    def within(tiles: Tiles) -> Scores:
        # a random point of the tile: a tile that a stripe covers in part is black with that probability
        place = (tiles[..., axis] + chance.noise(tiles)) * (arena.tile / length) + phase
        inside: Scores = np.minimum(place - np.floor(place), 1.0 - 2.0**-53)
        return inside

    return within
