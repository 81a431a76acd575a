"""The engine's loops: what is compiled, and that batches do not matter; test_draws.py has their random numbers."""

from dataclasses import replace

import numpy as np
import pytest

from swarmcensus.engine import code_cache
from swarmcensus.engine.compiler import LOOP_TYPES, compile_helpers, compile_world
from swarmcensus.engine.constants import HEAR_PAIRS, HELPERS
from swarmcensus.runs.running import run
from swarmcensus.simulation.trials import Metrics, run_batch
from tests.support.small import study_of


@pytest.mark.skipif(code_cache.not_compiled(), reason="Numba is switched off")
def test_each_loop_is_compiled_for_one_kind_of_arguments():
    """Else the first run would compile it twice."""
    for given in (
        {"topology": ["ring", "full"], "link_success": [1.0, 0.5], "robots": [2, 300]}, {"ticks": 5},
        {"brain": "census", "message_delay": 2, "faults": [{"at": 2, "robots": 0.5, "stop": "talking"}]},
    ):  # fmt: skip
        run(study_of(trials=2, **given), progress=False)
    types = compile_world("trial_arguments")
    for name, takes in LOOP_TYPES.items():
        file, _, function = name.partition(".")
        assert getattr(compile_world(file), function).signatures == [getattr(types, takes)], name


def test_only_what_is_needed_of_the_engine_is_compiled():
    found = compile_helpers({"hear_pairs"})
    assert [k for k, address in enumerate(found) if address] == [HEAR_PAIRS]
    assert len(found) == len(HELPERS)


# ---- the compiled engine against the oracle, against CPython, and against itself in other batches
GO = np.zeros(1, np.uint8)
MEASURE = Metrics(0.01, 10, (10, 60))


def test_trials_do_not_depend_on_their_batch(small_study):
    for setting in small_study.settings()[::5]:
        whole = run_batch(setting, 7, 0, 4, MEASURE, GO)
        parts = [run_batch(setting, 7, t, 1, MEASURE, GO) for t in range(4)]
        for name in ("convergence", "error", "final"):
            assert (getattr(whole, name) == np.concatenate([getattr(p, name) for p in parts])).all()
        assert (whole.correct == np.concatenate([p.correct for p in parts], axis=1)).all()


def test_stop_ends_a_run_at_once(small_study):
    stop = np.ones(1, np.uint8)
    assert run_batch(replace(small_study.settings()[0], rounds=10**9, robots=100), 7, 0, 1, MEASURE, stop) is None
