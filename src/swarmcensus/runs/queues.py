"""Batch systems: the TOML file that describes jobs, and the submitted jobs."""

import contextlib
import inspect
import signal
import subprocess
import threading
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.hints import did_you_mean_any
from swarmcensus.support.options import wrong_option
from swarmcensus.support.texts import read_text
from swarmcensus.support.toml_text import read_toml
from swarmcensus.support.toml_types import table_error

GRACE_SECONDS = 30.0  # a job without a worker for longer has ended; a refused job is submitted again after as long
ASK_SECONDS = 20.0  # between two queries to Slurm about why no worker starts
NO_PAGE = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}  # without the address, Dask takes port 8787
Whole = Annotated[int, Field(strict=True, ge=1)]


SYSTEMS = {
    "slurm": "SLURM", "pbs": "PBS", "sge": "SGE", "lsf": "LSF", "htcondor": "HTCondor", "oar": "OAR", "moab": "Moab"
}  # fmt: skip


class Queue(BaseModel):
    """The keys of a cluster's TOML file: a batch system on which dask-jobqueue starts workers as jobs."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    system: Literal["slurm", "pbs", "sge", "lsf", "htcondor", "oar", "moab"] = "slurm"
    jobs: Whole
    cores: Whole  # of each job: as many worker processes
    memory: Annotated[str, Field(pattern=r"^\d+(\.\d+)? ?[KMGT]i?B$")]  # of each job, as "16GB"
    walltime: str | None = None
    partition: str | None = None
    account: str | None = None
    interface: str | None = None  # network interface that workers and this process share, such as "ib0"
    directives: list[str] = []  # further lines at the head of the job script, such as "--exclusive"
    prologue: list[str] = []  # shell commands before a worker starts, such as "source ~/venv/bin/activate"
    scratch: str | None = None  # a folder on each node, for what does not fit into a worker's memory
    logs: str | None = None  # a folder for what the jobs print
    options: dict[str, str | int] = {}  # further arguments of the system's class in dask-jobqueue, as disk = "1GB"

    def start(self) -> Any:
        """The dask-jobqueue cluster, without jobs. Raises ImportError; ValueError on a wrong option."""
        import dask_jobqueue

        kind = getattr(dask_jobqueue, f"{SYSTEMS[self.system]}Cluster")
        takes = {k for c in kind.job_cls.__mro__ if c is not object for k in inspect.signature(c.__init__).parameters}
        named = {
            "walltime": self.walltime, "queue": self.partition,
            "account" if "account" in takes else "project": self.account, **self.options,
        }  # fmt: skip
        named = {k: v for k, v in named.items() if v is not None}
        unknown = sorted(set(named) - takes)
        if unknown:
            hint = did_you_mean_any(unknown, takes)
            raise ValueError(f"{self.system} takes no {', '.join(unknown)}{': ' * bool(hint)}{hint.rstrip()}")
        common: dict[str, Any] = {
            "cores": self.cores, "processes": self.cores, "memory": self.memory, "interface": self.interface,
            "job_extra_directives": self.directives, "job_script_prologue": self.prologue,
            "local_directory": self.scratch, "log_directory": self.logs, "job_name": "swarmcensus",
            "scheduler_options": NO_PAGE, "silence_logs": "CRITICAL", "job_cls": _remembering_refusal(kind.job_cls),
        }  # fmt: skip
        return kind(**{k: v for k, v in common.items() if v is not None}, **named)


def _remembering_refusal(job: type) -> type:
    """A subclass of a job class that keeps why it was refused: Dask drops the reason and waits for workers."""
    from distributed.core import Status

    class JobWithRefusal(job):  # type: ignore[misc]
        refusal = ""

        async def start(self) -> None:
            try:
                await super().start()
            except FileNotFoundError as error:
                self.refusal = f"{error.filename}: no such command here"
            except (OSError, RuntimeError, ValueError) as error:
                self.refusal = "; ".join(str(error).rpartition("stderr:\n")[2].split("\n")).strip("; ")
            self.status = Status.running

        async def close(self) -> None:
            await super().close()
            self.status = Status.closed  # Dask asserts this at the end

    return JobWithRefusal


class Jobs:
    """The jobs of a batch system: a job that ends, for example at its walltime, is submitted again."""

    def __init__(self, cluster: Any, queue: Queue) -> None:
        """Submit all jobs. Raises RuntimeError, with the system's message, if it refuses every one."""
        self.cluster, self.queue = cluster, queue
        self._seen: dict[str, float] = {}  # when a job last had a worker, or was refused
        self._last_query = time.monotonic()
        self._reason = ""
        self._began = False  # whether any worker ever started
        self._ended = 0  # jobs that ended before that
        cluster.scale(jobs=queue.jobs)
        while not cluster.workers:  # filled once the system has answered for all jobs
            time.sleep(0.05)
        refused = self._refused()
        if len(refused) == queue.jobs:
            raise RuntimeError(refused[0])
        if refused:
            warnings.warn(
                f"{len(refused)} of {counted(queue.jobs, 'job')} were refused, and are tried again every "
                f"{GRACE_SECONDS:.0f} seconds: {refused[0]}",
                stacklevel=2,
            )

    def renew(self) -> str:
        """Submit missing jobs. Returns why there is no worker, if known. Raises InputError if none can start."""
        there = [str(worker["name"]) for worker in self.cluster.scheduler_info["workers"].copy().values()]
        now = time.monotonic()
        jobs = self.cluster.workers.copy()
        self._seen = {name: when for name, when in self._seen.items() if name in jobs}
        for name, job in jobs.items():
            if any(worker == name or worker.startswith(f"{name}-") for worker in there):
                self._seen[name] = now
            elif job.refusal:
                self._seen.setdefault(name, now)
            if now - self._seen.get(name, now) > GRACE_SECONDS:
                self._replace(name)
        self.cluster.scale(jobs=self.queue.jobs)
        self._began |= bool(there)
        if there or self.queue.system != "slurm":
            self._reason = ""
        elif now - self._last_query > ASK_SECONDS:
            self._last_query = now
            self._reason = self._ask_slurm(jobs)
        return next(iter(self._refused()), self._reason) if not there else ""

    def _refused(self) -> list[str]:
        return [job.refusal for job in self.cluster.workers.copy().values() if job.refusal]

    def _replace(self, name: str) -> None:
        self._seen.pop(name, None)
        job = self.cluster.workers.pop(name, None)  # Dask may let go of it at the same time
        if job is not None:
            self.cluster.loop.add_callback(job.close)

    def _ask_slurm(self, jobs: dict[str, Any]) -> str:
        """Ask why no job has a worker; jobs that ended before any worker started are submitted again."""
        command = ["squeue", "--me", "--noheader", "--format=%i %T, %r"]
        try:
            answer = subprocess.run(command, capture_output=True, text=True, timeout=ASK_SECONDS)
        except (OSError, subprocess.TimeoutExpired):
            return ""
        if answer.returncode:
            return "; ".join(answer.stderr.strip().split("\n"))
        states = dict(line.strip().split(" ", 1) for line in answer.stdout.splitlines())
        ended = [name for name, job in jobs.items() if job.job_id and job.job_id not in states]
        self._ended += len(ended)
        if self._ended >= self.queue.jobs and not self._began:
            where = f"the folder {self.queue.logs}" if self.queue.logs else "what they printed"
            raise InputError(
                f"{counted(self._ended, 'job')} ended or {'was' if self._ended == 1 else 'were'} cancelled "
                f"before a worker came: {where} may say why"
            )
        for name in ended:
            self._replace(name)
        current = [states[job.job_id] for job in jobs.values() if job.job_id in states]
        return f"Slurm says {current[0].removesuffix(', None')}" if current else ""


@contextlib.contextmanager
def interrupted_by_signals() -> Iterator[None]:
    """Make SIGTERM and SIGHUP act like Ctrl-C, so that jobs are cancelled however this process is ended.

    Importing dask-jobqueue makes Ctrl-C end Python at once, with exit code 0 and work lost: this undoes it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {number: signal.getsignal(number) or signal.SIG_DFL for number in numbers}
    with contextlib.suppress(ImportError):
        import dask_jobqueue  # noqa: F401
    for number, handler in before.items():  # under nohup SIGHUP stays ignored
        ends = handler is signal.SIG_DFL or getattr(handler, "__module__", None) == "dask_jobqueue.runner"
        signal.signal(number, signal.default_int_handler if ends else handler)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def read_queue(path: Path) -> Queue:
    """Read a cluster's TOML file. Raises InputError."""
    try:
        text = read_text(path)
    except InputError as error:
        raise wrong_option(
            "cluster",
            str(path),
            f"should be local:4, a scheduler's address, or a TOML file, which cannot be read: {error}",
        ) from None
    try:
        return Queue.model_validate(read_toml(text, f"cluster file {path}"))
    except ValidationError as error:
        raise table_error(error, f"cluster file {path}", Queue) from None
