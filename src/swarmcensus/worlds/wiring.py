"""The links of named topologies: their files give edges, which are checked here."""

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from swarmcensus.support.errors import BrainError
from swarmcensus.support.formatting import counted
from swarmcensus.support.plugins import (
    Keys,
    PluginName,
    Plugins,
    defaults_of,
    error_message,
    keys_of,
    read_keys,
    text_of,
)
from swarmcensus.worlds.chance import Chance

PLUGINS = Plugins("topology", "swarmcensus.topologies", "swarmcensus.worlds.topologies")
TAKEN = {"name", "edges", "file", "networkx", "directed", "label"}  # keys of other forms of topologies
Heard = tuple[np.ndarray, np.ndarray]  # receivers and senders, sorted by them


def _no_edges() -> None:
    """In place of the function of full networks and of robots that move, which have no edges and no keys."""


def function_of(name: PluginName) -> Callable[..., Any]:
    """The function of a topology's file that makes edges. Raises InputError if it has none."""
    module = PLUGINS.module(name)
    if name in PLUGINS.shipped:
        return getattr(module, "edges", _no_edges)  # type: ignore[no-any-return]
    if not callable(getattr(module, "edges", None)):
        raise PLUGINS.error(name, "it has no function edges")
    return module.edges  # type: ignore[no-any-return]


def read(name: PluginName, given: dict[str, Any]) -> tuple[str, Keys]:
    """The text of a named topology, such as torus(columns=5), and its keys. Raises ValueError."""
    function = function_of(name)
    for key in keys_of(function).model_fields.keys() & TAKEN:
        raise BrainError.named("topology", str(name), f"it has a key {key}, which means something else in study files")
    keys = read_keys(f"topology {name}", function, given)
    return text(name, keys), keys


def text(name: PluginName, keys: Iterable[tuple[str, Any]]) -> str:
    """The text of a named topology with these keys, without those at their default."""
    defaults = defaults_of(function_of(name))
    shown = ",".join(f"{key}={text_of(value)}" for key, value in keys if key not in defaults or defaults[key] != value)
    return f"{name}({shown})" if shown else str(name)


@functools.cache
def varies(name: PluginName) -> bool:
    """Whether graphs differ from trial to trial: the function then takes `chance` too."""
    parameters = inspect.signature(function_of(name)).parameters.values()
    return sum(p.kind is not p.KEYWORD_ONLY and p.default is p.empty for p in parameters) > 1


def check(name: PluginName, keys: Keys, robots: int) -> None:
    """Raise ValueError if the topology's own `check` refuses a swarm of this size."""
    refuse = getattr(PLUGINS.module(name), "check", None)
    if refuse is not None:
        _call(name, keys, robots, functools.partial(refuse, **dict(keys)), robots)


def check_repeats(name: PluginName, keys: Keys, robots: int) -> None:
    """Raise InputError if a graph fails, or differs when it is made again."""
    chances = [Chance(np.zeros(2, np.uint64), 0) if varies(name) else None]
    one, other = (graphs(name, keys, robots, chances)[0] for _ in range(2))
    if not all(map(np.array_equal, one, other)):
        drawn = "those that differ from trial to trial are drawn from chance.generator()"
        what = f"its edges should be the same at each call: {drawn}, by a function edges(robots, chance)"
        raise BrainError.named("topology", str(name), what)


def graphs(name: PluginName, keys: Keys, robots: int, chances: Iterable[Chance | None]) -> list[Heard]:
    """Who hears whom in each trial; a chance is None if all trials share a graph. Raises InputError if one fails."""
    module, function, own = PLUGINS.module(name), function_of(name), dict(keys)
    directed = getattr(module, "DIRECTED", False)

    def edges(chance: Chance | None) -> np.ndarray:
        given = (robots,) if chance is None else (robots, chance)
        return pairs_of(function(*given, **own), robots)

    return [heard(_call(name, keys, robots, edges, chance), directed) for chance in chances]


def _call(name: PluginName, keys: Keys, robots: int, call: Callable[..., Any], argument: object) -> Any:
    try:
        return call(argument)
    except Exception as error:
        own = "".join(f", {key} = {text_of(value)}" for key, value in keys if value is not None)
        where = f"topology {str(name)!r} of {counted(robots, 'robot')}{own}"
        what = error_message(error, PLUGINS.path(name))
        raise BrainError(f"{where}: {what}", key="topology", value=str(name)) from error


def pairs_of(given: Any, robots: int) -> np.ndarray:
    """Edges as an array (edge, 2). Raises ValueError if they are not pairs of the swarm's robots."""
    pairs = given if isinstance(given, np.ndarray) else list(given)
    try:
        edges = np.asarray(pairs) if len(pairs) else np.zeros((0, 2), np.int64)
    except (ValueError, OverflowError):  # rows of several lengths
        edges = np.zeros(0)
    if edges.ndim != 2 or edges.shape[1] != 2 or edges.dtype.kind not in "iu":
        raise ValueError("its edges should be pairs of robot numbers, from 0")
    for wrong, problem in (
        ((edges < 0) | (edges >= robots), f"leads to a robot that is not there: they are numbered 0 to {robots - 1}"),
        (edges[:, :1] == edges[:, 1:], "joins a robot to itself"),
    ):
        if wrong.any():
            u, v = edges[wrong.any(axis=1)][0].tolist()
            raise ValueError(f"its edge ({u}, {v}) {problem}")
    return edges.astype(np.int64)


def heard(edges: np.ndarray, directed: bool) -> Heard:
    """Edges (edge, 2) as links, each once; in a directed edge, the second robot hears the first."""
    if not edges.size:
        return np.zeros(0, np.uint32), np.zeros(0, np.uint32)
    n = np.int64(edges.max()) + 1
    found = edges @ [1, n]  # receiver n + sender, of (sender, receiver)
    ordered = np.sort(found if directed else np.concatenate([edges @ [n, 1], found]))
    once = ordered[np.append(True, ordered[1:] != ordered[:-1])]
    return (once // n).astype(np.uint32), (once % n).astype(np.uint32)
