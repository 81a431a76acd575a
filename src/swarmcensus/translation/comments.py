"""The comments of a Python source, by line, for a translation that keeps them."""

import io
import re
import tokenize
from collections.abc import Iterator

from swarmcensus.support.control_characters import printable


class Comments:
    """The comments of a source; each is given out once."""

    def __init__(self, source: str) -> None:
        """Read all comments."""
        self.trailing: dict[int, str] = {}  # by line: comments after code
        self.alone: dict[int, str] = {}  # comments that have a line of their own
        for token in tokenize.generate_tokens(io.StringIO(source).readline):
            if token.type == tokenize.COMMENT:
                line, column = token.start
                is_alone = not token.line[:column].strip()
                (self.alone if is_alone else self.trailing)[line] = plain(token.string.lstrip("#"))

    def above(self, line: int, begin: int = 0) -> Iterator[str]:
        """The comments on lines of their own from `begin` to above `line`."""
        for place in sorted(place for place in self.alone if begin <= place < line):
            yield self.alone.pop(place)

    def at(self, first: int, last: int) -> str:
        """The comments after the code of these lines, both included."""
        found = [self.trailing.pop(line) for line in range(first, last + 1) if line in self.trailing]
        return "; ".join(found)


def plain(text: str) -> str:
    """A text that can follow // in C: a line must not end in a backslash, and ?? may begin a trigraph."""
    return re.sub(r"\?(?=\?)", "? ", text.strip().rstrip("\\ \t\f\v"))


def remark(text: str) -> str:
    """A comment after a line of C, unless the text is empty."""
    return f"  // {text}" if text else ""


def quoted(label: str) -> str:
    """A brain's label, which has its file's name, for a comment or docstring: it ends neither, and is one line."""
    return plain(printable(" ".join(label.split()).replace("\\", "/").replace('"', "'")))
