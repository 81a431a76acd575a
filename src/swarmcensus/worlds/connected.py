"""The connected components of networks."""

import numpy as np


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


def components(robots: int, receivers: np.ndarray, senders: np.ndarray) -> int:
    """The number of strongly connected components: in each, every robot is reached by what any of them says."""
    receivers, senders = receivers.astype(np.int64), senders.astype(np.int64)
    to, back = receivers * robots + senders, senders * robots + receivers
    if np.array_equal(np.sort(to), np.sort(back)):
        return len(np.unique(lowest_reached(robots, receivers, senders)))
    import networkx  # imported only for directed networks

    graph = networkx.DiGraph()
    graph.add_nodes_from(range(robots))
    graph.add_edges_from(zip(senders.tolist(), receivers.tolist(), strict=True))
    return int(networkx.number_strongly_connected_components(graph))
