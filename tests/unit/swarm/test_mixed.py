"""Minds of mixed swarms in all that can happen are lived again to the bit, also from logs that are cut anywhere."""

import importlib
import sys

import pytest

from tests.support.places import ROOT

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes with signals")
ROBOTS, ROUNDS = 8, 320


@pytest.fixture
def minds(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    return importlib.import_module("minds")


@pytest.mark.long
@pytest.mark.parametrize("brain", ["commons", "steadfast", "minimalistic", "tracking", "voter"])
def test_all_minds_of_a_mixed_swarm_are_lived_again(tmp_path, minds, brain):
    swarms = [given for given in minds.SWARMS if given["brain"] == brain]
    [(_, outcome, whole, logs, cut)] = minds.rows(tmp_path, swarms, ROBOTS, ROUNDS)
    assert outcome.died == {}
    assert (whole.differences, cut.differences) == ([], [])
    assert (whole.to_the_bit, cut.to_the_bit) == (ROBOTS, ROBOTS)
    assert whole.starts == {"blank": ROBOTS + 1, "resumed": 2, "unknown": 0}
    assert whole.ticks > ROBOTS * ROUNDS * 0.5
    assert whole.heard > whole.ticks / 2
    assert logs > 0
    assert cut.ticks < whole.ticks
    assert (whole.relived, cut.relived) == (whole.ticks, cut.ticks)


def test_every_brain_of_the_benchmark_is_tested(minds):
    assert [given["brain"] for given in minds.SWARMS] == ["commons", "steadfast", "minimalistic", "tracking", "voter"]
