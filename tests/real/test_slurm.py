"""Studies on the jobs of a real Slurm, and what may happen to those."""

import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import swarmcensus as sc
from swarmcensus.cli.commands import main
from swarmcensus.runs import queues
from swarmcensus.runs.running import run
from tests.real.one_node import Slurm, missing, until
from tests.support.clusters import LONG, Once, study
from tests.support.results import same

pytestmark = pytest.mark.skipif(bool(missing()), reason=f"no {', '.join(missing())} here: see tests/real/install.sh")
CLUSTER = """
jobs      = {jobs}
cores     = {cores}
memory    = "2GB"
walltime  = "00:05:00"
partition = "short"
interface = "lo"
scratch   = "{folder}/scratch"
logs      = "{folder}/logs"
"""


@pytest.fixture(scope="module")
def daemons():
    slurm = Slurm()
    yield slurm
    slurm.close()


@pytest.fixture
def slurm(daemons, tmp_path, monkeypatch):
    """A Slurm whose node is idle, in a folder with cluster files; no job is left behind."""
    for name, value in daemons.environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))  # for a job, which starts elsewhere
    monkeypatch.setattr(queues, "ASK_SECONDS", 1.0)
    monkeypatch.setattr(queues, "GRACE_SECONDS", 2.0)
    monkeypatch.chdir(tmp_path)
    Path("single.toml").write_text(CLUSTER.format(jobs=1, cores=1, folder=tmp_path))
    Path("one.toml").write_text(CLUSTER.format(jobs=1, cores=2, folder=tmp_path))
    Path("two.toml").write_text(CLUSTER.format(jobs=2, cores=1, folder=tmp_path))
    Path("long.toml").write_text(LONG)
    yield daemons
    left = daemons.jobs()
    daemons.says("scancel", "--quiet", "--me")
    until(lambda: not daemons.jobs(), "no jobs are left")
    assert not left


@pytest.fixture(scope="module")
def threads():
    return sc.run(sc.Study.parse(LONG), jobs=2)


def changed(file, old, new):
    text = Path(file).read_text()
    assert old in text
    Path("changed.toml").write_text(text.replace(old, new))
    return "changed.toml"


def test_jobs_give_the_bits_of_threads(slurm, threads, capsys):
    assert main(["run", "long.toml", "--cluster", "two.toml"]) == 0
    assert same(sc.load("long.nc"), threads)
    assert "long: submitting 2 jobs of 1 workers to slurm" in capsys.readouterr().err
    assert len(list(Path("logs").glob("*.err"))) == 2


def test_jobs_that_a_user_cancels_are_replaced(slurm, threads):
    cancelled = []
    cancel = Once(lambda: cancelled.extend(slurm.jobs()) or slurm.says("scancel", *cancelled))
    data = run(study(LONG), cluster="two.toml", progress=cancel, out="s.nc")
    assert cancelled
    assert same(data, threads)


def test_a_node_that_crashes_and_comes_back_costs_nothing(slurm, threads):
    def power_cut():
        slurm.crash()
        slurm.daemon("slurmd", "-D")

    data = run(study(LONG), cluster="one.toml", progress=Once(power_cut), out="s.nc")
    slurm.wait_for_node()
    assert "failed" not in data.attrs
    assert same(data, threads)


def test_a_job_that_hits_its_walltime_is_submitted_again(slurm, threads, monkeypatch):
    """The work lasts for longer than Slurm takes to look at the clock; trials are the same however many there are."""
    monkeypatch.setattr(queues, "GRACE_SECONDS", 30.0)
    ids = set()
    minutes = study(LONG).with_(trials=10_000)

    def show(progress):
        ids.update(slurm.jobs() if len(ids) < 2 else ())

    data = run(minutes, cluster=changed("single.toml", "00:05:00", "00:01:00"), progress=show, out="s.nc")
    assert len(ids) > 1
    assert "TIME LIMIT" in "".join(path.read_text() for path in Path("logs").glob("*.err"))
    assert "failed" not in data.attrs
    assert same(data.isel(trial=slice(200)), threads)


def test_what_slurm_refuses_is_one_sentence(slurm, capsys):
    assert main(["run", "long.toml", "--cluster", changed("one.toml", '"short"', '"nowhere"')]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2
    assert "no jobs could be submitted: sbatch: error: invalid partition specified: nowhere" in lines[1]
    assert not Path("long.nc").exists()


def test_jobs_that_end_before_a_worker_comes_end_the_run(slurm, capsys):
    cluster = changed("two.toml", "logs ", 'prologue = ["exit 3"]\nlogs ')
    assert main(["run", "long.toml", "--cluster", cluster]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert "jobs ended or were cancelled before a worker came: the folder" in said


def test_why_jobs_wait_is_said(slurm):
    """Slurm takes a job that asks for more time than its partition gives, and never starts it."""
    notes = []

    def show(progress):
        notes.append(progress.note)
        if "Slurm" in progress.note:
            raise KeyboardInterrupt

    with pytest.raises(sc.Interrupted):
        run(study(LONG), cluster=changed("one.toml", "00:05:00", "10:00:00"), progress=show, out="s.nc")
    assert notes[-1] == "waiting for workers: Slurm says PENDING, PartitionTimeLimit"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_stopped_cancels_its_jobs(slurm, number):
    with running("two.toml") as process:
        until(lambda: "starting" in Path("said").read_text(), "workers are there")
        process.send_signal(number)
        assert process.wait(60) == 130
    assert not slurm.jobs()
    assert "the same command continues" in Path("said").read_text()


def test_jobs_end_by_themselves_when_the_run_is_killed(slurm):
    with running("one.toml"):
        until(lambda: "starting" in Path("said").read_text(), "workers are there")
    until(lambda: not slurm.jobs(), "jobs are gone", 120)


@contextlib.contextmanager
def running(cluster):
    """A run that lasts for long, in a process that is killed at the end; what it says is in the file `said`."""
    Path("long.toml").write_text(LONG.replace("trials = 200", "trials = 50000"))
    with open("said", "w") as said:
        process = subprocess.Popen(
            [sys.executable, "-m", "swarmcensus", "run", "long.toml", "--cluster", cluster],
            stderr=said, stdout=said,
        )  # fmt: skip
        try:
            yield process
        finally:
            process.kill()
            process.wait()
