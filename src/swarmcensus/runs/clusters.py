"""Bundles run by the workers of a Dask cluster, with the same results to the last bit.

Workers receive a study as text, with the sources of its brains, and read it as they would read a results file. The
scheduler keeps it, so that workers may start late, stop and return.
"""

import contextlib
import functools
import logging
import pickle
import platform
import time
import uuid
import warnings
import zlib
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from swarmcensus import brains
from swarmcensus.brains import adversary, metrics
from swarmcensus.runs.devices import Device, Hardware, open_card
from swarmcensus.runs.pools import Pool
from swarmcensus.runs.tasks import Bundle, Outcome, metrics_of, run_bundle
from swarmcensus.studies import Setting, Study
from swarmcensus.support.errors import InputError
from swarmcensus.support.plugins import PluginFile
from swarmcensus.support.version import __version__

NEEDS = "clusters need Dask: pip install 'swarmcensus[cluster]'"
BUNDLES_PER_WORKER = 4  # at least, so that all workers finish at about the same time
SHORTEST, LONGEST = 0.2, 1.0  # predicted seconds of a bundle; longer if there are very many workers
BUNDLES_PER_SECOND = 200.0  # at most: Dask takes a few milliseconds to submit one
WAITING_PER_WORKER = 3  # bundles submitted per worker
CONNECT = "10s"  # for a scheduler to answer
COUNT_SECONDS = 2.0  # between two counts of the workers
SAME_BITS = ("numpy", "numba", "networkx")  # packages that results depend on, besides swarmcensus and Python
PARSERS: dict[str, Callable[[str, str, Path], Any]] = {  # of the files that a study's context holds by name
    "brains": brains.parse, "adversaries": adversary.parse, "metrics": metrics.parse,
}  # fmt: skip
LOST = "the cluster is gone: finished work is kept, and the same command continues from there"


class Workers(Pool):
    """The workers of a cluster, as a pool that runs bundles."""

    def __init__(self, client: Any, study: Study, device: Device = "cpu") -> None:
        """Send the study to the scheduler; `device` is the workers'."""
        self.client, self._device = client, device
        self._last_count = time.monotonic()
        self._worker_count: int = sum(client.nthreads().values())
        self._key = f"swarmcensus-{uuid.uuid4().hex}"
        client.set_metadata(self._key, zlib.compress(pickle.dumps(payload_of(study)), 1))
        self._executor = client.get_executor(pure=False)

    @property
    def queue_length(self) -> int:
        """How many bundles should be submitted at a time. Raises InputError if the scheduler no longer answers."""
        if time.monotonic() - self._last_count > COUNT_SECONDS:
            try:
                self._worker_count = sum(self.client.nthreads().values())
            except (OSError, TimeoutError) as error:
                raise InputError(LOST) from error
            self._last_count = time.monotonic()
        return WAITING_PER_WORKER * max(1, self._worker_count)

    @property
    def note(self) -> str:
        """A note for a person who waits, or an empty text."""
        return "" if self._worker_count else "waiting for workers"

    def bundle_seconds(self, work: float) -> float:
        """How long a bundle should take, if `work` seconds of work remain."""
        count = max(1, self._worker_count)
        return min(max(work / (BUNDLES_PER_WORKER * count), SHORTEST), max(LONGEST, count / BUNDLES_PER_SECOND))

    def submit(self, bundle: Bundle) -> Future[Outcome]:
        """Start a bundle on a worker."""
        on_card = (self._device,) if any(task.on_card for task in bundle) else ()
        return self._executor.submit(run_remotely, self._key, bundle, *on_card)  # type: ignore[no-any-return]

    def halt(self) -> None:
        """Do nothing: bundles are short, and the caller cancels those that wait."""

    def why_lost(self, error: BaseException) -> str | None:
        """Why a bundle was lost, or None if the study cannot go on. Raises InputError if the cluster is lost."""
        from distributed import KilledWorker

        if isinstance(error, KilledWorker):
            return "its worker died again and again (out of memory?)"
        if isinstance(error, CancelledError | OSError):
            raise InputError(LOST) from error
        return None

    def forget(self) -> None:
        """Delete the study from the scheduler, if that is still there."""
        if self.client.status == "running":
            with contextlib.suppress(OSError, TimeoutError, CancelledError):
                self.client.set_metadata(self._key, None)


