"""Brains whose functions do not return: Ctrl-C ends what runs them."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.engine import threads
from swarmcensus.runs import tasks
from swarmcensus.support.errors import BrainError, Interrupted

ENDLESS = (
    brains.load("alone").source.replace(
        "    me.t += looks\n", "    me.t += looks\n    while me.t > 50.0:\n        me.x = me.x\n"
    )
)  # fmt: skip
STUDY = {
    "trials": 2, "seed": 1, "world": {"topology": "ring", "fill_ratio": 0.5},
    "schedule": {"rounds": 10, "observations_per_round": 10},
}  # fmt: skip


def study_of(folder, source=ENDLESS, robots=4, **more):
    (folder / "mine.py").write_text(source)
    swarm = {"robots": robots, "accuracy": 0.7, "brain": ["minimalistic", str(folder / "mine.py")]}
    return sc.Study(**STUDY | more, swarm=swarm)


def interrupt_soon():
    """Press Ctrl-C in a tenth of a second."""
    threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()


@pytest.fixture
def hangs():
    """An event that machine code waits for in place of a loop that never ends; the test's end sets it."""
    event = threading.Event()
    yield event
    event.set()


@pytest.mark.skipif(threads.not_compiled(), reason="CPython itself hears Ctrl-C")
def test_the_main_thread_leaves_machine_code_behind(hangs):
    assert threads.interruptible(lambda: threading.current_thread())() is not threading.main_thread()
    interrupt_soon()
    with pytest.raises(KeyboardInterrupt):
        threads.interruptible(hangs.wait)()


def test_threads_that_hang_are_left_behind(hangs):
    begun = time.monotonic()
    with threads.LeavableThreads(2) as executor:
        stuck, done = executor.submit(hangs.wait), executor.submit(int, "7")
        assert done.result() == 7
    assert time.monotonic() - begun < 5
    assert stuck.running()


def test_a_brain_that_does_not_return_is_not_run(tmp_path):
    with pytest.raises(BrainError, match="observe has run 300,000 lines"):
        sc.run(study_of(tmp_path), jobs=1, progress=False)


def test_finished_trials_of_a_bundle_that_hangs_are_kept(hangs, monkeypatch, tmp_path):
    run_batch = tasks.run_batch

    def batch(setting, *given):
        if setting.brain.name != "minimalistic":
            interrupt_soon()
            hangs.wait()
        return run_batch(setting, *given)

    monkeypatch.setattr(tasks, "run_batch", batch)
    monkeypatch.setattr("swarmcensus.runs.pools._run_once", lambda *_: None)
    with pytest.raises(Interrupted) as stopped:
        sc.run(study_of(tmp_path, brains.load("alone").source), jobs=1, progress=False)
    assert stopped.value.done == 2


@pytest.mark.long
def test_ctrl_c_ends_a_run_that_hangs(tmp_path):
    study_of(tmp_path, ENDLESS.replace("> 50.0", "== 370.0"))  # which no short history has
    (tmp_path / "endless.toml").write_text(
        'trials = 2\n[swarm]\nbrain = ["minimalistic", "mine.py"]\nrobots = 4\naccuracy = 0.7\n'
        '[world]\ntopology = "ring"\nfill_ratio = 0.5\n[schedule]\nrounds = 40\nobservations_per_round = 10\n'
    )
    words = [sys.executable, "-m", "swarmcensus", "run", "endless.toml", "--jobs", "1"]
    with subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as running:
        try:
            lines = []
            for line in running.stderr:
                lines.append(line)
                if "of 4 trials" in line:
                    break
            time.sleep(20)  # compiling, and trials of the other brain
            begun = time.monotonic()
            running.send_signal(signal.SIGINT)
            assert running.wait(20) == 130
            took = time.monotonic() - begun
            lines.append(running.stderr.read())
        finally:
            running.kill()
    said = "".join(lines)
    assert "kept 2 of 4 trials in endless.nc: the same command continues" in said
    assert "Traceback" not in said
    assert took < 10  # half a second for threads to end, then saving
    assert Path(tmp_path / "endless.nc").exists()
