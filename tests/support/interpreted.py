"""Tests that are marked `interpreted` run in a process beside this one, in which Numba is switched off.

Compiling a brain takes seconds, and CPython lives a small swarm's life in a fraction of one. NUMBA_DISABLE_JIT in the
environment decides otherwise: all tests are compiled where it is 0, and none where it is 1.
"""

import json
import os
import socket
import subprocess
import sys
import tempfile
from typing import IO

import pytest

PORT = "SWARMCENSUS_INTERPRETED_TESTS"  # of this machine, where the process beside is told what to run
OPTIONS = ["-n", "0", "-p", "no:cacheprovider", "--no-cov"]
WRAPS = "ignore:overflow encountered:RuntimeWarning"  # as the engine's whole numbers are meant to


def register(config):
    """Take part in a run of pytest, on either side."""
    if PORT in os.environ:
        config.addinivalue_line("filterwarnings", WRAPS)
        config.pluginmanager.register(Told(config))
    elif "NUMBA_DISABLE_JIT" not in os.environ:
        if not config.option.usepdb and config.option.capture != "no":  # a debugger talks to this process
            config.pluginmanager.register(Beside())
    elif os.environ["NUMBA_DISABLE_JIT"] == "1":
        config.addinivalue_line("filterwarnings", WRAPS)


class Beside:
    """Has marked tests run by a process beside this one, which begins with the first of them."""

    def __init__(self):
        self.process: subprocess.Popen | None = None
        self.last: pytest.Item  # that was run, here or there
        self.line: IO[bytes]
        self.said: IO[bytes]

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        items.sort(key=lambda item: not is_marked(item))  # the first of several workers gets them all: one process

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item, nextitem):
        self.last = item
        if not is_marked(item):
            return None
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        reports = self.reports(item, nextitem)
        try:
            item.session._setupstate.teardown_exact(nextitem)  # what the test before this one left for its neighbours
        except Exception as error:
            reports.append(failed(item, f"what an earlier test left could not be taken down: {error!r}", "teardown"))
        for report in reports:
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        return True

    def reports(self, item, nextitem):
        """What became of a test."""
        try:
            if not self.process:
                self.begin(item.session)
            tell(self.line, (item.nodeid, nextitem.nodeid if nextitem and is_marked(nextitem) else None))
            told = heard(self.line)
        except OSError as error:
            return [failed(item, self.ended()[1] if self.process else repr(error), "call")]
        for one in told:
            if one["outcome"] == "skipped" and isinstance(one["longrepr"], list):
                one["longrepr"] = tuple(one["longrepr"])  # JSON has none, and pytest asks for one
        return [item.config.hook.pytest_report_from_serializable(config=item.config, data=one) for one in told]

    def begin(self, session):
        """Begin the process, which collects the files that have marked tests. Raises OSError where it ends at once."""
        files = sorted({str(item.path) for item in session.items if is_marked(item)})
        given = session.config.option
        options = [f"--verbosity={given.verbose}", f"--tb={given.tbstyle}", *["--showlocals"] * given.showlocals]
        self.said = tempfile.TemporaryFile()  # noqa: SIM115
        with socket.create_server(("127.0.0.1", 0)) as server:
            server.settimeout(0.1)
            self.process = subprocess.Popen(
                [sys.executable, "-m", "pytest", *OPTIONS, *options, *files],
                cwd=session.config.invocation_params.dir,
                env=os.environ | {PORT: str(server.getsockname()[1]), "NUMBA_DISABLE_JIT": "1"},
                stdout=self.said,
                stderr=self.said,
            )
            while True:
                try:
                    connection, _ = server.accept()
                    break
                except TimeoutError:
                    if self.process.poll() is not None:
                        raise
        connection.settimeout(None)
        self.line = connection.makefile("rwb")
        connection.close()

    def ended(self):
        """Wait for the process: its exit code, and what it said."""
        code, self.process = self.process.wait(), None
        with self.said:
            self.said.seek(0)
            told = self.said.read().decode(errors="replace")
        self.line.close()
        return code, f"the process that runs tests without Numba ended with {code}:\n{told}"

    @pytest.hookimpl(wrapper=True, trylast=True)  # before coverage is put together
    def pytest_runtestloop(self):
        try:
            return (yield)
        finally:
            if self.process:
                self.line.close()
                code, said = self.ended()
                if code:
                    self.last.ihook.pytest_runtest_logreport(report=failed(self.last, said, "teardown"))


class Told:
    """Runs the tests that it is told to, and says what became of them."""

    def __init__(self, config):
        self.config = config
        with socket.create_connection(("127.0.0.1", int(os.environ.pop(PORT)))) as connection:
            self.line = connection.makefile("rwb")

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session):
        items = {item.nodeid: item for item in session.items}
        apart = Apart.from_parent(session, name="apart")
        while True:
            try:
                name, following = heard(self.line)
            except OSError:
                return True
            self.reports = []
            session.config.hook.pytest_runtest_protocol(item=items[name], nextitem=items.get(following, apart))
            tell(self.line, self.reports)

    def pytest_runtest_logreport(self, report):
        self.reports.append(self.config.hook.pytest_report_to_serializable(config=self.config, report=report))

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session):
        session.exitstatus = 0  # what failed is told; what fails from here on is not


class Apart(pytest.Item):
    """A test in no file: only fixtures of a session are kept for it."""

    def runtest(self):
        """Never called: it only stands for what comes next."""


def is_marked(item):
    """Whether a test is run without Numba."""
    return item.get_closest_marker("interpreted") is not None


def failed(item, said, when):
    """The report of a test that failed, with these words."""
    return pytest.TestReport(item.nodeid, item.location, {}, "failed", said, when)


def tell(line, what):
    """Send something to the other process."""
    line.write(json.dumps(what, default=str).encode() + b"\n")
    line.flush()


def heard(line):
    """What the other process sends. Raises OSError where it is gone."""
    said = line.readline()
    if not said.endswith(b"\n"):
        raise OSError("the other process is gone")
    return json.loads(said)
