"""The links of a topology that has a name: its file is asked for edges, and what it gives is made sure of."""

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.basics.plugins import Keys, Plugins, defaults_of, error_message, keys_of, read_keys, text_of
from swarmcensus.worlds.chance import Chance

PLUGINS = Plugins("topology", "swarmcensus.topologies", "swarmcensus.worlds.topologies")
TAKEN = {"name", "edges", "file", "networkx", "directed"}  # keys of other forms of topologies
Heard = tuple[np.ndarray, np.ndarray]  # receivers and senders, sorted by them


def _no_edges() -> None:
    """What full networks and robots that move have instead: no keys."""


def _function(name: str) -> Callable[..., Any]:
    module = PLUGINS.module(name)
    if name in PLUGINS.shipped:
        return getattr(module, "edges", getattr(module, "links", _no_edges))  # type: ignore[no-any-return]
    if not callable(getattr(module, "edges", None)):
        raise InputError(f"topology {name!r}, {PLUGINS.outside[name].value}: it has no function edges")
    return module.edges  # type: ignore[no-any-return]


def read(name: str, given: dict[str, Any]) -> tuple[str, Keys]:
    """A named topology's text, such as torus(columns=5), and its keys. Raises ValueError."""
    function = _function(name)
    for key in keys_of(function).model_fields.keys() & TAKEN:
        raise InputError(f"topology {name!r}: it has a key {key}, which means something else in study files")
    keys = read_keys(f"topology {name}", function, given)
    usual = defaults_of(function)
    shown = ",".join(f"{key}={text_of(value)}" for key, value in keys if key not in usual or usual[key] != value)
    return f"{name}({shown})" if shown else name, keys


@functools.cache
def varies(name: str) -> bool:
    """Whether each trial has another graph."""
    taken = inspect.signature(_function(name)).parameters.values()
    return sum(one.kind is not one.KEYWORD_ONLY and one.default is one.empty for one in taken) > 1


def check(name: str, keys: Keys, robots: int) -> None:
    """Raise ValueError where the topology's own file refuses a swarm of this size."""
    refuse = getattr(PLUGINS.module(name), "check", None)
    if refuse is not None:
        _asked(name, keys, robots, functools.partial(refuse, **dict(keys)), robots)


def check_repeats(name: str, keys: Keys, robots: int) -> None:
    """Raise InputError where a graph fails, or is another when it is asked for again."""
    chances = [Chance(np.zeros(2, np.uint64), 0) if varies(name) else None]
    one, other = (graphs(name, keys, robots, chances)[0] for _ in range(2))
    if not all(map(np.array_equal, one, other)):
        raise InputError(
            f"topology {name!r}: its edges are others when they are asked for again: what differs from trial to trial "
            "is drawn from chance.generator(), with edges(robots, chance)"
        )


def graphs(name: str, keys: Keys, robots: int, chances: Iterable[Chance | None]) -> list[Heard]:
    """Who hears whom, trial by trial; chance is None where all have one graph. Raises InputError where one fails."""
    module, function, own = PLUGINS.module(name), _function(name), dict(keys)
    if name in PLUGINS.shipped and hasattr(module, "links"):
        return [function(robots, chance, **own) for chance in chances]
    directed = getattr(module, "DIRECTED", False)

    def edges(chance: Chance | None) -> np.ndarray:
        given = (robots,) if chance is None else (robots, chance)
        return pairs_of(function(*given, **own), robots)

    return [heard(_asked(name, keys, robots, edges, chance), directed) for chance in chances]


def _asked(name: str, keys: Keys, robots: int, ask: Callable[..., Any], given: object) -> Any:
    try:
        return ask(given)
    except Exception as error:
        own = "".join(f", {key} = {text_of(value)}" for key, value in keys)
        raise InputError(
            f"topology {name!r} of {counted(robots, 'robot')}{own}: {error_message(error, PLUGINS.path(name))}"
        ) from error


def pairs_of(given: Any, robots: int) -> np.ndarray:
    """Edges as an array (edge, 2). Raises ValueError where they are no pairs of robots that there are."""
    pairs = given if isinstance(given, np.ndarray) else list(given)
    try:
        edges = np.asarray(pairs) if len(pairs) else np.zeros((0, 2), np.int64)
    except (ValueError, OverflowError):  # rows of several lengths
        edges = np.zeros(0)
    if edges.ndim != 2 or edges.shape[1] != 2 or edges.dtype.kind not in "iu":
        raise ValueError("its edges should be pairs of robot numbers, from 0")
    for wrong, said in (
        ((edges < 0) | (edges >= robots), f"leads to a robot that is not there: they are numbered 0 to {robots - 1}"),
        (edges[:, :1] == edges[:, 1:], "joins a robot to itself"),
    ):
        if wrong.any():
            u, v = edges[wrong.any(axis=1)][0].tolist()
            raise ValueError(f"its edge ({u}, {v}) {said}")
    return edges.astype(np.int64)


def heard(edges: np.ndarray, directed: bool) -> Heard:
    """Edges (edge, 2) as links, each once; of a directed one, the second hears the first."""
    if not edges.size:
        return np.zeros(0, np.uint32), np.zeros(0, np.uint32)
    n = np.int64(edges.max()) + 1
    found = edges @ [1, n]  # receiver n + sender, of (sender, receiver)
    ordered = np.sort(found if directed else np.concatenate([edges @ [n, 1], found]))
    once = ordered[np.append(True, ordered[1:] != ordered[:-1])]
    return (once // n).astype(np.uint32), (once % n).astype(np.uint32)
