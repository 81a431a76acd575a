"""What quick tests take of a processor: those above a second are listed behind a run, and those above five fail.

These are seconds of a machine on which `pace` is 1, so that a slow or a busy one fails no test. What Numba compiles
here is not counted, because it depends on what was compiled before. No test fails for its fixtures, which others share.
"""

import os
import sys
import threading
import time

import numba
import pytest
from numba.core import event

LISTED, MOST = 1.0, 5.0  # a test that is meant to take 3 s at most may meet a slow or busy machine
TRACED = 2.0  # times as long where coverage is measured


def pace():
    """How many times as long as where the limits were set something takes here, at this moment."""

    def turns():
        begun, total = time.thread_time(), 0
        for k in range(100_000):
            total += k % 7 * k
        return time.thread_time() - begun

    return min(turns() for _ in range(3)) / 0.0035 * (TRACED if sys.gettrace() else 1.0)


class Costs(event.Listener):
    """`judges`: whether tests above MOST fail where Numba is on; then what many of them need was compiled before."""

    def __init__(self, judges):
        self.judges, self.listed, self.here, self.compiled, self.begun = judges, [], threading.local(), 0.0, 0.0
        self.parts = {}  # of a test, and the seconds of each
        event.register("numba:compile", self)

    def on_start(self, _):
        self.here.begun = [*getattr(self.here, "begun", ()), time.thread_time()]

    def on_end(self, _):
        begun = self.here.begun.pop()
        if not self.here.begun:  # else what is compiled is part of something else
            self.compiled += time.thread_time() - begun

    def seconds(self):
        """What this process and those that it waited for took, but for compiling."""
        of = os.times()
        return of.user + of.system + of.children_user + of.children_system - self.compiled

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_logstart(self):
        self.begun, self.parts = self.seconds(), {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item, call):
        report = yield
        before, self.begun = self.begun, self.seconds()
        self.parts[call.when] = self.begun - before
        every = sum(self.parts.values())
        if call.when == "teardown" and every > LISTED / 2 and not item.get_closest_marker("long"):
            slow = pace()
            report.user_properties.append(("processor", every / slow))
            seconds = self.parts.get("call", 0.0) / slow
            judges = self.judges or (numba.config.DISABLE_JIT and item.get_closest_marker("interpreted"))
            if seconds > MOST and judges and report.passed:
                report.outcome = "failed"
                report.longrepr = f"took {seconds:.1f} s of a processor: should be `long`, or at most {MOST:g} s"
        return report

    def pytest_runtest_logreport(self, report):
        seconds = dict(report.user_properties).get("processor", 0.0)
        if report.when == "teardown" and seconds > LISTED:
            self.listed.append(f"{seconds:.1f} s  {report.nodeid}")

    def pytest_terminal_summary(self, terminalreporter):
        if self.listed:
            terminalreporter.section(f"quick tests above {LISTED:g} s of a processor")
            terminalreporter.write("\n".join([*sorted(self.listed, reverse=True), ""]))
