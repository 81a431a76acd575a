"""What the markers of tests do: nothing that fails is lost, and what is left out is told."""

import os
import subprocess
import sys

import numba
import pytest

from tests.support.places import ROOT

CONFTEST = """
from tests.support import interpreted
from tests.support.long import Long

def pytest_configure(config):
    config.addinivalue_line("markers", "long")
    config.addinivalue_line("markers", "interpreted")
    interpreted.register(config)
    config.pluginmanager.register(Long(config))
"""
TESTS = """
import os
import numba
import pytest

made = []

@pytest.fixture(scope="module")
def shared():
    made.append(1)

@pytest.mark.interpreted
@pytest.mark.parametrize("k", range(3))
def test_besides(shared, k):
    assert numba.config.DISABLE_JIT
    assert made == [1]

@pytest.mark.interpreted
def test_fails():
    assert [1, 2] == [1, 3]

@pytest.mark.interpreted
def test_ends_the_process():
    os._exit(7)

@pytest.mark.interpreted
def test_goes_on(shared):
    assert numba.config.DISABLE_JIT
    pytest.skip("not here")

def test_here(shared):
    assert not numba.config.DISABLE_JIT

@pytest.fixture(scope="session")
def breaks_at_the_end():
    yield
    raise AssertionError("too late")

@pytest.mark.interpreted
def test_is_the_last(breaks_at_the_end):
    pass

@pytest.mark.long
def test_long():
    pass

@pytest.mark.long(but=["0"])
@pytest.mark.parametrize("k", range(3))
def test_often_long(k):
    pass

@pytest.mark.long(only=["0"])
@pytest.mark.parametrize("k", range(3))
def test_seldom_long(k):
    pass

@pytest.mark.long(but_every=3)
@pytest.mark.parametrize("k", range(4))
def test_long_but_now_and_then(k):
    pass

@pytest.mark.long(but=["1", "seven"])
@pytest.mark.parametrize("k", range(2))
def test_wrong_ids(k):
    pass

@pytest.mark.long(only=["1"])
def test_no_parameters():
    pass
"""


@pytest.mark.interpreted
def test_numba_is_off_unless_the_environment_says_otherwise():
    assert bool(numba.config.DISABLE_JIT) is (os.environ.get("NUMBA_DISABLE_JIT", "0") != "0")


@pytest.mark.long(but=["0"])
@pytest.mark.parametrize("workers", ["0", "2"])
def test_a_run(tmp_path, workers):
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "test_some.py").write_text(TESTS)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    for name in [name for name in environment if name.startswith(("PYTEST_", "COV", "NUMBA_", "SWARMCENSUS_"))]:
        del environment[name]
    command = [sys.executable, "-m", "pytest", "-n", workers, "-v", "-p", "no:cacheprovider", "-m", "not long"]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False, timeout=300
    )
    outcomes = {"PASSED": set(), "FAILED": set()}
    for line in done.stdout.splitlines():
        words = line.split()
        outcome = next((word for word in words if word in outcomes), None)
        if outcome and "::" in line and " - " not in line:
            outcomes[outcome].add(next(word for word in words if "::" in word).partition("::")[2])
    passed = "besides[0] besides[1] besides[2] here is_the_last often_long[0] seldom_long[1] seldom_long[2]"
    passed += " long_but_now_and_then[0] long_but_now_and_then[3]"
    failed = "fails ends_the_process wrong_ids[0] wrong_ids[1] no_parameters"
    assert outcomes == {
        "PASSED": {f"test_{name}" for name in passed.split()}, "FAILED": {f"test_{name}" for name in failed.split()},
    }, done.stdout  # fmt: skip
    for said in (
        "long(but=...) names 'seven': the ids are '0', '1'",
        "long(only=...) is for tests with parameters",
        "At index 1 diff: 2 != 3",
        "too late",
        "1 skipped",
        "the process that runs tests without Numba ended with 7",
    ):
        assert said in done.stdout
    assert done.stdout.splitlines()[-1] == "6 long tests were left out: `pytest -n 2` runs all tests"
