"""Files appear whole or not at all: written beside their name, then renamed."""

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path

from swarmcensus.errors import InputError


@contextlib.contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its name once the block ends well.

    Raises InputError where the place cannot be written.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            raise IsADirectoryError("it is a folder")
        beside = path.with_name(f".{path.stem}-{secrets.token_hex(4)}{path.suffix}")
        beside.touch(exist_ok=False)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from error
    try:
        yield beside
        beside.replace(path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        beside.unlink(missing_ok=True)


def check_writable(path: str | Path, *inputs: Path) -> None:
    """Raise InputError now where `path` could not be written at the end of a long run, or is one of the inputs."""
    path = Path(path)
    if any(path.absolute().resolve() == source.absolute().resolve() for source in inputs):
        raise InputError(f"cannot write {path}: it is what is read")
    folder = next(p for p in path.absolute().parents if p.exists())
    if path.is_dir():
        raise InputError(f"cannot write {path}: it is a folder")
    if not folder.is_dir() or not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"cannot write {path}: the folder {folder} cannot be written")
