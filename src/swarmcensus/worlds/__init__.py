"""What surrounds a mind: sensors, networks, floors, bodies, arenas, faults; each parsed, validated and drawn here.

In: values of a study's tables, keys.
Out: accuracies, links, colours, stops, as arrays; how robust a network is.
Must not know: brains, studies, settings, what is measured.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swarmcensus.worlds.robustness import is_rs_robust, r_robustness

__all__ = ["is_rs_robust", "r_robustness"]


def __getattr__(name: str) -> Any:
    """Import on first use: most studies ask for neither."""
    if name in __all__:
        from swarmcensus.worlds import robustness

        return getattr(robustness, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
