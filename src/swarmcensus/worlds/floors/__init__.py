"""Kinds of floor: which tiles are black. Each file in this folder is a kind.

`score(arena, chance, *, length: float)` returns a function of tiles (tick, robot, 2), columns and rows from the arena's
centre, which returns their scores (tick, robot). The tiles with the lowest scores are black, as many as the fill ratio
says. The function is called for the tiles under sensors, in any order and many times: a tile's score must always be the
same. Its randomness comes from `chance.noise(tiles)`, or is drawn before the function is returned. Tiles with equal
scores have the same colour. `arena` is a `swarmcensus.worlds.arena.Arena`, `chance` a
`swarmcensus.worlds.chance.Chance`. Keyword-only arguments are the floor's own keys in a study file, and their pydantic
annotations say what they may be; the first key has the name of the kind: `{clusters = 0.2}`. Further functions, if
needed:

- `check(arena, *, ...)` raises ValueError for arenas that the floor does not fit;
- `paint(arena, chance, share, *, ...)` instead of `score` returns a function that tells which tiles are black;
- `level(arena, chance, *, ...)` next to `paint`, for floors that change, returns a function that gives tiles' levels: a
  tile is black if its level is below the share, so a larger share only adds black tiles;
- `most_counted(arena, *, ...)` returns the largest number of tiles among which black ones are counted.

Another package adds a kind by an entry point of the group `swarmcensus.floors`.
"""
