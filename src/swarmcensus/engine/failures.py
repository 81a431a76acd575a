"""Whether a part of a robot works in a round, or tick.

The first three rows of `stops` (row, robot) hold the round from which on each part does not work for the first time.
If parts recover, there are six more rows per fault: the rounds in which each part fails, and those in which it
recovers. There are no robots where nothing ever fails.
"""

from swarmcensus.engine.compiling import loop
from swarmcensus.engine.constants import PARTS


@loop(from_cpython=True, forceinline=True)
def works(stops, part, i, tick):
    """Whether a part of robot i works at `tick`."""
    if stops.shape[1] == 0 or tick < stops[part, i]:
        return True
    for row in range(PARTS + part, stops.shape[0], 2 * PARTS):
        if stops[row, i] <= tick < stops[row + PARTS, i]:
            return False
    return stops.shape[0] > PARTS
