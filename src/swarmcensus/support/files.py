"""Writing files atomically, checks of output paths before long runs, and the paths of shipped studies."""

import contextlib
import errno
import os
import re
import secrets
import stat
from collections.abc import Callable, Iterator
from pathlib import Path

from swarmcensus.support.errors import InputError
from swarmcensus.support.options import option, wrong_option

LARGEST = 20_000_000  # bytes of a file that a person wrote


def content(path: str | Path, most: int | None = LARGEST) -> bytes:
    """What a file holds. Raises OSError, also for devices and pipes, which may never end, and for too large a file."""
    kind = os.stat(path).st_mode
    if not stat.S_ISREG(kind) and not stat.S_ISDIR(kind):
        raise OSError("it is a device or a pipe, not a file")
    with open(path, "rb") as file:
        found = file.read(-1 if most is None else most + 1)
    if most is not None and len(found) > most:
        raise OSError(f"it is over {most:,} bytes")
    return found


@contextlib.contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """Write a file whole or not at all: yields a temporary path, which is renamed to `path` when the block succeeds.

    If `path` is a link, the file that it points to is replaced. Raises InputError if the file cannot be written, or is
    a device, a pipe or a folder.
    """
    try:
        target, _ = _target(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = target.with_name(f".{target.stem}-{secrets.token_hex(4)}{target.suffix}")
        temporary.touch(exist_ok=False)
        try:
            yield temporary  # what the block itself raises as OSError, such as a full disk, is reported likewise
            _sync(temporary)  # a power cut must not leave an empty file under the name
            temporary.replace(target)
            with contextlib.suppress(OSError):  # some systems cannot sync folders
                _sync(target.parent)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}", file=path) from error


def remove_leftovers(path: str | Path) -> None:
    """Remove the temporary files of processes that were killed while they wrote `path`; none may be writing it now."""
    target = Path(os.path.realpath(path))
    with contextlib.suppress(OSError):
        for file in target.parent.iterdir():
            if is_leftover(file, re.escape(target.stem), re.escape(target.suffix)):
                file.unlink(missing_ok=True)


def is_leftover(path: Path, stem: str, suffix: str) -> bool:
    """Whether `path` is a temporary file of `atomic_write`; `stem` and `suffix` are regular expressions."""
    match = re.fullmatch(rf"\.(?:{stem})-[0-9a-f]{{8}}{suffix}", path.name)
    return match is not None and path.is_file() and not path.is_symlink()


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _target(path: str | Path) -> tuple[Path, Path]:
    """The path with links resolved, and the innermost existing folder above it.

    Raises OSError if no file can be written there.
    """
    if str(path) == "-":
        raise OSError("it is a sign for standard output, where no file is written: name a file")
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise OSError(errno.ELOOP, "its links lead round in a circle")
    if target.is_dir():
        raise IsADirectoryError("it is a folder")
    if os.path.lexists(target) and not target.is_file():
        raise OSError("it is a device or a pipe, not a file")
    folder = next(p for p in target.parents if p.exists())
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder} is a file, not a folder")
    return target, folder


def check_writable(path: str | Path, *inputs: Path) -> None:
    """Raise InputError before a long run if `path` cannot be written, or is one of the inputs."""
    try:
        target, folder = _target(path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}", file=path) from error
    if any(target == Path(os.path.realpath(source)) for source in inputs):
        raise InputError(f"cannot write {path}: it is an input", file=path)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"cannot write {path}: the folder {folder} cannot be written", file=path)


def check_output(name: str, path: str | Path | None, suffixes: tuple[str, ...], *inputs: Path) -> None:
    """Raise InputError before a long run if the output of an option has another ending, or cannot be written."""
    if path is None:
        return
    if Path(path).suffix.lower() not in suffixes:
        raise wrong_option(name, str(path), f"what this writes ends in {' or '.join(suffixes)}")
    check_writable(path, *inputs)


def check_own(page: Path, is_ours: Callable[[str], bool], command: str) -> None:
    """Raise InputError if the page of a command cannot be written, or an existing file is not such a page."""
    check_writable(page)
    if page.exists() and not is_ours(page.read_text(encoding="utf-8", errors="replace")):
        elsewhere = f"write to another folder with {option('out')}"
        raise InputError(f"{page} exists, and is not a page of {command}: {elsewhere}", file=page)


def data_path(out: Path, study: str) -> Path:
    """The path of a study's results in a folder with a page."""
    return out / "data" / f"{study}.nc"


def shipped_study(name: str) -> Path:
    """The path of a shipped study file or folder. Raises InputError if it is missing."""
    package = Path(__file__).parents[1]
    for path in (package / "shipped_studies" / name, package.parents[1] / "studies" / name):
        if path.exists():
            return path
    missing = package / "shipped_studies" / name
    raise InputError(f"study files are missing: this installation has no {missing}", file=missing)


def shipped_studies() -> dict[str, Path]:
    """The paths of all shipped studies by name, such as ring or paper/topologies. Raises InputError."""
    root = shipped_study("")
    studies = {path.relative_to(root).with_suffix("").as_posix(): path for path in root.rglob("*.toml")}
    return dict(sorted(studies.items(), key=lambda item: (item[0].count("/"), item[0])))


def check_no_log(path: Path) -> None:
    """Raise InputError if this is the log of one robot."""
    if path.suffix.lower() == ".log" and path.is_file():
        right = f"relive, watch and export read the folder that it is in, {path.parent}"
        raise InputError(f"{path} is the log of one robot: {right}", file=path)
