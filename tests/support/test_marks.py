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
from tests.support import interpreted
from tests.support.long import Long

def pytest_configure(config):
    config.addinivalue_line("markers", "long")
    config.addinivalue_line("markers", "interpreted")
    interpreted.register(config)
    config.pluginmanager.register(Long())
"""
TESTS = """
import numba
import pytest

@pytest.mark.interpreted
@pytest.mark.parametrize("k", range(3))
def test_behind(k):
    assert numba.config.DISABLE_JIT
    assert k < 2, "no 2"

def test_here():
    assert not numba.config.DISABLE_JIT

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

    def run():
        told = environment | {"PYTHONPATH": str(ROOT)}
        return subprocess.run(command, cwd=tmp_path, env=told, capture_output=True, text=True, timeout=300)

    done = run()
    assert done.returncode == 1
    assert "no 2" in done.stdout
    assert re.findall(r"(?:\d failed, )?\d passed", done.stdout) == ["1 failed, 2 passed", "2 passed"]
    (tmp_path / "test_some.py").write_text(TESTS.replace('but=["0"]', 'but=["seven"]'))
    done = run()
    assert done.returncode != 0
    assert "long names seven: the ids are 0, 1, 2" in done.stdout + done.stderr
