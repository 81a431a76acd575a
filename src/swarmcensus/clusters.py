"""Where one machine is too small: bundles run by the workers of a Dask cluster, to the same bits.

What travels is a study as text, with the sources of its brains; a worker reads it as a results file is read.
"""

import contextlib
import functools
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from swarmcensus import __version__, brains
from swarmcensus.errors import InputError
from swarmcensus.studies import Study, explain, read_toml
from swarmcensus.tasks import Bundle, Outcome, metrics_of, run_bundle

NEEDS = "clusters need Dask: pip install 'swarmcensus[cluster]'"
EACH = 4  # bundles a worker at the least, so that the last ones end together
SHORTEST, LONGEST = 0.2, 5.0  # predicted seconds of a bundle: Dask takes about a millisecond to hand one out
AT_HAND = 3  # bundles a worker has waiting
ASK_SECONDS = 2.0  # between questions for how many workers there are
Whole = Annotated[int, Field(strict=True, ge=1)]


class Queue(BaseModel):
    """A batch system on which workers are started as jobs, by dask-jobqueue: the keys of a cluster's TOML file."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    system: Literal["slurm", "pbs", "sge", "lsf", "htcondor", "oar", "moab"] = "slurm"
    jobs: Whole
    cores: Whole  # of each job: as many worker processes
    memory: str  # of each job, as "16GB"
    walltime: str | None = None
    partition: str | None = None
    account: str | None = None
    interface: str | None = None  # the network that workers and this process share, as "ib0"
    directives: list[str] = []  # further lines of the job script's head, as "--exclusive"
    prologue: list[str] = []  # shell commands before a worker starts, as "source ~/venv/bin/activate"
    scratch: str | None = None

    def start(self) -> Any:
        """Submit the jobs; returns the dask-jobqueue cluster."""
        import dask_jobqueue

        kinds = {"slurm": "SLURM", "pbs": "PBS", "sge": "SGE", "lsf": "LSF", "htcondor": "HTCondor", "oar": "OAR",
                 "moab": "Moab"}  # fmt: skip
        options: dict[str, Any] = {
            "cores": self.cores, "processes": self.cores, "memory": self.memory, "walltime": self.walltime,
            "queue": self.partition, "account": self.account, "interface": self.interface,
            "job_extra_directives": self.directives, "job_script_prologue": self.prologue,
            "local_directory": self.scratch, "log_directory": None,
            "scheduler_options": {"dashboard": False, "dashboard_address": None},
        }  # fmt: skip
        cluster = getattr(dask_jobqueue, f"{kinds[self.system]}Cluster")(
            **{k: v for k, v in options.items() if v is not None}
        )
        cluster.scale(jobs=self.jobs)
        return cluster


class Workers:
    """The workers of a cluster, as a pool that bundles are handed to."""

    def __init__(self, client: Any, study: Study, expected: int) -> None:
        """Send the study once; `expected` workers are counted on until they are there."""
        self.client, self._expected, self._asked = client, expected, 0.0
        self._payload = client.scatter(payload_of(study), broadcast=True, hash=False)
        self._executor = client.get_executor(pure=False)

    @property
    def width(self) -> int:
        """How many bundles should be at hand."""
        if time.monotonic() - self._asked > ASK_SECONDS:
            self._expected = max(1, sum(self.client.nthreads().values())) if self._asked else self._expected
            self._asked = time.monotonic()
        return AT_HAND * self._expected

    def bundle_seconds(self, work: float) -> float:
        """How long a bundle should be, of so many seconds of work."""
        return min(max(work / (EACH * self._expected), SHORTEST), LONGEST)

    def submit(self, bundle: Bundle) -> Future[Outcome]:
        """Have a bundle run by a worker."""
        return self._executor.submit(run_remotely, self._payload, bundle)  # type: ignore[no-any-return]

    def halt(self) -> None:
        """Nothing to tell: bundles are short, and are cancelled by whoever waits for them."""

    def explain(self, error: BaseException) -> str | None:
        """Why a bundle was lost though its study goes on; None where it cannot."""
        from distributed import KilledWorker

        if isinstance(error, KilledWorker):
            return "its worker died again and again (out of memory?)"
        return None


def payload_of(study: Study) -> dict[str, Any]:
    """All that a worker must know of a study: plain text and numbers."""
    context = study.context
    sources = {name: (brain.source, str(brain.path)) for name, brain in context["brains"].items()}
    return {"version": __version__, "text": study.text, **context, "brains": sources}


def run_remotely(payload: dict[str, Any], bundle: Bundle) -> Outcome:
    """Run a bundle in a worker's process. Raises InputError where the worker has another swarmcensus."""
    if payload["version"] != __version__:
        raise InputError(f"a worker has swarmcensus {__version__}, the study was sent by {payload['version']}")
    study, settings = _read(_Sent(payload))
    return run_bundle(settings, study.seed, bundle, metrics_of(study), np.zeros(1, np.uint8))