def versions() -> dict[str, str]:
    """The versions of all packages that results depend on."""
    known = {name: metadata.version(name) for name in SAME_BITS}
    return {"swarmcensus": __version__, "Python": platform.python_version(), **known}


def payload_of(study: Study) -> dict[str, Any]:
    """A study as plain text and numbers, for a worker."""
    context = study.context
    sources = {kind: {name: (file.source, str(file.path)) for name, file in context[kind].items()} for kind in PARSERS}
    plugins = [(file.kind, file.name, file.source, str(file.path)) for file in context["plugins"]]
    return {"versions": versions(), "text": study.text, **context, **sources, "plugins": plugins}


def run_remotely(key: str, bundle: Bundle, device: Device = "cpu") -> Outcome:
    """Run a bundle in a worker's process. Raises InputError if the worker has other versions, or has no such device."""
    study, settings = _study(key)
    given = settings, study.seed, bundle, metrics_of(study), np.zeros(1, np.uint8)
    if device == "cpu":
        return run_bundle(*given)
    from swarmcensus.gpu import CardError

    try:
        return run_bundle(*given, card=open_card(device))
    except CardError as error:
        if device == "auto":
            return run_bundle(*given)
        raise type(error)(f"the worker on {platform.node()}: {error}") from None


@functools.lru_cache(maxsize=2)
def _study(key: str) -> tuple[Study, list[Setting]]:
    from distributed import get_worker
    from distributed.utils import sync

    worker = get_worker()  # type: ignore[no-untyped-call]
    return read_payload(pickle.loads(zlib.decompress(sync(worker.loop, worker.scheduler.get_metadata, keys=[key]))))  # type: ignore[no-untyped-call]


def read_payload(payload: dict[str, Any]) -> tuple[Study, list[Setting]]:
    """A study from its payload, and its settings. Raises InputError if the sender has other versions."""
    differ = [f"{name} {version} there, {payload['versions'].get(name)} here"
              for name, version in versions().items() if version != payload["versions"].get(name)]  # fmt: skip
    if differ:
        raise InputError(f"a worker would not give the same bits: {'; '.join(differ)}")
    files = {
        kind: {name: parse(source, name, Path(path)) for name, (source, path) in payload[kind].items()}
        for kind, parse in PARSERS.items()
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the sender was warned already
        plugins = [PluginFile(kind, name, source, Path(path)) for kind, name, source, path in payload["plugins"]]
        context = {"edges": payload["edges"], "images": payload["images"], **files, "plugins": plugins}
        study = Study.parse(payload["text"], where="the study as sent", context=context)
    return study, study.settings()


@contextlib.contextmanager
def workers(hardware: Hardware, study: Study) -> Iterator[Workers]:
    """Workers of the scheduler of a cluster. Raises InputError."""
    where = hardware.cluster
    try:
        import distributed
    except ImportError:
        raise InputError(NEEDS) from None
    with contextlib.ExitStack() as stack:
        stack.enter_context(_silent_dask())
        try:
            client: Any = distributed.Client(where, timeout=CONNECT, set_as_default=False)  # type: ignore[no-untyped-call]
        except TypeError:
            needs = f"{where} needs certificates, which Dask's configuration should name (distributed.comm.tls)"
            raise InputError(needs, key="cluster", value=where) from None
        except (OSError, TimeoutError, ValueError) as error:
            silent = f"no Dask scheduler answers at {where}: {error}"
            raise InputError(silent, key="cluster", value=where) from None
        stack.enter_context(client)
        pool = Workers(client, study, hardware.device)
        try:
            yield pool
        finally:
            pool.forget()


@contextlib.contextmanager
def _silent_dask() -> Iterator[None]:
    """Keep Dask's log messages off the terminal: notes and errors say what a person should know."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client", "tornado.application")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
