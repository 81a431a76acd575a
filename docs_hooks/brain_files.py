"""Pages show what brain files say, so that rules, deviations and parameters are written once, in the file.

Its docstring and parameters stand below the paragraph that links the file. On a forge readers follow the link.
"""

from __future__ import annotations

import ast
import re
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # so that tests can use it without mkdocs
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

LIBRARY = "../src/swarmcensus/brains/library/"
PARAGRAPH = re.compile(r"^(?:The rule|Source, rule and deviations): .*?(?=\n\n|\Z)", re.MULTILINE | re.DOTALL)
PARAMETERS = re.compile(r"^PARAMETERS = \{.*?^\}", re.MULTILINE | re.DOTALL)
FILE = re.compile(rf"\]\({re.escape(LIBRARY)}(\w+\.py)\)")


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Add what the linked files say."""
    return PARAGRAPH.sub(lambda found: "\n\n".join([found[0], *map(_shown, FILE.findall(found[0]))]), markdown)


def _shown(name: str) -> str:
    source = (Path(__file__).parents[1] / "docs" / LIBRARY / name).read_text(encoding="utf-8")
    text = (ast.get_docstring(ast.parse(source)) or "").replace(":\n- ", ":\n\n- ")  # Markdown lists follow empty lines
    parameters = "".join(f"\n\n```python\n{block}\n```" for block in PARAMETERS.findall(source))
    return f'??? quote "{name}"\n\n{textwrap.indent(text + parameters, "    ")}'
