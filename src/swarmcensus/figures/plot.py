"""All kinds of figures by name, such as `sc.plot.scatter(results)`: shipped kinds and those of other packages.

`dir(sc.plot)` lists them. Each returns a matplotlib Figure, which `sc.plot.save` writes, and `sc.plot.caption`
describes. They need no display. matplotlib is imported on first use.
"""

import importlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from swarmcensus.figures import kinds
from swarmcensus.support.hints import did_you_mean

if TYPE_CHECKING:  # so that editors and type checkers know the signatures
    from swarmcensus.figures.captions import caption as caption
    from swarmcensus.figures.files import save as save
    from swarmcensus.figures.kinds.arena import arena as arena
    from swarmcensus.figures.kinds.compare import compare as compare
    from swarmcensus.figures.kinds.curves import curves as curves
    from swarmcensus.figures.kinds.film import film as film
    from swarmcensus.figures.kinds.heatmap import heatmap as heatmap
    from swarmcensus.figures.kinds.interaction import interaction as interaction
    from swarmcensus.figures.kinds.lines import lines as lines
    from swarmcensus.figures.kinds.pareto import pareto as pareto
    from swarmcensus.figures.kinds.ranks import ranks as ranks
    from swarmcensus.figures.kinds.scatter import scatter as scatter

MORE = {"save": "swarmcensus.figures.files", "caption": "swarmcensus.figures.captions"}


def __getattr__(name: str) -> Callable[..., Any]:
    """The function that draws a kind. Raises AttributeError for an unknown kind, InputError if it cannot be loaded."""
    if name in MORE:
        return getattr(importlib.import_module(MORE[name]), name)  # type: ignore[no-any-return]
    if name.startswith("_"):
        raise AttributeError(f"sc.plot has no {name!r}")
    for kind in (name, name.replace("_", "-")):
        if kind in kinds.PLUGINS:
            return kinds.find(kind)
    known = __dir__()
    there = f"{did_you_mean(name, known)}there are {', '.join(known)}"
    raise AttributeError(f"sc.plot has no {name!r}: {there}")


def __dir__() -> list[str]:
    """All kinds, and what is done with figures."""
    return [*(name.replace("-", "_") for name in kinds.PLUGINS.names), *MORE]
