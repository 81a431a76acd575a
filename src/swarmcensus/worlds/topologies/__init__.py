"""Topologies by name: who hears whom, one file each, and each found because it lies here.

`edges(robots, *, columns: int = 10)` gives the undirected pairs of robots, numbered from 0: any iterable of pairs, or
an array (edge, 2). Keyword-only arguments are the topology's own keys in a study file, and their annotations, those of
pydantic, say what they may be. Further, where a file needs it:

- `edges(robots, chance, *, ...)`: the graph is another in each trial, drawn from a `swarmcensus.worlds.chance.Chance`;
- `DIRECTED = True`: of a pair (u, v), v hears u, and u does not hear v for that;
- `check(robots, *, ...)` raises ValueError for swarms of a size that it does not fit.

Another package adds a topology by an entry point of the group `swarmcensus.topologies`. Files here may say in place of
edges, and nobody makes sure of it:

- `links(robots, chance)`: arrays of receivers and senders, both ways, sorted by receiver and sender;
- `EVERYONE = True`: everybody hears everybody, and nothing has to be listed;
- `MOVES = True`: whom robots hear is for their walk to say.
"""
