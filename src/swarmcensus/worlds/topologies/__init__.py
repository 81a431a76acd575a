"""Topologies with a name: who hears whom. Each file in this folder is a topology.

`edges(robots, *, columns: int = 10)` returns the undirected pairs of robots, numbered from 0: any iterable of pairs, or
an array (edge, 2). Keyword-only arguments are the topology's own keys in a study file, and their pydantic annotations
say what they may be. Further, if needed:

- `edges(robots, chance, *, ...)` draws another graph for each trial from a `swarmcensus.worlds.chance.Chance`;
- `DIRECTED = True`: in a pair (u, v) only v hears u;
- `check(robots, *, ...)` raises ValueError for swarms of a size that the topology does not fit.

Another package adds a topology by an entry point of the group `swarmcensus.topologies`. Files in this folder
may have one of these in place of edges, which is not checked:

- `links(robots, chance)` returns arrays of receivers and senders, in both directions, sorted by receiver and sender;
- `EVERYONE = True`: every robot hears every other, and no links are listed;
- `MOVES = True`: robots move, and their trajectories decide whom they hear.
"""
