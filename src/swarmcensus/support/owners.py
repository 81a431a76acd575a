"""Files that say which process is at work on something, so that no other one is: the locks of all commands.

Such a file is made exclusively, which every file system can do; some cannot lock files. Processes that were killed
leave theirs. Whether an owner lives is known where its process can be seen, by its number and the time of its start, as
numbers are used again. An owner on another machine, or in a container, is known by its signs of life: it sets the
file's time every few seconds. This is compared with the time of a new file, as the clocks of machines differ.
"""

import contextlib
import functools
import hashlib
import json
import logging
import os
import secrets
import socket
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, NamedTuple, Self

BEAT = 5.0  # seconds between two signs of life
SILENT = 60.0  # seconds without one, after which an owner that cannot be seen is dead
LOOK = 0.1  # seconds between two looks at another owner
MOST_BYTES = 4096  # of a file of ours
LOG = logging.getLogger(__name__)
HEARTBEAT = "heartbeat"  # name of a thread, which takes no locks: a process may be forked while it runs


class Busy(Exception):
    """Another owner is at work: which, and what its file is."""


class Seen(NamedTuple):
    """A file as it was read."""

    text: bytes
    changed: int  # nanoseconds of the file server's clock

    @property
    def about(self) -> dict[str, Any]:
        """What the owner says of itself; empty if nothing can be understood, as of a file without content."""
        with contextlib.suppress(ValueError):
            about = json.loads(self.text)
            if isinstance(about, dict) and isinstance(about.get("process"), int):
                return about
        return {}

    def __str__(self) -> str:
        """The owner in words."""
        return "process {process} on {host}, since {since}".format(**dict.fromkeys(_myself(), "?") | self.about)

    def lives(self) -> bool | None:
        """Whether the owner's process lives; None if it cannot be seen from here."""
        about = self.about
        if sys.platform == "win32" or about.get("system") != _system():
            return None
        try:
            os.kill(about["process"], 0)
        except (ProcessLookupError, OverflowError):
            return False
        except OSError:  # another user's
            pass
        began = _began(about["process"]), str(about.get("began", ""))
        return began[0] == began[1] if all(began) else None


class Owner:
    """A file of this process; inside its `with` block no other process, thread or block owns it."""

    def __init__(self, path: Path, wait: float = 0.0) -> None:
        """Wait at most so many seconds for a living owner."""
        self.path, self.wait = path, wait
        self._text = json.dumps(_myself() | {"mark": secrets.token_hex(8)}).encode()
        self._silent = False

    def __enter__(self) -> Self:
        """Make the file, also in place of a dead owner's. Raises Busy, and OSError."""
        until, first = time.monotonic() + self.wait, None
        while not self._make():
            if (seen := _look(self.path)) is None:
                continue
            if _is_dead(self.path, seen):
                # of all processes that see a dead owner's file, the owner of another file removes it
                name = f"{self.path.name}-{hashlib.sha256(seen.text).hexdigest()[:16]}"
                with contextlib.suppress(Busy), Owner(self.path.with_name(name)):
                    if _look(self.path) == seen:
                        self.path.unlink()
            elif time.monotonic() >= until and (seen.lives() or first not in (None, seen)):
                raise Busy(f"{seen}; if that has ended, remove {self.path}")
            else:
                if first is None and not seen.lives():
                    LOG.info("waiting up to %.0f s for a sign of life of %s (%s)", SILENT, seen, self.path)
                first = first or seen
                time.sleep(LOOK if seen.lives() else 10 * LOOK)
        self._sign = time.time()
        _HELD.add(self)
        if HEARTBEAT not in {thread.name for thread in threading.enumerate()}:
            threading.Thread(target=_beat, name=HEARTBEAT, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the file."""
        _HELD.discard(self)
        with contextlib.suppress(OSError):
            if self.is_there():
                self.path.unlink()

    def keeps(self) -> bool:
        """Whether the file is still of this owner, which another one may have taken for dead, and ended since.

        A file that was removed is made again, unless this process was silent for so long. Raises OSError.
        """
        silent = self.was_silent()
        return self.is_there() or (not silent and self._make())

    def was_silent(self) -> bool:
        """Whether there ever was so long without a sign of life that another owner may have come; this call is one."""
        now = time.time()  # which goes on while the machine sleeps
        if now - self._sign > SILENT:
            self._silent = True
        self._sign = now
        return self._silent

    def is_there(self) -> bool:
        """Whether the file is there and of this owner. Raises OSError."""
        seen = _look(self.path)
        return seen is not None and seen.text == self._text

    def _make(self) -> bool:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        try:
            handle = os.open(self.path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o644)
        except (FileExistsError, FileNotFoundError):  # a folder may go with its owner
            return False
        try:
            os.write(handle, self._text)
        except OSError:
            self.path.unlink()
            raise
        finally:
            os.close(handle)
        return True


_HELD: set[Owner] = set()
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_HELD.clear)


def _beat() -> None:
    """Give signs of life for the files of this process."""
    while True:
        time.sleep(BEAT)
        for owner in [*_HELD]:
            owner.was_silent()
            with contextlib.suppress(OSError):
                if owner.is_there():
                    os.utime(owner.path)


def owner_of(path: Path) -> str:
    """Who owns a file, in words; empty if nobody does, or somebody who is dead."""
    try:
        seen = _look(path)
        return "" if seen is None or _is_dead(path, seen) else str(seen)
    except OSError as error:
        return f"{path}: {error.strerror or error}"


def _is_dead(path: Path, seen: Seen) -> bool:
    """Whether an owner has ended, or gave no sign of life for long, by the clock of its file server."""
    if (lives := seen.lives()) is not None:
        return not lives
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}-") as now:
        os.utime(now.name)
        return (os.stat(now.name).st_mtime_ns - seen.changed) / 1e9 > SILENT


def _look(path: Path) -> Seen | None:
    """A file's content and time; opening it asks the file server for both."""
    try:
        with path.open("rb") as file:
            return Seen(file.read(MOST_BYTES), os.fstat(file.fileno()).st_mtime_ns)
    except FileNotFoundError:
        if path.is_symlink():
            raise
        return None


def _myself() -> dict[str, Any]:
    process, since = os.getpid(), time.strftime("%Y-%m-%d %H:%M:%S")
    about = {"process": process, "host": socket.gethostname(), "since": since}
    return about | {"system": _system(), "began": _began(process)}


@functools.cache
def _system() -> str:
    """What has the same numbers of processes: a machine from start to end, or a container."""
    parts = [socket.gethostname()]
    with contextlib.suppress(OSError):
        parts += [Path("/proc/sys/kernel/random/boot_id").read_text().strip(), os.readlink("/proc/self/ns/pid")]
    return " ".join(parts)


def _began(process: int) -> str:
    """When a process began, as Linux writes it; empty on other systems, where signs of life decide."""
    with contextlib.suppress(OSError):
        state, *fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return "ended" if state in "ZX" else fields[18]
    return ""
