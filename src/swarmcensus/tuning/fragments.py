"""What a search leaves for a person: a study file's line with the values found, and below which evidence."""

import textwrap
from collections.abc import Sequence

from swarmcensus.brains import Brain
from swarmcensus.studies.toml_text import to_toml_value

WIDTH = 110


def fragment(brain: Brain, head: Sequence[str], evidence: Sequence[str], told: Sequence[str]) -> str:
    """TOML text: comments of what came of it, the line to paste, and comments of how it came to be."""
    lines = [*_comments(head), "#", *_comments(evidence)]
    lines += ["", "[swarm]", f"brain = [{to_toml_value(brain)}]", "", *_comments(told)]
    return "\n".join(lines) + "\n"


def _comments(lines: Sequence[str]) -> list[str]:
    return [
        f"{'# ' if k == 0 else '#   '}{part}"
        for line in lines
        for k, part in enumerate(textwrap.wrap(line, WIDTH, break_long_words=False, break_on_hyphens=False))
    ]
