"""The version of swarmcensus next to the link to its repository; without a repository no page can be edited there."""

from mkdocs.config.defaults import MkDocsConfig

import swarmcensus


def on_config(config: MkDocsConfig) -> None:
    """Set them."""
    config.extra["version"] = swarmcensus.__version__
    if not config.repo_url:
        config.edit_uri = None
