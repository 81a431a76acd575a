"""States of mixed swarms are replayed to the bit whatever happens to them, also from logs that are cut anywhere."""

import sys

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes with signals")
ROBOTS, ROUNDS = 8, 320


@pytest.mark.long
@pytest.mark.parametrize("number", range(5))
def test_all_states_of_a_mixed_swarm_are_replayed(tmp_path, benchmark, number):
    swarm = benchmark("swarm")
    [(_, outcome, whole, logs, cut)] = swarm.rows(tmp_path, swarm.SWARMS[number : number + 1], ROBOTS, ROUNDS)
    assert outcome.died == {}
    assert (whole.differences, cut.differences) == ([], [])
    assert (whole.to_the_bit, cut.to_the_bit) == (ROBOTS, ROBOTS)
    assert whole.starts == {"blank": ROBOTS + 1, "resumed": 2, "unknown": 0}
    assert whole.ticks > ROBOTS * ROUNDS * 0.5
    assert whole.heard > whole.ticks / 2
    assert logs > 0
    assert cut.ticks < whole.ticks
    assert (whole.relived, cut.relived) == (whole.ticks, cut.ticks)
