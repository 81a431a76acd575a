"""What the search finds first: pages that explain a word come before those that only use it or have it in a heading."""

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

BOOSTS = {
    "index.md": 3,
    "beyond.md": 3,
    "concepts.md": 3,
    "data-format.md": 2,
    "liars.md": 2,
    "long-studies.md": 3,
    "study-file.md": 2,
}
WORDS = {"concepts.md": ["K", "fill ratio", "accuracy"], "paper.md": ["reproduce"]}


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> None:
    """Set it here, so that pages keep no front matter for a forge to show."""
    if page.file.src_uri in BOOSTS:
        page.meta["search"] = {"boost": BOOSTS[page.file.src_uri]}
    if page.file.src_uri in WORDS:
        page.meta["tags"] = WORDS[page.file.src_uri]
