"""From sources to machine code that is kept: the engine's loops once a machine, few short functions for every brain.

Numba caches machine code beside a source file and does not see what that file imports. So each brain gets
a folder of its own, named by the hash of all that the code depends on, with a copy of the brain, of the
phases of a round, and of a few lines that fit the brain's fields to the engine's rows; and so do the loops.
"""

import atexit
import contextlib
import functools
import hashlib
import importlib
import importlib.util
import os
import shutil
import sys
import tempfile
import threading
import types
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from swarmcensus.brains import Brain, numbers
from swarmcensus.engine import glue
from swarmcensus.engine.keeping import sealed
from swarmcensus.engine.modes import PHASES
from swarmcensus.metrics import GIVEN, Metric

HERE = Path(__file__).parent
SOURCES = (
    "draws.py",
    "random.py",
    "modes.py",
    "wishes.py",
    "calling.py",
    "swarms.py",
    "compiler.py",
)  # what all code depends on
WALK = ("motion.py", "neighbours.py")
PARTS = {  # what a file imports from its own folder
    "kernel": ("rounds.py", "minds.py"),
    "riding": ("minds.py",),
    "walk": WALK,
    "steering": ("riding.py", "minds.py", "walk.py", *WALK),
}
ALWAYS = ("sense", "hear", "end_round", "believe")  # what of a brain is needed with whatever neighbours


class NotCompiled(Exception):
    """A brain of which Numba makes no machine code, in Numba's own words."""

    def __init__(self, brain: Brain, said: str) -> None:
        """Say which, and why."""
        super().__init__(said)
        self.brain = brain


def compiled(function: types.FunctionType, checked: bool = False) -> Any:
    """Machine code without the GIL that divides as CPython does: by zero is an error, not infinity.

    Where it is `checked`, so is an index beyond a vector's ends, which would be somebody else's memory.
    """
    import numba

    return numba.njit(nogil=True, error_model="python", forceinline=True, boundscheck=checked or None)(function)


def entry(function: types.FunctionType) -> Any:
    """The same, kept on disk: what CPython calls."""
    import numba

    return sealed(numba.njit(nogil=True, error_model="python", cache=True)(function), function)


def not_compiled() -> bool:
    """Whether Numba is switched off, and CPython runs all of the engine."""
    import numba

    return bool(numba.config.DISABLE_JIT)  # type: ignore[attr-defined]


@functools.lru_cache(maxsize=64)
def record_type(brain: Brain) -> np.dtype:
    """A robot's mind as a NumPy record."""
    return np.dtype((np.record, glue.record_fields(brain)))  # np.record: attributes work in CPython too


def blank(brain: Brain) -> np.ndarray:
    """A mind before its first observation: MEMORY's values and parameters, then room for what is given, (number,)."""
    told = [*numbers(brain.memory), *numbers(brain.parameters)]
    return np.array([*told, *(0.0 for _ in range(width(brain) - len(told)))])


def width(brain: Brain) -> int:
    """How many numbers a mind is."""
    return record_type(brain).itemsize // 8


def outbox(brain: Brain, robots: int, mixed: bool = False) -> np.ndarray:
    """Room for what so many robots say in a round, as the loops keep it."""
    return np.zeros((robots, glue.outbox_width(brain, mixed)))


def flag_of(brain: Brain, mixed: bool = False) -> int:
    """Where in that it stands whether a robot said anything; -1 where all do."""
    return glue.outbox_width(brain, mixed) - 1 if glue.is_flagged(brain, mixed) else -1


def records(brain: Brain, minds: np.ndarray) -> np.ndarray:
    """Minds (..., field) as records with the brain's names, shape (...)."""
    return minds.view(record_type(brain))[..., 0]


def blank_record(metric: Metric, **given: float) -> np.ndarray:
    """What a metric's record is before `begin`, shape (1,): what is GIVEN, and its fields."""
    record = np.zeros(1, np.dtype((np.record, [(name, np.float64) for name in (*GIVEN, *metric.fields)])))
    for name, value in given.items():
        record[name] = value
    return record


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


