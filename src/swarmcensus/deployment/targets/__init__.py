"""Targets that brains are deployed to, one file each; another package's are entry points of `swarmcensus.targets`."""

from swarmcensus.basics.hints import did_you_mean
from swarmcensus.basics.options import wrong_option
from swarmcensus.basics.plugins import Plugins
from swarmcensus.deployment.target import Target

PLUGINS = Plugins("target", "swarmcensus.targets", "swarmcensus.deployment.targets")


def find(name: str) -> Target:
    """The target of this name. Raises InputError."""
    if name not in PLUGINS:
        hint = did_you_mean(name, PLUGINS.names)
        raise wrong_option("target", name, f"{hint}should be one of {', '.join(PLUGINS.names)}")
    target = PLUGINS.module(name)
    found: Target = getattr(target, "TARGET", target)
    return found
