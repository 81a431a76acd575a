"""Shards: finished trials on disk while a run goes on, so that nothing is lost if it is killed.

A shard is a NumPy archive of plain numbers; opening it runs no code. Its name ends in the hash of its bytes, so a
damaged shard is recognised before it is read. A setting is identified by its fingerprint, a trial by its number.
"""

import contextlib
import functools
import hashlib
import io
import json
import re
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import IO, Any, Self

import numpy as np
from numpy.typing import NDArray

from swarmcensus.results.existing_files import folder_of
from swarmcensus.results.values import ALL_VARIABLES, Piece, metrics_in, metrics_label, shapes
from swarmcensus.studies import UNNAMED
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.files import atomic_write, is_leftover, remove_leftovers
from swarmcensus.support.options import option
from swarmcensus.support.owners import Busy, Owner, owner_of

FORMAT = "swarmcensus shard 1"
SKETCH = "study.nc"  # the dataset without trials: see `partial`
LOCK = "lock"  # the file of the run that owns the folder
OTHER_FILES = (LOCK, "run.json", "fresh", SKETCH)  # other files in the folder of shards
NAME = re.compile(r"(\d{6,})-([0-9a-f]{32})\.npz")
METRIC = "metric "  # prefix of a metric's column
HASH = functools.partial(hashlib.blake2b, digest_size=16)
ITEM = np.dtype([("setting", "S32"), ("first", "i4"), ("trials", "i4"), ("robots", "i4"), ("local", "?")])
SPOOLED_BYTES = 4_000_000  # largest shard that is assembled in memory
SKETCH_AFTER = 1.0, 3e-3  # seconds, and seconds per setting: shorter runs need no partial results
AT_LEAST, AT_MOST, OF_ELAPSED = 0.25, 30.0, 0.002  # seconds between shards, which limits their number


@dataclass(frozen=True)
class Identity:
    """What two runs must have in common for their trials to be combined."""

    study: str
    seed: int
    version: str
    delta: float
    bins: int
    truth: str
    metrics: str  # metric files and their hashes

    @classmethod
    def of(cls, data: Any) -> Self:
        """The identity of the run, or merged runs, that results are of."""
        of, metrics = data.attrs, metrics_label(metrics_in(data))
        return cls(of["title"], of["seed"], of["swarmcensus_version"], of["delta"], of["bins"], of["truth"], metrics)

    def check(self, other: Mapping[str, Any], where: str, hint: str) -> None:
        """Raise InputError with the differences, if `other` is the identity of another run."""
        ours = asdict(self)
        differ = [k for k, v in ours.items() if other.get(k) != v]
        if other.get("study") == UNNAMED and "study" in differ:  # the run began before the study had a name
            differ.remove("study")
        if differ:
            differences = "; ".join(f"{k} is {other.get(k)!r} there and {ours[k]!r} here" for k in differ)
            other_run = f"{where} is of another run: {differences}. {hint}"
            raise ResultsError(other_run, file=where, key=differ[0], value=ours[differ[0]])


@dataclass
class Shard:
    """The content of a shard: what is said about the run, and the finished trials, of settings by fingerprint."""

    about: dict[str, Any]
    found: list[Piece] = field(default_factory=list)


def read(path: Path) -> Shard | None:
    """Read a shard; None if it is damaged or was not written by a run. Raises InputError if it cannot be read."""
    name = NAME.fullmatch(path.name)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}", file=path) from error
    if name is None or HASH(data).hexdigest() != name[2]:
        return None
    try:
        with np.load(io.BytesIO(data)) as arrays:
            about = json.loads(arrays["about"].tobytes())
            if min(float(about[key]) for key in ("wall_seconds", "cpu_seconds", "work")) < 0.0:
                return None
            return Shard(about, list(_unpacked(arrays, about)))
    except Exception:  # an archive of other things may raise anything
        return None


