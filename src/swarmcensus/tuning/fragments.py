"""What a search leaves for a person: a study file's line with the values found, and below which evidence."""

import textwrap
from collections.abc import Sequence

from swarmcensus.brains import Brain
from swarmcensus.studies.toml_text import to_toml_value

WIDTH = 110


def fragment(
    brain: Brain, searched: Sequence[str], head: Sequence[str], evidence: Sequence[str], told: Sequence[str]
) -> str:
    """TOML text: comments of what came of it, the line to paste, and comments of how it came to be.

    The line names all parameters that were searched, those too that are as the brain's file says.
    """
    table = {"file": brain.name, **{name: brain.parameters[name] for name in searched}, **dict(brain.given)}
    lines = [*_comments(head), "#", *_comments(evidence)]
    lines += ["", "[swarm]", f"brain = [{to_toml_value(table)}]", "", *_comments(told)]
    return "\n".join(lines) + "\n"


def _comments(lines: Sequence[str]) -> list[str]:
    return [
        f"{'# ' if k == 0 else '#   '}{part}"
        for line in lines
        for k, part in enumerate(textwrap.wrap(line, WIDTH, break_long_words=False, break_on_hyphens=False))
    ]
