"""What the markers of tests do: nothing that fails is lost, and what is left out is not run."""

import os
import re
import subprocess
import sys

import numba
import pytest

from tests.support.long import is_meant
from tests.support.places import ROOT

CONFTEST = """
from tests.support import costs, interpreted
from tests.support.long import Long

costs.LISTED, costs.MOST = 0.05, 0.1

def pytest_configure(config):
    config.addinivalue_line("markers", "long")
    config.addinivalue_line("markers", "interpreted")
    interpreted.register(config)
    config.pluginmanager.register(Long())
    config.pluginmanager.register(costs.Costs(True))
"""
TESTS = """
import time

import numba
import pytest
from tests.support import costs

@pytest.mark.interpreted
@pytest.mark.parametrize("k", range(3))
def test_behind(k):
    assert numba.config.DISABLE_JIT
    assert k < 2, "no 2"

@pytest.mark.parametrize("k", range(2))
def test_here(k):
    assert not numba.config.DISABLE_JIT
    end = time.process_time() + 2.0 * k * costs.MOST * costs.pace()
    while time.process_time() < end:
        pass

@pytest.mark.interpreted
@pytest.mark.long
def test_long():
    raise AssertionError("not meant")

@pytest.mark.long(but=["0"])
@pytest.mark.parametrize("k", range(3))
def test_often_long(k):
    assert k == 0
"""


@pytest.mark.interpreted
def test_numba_is_off_unless_the_environment_says_otherwise():
    assert bool(numba.config.DISABLE_JIT) is (os.environ.get("NUMBA_DISABLE_JIT", "0") != "0")


@pytest.mark.parametrize(
    ("given", "meant"), [({}, "012"), ({"but": ["0"]}, "12"), ({"only": ["0"]}, "0"), ({"but_every": 2}, "1")]
)
def test_parameters_that_a_marker_is_for(given, meant):
    assert [one for one in "012" if is_meant(list("012"), int(one), **given)] == list(meant)


@pytest.mark.long(but=["0"])
@pytest.mark.parametrize("workers", ["0", "2"])
def test_a_run(tmp_path, workers):
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "test_some.py").write_text(TESTS)
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST_", "COV", "NUMBA_"))}
    command = [sys.executable, "-m", "pytest", "-n", workers, "-p", "no:cacheprovider", "-m", "not long"]

    told = environment | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=tmp_path, env=told, capture_output=True, text=True, timeout=300)
    assert done.returncode == 1
    assert "no 2" in done.stdout
    assert re.findall(r"(?:\d failed, )?\d passed", done.stdout) == ["1 failed, 2 passed", "3 passed"]
    assert ", 1 error in " in done.stdout
    assert re.search(r"^took 0\.\d s of a processor: should be `long`, or at most 0\.1 s$", done.stdout, re.MULTILINE)
    assert len(re.findall(r"^\d\.\d s  test_some\.py", done.stdout, re.MULTILINE)) == 1


def test_a_marker_that_names_what_is_not_there():
    with pytest.raises(ValueError, match="long names seven: the ids are 0, 1, 2"):
        is_meant(list("012"), 0, but=["seven"])
