"""The cache of machine code.

Numba caches machine code next to its source file and does not notice changes in what that file imports. So each brain
gets a folder, named by the hash of all that its code depends on, with a copy of the brain, of `brain_calls.py`, and of
the lines of `codegen.py`. The engine's loops have such a folder, too.

A wheel may bring machine code for any processor with some features (SHIPPED, made by `tools/machine_code.py`). It is
used where there is no native code, and only with the very versions that made it, as the names of its folders say.
"""

import atexit
import contextlib
import functools
import gc
import hashlib
import importlib
import importlib.util
import multiprocessing
import os
import pickle
import shutil
import sys
import tempfile
import threading
import types
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from swarmcensus.support.errors import InputError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.owners import Busy, Owner

HERE = Path(__file__).parent
NUMBERS = ("changes.py", "constants.py", "draws.py", "layout.py", "random.py", "records.py")
CALLS = ("calling.py", "compiling.py", "inlined.py", "python_errors.py", "return_values.py")
SOURCES = (*NUMBERS, *CALLS)  # what all code depends on
LOCK = threading.Lock()
SHIPPED = HERE / "machine_code"
NATIVE = threading.Event()  # set in a process that makes native code in place of what is shipped


def not_compiled() -> bool:
    """Whether Numba is switched off, and CPython runs all of the engine."""
    import numba

    return bool(numba.config.DISABLE_JIT)  # type: ignore[attr-defined]


def cache_root() -> Path:
    """Where compiled brains are kept: $SWARMCENSUS_CACHE, or the user's cache folder. Raises OSError without a home."""
    if os.environ.get("SWARMCENSUS_CACHE"):
        return Path(os.environ["SWARMCENSUS_CACHE"])
    if os.environ.get("XDG_CACHE_HOME"):
        return Path(os.environ["XDG_CACHE_HOME"]) / "swarmcensus"
    try:
        return Path("~/.cache/swarmcensus").expanduser()
    except RuntimeError:  # a container's user that no list of users knows
        raise FileNotFoundError("~/.cache/swarmcensus") from None


def keeps() -> bool:
    """Whether compiled code is kept on disk, for other processes too."""
    try:
        root = cache_root()
        root.mkdir(parents=True, exist_ok=True)
        return os.access(root, os.R_OK | os.W_OK | os.X_OK)
    except OSError:
        return False


def is_kept(folder: str, code: str, native: bool = False) -> bool:
    """Whether machine code is on disk, in a folder of the cache, in files whose names match a pattern, or shipped."""
    if not native and (shipped := _shipped()) and any((shipped / folder).glob(code)):
        return True
    with contextlib.suppress(OSError):
        return any((cache_root() / folder / "__pycache__").glob(code))
    return False


def shipped_name(name: str, signature: Any) -> str:
    """The file in which machine code of a function for arguments of these types is shipped, after its own hash."""
    return f"{name}-{hashlib.sha256(str(signature).encode()).hexdigest()[:16]}.nbc"


@functools.cache
def _shipped() -> Path | None:
    """Where machine code is shipped that this processor can run; its file `needs` has the features of processors."""
    try:
        needed = (SHIPPED / "needs").read_text(encoding="ascii").split()
    except OSError:  # nothing is shipped, as with a source installation
        return None
    from llvmlite.binding import get_host_cpu_features

    features = get_host_cpu_features()
    return SHIPPED if all(features.get(name) for name in needed) else None


def _read_shipped(folder: str, name: str) -> Any:
    """What Numba would keep of a function, if it is shipped, and whole."""
    with contextlib.suppress(OSError):
        code = (SHIPPED / folder / name).read_bytes()
        if hashlib.sha256(code[32:]).digest() == code[:32]:
            return pickle.loads(code[32:])
    return None


