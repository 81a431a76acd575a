"""The kinds of figures: one file each, and kinds of other installed packages in the group `swarmcensus.figures`.

A kind is a function with the file's name. Its only positional argument is a study's results. Its keyword-only
parameters are its options, also on the command line, where `--option` gives those without a flag. It returns a
matplotlib Figure. A kind with the option `out` writes that file itself and returns the number of its frames. Every kind
also takes the options of `PageOptions`.
"""

import inspect
from collections.abc import Callable
from types import ModuleType
from typing import Any

from swarmcensus.support.errors import InputError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.plugins import Plugins

Kind = inspect.Parameter
PLUGINS = Plugins("figure", "swarmcensus.figures", __name__)


def find(name: str) -> Callable[..., Any]:
    """The function that draws a kind. Raises InputError if there is none, or if its parameters are wrong."""
    if name not in PLUGINS:
        known = PLUGINS.names
        there = f"{did_you_mean(name, known)}there are {', '.join(known)}"
        raise InputError(f"no figure {name!r}: {there}", key="kind", value=name)
    loaded = PLUGINS.module(name)
    function: Callable[..., Any] | None = loaded
    if isinstance(loaded, ModuleType):
        function = getattr(loaded, name.replace("-", "_"), None)
    if name in PLUGINS.shipped and function is not None:
        return function
    if not callable(function) or not _is_kind(function):
        raise PLUGINS.error(name, "should be a function of results and keyword-only options")
    from swarmcensus.figures.page import on_page  # imports matplotlib

    return on_page(function)


def _is_kind(function: Callable[..., Any]) -> bool:
    first, *others = [p.kind for p in inspect.signature(function).parameters.values()] or [Kind.VAR_POSITIONAL]
    return first in (Kind.POSITIONAL_ONLY, Kind.POSITIONAL_OR_KEYWORD) and {*others} <= {Kind.KEYWORD_ONLY}
