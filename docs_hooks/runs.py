"""Runs that play in pages: each an export of the live page, made when the site is built.

A page shows one with `<iframe class="run" src="runs/NAME.html">`, and the frame leaves out the live page's panels.
"""

import functools

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files, InclusionLevel

from swarmcensus.live.exporting import page_of
from swarmcensus.live.offers import PLAYED, offer_of

RUNS = {
    "arena": {"topology": "moving", "fill_ratio": "0.55", "brain": "census", "density": "2", "rounds": "900"},
}  # what --set of `swarmcensus watch` would say
MEMORIES = 100_000  # bytes of robots' memories in a run


def on_files(files: Files, *, config: MkDocsConfig) -> None:
    """Add the runs to the site."""
    for name in RUNS:
        files.append(File.generated(config, f"runs/{name}.html", content=run(name), inclusion=InclusionLevel.INCLUDED))


@functools.cache  # so that `mkdocs serve` makes them once
def run(name: str) -> str:
    """The page of a run."""
    asked = {key: value for key, value in RUNS[name].items() if key not in PLAYED}
    played = {key: value for key, value in RUNS[name].items() if key in PLAYED}
    return page_of(offer_of(None), asked, played, memories=MEMORIES)
