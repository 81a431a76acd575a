"""Half the floor: black from one wall on. Which of the four walls is drawn for each trial."""

from swarmcensus.worlds.arena import Arena, Score, Scores, Tiles
from swarmcensus.worlds.chance import Chance


def score(arena: Arena, chance: Chance) -> Score:
    """Scores that grow tile by tile, line by line from the wall, so that any fill ratio is possible."""
    which = int(4.0 * chance.uniform(1)[0])
    axis, sign = which % 2, 1.0 if which < 2 else -1.0

    def order(tiles: Tiles) -> Scores:
        place: Scores = sign * 2.0**31 * tiles[..., axis] + tiles[..., 1 - axis]
        return place

    return order
