"""Tests that are marked `interpreted` run in a process beside this one, in which Numba is switched off.

Compiling a brain takes seconds, and CPython lives a small swarm's life in a fraction of one. NUMBA_DISABLE_JIT in the
environment decides otherwise: all tests are compiled where it is 0, and none where it is 1.
"""

import os
import subprocess
import sys
import tempfile
from multiprocessing.connection import Client, Connection, Listener
from typing import IO

import pytest

ADDRESS = "SWARMCENSUS_INTERPRETED_TESTS"  # where the process beside is told what to run
KEY = b"tests"
OPTIONS = ["-q", "-p", "no:xdist", "-p", "no:cacheprovider", "--no-cov"]
WRAPS = "ignore:overflow encountered:RuntimeWarning"  # as the engine's whole numbers are meant to


def register(config):
    """Take part in a run of pytest, on either side."""
    if ADDRESS in os.environ:
        config.addinivalue_line("filterwarnings", WRAPS)
        config.pluginmanager.register(Told(config))
    elif "NUMBA_DISABLE_JIT" not in os.environ:
        config.pluginmanager.register(Beside())
    elif os.environ["NUMBA_DISABLE_JIT"] == "1":
        config.addinivalue_line("filterwarnings", WRAPS)


class Beside:
    """Has marked tests run by a process beside this one, which begins with the first of them."""

    def __init__(self):
        self.process: subprocess.Popen | None = None
        self.connection: Connection
        self.said: IO[bytes]

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item, nextitem):
        if not is_marked(item):
            return None
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        for report in self.reports(item, nextitem):
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        item.session._setupstate.teardown_exact(nextitem)  # what the test before this one left for its neighbours
        return True

    def reports(self, item, nextitem):
        """What became of a test."""
        try:
            if not self.process:
                self.begin(item.session)
            self.connection.send((item.nodeid, nextitem.nodeid if nextitem and is_marked(nextitem) else None))
            told = self.connection.recv()
        except (EOFError, OSError):
            ended = self.process.wait()
            self.said.seek(0)
            said = f"the process that runs tests without Numba ended with {ended}:\n{self.said.read().decode()}"
            self.process = None
            return [pytest.TestReport(item.nodeid, item.location, {}, "failed", said, "call")]
        return [item.config.hook.pytest_report_from_serializable(config=item.config, data=one) for one in told]

    def begin(self, session):
        """Begin the process, which collects the files that have marked tests."""
        self.said = tempfile.TemporaryFile()  # noqa: SIM115
        files = sorted({str(item.path) for item in session.items if is_marked(item)})
        with Listener(authkey=KEY) as listener:
            told = {ADDRESS: str(listener.address), "NUMBA_DISABLE_JIT": "1"}
            command = [sys.executable, "-m", "pytest", *OPTIONS, *files]
            self.process = subprocess.Popen(
                command,
                cwd=session.config.invocation_params.dir,
                env=os.environ | told,
                stdout=self.said,
                stderr=self.said,
            )
            self.connection = listener.accept()

    def pytest_sessionfinish(self):
        if self.process:
            self.connection.close()
            self.process.wait()


class Told:
    """Runs the tests that it is told to, and says what became of them."""

    def __init__(self, config):
        self.config = config
        self.connection = Client(os.environ[ADDRESS], authkey=KEY)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session):
        items = {item.nodeid: item for item in session.items}
        apart = Apart.from_parent(session, name="apart")
        while True:
            try:
                name, following = self.connection.recv()
            except EOFError:
                return True
            self.reports = []
            session.config.hook.pytest_runtest_protocol(item=items[name], nextitem=items.get(following, apart))
            self.connection.send(self.reports)

    def pytest_runtest_logreport(self, report):
        self.reports.append(self.config.hook.pytest_report_to_serializable(config=self.config, report=report))


class Apart(pytest.Item):
    """A test in no file: only fixtures of a session are kept for it."""

    def runtest(self):
        raise NotImplementedError


def is_marked(item):
    """Whether a test is run without Numba."""
    return item.get_closest_marker("interpreted") is not None
