"""Files appear whole or not at all: written beside their name, then renamed."""

import contextlib
import errno
import os
import re
import secrets
from collections.abc import Callable, Iterator
from pathlib import Path

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.options import option


@contextlib.contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its name once the block ends well; a link's target, its target's.

    Raises InputError where the place cannot be written, or is a device, a pipe or a folder.
    """
    try:
        place = _place(path)
        _folder_of(place)
        place.parent.mkdir(parents=True, exist_ok=True)
        beside = place.with_name(f".{place.stem}-{secrets.token_hex(4)}{place.suffix}")
        beside.touch(exist_ok=False)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from error
    try:
        yield beside
        _to_disk(beside)  # a power cut must not leave a name without its bytes
        beside.replace(place)
        with contextlib.suppress(OSError):  # not every system can do this
            _to_disk(place.parent)
    except OSError as error:
        raise InputError(f"cannot write {path}: {reason(error)}") from error
    finally:
        beside.unlink(missing_ok=True)


def reason(error: Exception) -> str:
    """What the system says of an error, also where HDF5 hides it in a long text."""
    number = re.search(r"errno = (\d+)", str(error))
    told = error.strerror if isinstance(error, OSError) else None
    return told or (os.strerror(int(number[1])) if number else str(error).partition("\n")[0])


def remove_leftovers(path: str | Path) -> None:
    """Remove what processes that were killed while they wrote `path` left beside it; nobody else may be writing it."""
    place = Path(os.path.realpath(path))
    with contextlib.suppress(OSError):
        for left in place.parent.iterdir():
            if is_leftover(left, re.escape(place.stem), re.escape(place.suffix)):
                left.unlink(missing_ok=True)


def is_leftover(path: Path, stem: str, suffix: str) -> bool:
    """Whether this is a file as `whole` begins it, for a name of such stem and suffix (regular expressions)."""
    ours = re.fullmatch(rf"\.(?:{stem})-[0-9a-f]{{8}}{suffix}", path.name)
    return ours is not None and path.is_file() and not path.is_symlink()


def _to_disk(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _place(path: str | Path) -> Path:
    """Where a file of this name really lies. Raises OSError where no file can."""
    place = Path(os.path.realpath(path))
    if place.is_symlink():
        raise OSError(errno.ELOOP, "its links lead round in a circle")
    if place.is_dir():
        raise IsADirectoryError("it is a folder")
    if os.path.lexists(place) and not place.is_file():
        raise OSError("it is a device or a pipe, not a file")
    return place


def _folder_of(place: Path) -> Path:
    """The innermost folder above a place that is there. Raises OSError where a file stands in its stead."""
    folder = next(p for p in place.parents if p.exists())
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder} is a file, not a folder")
    return folder


def check_writable(path: str | Path, *inputs: Path) -> None:
    """Raise InputError now where `path` could not be written at the end of a long run, or is one of the inputs."""
    try:
        place = _place(path)
        folder = _folder_of(place)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from error
    if any(place == Path(os.path.realpath(source)) for source in inputs):
        raise InputError(f"cannot write {path}: it is what is read")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"cannot write {path}: the folder {folder} cannot be written")


def check_own(page: Path, is_ours: Callable[[str], bool], command: str) -> None:
    """Raise InputError where a command's page cannot be written, or is somebody else's, by what it says."""
    check_writable(page)
    if page.exists() and not is_ours(page.read_text(encoding="utf-8", errors="replace")):
        raise InputError(f"{page} is there, and no page of {command}: write to another folder with {option('out')}")


def data_path(out: Path, study: str) -> Path:
    """Where the results of a study go in a folder with a page."""
    return out / "data" / f"{study}.nc"


def shipped_study(name: str) -> Path:
    """Where a study file, or a folder of them, is. Raises InputError where it is missing."""
    package = Path(__file__).parents[1]
    for place in (package / "shipped_studies" / name, package.parents[1] / "studies" / name):
        if place.exists():
            return place
    raise InputError(f"study files are missing: this installation has no {package / 'shipped_studies' / name}")


def shipped_studies() -> dict[str, Path]:
    """All of them by their names, as ring or paper/topologies. Raises InputError where they are missing."""
    root = shipped_study("")
    found = {path.relative_to(root).with_suffix("").as_posix(): path for path in root.rglob("*.toml")}
    return dict(sorted(found.items(), key=lambda item: (item[0].count("/"), item[0])))
