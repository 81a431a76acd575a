"""Tests that are marked `interpreted` run in a second run of pytest behind the first, in which Numba is switched off.

Compiling a brain takes seconds, and CPython lives a small swarm's life in a fraction of one. NUMBA_DISABLE_JIT in the
environment decides otherwise: all tests are compiled where it is 0, and none where it is 1.
"""

import os
import subprocess
import sys

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
    """Leaves marked tests out of a run, and runs them behind it; that they fail counts as one failed test."""

    def __init__(self, config):
        self.config = config
        self.marked = []  # ids of tests

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        marked = [item for item in items if item.get_closest_marker("interpreted")]
        items[:] = [item for item in items if item not in marked]
        self.marked = [item.nodeid for item in marked]

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self):
        if hasattr(self.config, "workeroutput"):
            self.config.workeroutput["interpreted"] = self.marked

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node):
        self.marked = getattr(node, "workeroutput", {}).get("interpreted", self.marked)

    @pytest.hookimpl(wrapper=True, trylast=True)  # before coverage is put together
    def pytest_runtestloop(self, session):
        done = yield
        if self.marked and not hasattr(self.config, "workeroutput"):
            code = self.run()
            session.testscollected += len(self.marked)
            session.testsfailed += code != 0
        return done

    def run(self):
        """Run the marked tests: the exit code."""
        given = self.config.option
        options = [f"--verbosity={given.verbose}", f"--tb={given.tbstyle}"]
        options += [f"--durations={given.durations}"] * bool(given.durations)
        options += ["-n", str(given.numprocesses or 0), "-p", "no:cacheprovider"]
        options += ["--no-cov"] * self.config.pluginmanager.hasplugin("pytest_cov")
        command = [sys.executable, "-m", "pytest", *options, *self.marked]
        with self.config.pluginmanager.get_plugin("capturemanager").global_and_fixture_disabled():
            print("\nwithout Numba:", flush=True)
            environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
            return subprocess.run(command, cwd=self.config.rootpath, env=environment, check=False).returncode
