"""Machine code on disk, made by one process at a time, under a seal: a hash of it, so that damage is noticed."""

import contextlib
import hashlib
import os
import types
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from swarmcensus.basics.files import whole

WAIT = 300.0  # seconds after which a process compiles what another one seems to compile for ever
_WAITED_FOR: set[Path] = set()  # files of which that was so
# one for each file, for a thread that compiles may compile something else on the way; a forked process has its own
_LOCKS: dict[tuple[Path, int], FileLock] = {}


def sealed(made: Any, function: types.FunctionType) -> Any:
    """The same compiled function, with a cache on disk of which a damaged file is removed and never loaded.

    Processes that need the same function at the same time compile it once: the others wait, and load it.
    """
    if isinstance(made, types.FunctionType):  # under NUMBA_DISABLE_JIT: nothing is kept
        return made
    from numba.core.compiler_lock import global_compiler_lock

    kept = made._cache
    load, save = kept.load_overload, kept.save_overload
    place = Path(kept.cache_path)
    stem = Path(function.__code__.co_filename).stem
    name = f"{stem}.{function.__name__}"
    seal = place / f"{name}.sha256"

    def files() -> list[Path]:
        return sorted(place.glob(f"{name}-*.nb[ic]"))

    def digest() -> str:
        return hashlib.sha256(b"".join(path.name.encode() + path.read_bytes() for path in files())).hexdigest()

    def load_whole(signature: Any, target: Any) -> Any:
        with contextlib.suppress(Exception):  # whatever a damaged pickle provokes
            if not files() or seal.read_text(encoding="ascii") == digest():
                return load(signature, target)
        for path in (seal, *files()):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
        return None

    def save_sealed(signature: Any, result: Any) -> None:
        save(signature, result)
        if files():
            with whole(seal) as beside:
                beside.write_text(digest(), encoding="ascii")

    compile_it = made.compile

    def compile_once(signature: Any) -> Any:
        # all threads take Numba's own lock first: otherwise two of them could wait for each other for ever
        with global_compiler_lock, contextlib.ExitStack() as held:
            _take(held, place.parent / f"{stem}.lock")
            return compile_it(signature)

    kept.load_overload, kept.save_overload = load_whole, save_sealed
    made.compile = compile_once
    return made


def _take(held: contextlib.ExitStack, path: Path) -> None:
    """Keep other processes from compiling what is in a file; where nothing can be locked, compile all the same."""
    if path in _WAITED_FOR:
        return
    lock = _LOCKS.setdefault((path, os.getpid()), FileLock(path, timeout=WAIT))
    with contextlib.suppress(OSError, NotImplementedError):  # said where a disk locks nothing
        try:
            held.enter_context(lock)
        except Timeout:
            _WAITED_FOR.add(path)
