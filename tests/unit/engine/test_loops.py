"""The engine's loops, which are compiled before there is anything to run."""

import pytest

from swarmcensus.engine import code_cache
from swarmcensus.engine.compiler import LOOP_TYPES, compile_helpers, compile_world
from swarmcensus.engine.constants import HEAR_PAIRS, HELPERS
from swarmcensus.runs.running import run
from tests.support.small import study_of

RUNS = {
    "ring": {"topology": ["ring", "full"], "link_success": [1.0, 0.5], "robots": [2, 300]},
    "odd": {"brain": "census", "message_delay": 2, "faults": [{"at": 2, "robots": 0.5, "stop": "talking"}]},
    "moving": {"ticks": 5},
}


@pytest.mark.skipif(code_cache.not_compiled(), reason="Numba is switched off")
def test_each_loop_is_compiled_for_one_kind_of_arguments():
    """Else the first run would compile it twice."""
    for given in RUNS.values():
        run(study_of(trials=2, **given), progress=False)
    types = compile_world("trial_arguments")
    for name, takes in LOOP_TYPES.items():
        file, _, function = name.partition(".")
        assert getattr(compile_world(file), function).signatures == [getattr(types, takes)], name


def test_only_what_is_needed_of_the_engine_is_compiled():
    found = compile_helpers({"hear_pairs"})
    assert [k for k, address in enumerate(found) if address] == [HEAR_PAIRS]
    assert len(found) == len(HELPERS)