@functools.cache
def _scratch() -> Path:
    """A cache for this process alone, on a machine without a usable one; says so once."""
    folder = Path(tempfile.mkdtemp(prefix="swarmcensus-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    try:
        where = f"the cache {cache_root()} cannot be used"
    except OSError:
        where = "there is no home folder to keep a cache in"
    warnings.warn(f"{where}: brains are compiled for this run alone ($SWARMCENSUS_CACHE names another)", stacklevel=2)
    return folder


def _write_once(folder: Path, files: dict[str, str]) -> None:
    """Make the folder whole or not at all; a race is won by whoever renames first."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    beside = Path(tempfile.mkdtemp(prefix="making-", dir=folder.parent))
    beside.chmod(0o755)
    for name, text in files.items():
        (beside / name).write_bytes(text.encode())
    try:
        beside.rename(folder)
    except OSError:
        shutil.rmtree(beside, ignore_errors=True)
        if not folder.is_dir():
            raise


def compile_brain(brain: Brain, use: str = "network", exact: bool = False, mixed: bool = False) -> Any:
    """The addresses of a brain's functions, by their places in `modes.py`, as the engine's loops take them.

    Only what the use needs is there: "network", "moving", "alone" (local estimates) or "recorded". Brains that differ
    in comments or parameters share machine code; `exact` is for messages that name a line of the very file; a `mixed`
    swarm has several brains. Raises NotCompiled.
    """
    return _compiled(brain.as_written, use, exact, mixed)


@functools.lru_cache(maxsize=256)
def _compiled(brain: Brain, use: str, exact: bool, mixed: bool) -> Any:
    needed = needs(brain, use, mixed)
    try:
        module = phases_of(brain, exact, mixed)
        with _LOCK:
            found = [getattr(module, name).address() if name in needed else None for name in PHASES]
    except MemoryError:
        raise
    except Exception as error:
        raise NotCompiled(brain, str(error)) from error
    if not_compiled():
        return np.array(found, object)
    return np.array([address or 0 for address in found], np.uint64)


def needs(brain: Brain, use: str, mixed: bool = False) -> set[str]:
    """Which of a brain's functions a use calls."""
    judged = {"judge"} if mixed or brain.decides or brain.ends else set()
    if use == "alone":
        return {"go_alone", "believe"}
    in_sums = {"network": {"hear_sums", "add_up", "hear_all"}, "moving": {"hear_sums"}}
    sums = in_sums.get(use, set()) if brain.sums and not mixed else set()
    asked = {"ask"} if use == "moving" and brain.steers else set()
    return {*ALWAYS, *judged, *sums, *asked}


def phases_of(brain: Brain, exact: bool = False, mixed: bool = False) -> types.ModuleType:
    """The module `phases.py` around a brain, none of it compiled yet."""
    return _module(_brain_files(brain, exact or not_compiled(), mixed), "phases")  # a debugger wants the very file


@functools.lru_cache(maxsize=64)
def compile_metric(metric: Metric) -> types.ModuleType:
    """The module `watching.py` around a metric."""
    files = {"__init__.py": "", "metric.py": metric.source, "gauge.py": glue.of_metric(metric)}
    return _module(files | {"watching.py": _source("watching.py")}, "watching")


@functools.cache
def compile_world(name: str = "world") -> types.ModuleType:
    """The engine's entry points of one file, which know of no brain."""
    return _module(_world_files(name), name)


def is_known(world: str) -> bool:
    """Whether machine code of a file of the engine's loops is on disk."""
    with contextlib.suppress(OSError):
        return any((cache_root() / _digest(_world_files(world)) / "__pycache__").glob(f"{world}.*.nbc"))
    return False


def is_compiled(brain: Brain, use: str = "network", mixed: bool = False) -> bool:
    """Whether all that a use needs of a brain is on disk as machine code."""
    with contextlib.suppress(OSError):
        kept = cache_root() / _digest(_brain_files(brain, mixed=mixed)) / "__pycache__"
        return all(any(kept.glob(f"phases.{name}-*.nbc")) for name in needs(brain, use, mixed))
    return False


def _world_files(name: str) -> dict[str, str]:
    return {"__init__.py": "", **{part: _source(part) for part in (f"{name}.py", *PARTS.get(name, ()))}}


def _source(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")


def _brain_files(brain: Brain, exact: bool = False, mixed: bool = False) -> dict[str, str]:
    return {
        "__init__.py": "",
        "brain.py": brain.source if exact else glue.essence(brain.source),
        "mind.py": glue.of_brain(brain, mixed),
        "phases.py": _source("phases.py"),
    }


@functools.cache
def _engine() -> tuple[str, ...]:
    from importlib.metadata import version  # Numba itself may not be needed

    return (*map(_source, SOURCES), sys.version, version("numba"), np.__version__)


def _digest(files: dict[str, str]) -> str:
    return hashlib.sha256("\0".join((*_engine(), *files.values())).encode()).hexdigest()[:24]


_LOCK = threading.Lock()


def _module(files: dict[str, str], main: str) -> types.ModuleType:
    with _LOCK:  # a module is in sys.modules before it is whole
        return _load(files, main)


def _load(files: dict[str, str], main: str) -> types.ModuleType:
    digest = _digest(files)
    name = f"_swarmcensus_{digest}"
    if f"{name}.{main}" in sys.modules:
        return sys.modules[f"{name}.{main}"]
    folder = _folder(digest, files)
    try:
        return _imported(name, folder, main)
    except Exception:  # Python's own compiled files beside the sources may be damaged: they are made anew
        for known in [known for known in sys.modules if known.partition(".")[0] == name]:
            del sys.modules[known]
        shutil.rmtree(folder, ignore_errors=True)
        importlib.invalidate_caches()
        return _imported(name, _folder(digest, files), main)


def _imported(name: str, folder: Path, main: str) -> types.ModuleType:
    # under NUMBA_DISABLE_JIT nothing is cached, and debuggers and coverage want the source in its own place
    homes = [HERE, folder] if not_compiled() else [folder]
    spec = importlib.util.spec_from_file_location(
        name, folder / "__init__.py", submodule_search_locations=list(map(str, homes))
    )
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
        if folder.is_dir() and not all(_holds(folder / name, text) for name, text in files.items()):
            shutil.rmtree(folder)  # damaged, or what cleaners of old files leave
        if not folder.is_dir():
            _write_once(folder, files)
        if os.access(folder, os.R_OK | os.W_OK | os.X_OK):
            return folder
    except OSError:
        pass
    folder = _scratch() / digest
    if not folder.is_dir():
        _write_once(folder, files)
    return folder


def _holds(path: Path, text: str) -> bool:
    return path.is_file() and path.read_bytes() == text.encode()