class _Sent:
    """A payload, known by its text: what is sent for one study is the same each time."""

    def __init__(self, payload: dict[str, Any]) -> None:
        self.payload = payload
        self.key = payload["text"], tuple(sorted((k, v[0]) for k, v in payload["brains"].items()))

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Sent) and self.key == other.key


@functools.lru_cache(maxsize=2)
def _read(sent: _Sent) -> tuple[Study, list[Any]]:
    known = {name: brains.parse(source, name, Path(path)) for name, (source, path) in sent.payload["brains"].items()}
    others = {k: v for k, v in sent.payload.items() if k not in ("version", "text", "brains")}
    study = Study.parse(sent.payload["text"], where="the study as sent", context={**others, "brains": known})
    return study, study.settings()


@contextlib.contextmanager
def workers(where: str, study: Study, show: Callable[[str], None]) -> Iterator[Workers]:
    """The workers of a scheduler's address, of "local:4", or of a TOML file. Raises InputError."""
    try:
        import distributed
    except ImportError:
        raise InputError(NEEDS) from None
    with contextlib.ExitStack() as stack:
        if where.startswith("local:"):
            count = _count(where)
            show(f"starting {count} worker processes")
            cluster: Any = stack.enter_context(
                distributed.LocalCluster(  # type: ignore[no-untyped-call]
                    n_workers=count, threads_per_worker=1, dashboard_address=None, silence_logs="CRITICAL"
                )
            )
        elif "://" in where:
            count, cluster = 1, where
        else:
            queue = read_queue(Path(where))
            count = queue.jobs * queue.cores
            show(f"submitting {queue.jobs} jobs of {queue.cores} workers to {queue.system}")
            try:
                cluster = stack.enter_context(queue.start())
            except ImportError:
                raise InputError(NEEDS) from None
            except (OSError, RuntimeError, ValueError) as error:
                raise InputError(f"{where}: no jobs could be submitted: {error}") from error
        try:
            client: Any = distributed.Client(cluster, timeout="10s", set_as_default=False)  # type: ignore[no-untyped-call]
            stack.enter_context(client)
        except (OSError, TimeoutError, ValueError) as error:
            raise InputError(f"no Dask scheduler answers at {where}: {error}") from None
        yield Workers(client, study, count)


def _count(where: str) -> int:
    text = where.removeprefix("local:")
    if not text.isdigit() or int(text) < 1:
        raise InputError(f"--cluster {where}: should be local: and a number of processes, as local:4")
    return int(text)


def read_queue(path: Path) -> Queue:
    """Read a cluster's TOML file. Raises InputError."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise InputError(
            f"--cluster {path}: should be local:4, a scheduler's address, or a TOML file, which cannot be read: {error}"
        ) from None
    try:
        return Queue.model_validate(read_toml(text, f"cluster file {path}"))
    except ValidationError as error:
        raise InputError(explain(error, f"cluster file {path}", Queue)) from None
