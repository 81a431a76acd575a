"""How messages travel in a round: along listed links, all in two sums, or between all pairs one by one."""

LISTED, FULL, PAIRS = 0, 1, 2
