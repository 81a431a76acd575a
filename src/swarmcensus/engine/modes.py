"""Numbers that the engine's files share."""

# how messages travel in a round: along listed links, all in two sums, or between all pairs one by one
LISTED, FULL, PAIRS = 0, 1, 2

# what of a robot may fail
MOVING, SENSING, TALKING = 0, 1, 2
NEVER = 1 << 62

TILE_ZERO = 1 << 30  # tiles are counted from the arena's centre, addresses from zero
