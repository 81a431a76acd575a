"""The version of swarmcensus next to the link to its repository."""

from mkdocs.config.defaults import MkDocsConfig

import swarmcensus


def on_config(config: MkDocsConfig) -> None:
    """Set it."""
    config.extra["version"] = swarmcensus.__version__
