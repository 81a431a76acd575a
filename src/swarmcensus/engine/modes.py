"""Numbers that the engine's files share."""

# how messages travel in a round: along listed links, all in two sums, or between all pairs one by one
LISTED, FULL, PAIRS = 0, 1, 2

# what of a robot may fail
MOVING, SENSING, TALKING = 0, 1, 2
NEVER = 1 << 62

TILE_ZERO = 1 << 30  # tiles are counted from the arena's centre, addresses from zero

# what is compiled for every brain (`phases.py`), and where in `minds` each function's address stands
PHASES = ("sense", "hear", "hear_sums", "hear_all", "end_round", "go_alone", "believe", "ask")
SENSE, HEAR, HEAR_SUMS, HEAR_ALL, END_ROUND, GO_ALONE, BELIEVE, ASK = range(8)
