"""Targets that brains are deployed to, one file each; another package's are entry points of `swarmcensus.targets`."""

from swarmcensus.robots.target import Target
from swarmcensus.support.options import wrong_option
from swarmcensus.support.plugins import Plugins

PLUGINS = Plugins("target", "swarmcensus.targets", "swarmcensus.robots.targets")


def find(name: str) -> Target:
    """The target of this name. Raises InputError."""
    if name not in PLUGINS:
        raise wrong_option("target", name, f"should be one of {', '.join(PLUGINS.names)}")
    target = PLUGINS.module(name)
    return getattr(target, "TARGET", target)  # type: ignore[no-any-return]
