"""When parts of robots do not work.

`stops` (row, robot) holds in its first rows the first round, or tick, at which each part does not work. Only where some
work again there are more: for each fault the rounds from which on each part does not work, and those from which on it
does again. It is without robots where nothing ever fails.
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
