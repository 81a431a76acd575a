"""Folders that appear whole or not at all."""

import contextlib
import fnmatch
import os
import secrets
import shutil
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from swarmcensus.support.errors import InputError


def check_free(folder: Path, may_replace: Collection[str] = ()) -> None:
    """Raise InputError unless the folder is not there, or holds only files that may be replaced, given as patterns."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file: name a new folder", file=folder)
    names = sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []
    others = [name for name in names if not any(fnmatch.fnmatchcase(name, pattern) for pattern in may_replace)]
    if others:
        raise InputError(f"the folder {folder} is not empty, it holds {others[0]!r}: name a new folder", file=folder)


def check_same(folder: Path, texts: Mapping[str, str]) -> None:
    """Raise InputError if the folder has one of these files, and with another text."""
    for name, text in texts.items():
        path = folder / name
        if path.exists() and not (path.is_file() and path.read_bytes() == text.encode()):
            raise InputError(f"the folder {folder} holds another {name!r}: delete it, or name a new folder", file=path)


@contextlib.contextmanager
def new_folder(folder: Path, may_replace: Collection[str] = ()) -> Iterator[Path]:
    """A temporary folder next to `folder`, which is moved there when the block succeeds. Raises InputError."""
    check_free(folder, may_replace)
    target = Path(os.path.abspath(folder))
    made = target.with_name(f".{target.name}-{secrets.token_hex(4)}")
    try:
        made.mkdir(parents=True)
        yield made
        if target.is_dir():
            for path in made.iterdir():
                path.replace(target / path.name)
        else:
            made.rename(target)
    except OSError as error:
        raise InputError(f"cannot write {folder}: {error.strerror or error}", file=folder) from error
    finally:
        shutil.rmtree(made, ignore_errors=True)


def write_texts(folder: Path, texts: Mapping[str, str]) -> None:
    """Write files, texts by name, into an existing folder."""
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
