"""What pages need on a phone: a short piece of code stays on one line, and a picture opens alone, to be made larger."""

import html
import re

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

SHORT = 24  # characters: fit into a column of a table
CODE = re.compile(r"(<pre\b.*?</pre>)|<code>([^<]*)</code>", re.DOTALL)
PICTURE = re.compile(r'(<a\b[^>]*>.*?</a>)|<img\b[^>]*\bsrc="([^"]+)"[^>]*>', re.DOTALL)


def on_page_content(content: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Mark short code, and link each picture to itself."""
    return PICTURE.sub(_picture, CODE.sub(_code, content))


def _code(found: re.Match[str]) -> str:
    is_short = not found[1] and len(html.unescape(found[2])) <= SHORT
    return f'<code class="short">{found[2]}</code>' if is_short else found[0]


def _picture(found: re.Match[str]) -> str:
    return found[0] if found[1] else f'<a href="{found[2]}">{found[0]}</a>'
