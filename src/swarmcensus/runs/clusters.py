"""Where one machine is too small: bundles run by the workers of a Dask cluster, to the same bits.

What travels is a study as text, with the sources of its brains; a worker reads it as a results file is read. The
scheduler holds it, so that workers may come late, go and come back.
"""

import contextlib
import functools
import logging
import pickle
import platform
import tempfile
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

from swarmcensus import brains, metrics
from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.basics.options import option
from swarmcensus.basics.version import __version__
from swarmcensus.brains import adversary
from swarmcensus.runs.queues import NO_PAGE, Jobs, ended_politely, read_queue
from swarmcensus.runs.tasks import Bundle, Outcome, metrics_of, run_bundle
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study

NEEDS = "clusters need Dask: pip install 'swarmcensus[cluster]'"
EACH = 4  # bundles a worker at the least, so that the last ones end together
SHORTEST, LONGEST = 0.2, 1.0  # predicted seconds of a bundle, and more for a crowd of workers:
RATE = 200.0  # bundles a second at the most, for Dask takes a few milliseconds to hand one out
AT_HAND = 3  # bundles a worker has waiting
CONNECT = "10s"  # for a scheduler to answer
ASK_SECONDS = 2.0  # between questions for how many workers there are
SAME_BITS = ("numpy", "numba", "networkx")  # what numbers depend on, beside swarmcensus and Python
LOST = "the cluster is gone: what was finished is kept, and the same command goes on with it"


class Workers:
    """The workers of a cluster, as a pool that bundles are handed to."""

    def __init__(self, client: Any, study: Study, expected: int, renew: Callable[[], str] = str) -> None:
        """Leave the study with the scheduler.

        `expected` workers are counted on until they are there; `renew` is called now and then to replace lost ones, and
        says why there are none, where it knows.
        """
        self.client, self._expected, self._renew = client, expected, renew
        self._why = ""
        self._asked = time.monotonic()
        self._there: int = sum(client.nthreads().values())
        self._key = f"swarmcensus-{uuid.uuid4().hex}"
        client.set_metadata(self._key, zlib.compress(pickle.dumps(payload_of(study)), 1))
        self._executor = client.get_executor(pure=False)

    @property
    def width(self) -> int:
        """How many bundles should be at hand. Raises InputError where no scheduler answers any more."""
        if time.monotonic() - self._asked > ASK_SECONDS:
            try:
                self._there = sum(self.client.nthreads().values())
                self._why = self._renew()
            except (OSError, TimeoutError) as error:
                raise InputError(LOST) from error
            self._asked = time.monotonic()
        return AT_HAND * max(1, self._there)

    @property
    def note(self) -> str:
        """What to tell a person who waits."""
        return "" if self._there else ": ".join(filter(None, ("waiting for workers", self._why)))

    def bundle_seconds(self, work: float) -> float:
        """How long a bundle should be, of so many seconds of work."""
        count = max(self._expected, self._there)
        return min(max(work / (EACH * count), SHORTEST), max(LONGEST, count / RATE))

    def submit(self, bundle: Bundle) -> Future[Outcome]:
        """Have a bundle run by a worker."""
        return self._executor.submit(run_remotely, self._key, bundle)  # type: ignore[no-any-return]

    def halt(self) -> None:
        """Nothing to tell: bundles are short, and are cancelled by whoever waits for them."""

    def explain(self, error: BaseException) -> str | None:
        """Why a bundle was lost though its study goes on; None where it cannot, InputError where the cluster is."""
        from distributed import KilledWorker

        if isinstance(error, KilledWorker):
            return "its worker died again and again (out of memory?)"
        if isinstance(error, CancelledError | OSError):
            raise InputError(LOST) from error
        return None

    def forget(self) -> None:
        """Have the scheduler forget the study, if it is there still."""
        if self.client.status == "running":
            with contextlib.suppress(OSError, TimeoutError, CancelledError):
                self.client.set_metadata(self._key, None)


def versions() -> dict[str, str]:
    """Of all that the bits depend on."""
    known = {name: metadata.version(name) for name in SAME_BITS}
    return {"swarmcensus": __version__, "Python": platform.python_version(), **known}


def payload_of(study: Study) -> dict[str, Any]:
    """All that a worker must know of a study: plain text and numbers."""
    context = study.context
    sources = {name: (brain.source, str(brain.path)) for name, brain in context["brains"].items()}
    lying = {name: (one.source, str(one.path)) for name, one in context["adversaries"].items()}
    watched = {name: (metric.source, str(metric.path)) for name, metric in context["metrics"].items()}
    return {"versions": versions(), "text": study.text, **context, "brains": sources, "adversaries": lying,
            "metrics": watched}  # fmt: skip