@functools.cache
def _scratch() -> Path:
    """A cache for this process alone, on a machine without a usable one."""
    _say_not_kept()
    folder = Path(tempfile.mkdtemp(prefix="swarmcensus-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@functools.cache
def _say_not_kept() -> None:
    """Warn, once, that nothing is kept; a forked copy that compiles leaves that to the process that it works for."""
    try:
        where = f"the cache {cache_root()} cannot be used"
    except OSError:
        where = "there is no home folder to keep a cache in"
    if not multiprocessing.current_process().daemon:
        only = "brains are compiled for this run alone ($SWARMCENSUS_CACHE names another)"
        warnings.warn(f"{where}: {only}", stacklevel=2)


def _write_once(folder: Path, files: dict[str, str]) -> None:
    """Make the folder whole or not at all; of processes that race, the first to rename wins."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    unfinished = Path(tempfile.mkdtemp(prefix="making-", dir=folder.parent))
    try:
        unfinished.chmod(0o755)
        for name, text in files.items():
            (unfinished / name).write_bytes(text.encode())
        unfinished.rename(folder)
    except OSError:
        shutil.rmtree(unfinished, ignore_errors=True)
        if not folder.is_dir():
            raise


def source(name: str) -> str:
    """The text of one of the engine's files."""
    return (HERE / name).read_text(encoding="utf-8")


@functools.cache
def _engine() -> tuple[str, ...]:
    from importlib.metadata import version  # Numba itself may not be needed

    versions = [version(name) for name in ("numba", "llvmlite")]
    return (*map(source, SOURCES), str(sys.implementation.cache_tag), *versions, np.__version__)


def folder_name(files: dict[str, str]) -> str:
    """The folder of the cache that machine code of these files has."""
    return hashlib.sha256("\0".join((*_engine(), *files.values())).encode()).hexdigest()[:24]


def module(files: dict[str, str], main: str) -> types.ModuleType:
    """The module `main` of these files by name, imported from the folder where its machine code is kept."""
    with LOCK:  # a module is in sys.modules before it is whole
        return _load(files, main)


def _load(files: dict[str, str], main: str) -> types.ModuleType:
    digest = folder_name(files)
    name = f"_swarmcensus_{digest}"
    if f"{name}.{main}" in sys.modules:
        return sys.modules[f"{name}.{main}"]
    folder, make = _folder(digest, files), _folder
    try:
        return _import_from(name, folder, main)
    except Exception as error:
        for known in [known for known in sys.modules if known.partition(".")[0] == name]:
            del sys.modules[known]
        if "cannot cache function" in str(error):  # in Numba's words: the disk became full, or read-only
            make = _own_folder
        else:  # Python's own compiled files next to the sources may be damaged: they are made again
            shutil.rmtree(folder, ignore_errors=True)
        importlib.invalidate_caches()
        return _import_from(name, make(digest, files), main)


def _import_from(name: str, folder: Path, main: str) -> types.ModuleType:
    # under NUMBA_DISABLE_JIT nothing is cached, and debuggers and coverage want the source in its own place
    homes = [str(HERE), str(folder)] if not_compiled() else [str(folder)]
    spec = importlib.util.spec_from_file_location(name, folder / "__init__.py", submodule_search_locations=homes)
    assert spec is not None
    assert spec.loader is not None
    package = importlib.util.module_from_spec(spec)
    sys.modules[name] = package
    spec.loader.exec_module(package)
    return importlib.import_module(f"{name}.{main}")


def _folder(digest: str, files: dict[str, str]) -> Path:
    """The cache folder, whole; or, on a machine without a usable one, a folder for this process alone."""
    try:
        folder = cache_root() / digest
        there = {path.name: path.read_bytes() for path in folder.glob("*.py") if path.is_file()}
        if folder.is_dir() and not all(there.get(name) == text.encode() for name, text in files.items()):
            shutil.rmtree(folder)  # damaged, or partly removed by a cleaner of old files
        if not folder.is_dir():
            _write_once(folder, files)
        if os.access(folder, os.R_OK | os.W_OK | os.X_OK):
            return folder
    except OSError:
        pass
    return _own_folder(digest, files)


def _own_folder(digest: str, files: dict[str, str]) -> Path:
    try:
        folder = _scratch() / digest
        if not folder.is_dir():
            _write_once(folder, files)
    except OSError as error:
        where = f"nor in the folder of temporary files ({error.strerror}): $TMPDIR names another"
        raise InputError(f"brains cannot be compiled: there is no room in their cache, {where}") from error
    return folder


WAIT = 300.0  # seconds after which a process compiles what another one seems to compile for ever
# files of which that was so, and those that this process owns, as what compiles may compile something else on the way
_NOT_TAKEN: set[Path] = set()


def sealed(made: Any, function: types.FunctionType) -> Any:
    """Make a compiled function check its files in the cache: damaged ones are removed and never loaded.

    Processes that need the same function at the same time compile it once: the others wait, and load it.
    """
    if isinstance(made, types.FunctionType):  # under NUMBA_DISABLE_JIT: nothing is kept
        return made
    from numba.core.compiler_lock import global_compiler_lock

    kept = made._cache
    load, save = kept.load_overload, kept.save_overload
    place = Path(kept.cache_path)
    if not place.is_relative_to(Path(function.__code__.co_filename).parent) and not os.environ.get("NUMBA_CACHE_DIR"):
        raise OSError(f"cannot cache function {function.__name__}: its folder cannot be written")  # not elsewhere
    stem = Path(function.__code__.co_filename).stem
    name = f"{stem}.{function.__name__}"
    seal = place / f"{name}.sha256"

    def files() -> list[Path]:
        return sorted(place.glob(f"{name}-*.nb[ic]"))

    def digest() -> str:
        return hashlib.sha256(b"".join(path.name.encode() + path.read_bytes() for path in files())).hexdigest()

    def load_whole(signature: Any, target: Any) -> Any:
        try:  # whatever a damaged pickle provokes
            is_whole = not files() or seal.read_text(encoding="ascii") == digest()
            native = load(signature, target) if is_whole else None
        except Exception:
            is_whole, native = False, None
        for path in () if is_whole else (seal, *files()):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
        if native is None and not NATIVE.is_set() and _shipped():
            shipped = _read_shipped(place.parent.name, shipped_name(name, signature))
            return shipped and kept._impl.rebuild(target, shipped)
        return native

    def save_sealed(signature: Any, result: Any) -> None:
        try:
            save(signature, result)
            if files():
                with atomic_write(seal) as temporary:
                    temporary.write_text(digest(), encoding="ascii")
        except (OSError, InputError):  # the disk became full or read-only, or the folder was removed
            _say_not_kept()

    compile_it = made.compile

    def compile_once(signature: Any) -> Any:
        # all threads take Numba's own lock first: otherwise two of them could wait for each other for ever
        with global_compiler_lock, contextlib.ExitStack() as held:
            if gc.isenabled():  # little of what a compiler makes is garbage, and to look takes a twentieth of its time
                gc.disable()
                held.callback(gc.enable)
                held.callback(gc.unfreeze)  # moves all to the oldest generation, which is rarely looked at
                held.callback(gc.freeze)
            if not NATIVE.is_set():  # others go on with what is shipped
                _take(held, place.parent / f"{stem}.owner")
            return compile_it(signature)

    kept.load_overload, kept.save_overload = load_whole, save_sealed
    made.compile = compile_once
    return made


def _take(held: contextlib.ExitStack, path: Path) -> None:
    """Keep other processes from compiling the same file; where none can be written, go on without."""
    if path in _NOT_TAKEN:
        return
    with contextlib.suppress(OSError):
        try:
            held.enter_context(Owner(path, WAIT))
            held.callback(_NOT_TAKEN.discard, path)
        except Busy:
            pass
        _NOT_TAKEN.add(path)
