"""Tests that are marked `interpreted` run in a second run of pytest, in which Numba is switched off.

Compiling a brain takes seconds, and CPython lives a small swarm's life in a fraction of one. NUMBA_DISABLE_JIT in the
environment decides otherwise: all tests are compiled where it is 0, and none where it is 1. Where workers share the
first run, the second goes on next to them, in whatever time they leave a processor idle; else it follows.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

WRAPS = "ignore:overflow encountered:RuntimeWarning"  # as the engine's whole numbers are meant to


def register(config):
    """Take part in a run of pytest."""
    if os.environ.get("NUMBA_DISABLE_JIT") == "1":
        config.addinivalue_line("filterwarnings", WRAPS)
    given = config.option
    at_a_prompt = given.usepdb or given.capture == "no"  # a debugger talks to this process
    if "NUMBA_DISABLE_JIT" not in os.environ and not at_a_prompt and not given.collectonly:
        config.pluginmanager.register(Apart(config))


class Apart:
    """Leaves marked tests out of a run, and runs them apart; that they fail counts as one failed test."""

    def __init__(self, config):
        self.config = config
        self.worker = getattr(config, "workerinput", {})
        self.marked, self.begun = [], None  # ids of tests, and the process that runs them
        self.printed = tempfile.TemporaryFile()  # noqa: SIM115 - as long as the run

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        marked = [item for item in items if item.get_closest_marker("interpreted")]
        items[:] = [item for item in items if item not in marked]
        self.marked = [item.nodeid for item in marked]
        if self.worker.get("workerid") == "gw0":
            note_of(self.worker["testrunuid"]).write_text(json.dumps(self.marked), encoding="utf-8")

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, node):
        note = note_of(node.workerinput["testrunuid"])
        if note.exists():
            self.marked = json.loads(note.read_text(encoding="utf-8"))
            note.unlink()
            self.begin()

    @pytest.hookimpl(wrapper=True, trylast=True)  # before coverage is put together
    def pytest_runtestloop(self, session):
        try:
            done = yield
            if self.marked and not self.worker:
                if not self.begun:
                    self.begin()
                code = self.begun.wait()
                self.printed.seek(0)
                with self.config.pluginmanager.get_plugin("capturemanager").global_and_fixture_disabled():
                    print("\nwithout Numba:", self.printed.read().decode(errors="replace"), sep="\n", flush=True)
                session.testscollected += len(self.marked)
                session.testsfailed += code != 0
        finally:
            if self.begun and self.begun.poll() is None:
                self.begun.terminate()
        return done

    def begin(self):
        """Begin to run the marked tests, where there are any."""
        given = self.config.option
        options = [f"--verbosity={given.verbose}", f"--tb={given.tbstyle}"]
        options += [f"--durations={given.durations}"] * bool(given.durations)
        options += ["-n", str((given.numprocesses or 0) // 4), "-p", "no:cacheprovider"]
        options += ["--no-cov"] * self.config.pluginmanager.hasplugin("pytest_cov")
        command = [sys.executable, "-m", "pytest", *options, *self.marked]
        if self.marked:
            environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
            self.begun = subprocess.Popen(
                command, cwd=self.config.rootpath, env=environment, stdout=self.printed, stderr=subprocess.STDOUT
            )
            if hasattr(os, "setpriority"):  # it takes what others leave, for about as long as they run
                os.setpriority(os.PRIO_PROCESS, self.begun.pid, os.getpriority(os.PRIO_PROCESS, 0) + 5)


def note_of(run):
    """The file in which a worker of a run tells which tests are marked."""
    return Path(tempfile.gettempdir()) / f"interpreted-{run}.json"
