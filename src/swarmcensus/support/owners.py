"""Locks of files: inside its `with` block one process is at work on something, and no other one is.

They are the system's, which frees them when a process ends, however it ends, also on a file server. A process that was
forked does not have the locks of the one that it is a copy of.
"""

import contextlib
import errno
import logging
import os
import socket
import sys
import time
from pathlib import Path
from typing import Self

from swarmcensus.support.control_characters import printable

LOOK = 0.05  # seconds between two tries
LEAST = 0.2  # seconds of trying: whoever asks for an owner has the lock for an instant
MOST_BYTES = 200  # of a file of ours
NO_LINK = getattr(os, "O_NOFOLLOW", 0)
IS_WINDOWS = sys.platform == "win32"
TAKEN, LACKING = (errno.EAGAIN, errno.EACCES, errno.EDEADLK), (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)
LOG = logging.getLogger(__name__)


class Busy(Exception):
    """Another process is at work: which."""


class Owner:
    """The lock of a file; inside its `with` block no other process, thread or block has it."""

    def __init__(self, path: Path, wait: float = 0.0) -> None:
        """Wait at most so many seconds for another owner."""
        self.path, self.wait = path, max(wait, LEAST)
        self._handle = -1

    def __enter__(self) -> Self:
        """Make and lock the file. Raises Busy, and OSError."""
        until = time.monotonic() + self.wait
        while not self._take():
            if time.monotonic() > until:
                raise Busy(_words(self.path))
            time.sleep(LOOK)
        _HELD.add(self)
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the file, and free it."""
        _HELD.discard(self)
        if IS_WINDOWS:  # which removes no open file
            os.close(self._handle)
        with contextlib.suppress(OSError):
            if IS_WINDOWS or self.is_there():
                self.path.unlink()
        if not IS_WINDOWS:
            os.close(self._handle)

    def keeps(self) -> bool:
        """Whether nobody else can lock the file; one that was removed is made again. Raises OSError."""
        return self.is_there() or self._take()

    def is_there(self) -> bool:
        """Whether the file that is locked is the one at its path."""
        return _is_at(self._handle, self.path)

    def _take(self) -> bool:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        try:
            handle = os.open(self.path, os.O_RDWR | os.O_CREAT | NO_LINK, 0o644)
        except FileNotFoundError:  # a folder may go with its owner
            return False
        try:
            if _lock(handle) and _is_at(handle, self.path):  # the owner before removes the file
                os.ftruncate(handle, 0)
                os.write(handle, f"process {os.getpid()} on {socket.gethostname()}, since {time.ctime()}".encode())
                handle, self._handle = self._handle, handle
                return True
        finally:
            if handle >= 0:
                os.close(handle)
        return False


_HELD: set[Owner] = set()


def _forget() -> None:
    """Close the files of the process that this one is a copy of: as long as a copy is open, they are locked."""
    for owner in _HELD:
        os.close(owner._handle)
    _HELD.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


def owner_of(path: Path) -> str:
    """Who has locked a file, in words; empty if nobody has."""
    try:
        handle = os.open(path, os.O_RDONLY | NO_LINK)
    except FileNotFoundError:
        return ""
    except OSError as error:
        return f"{path}: {error.strerror or error}"
    try:
        return "" if _lock(handle, shared=True) else _words(path)
    finally:
        os.close(handle)


def _words(path: Path) -> str:
    """What an owner says of itself."""
    with contextlib.suppress(OSError), path.open("rb") as file:
        return printable(file.read(MOST_BYTES).decode(errors="replace")) or "another process"
    return "another process"


def _is_at(handle: int, path: Path) -> bool:
    """Whether an open file is the one at a path."""
    try:
        return os.path.samestat(os.fstat(handle), os.stat(path, follow_symlinks=False))
    except FileNotFoundError:
        return False


def _lock(handle: int, shared: bool = False) -> bool:
    """Lock an open file if nobody else has. Where the system has no locks, which is logged, everybody may."""
    try:
        if sys.platform == "win32":
            import msvcrt

            os.lseek(handle, MOST_BYTES, os.SEEK_SET)  # behind what others may read
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
            os.lseek(handle, 0, os.SEEK_SET)
        else:
            import fcntl

            fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in TAKEN:
            return False
        if error.errno not in LACKING:
            raise
        LOG.info("files cannot be locked here (%s): let no two commands write the same output", error.strerror)
    return True
