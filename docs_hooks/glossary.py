"""Tooltips: the first use of a word on a page shows what the glossary of docs/concepts.md says of it.

Words that often mean something else have none.
"""

import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

GLOSSARY = "concepts.md"
UNMARKED = {"reading", "round", "setting", "interval", "estimate", "N"}
MADE = ("reference/command-line.md",)  # of help texts, whose words are options
ROW = re.compile(r"^\| \*\*(.+?)\*\*[^|]* \| (.+?) \|$", re.MULTILINE)
K = re.compile(r'(?<!<em>)<abbr title="[^"]*">K</abbr>')  # a number, unless it is italic
SHOWN = re.compile(r'<abbr title="[^"]*">(.*?)</abbr>', re.DOTALL)
HEADING = re.compile(r"<(h\d|summary|a)\b.*?</\1>", re.DOTALL)


def words() -> dict[str, str]:
    """What the glossary says, as plain text."""
    text = (Path(__file__).parents[1] / "docs" / GLOSSARY).read_text(encoding="utf-8")
    _, _, table = text.partition("## Glossary")
    return {
        word: re.sub(r"\[(.*?)\]\(.*?\)|[*`]", r"\1", told) for word, told in ROW.findall(table) if word not in UNMARKED
    }


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Define the words for the page."""
    if page.file.src_uri in (GLOSSARY, *MADE):
        return markdown
    return "\n".join([markdown, "", *(f"*[{word}]: {told}" for word, told in words().items()), ""])


def on_page_content(html: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Leave the first of each word, and none in headings and links."""
    html = K.sub("K", html)
    html = HEADING.sub(lambda found: SHOWN.sub(r"\1", found[0]), html)
    seen = set()

    def first(found: re.Match[str]) -> str:
        is_new = found[1] not in seen
        seen.add(found[1])
        return found[0] if is_new else found[1]

    return SHOWN.sub(first, html)
