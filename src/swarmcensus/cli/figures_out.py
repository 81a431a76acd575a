"""The files of a figure that a command draws, checked before time is spent."""

from pathlib import Path

from swarmcensus.support.errors import InputError


def figure_files(
    out: Path, default: tuple[str, ...] = ("png", "svg"), *inputs: Path, is_stem: bool = False
) -> tuple[Path, tuple[str, ...]]:
    """The path without its suffix, and the formats to write. Raises InputError if they cannot be written.

    With `is_stem` what follows a point in the name is no suffix.
    """
    from swarmcensus.support.files import check_writable

    if not out.suffix and (out.is_dir() or out.name in ("", "..")):
        raise InputError(f"cannot write {out}: it is a folder", file=out)
    suffix = "" if is_stem else out.suffix.lower().lstrip(".")
    if suffix and suffix not in ("png", "svg", "pdf"):
        raise InputError.of(out, "figures are written as .png, .svg or .pdf")
    stem, formats = (out.with_suffix(""), (suffix,)) if suffix else (out, default)
    for ending in formats:
        check_writable(stem.with_name(f"{stem.name}.{ending}"), *inputs)
    return stem, formats
