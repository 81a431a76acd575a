"""Text files of users: in UTF-8, or in UTF-16 as PowerShell and Excel write it."""

import codecs
from pathlib import Path
from typing import Literal

from swarmcensus.support.errors import InputError
from swarmcensus.support.files import LARGEST, content
from swarmcensus.support.hints import did_you_mean_file

BEGIN = 400  # bytes that show whether a text without a mark is in UTF-16
MARKS = {
    codecs.BOM_UTF32_LE: "utf-32", codecs.BOM_UTF32_BE: "utf-32", codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16",
}  # fmt: skip
BINARY = {
    b"PK": "a ZIP archive or a spreadsheet", b"\x1f\x8b": "compressed", b"\x93N": "an array of NumPy",
    b"\x80\4": "a pickle", b"\x80\5": "a pickle",
}  # fmt: skip  # how files begin that are no texts


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
        if name != "UTF-8":
            raise ValueError(f"it begins as {name}, and is cut or damaged: save it as UTF-8") from None
        line, byte = found.count(b"\n", 0, error.start) + 1, found[error.start]
        letter = bytes([byte]).decode("cp1252", "replace")
        meant = f", and {letter!r} in Windows-1252" if letter.isprintable() and b"\0" not in found else ""
        what = f"line {line} has the byte 0x{byte:02x}, which is not UTF-8{meant}: save it as UTF-8"
        if kind := BINARY.get(found[:2]):
            what = f"it is {kind}: unpack it, or save it as CSV"
        raise ValueError(what) from None
    zeros = [found[k:BEGIN:2].count(0) for k in (0, 1)]
    if errors == "strict" and encoding == "utf-8" and 5 * max(zeros) > min(len(found), BEGIN):
        raise ValueError("it seems to be in UTF-16 without a byte order mark: save it as UTF-8")
    return text
