"""The world of a swarm: sensors, networks, floors, bodies, arenas and faults; parsed, validated and drawn here.

In: values of a study's tables, addresses of random numbers.
Out: arrays of accuracies, links, colours and faults; the robustness of networks.
Must not know: brains, studies, settings, what is measured.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swarmcensus.worlds.robustness import is_rs_robust, r_robustness

__all__ = ["is_rs_robust", "r_robustness"]


def __getattr__(name: str) -> Any:
    """Import on first use: most programs use neither."""
    if name in __all__:
        from swarmcensus.worlds import robustness

        return getattr(robustness, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