def shard_files(folder: Path) -> list[Path]:
    """The shards of a folder in the order in which they were written."""
    named = (path for path in folder.glob("*.npz") if NAME.fullmatch(path.name))
    return sorted(path for path in named if path.is_file() and not path.is_symlink())


def owner(folder: Path) -> str:
    """The run that is using this folder now, in words; empty if none is."""
    return owner_of(folder / LOCK)


class Parts:
    """The shards of one run; inside its `with` block no other run can write the same output."""

    def __init__(self, out: Path, identity: Identity, checkpoints: Sequence[int], fingerprints: Sequence[str]) -> None:
        """Identify the run; `fingerprints` are those of its settings."""
        self.out, self.folder = out, folder_of(out)
        self.identity, self.checkpoints, self.fingerprints = identity, list(checkpoints), fingerprints
        self.lock = Owner(self.folder / LOCK)
        self.sketch: Callable[[Path], None] | None = None  # writes the dataset without trials, once
        self.added = False  # whether this run finished anything
        self.device = ""  # the card that runs some of it
        self._waiting: list[Piece] = []
        self._work = 0.0

    def __enter__(self) -> Self:
        """Take the lock. Raises InputError if another run has it, or if a link leads elsewhere."""
        for path in (self.folder, *(self.folder / name for name in OTHER_FILES)):
            if path.is_symlink() or (path.is_dir() and path != self.folder):
                what = "link" if path.is_symlink() else "folder"
                why = f"{path} is a {what}: a run keeps its work there, and leaves none; remove it"
                raise InputError(why, file=path)
        try:
            self.lock.__enter__()
        except Busy as owner:
            raise ResultsError.of(self.out, f"another run is writing it ({owner})") from None
        except OSError as error:
            raise InputError(f"cannot write {self.folder}: {error.strerror or error}", file=self.folder) from error
        self._begun = self._last = time.monotonic()
        self._cpu = time.process_time()
        for left in self.folder.glob(".*.npz"):  # left by a run that was killed while writing
            if is_leftover(left, NAME.pattern.removesuffix(r"\.npz"), r"\.npz"):
                left.unlink(missing_ok=True)
        for path in (self.out, self.folder / "run.json", self.folder / SKETCH):
            remove_leftovers(path)
        self._next = max((int(path.name.partition("-")[0]) for path in shard_files(self.folder)), default=0) + 1
        return self

    def __exit__(self, *_: object) -> None:
        """Release the lock, and remove the folder if it is empty."""
        if not shard_files(self.folder) and self.lock.keeps():
            self.clear()
        self.lock.__exit__()
        with contextlib.suppress(OSError):
            self.folder.rmdir()  # it may be gone, or hold shards

    def announce(self, **state: Any) -> None:
        """Write run.json, which `status` reads."""
        state |= asdict(self.identity)
        with atomic_write(self.folder / "run.json") as temporary:
            temporary.write_text(json.dumps(state, indent=1), encoding="utf-8")

    def every_shard(self) -> Iterator[tuple[Path, Shard | None]]:
        """Yield every shard, None for a damaged one. Raises InputError for a shard of another run."""
        fresh, out = option("fresh", True), option("out")
        hint = f"Remove the folder, run with {fresh}, or write elsewhere with {out} ({self.folder})"
        for path in shard_files(self.folder):
            shard = read(path)
            if shard is not None:
                self.identity.check(shard.about, str(path), hint)
            yield path, shard

    def add(self, pieces: Sequence[Piece], work: float) -> None:
        """Keep finished trials, written to disk within seconds; `work` is their predicted cost in seconds."""
        self.added |= bool(pieces)
        self._waiting += pieces
        self._work += work
        now = time.monotonic()
        if now - self._last >= min(max(AT_LEAST, OF_ELAPSED * (now - self._begun)), AT_MOST):
            self.flush()

    def flush(self) -> None:
        """Write all waiting trials as one shard. Raises InputError if the disk is full, or the folder another run's."""
        if not self.lock.keeps():
            raise ResultsError.of(self.out, f"another run has taken it over ({owner(self.folder)})")
        if not self._waiting:
            return
        now, cpu = time.monotonic(), time.process_time()
        if self.sketch and now - self._begun >= SKETCH_AFTER[0] + SKETCH_AFTER[1] * len(self.fingerprints):
            self.sketch(self.folder / SKETCH)
            self.sketch = None
        about = asdict(self.identity) | {"format": FORMAT, "checkpoints": self.checkpoints}
        about |= {"wall_seconds": now - self._last, "cpu_seconds": cpu - self._cpu, "work": self._work}
        about |= {"device": self.device} if self.device else {}
        try:
            with tempfile.SpooledTemporaryFile(SPOOLED_BYTES, dir=str(self.folder.parent)) as packed:
                _pack(packed, about, self._waiting, self.fingerprints)
                packed.seek(0)
                name = f"{self._next:06d}-{hashlib.file_digest(packed, HASH).hexdigest()}.npz"
                packed.seek(0)
                with atomic_write(self.folder / name) as temporary, temporary.open("wb") as file:
                    shutil.copyfileobj(packed, file)
        except OSError as error:
            raise InputError(f"cannot write {self.folder}: {error.strerror or error}", file=self.folder) from error
        self._waiting, self._work = [], 0.0
        self._last, self._cpu = now, cpu
        self._next += 1

    @property
    def replaces(self) -> bool:
        """Whether the shards belong to a run with `fresh`, which will replace the output."""
        return (self.folder / "fresh").exists()

    def begin_anew(self) -> None:
        """Remove the shards, and note that the output is to be replaced."""
        self.clear()
        (self.folder / "fresh").touch()

    def clear(self) -> None:
        """Remove the shards, once their trials are in the output or not wanted."""
        # the mark is removed first: while it exists, trials of the output are not taken over
        for path in (self.folder / "fresh", *shard_files(self.folder), self.folder / "run.json", self.folder / SKETCH):
            path.unlink(missing_ok=True)


