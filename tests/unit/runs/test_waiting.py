"""What a run says while it runs, in which order trials come, and what memory it takes."""

import io
import sys
import threading
import tracemalloc
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.results import shards, values as arrays
from swarmcensus.runs import pools, progress
from swarmcensus.runs.collect import Progress
from swarmcensus.runs.running import run
from swarmcensus.runs.tasks import plan_tasks
from swarmcensus.support.errors import InputError
from swarmcensus.support.readers import AS_TERMINAL
from tests.support.small import study_of

# ---- what a study's work is cut into, and the order in which it is run
LONG = {
    "trials": 40, "swarm": {"robots": [50, 100], "accuracy": [0.6, 0.8]}, "schedule": {"rounds": 1000, "ticks": 1000},
    "world": {"topology": ["ring", "scale-free", "moving"], "density": 1, "fill_ratio": [0.55, 0.95]},
}  # fmt: skip


@pytest.mark.parametrize("local", [False, True])
@pytest.mark.parametrize("seconds", [0.1, 30.0], ids=["threads", "workers of a cluster"])
def test_some_trials_of_every_setting_come_before_more_of_any(seconds, local):
    tables = LONG | {"world": {"topology": ["ring", "full"], "fill_ratio": 0.55}, "schedule": {"rounds": 1000}}
    settings = sc.Study(**(tables if local else LONG)).settings()
    wanted = np.ones((len(settings), 40), np.bool_)
    tasks = plan_tasks(settings, wanted, wanted if local else None, seconds)
    seen = np.zeros((2, *wanted.shape), np.int64)
    for task in tasks:
        of_kind = seen[int(task.kind == "local")]
        again = of_kind.any(axis=1)[list(task.settings)].any()
        assert not again or seen[: 1 + local].any(axis=2).all(), "a second task before the first of another setting"
        of_kind[list(task.settings), task.first : task.first + task.trials] += 1
    assert (seen[: 1 + local] == 1).all(), "every trial once"


# ---- what a person sees who waits for the compiler: one line with a count, whatever the number of brains
def waited(show, kinds=60):
    """Show how so many kinds of swarms are compiled, and then a trial that is run."""
    for k in range(kinds):
        show(Progress(0, 0, 0.0, 0.0, f"compiling {k + 1} of {kinds}: voter"))
    show(Progress(0, 1, 0.0, 1.0))
    show(Progress(1, 1, 1.0, 1.0))


@pytest.mark.parametrize("asked", ["", "FORCE_COLOR", "TTY_COMPATIBLE"])  # as continuous integration does
def test_compiling_many_brains_without_a_terminal(asked, monkeypatch, capsys):
    monkeypatch.delenv(AS_TERMINAL)
    monkeypatch.setenv(asked or "NOTHING", "1")
    with progress.bar_or_lines("board") as show:
        waited(show)
    assert capsys.readouterr().err.splitlines() == ["board: compiling 1 of 60: voter", "board: 0 of 1 trial, starting"]
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    with progress.bar_or_lines("board") as show:
        waited(show)
    assert "board: compiling 37 of 60: voter" in capsys.readouterr().err.splitlines()


def test_compiling_bar_on_a_terminal(monkeypatch):
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv(AS_TERMINAL, "100")
    monkeypatch.setenv("TERM", "xterm")
    before = threading.active_count()
    with progress.bar_or_lines("board") as show:
        assert threading.active_count() == before  # a process with threads cannot be copied, and would compile alone
        waited(show)
    seen = terminal.getvalue()
    assert all(f"compiling {k} of 60: voter" in seen for k in range(1, 61))
    assert "60 trials" not in seen


def test_what_is_said_of_trials_that_take_minutes(monkeypatch):
    pace = progress._Pace()
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=iter([0.0, 25.0, 100.0]).__next__))
    said = [pace.of(Progress(done, 3, done, 3.0)) for done in (0, 0, 1)]
    assert said == [("", ""), ("0:25", ""), ("0.6/min", "3:20 left")]


# ---- what a study of large swarms keeps in memory while it runs, and what it does not
ROBOTS = 60_000


def crowds(settings, robots=ROBOTS):
    return study_of(robots=robots, accuracy=[round(0.6 + 0.02 * k, 2) for k in range(settings)], rounds=2, trials=1)


@pytest.fixture
def small_arrays(monkeypatch):
    """Arrays of a megabyte are large."""
    monkeypatch.setattr(arrays, "LARGE_BYTES", 1_000_000)
    monkeypatch.setattr(shards, "SPOOLED_BYTES", 1_000_000)


def peak(settings, out):
    """The dataset of a run, and the most bytes that it has at once, but for what lies in files."""
    tracemalloc.start()
    try:
        return run(crowds(settings), 1, progress=False, out=out), tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_the_numbers_of_large_settings_do_not_add_up_in_memory(small_arrays, tmp_path, monkeypatch):
    """Ten settings take no more than one and some that wait to be written, of which there are four at the most."""
    monkeypatch.setattr(pools, "BUNDLE_SECONDS", 0.0)
    monkeypatch.setattr(shards, "AT_LEAST", 0.0)  # as of trials that take seconds
    monkeypatch.setattr(shards, "OF_ELAPSED", 0.0)
    monkeypatch.setattr(shards, "SKETCH_AFTER", (0.0, 0.0))
    run(crowds(1, 10), 1, progress=False)  # compiles, and imports what is imported late
    _, one = peak(1, tmp_path / "one.nc")
    data, ten = peak(10, tmp_path / "ten.nc")
    assert ten - one < 5 * 36 * ROBOTS  # 36 bytes of results of a robot in a setting
    assert {path.name for path in tmp_path.iterdir()} == {"one.nc", "ten.nc"}
    assert sc.load(tmp_path / "ten.nc").equals(data)
    assert sc.load(tmp_path / "one.nc").equals(data.sel(setting=[0]))


def test_a_folder_or_memory_without_space_is_reported(small_arrays, tmp_path, monkeypatch):
    monkeypatch.setattr(arrays.tempfile, "TemporaryFile", Mock(side_effect=OSError(28, "No space left on device")))
    with pytest.raises(InputError, match=r"cannot keep results in .*: No space left on device"):
        run(crowds(5), 1, progress=False, out=tmp_path / "a.nc")
    monkeypatch.setattr("os.sysconf", lambda _: 1000)
    with pytest.raises(InputError, match="robots = 60000: their states take at least 0 GB of memory, and"):
        run(crowds(1), 1, progress=False, out=tmp_path / "a.nc")
    assert not list(tmp_path.iterdir())
