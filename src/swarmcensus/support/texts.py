"""Text files of users: in UTF-8, or in UTF-16 as PowerShell and Excel write it."""

import codecs
from pathlib import Path
from typing import Literal

from swarmcensus.support.errors import InputError
from swarmcensus.support.files import LARGEST, content
from swarmcensus.support.hints import did_you_mean_file

MARKS = {
    codecs.BOM_UTF32_LE: "utf-32", codecs.BOM_UTF32_BE: "utf-32", codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16",
}  # fmt: skip


def read_text(
    path: str | Path, where: str = "", kind: type[InputError] = InputError, *, ending: str = "",
    most: int | None = LARGEST, errors: Literal["strict", "replace"] = "strict", code: bool = False,
) -> str:  # fmt: skip
    """The text of a file in UTF-8, or in UTF-16 or UTF-32 with a byte order mark; its lines end with a line feed.

    `where` is how messages call the file, `kind` the error, `ending` that of files that may be meant instead of a
    missing one, and `most` the largest size in bytes. With `code` it must be UTF-8, which is all that Python imports.
    Raises InputError.
    """
    path = Path(path)
    try:
        found = content(path, most)
    except FileNotFoundError as error:
        hint = did_you_mean_file(path, ending).rstrip()
        raise kind.of(path, f"there is no such file{': ' * bool(hint)}{hint}", where=where) from error
    except (OSError, ValueError) as error:
        raise kind.of(path, f"cannot be read: {getattr(error, 'strerror', None) or error}", where=where) from error
    try:
        text = _decode(found, errors, code)
    except ValueError as error:
        raise kind.of(path, f"cannot be read as text: {error}", where=where) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _decode(found: bytes, errors: str, code: bool) -> str:
    encoding = next((encoding for mark, encoding in MARKS.items() if found.startswith(mark)), "utf-8")
    name = encoding.removesuffix("-sig").upper()
    if code and name != "UTF-8":
        raise ValueError(f"it is in {name}: save it as UTF-8")
    try:
        text = found.decode(encoding, errors)
    except UnicodeDecodeError as error:
        line = found.count(b"\n", 0, error.start) + 1
        raise ValueError(f"line {line} is not {name}: save it as text in UTF-8") from None
    if errors == "strict" and "\0" in text:
        raise ValueError("it is no text, or in another encoding: save it as text in UTF-8")
    return text
