"""Kinds of floor: which tiles are black, one file each, and each found because it lies here.

`score(arena, chance, *, length: float)` gives a function of tiles (tick, robot, 2), columns and rows from the arena's
centre, that returns their scores (tick, robot): black are those with the lowest scores, the share that a study asks
for. Tiles are asked for where sensors stand, in any order and again and again: a tile's score is always the same,
and what chance has to do with it comes from `chance.noise(tiles)`, or is drawn before. Tiles of one score are of one
colour. `arena` is a `swarmcensus.worlds.arena.Arena`, `chance` a `swarmcensus.worlds.chance.Chance`. Keyword-only
arguments are the floor's own keys in a study file, and their annotations, those of pydantic, say what they may be; the
first goes by the name of the kind: `{clusters = 0.2}`. Further, where a file needs it:

- `check(arena, *, ...)` raises ValueError for arenas that it does not fit;
- `paint(arena, chance, share, *, ...)` instead of `score`: a function of tiles that says which are black itself;
- `level(arena, chance, *, ...)` beside `paint`, for floors that change: a function of tiles that gives numbers; a tile
  is black where its number is below the share, and so the same tiles and more where the share is larger;
- `most_counted(arena, *, ...)`: of how many tiles at the most the black ones are counted.

Another package adds a kind by an entry point of the group `swarmcensus.floors`.
"""
