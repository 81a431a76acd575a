"""The connected components of networks."""

import numpy as np
from numpy.typing import ArrayLike


def lowest_reached(robots: int, one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """The lowest number of a robot that each reaches over links (one, two), in whichever direction these go."""
    least = np.arange(robots)
    while True:  # each takes the lowest of its neighbours, and then that of the robot of this number
        lower = least.copy()
        np.minimum.at(lower, one, least[two])
        np.minimum.at(lower, two, least[one])
        lower = lower[lower]
        if (lower == least).all():
            return least
        least = lower


def components(robots: int, receivers: np.ndarray, senders: np.ndarray, starts: ArrayLike = ()) -> np.ndarray:
    """The number of strongly connected components of each graph: in each, every robot is reached by what any one says.

    `starts` are where the links of each graph begin, and where the last ones end; by default there is one graph.
    """
    ends = np.array(starts if np.size(starts) else [0, len(receivers)])
    graphs, every = len(ends) - 1, robots * (len(ends) - 1)
    first = np.repeat(np.arange(graphs) * robots, np.diff(ends))  # all graphs as parts of one
    to, back = first + receivers, first + senders
    if np.array_equal(np.sort(to * every + back), np.sort(back * every + to)):
        lowest = np.flatnonzero(lowest_reached(every, to, back) == np.arange(every))  # one of each component
        return np.bincount(lowest // robots, minlength=graphs)
    import networkx  # imported only for directed networks

    whole = networkx.DiGraph()
    whole.add_nodes_from(range(every))
    whole.add_edges_from(zip(back.tolist(), to.tolist(), strict=True))
    lowest = np.array([min(part) for part in networkx.strongly_connected_components(whole)])
    return np.bincount(lowest // robots, minlength=graphs)
