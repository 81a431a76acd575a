"""Folders that appear whole or not at all."""

import contextlib
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path

from swarmcensus.basics.errors import InputError


def check_free(folder: Path, option: str = "--to") -> None:
    """Raise InputError unless the folder, which this option names, can be made: it is not there, or empty."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file: {option} should name a new folder", file=folder)
    if folder.is_dir() and any(folder.iterdir()):
        raise InputError(f"the folder {folder} is not empty: {option} should name a new folder", file=folder)


@contextlib.contextmanager
def new_folder(folder: Path, option: str = "--to") -> Iterator[Path]:
    """A temporary folder beside `folder`, which gets its name when the block succeeds. Raises InputError."""
    check_free(folder, option)
    target = Path(os.path.abspath(folder))
    made = target.with_name(f".{target.name}-{secrets.token_hex(4)}")
    try:
        made.mkdir(parents=True)
        yield made
        if target.is_dir():
            target.rmdir()
        made.rename(target)
    except OSError as error:
        raise InputError(f"cannot write {folder}: {error.strerror or error}", file=folder) from error
    finally:
        shutil.rmtree(made, ignore_errors=True)


def write_texts(folder: Path, texts: Mapping[str, str]) -> None:
    """Write files, texts by name, into an existing folder."""
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
