"""A picture over the whole arena: its darkest parts are black, or dithered, darker parts more likely are."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from swarmcensus.worlds.arena import Arena, Score, Scores, Tiles
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.pictures import PictureFile

SHADES = 512  # limits a dithered tile's odds of being black or white to 1 : SHADES


def score(
    arena: Arena,
    chance: Chance,
    *,
    image: Annotated[PictureFile, Field(examples=["leaves.png"])],
    mode: Literal["threshold", "dither"] = "threshold",
) -> Score:
    """Grey levels, with ties broken at random; dithered, random scores with odds that grow with darkness."""
    grey = image.grey
    rows, columns = grey.shape
    darkness = np.clip(1.0 - np.arange(65536) / 65535.0, 1.0 / (SHADES + 1), SHADES / (SHADES + 1))
    against = (1.0 - darkness) / darkness

    def rank(tiles: Tiles) -> Scores:
        across, up = (((tiles[..., axis] + 0.5) * (arena.tile / arena.side) + 0.5) for axis in (0, 1))
        column = np.clip(np.floor(across * columns).astype(np.int64), 0, columns - 1)
        row = np.clip(np.floor((1.0 - up) * rows).astype(np.int64), 0, rows - 1)
        level, u = grey[row, column], chance.noise(tiles)
        # dithered: below the cut with odds of cut * darkness / (1 - darkness)
        ranks: Scores = level + u if mode == "threshold" else against[level] * u / (1.0 - u)
        return ranks

    return rank