def _pack(out: IO[bytes], about: dict[str, Any], pieces: Sequence[Piece], fingerprints: Sequence[str]) -> None:
    """Write pieces as a shard; a single large piece is not copied."""
    items = np.array([(fingerprints[p.setting], p.first, *p.shape, p.local) for p in pieces], ITEM)
    flat: dict[str, list[NDArray[Any]]] = {}
    for piece in pieces:
        for name, values in piece.columns.items():
            flat.setdefault(name, []).append(values.ravel())
    watched = [name for name in flat if name not in ALL_VARIABLES]
    about = about | {"of_swarm": [n for n in watched if any(n in p.columns and p.columns[n].ndim == 1 for p in pieces)]}
    text = np.frombuffer(json.dumps(about).encode(), np.uint8)
    names = {name: name if name in ALL_VARIABLES else METRIC + name for name in flat}
    columns = {names[k]: v[0] if len(v) == 1 else np.concatenate(v) for k, v in flat.items()}
    np.savez(out, about=text, items=items, **columns)  # type: ignore[arg-type]


def _unpacked(arrays: Mapping[str, NDArray[Any]], about: Mapping[str, Any]) -> Iterator[Piece]:
    flat = {name.removeprefix(METRIC): arrays[name] for name in arrays if name not in ("about", "items")}
    used = dict.fromkeys(flat, 0)
    for setting, first, trials, robots, local in arrays["items"].astype(ITEM, casting="equiv").tolist():
        if min(first, trials - 1, robots - 1) < 0:
            raise ValueError("no trials")
        taken = {}
        for name, shape in shapes(trials, robots, len(about["checkpoints"]), local, flat, about["of_swarm"]).items():
            size = int(np.prod(shape))
            taken[name] = flat[name][used[name] : used[name] + size].reshape(shape)
            used[name] += size
        yield Piece(setting.decode(), first, taken, local)