def run_remotely(key: str, bundle: Bundle) -> Outcome:
    """Run a bundle in a worker's process. Raises InputError where the worker has other versions."""
    study, settings = _study(key)
    return run_bundle(settings, study.seed, bundle, metrics_of(study), np.zeros(1, np.uint8))


@functools.lru_cache(maxsize=2)
def _study(key: str) -> tuple[Study, list[Setting]]:
    from distributed import get_worker
    from distributed.utils import sync

    worker = get_worker()  # type: ignore[no-untyped-call]
    return read(pickle.loads(zlib.decompress(sync(worker.loop, worker.scheduler.get_metadata, keys=[key]))))  # type: ignore[no-untyped-call]


def read(payload: dict[str, Any]) -> tuple[Study, list[Setting]]:
    """A study as it was sent, and its settings. Raises InputError where it was sent by other versions."""
    differ = [f"{name} {mine} there, {payload['versions'].get(name)} here"
              for name, mine in versions().items() if mine != payload["versions"].get(name)]  # fmt: skip
    if differ:
        raise InputError(f"a worker would not give the same bits: {'; '.join(differ)}")
    known = {name: brains.parse(source, name, Path(path)) for name, (source, path) in payload["brains"].items()}
    lying = {name: adversary.parse(source, name, Path(path)) for name, (source, path) in payload["adversaries"].items()}
    watched = {name: metrics.parse(source, name, Path(path)) for name, (source, path) in payload["metrics"].items()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # whoever sent it was warned
        context = {"edges": payload["edges"], "images": payload["images"], "brains": known, "adversaries": lying,
                   "metrics": watched}  # fmt: skip
        study = Study.parse(payload["text"], where="the study as sent", context=context)
    return study, study.settings()


@contextlib.contextmanager
def workers(where: str, study: Study, show: Callable[[str], None]) -> Iterator[Workers]:
    """The workers of a scheduler's address, of "local:4", or of a TOML file. Raises InputError."""
    expected, queue = 1, None
    if where.startswith("local:"):
        expected = _count(where)
    elif "://" not in where:
        queue = read_queue(Path(where))
        expected = queue.jobs * queue.cores
    try:
        import distributed
    except ImportError:
        raise InputError(NEEDS) from None
    renew: Callable[[], str] = str  # nothing to do, and nothing to say
    with contextlib.ExitStack() as stack:
        stack.enter_context(_quiet())
        if where.startswith("local:"):
            show(f"starting {expected} worker processes")
            scratch = stack.enter_context(tempfile.TemporaryDirectory(ignore_cleanup_errors=True))
            try:
                cluster: Any = distributed.LocalCluster(  # type: ignore[no-untyped-call]
                    n_workers=expected, threads_per_worker=1, silence_logs="CRITICAL", local_directory=scratch,
                    dashboard_address=NO_PAGE["dashboard_address"], scheduler_kwargs=NO_PAGE,
                )  # fmt: skip
            except (OSError, RuntimeError) as error:
                raise InputError(f"{option('cluster', where)}: no processes could be started: {error}") from error
            stack.enter_context(cluster)
        elif queue is None:
            cluster = where
        else:
            show(f"submitting {counted(queue.jobs, 'job')} of {counted(queue.cores, 'worker')} to {queue.system}")
            stack.enter_context(ended_politely())
            try:
                cluster = stack.enter_context(queue.start())
                renew = Jobs(cluster, queue).renew
            except ImportError:
                raise InputError(NEEDS) from None
            except (OSError, RuntimeError, ValueError) as error:
                raise InputError(f"{where}: no jobs could be submitted: {error}") from error
        try:
            client: Any = distributed.Client(cluster, timeout=CONNECT, set_as_default=False)  # type: ignore[no-untyped-call]
        except TypeError:
            raise InputError(
                f"{where} needs certificates, which Dask's configuration should name (distributed.comm.tls)"
            ) from None
        except (OSError, TimeoutError, ValueError) as error:
            raise InputError(f"no Dask scheduler answers at {where}: {error}") from None
        stack.enter_context(client)
        pool = Workers(client, study, expected, renew)
        try:
            yield pool
        finally:
            pool.forget()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep what Dask logs off the terminal: what a person should know is told by a note or an error."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client", "tornado.application")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _count(where: str) -> int:
    text = where.removeprefix("local:")
    if not text.isdigit() or int(text) < 1:
        raise InputError(f"{option('cluster', where)}: should be local: and a number of processes, as local:4")
    return int(text)
