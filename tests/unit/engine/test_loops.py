"""The engine's loops: what is compiled, and that batches do not matter; test_draws.py has their random numbers."""

from dataclasses import replace

import numba
import numpy as np
import pytest

from swarmcensus.engine import code_cache
from swarmcensus.engine.compiler import compile_helpers, compile_world
from swarmcensus.engine.constants import HEAR_PAIRS, HELPERS
from swarmcensus.engine.inlined import Whole
from swarmcensus.simulation.trials import Metrics, run_batch


@pytest.mark.skipif(code_cache.not_compiled(), reason="Numba is switched off")
def test_machine_code_is_called_with_arrays_of_its_kinds_alone():
    conclude = compile_world("riding").conclude
    swarm, rows, *others = compile_world("trial_arguments").TO_CONCLUDE
    for wrong in (rows.astype(np.float32), rows.ravel(), np.ones((3, 2)).T):
        with pytest.raises(TypeError, match="machine code is called with"):
            conclude(swarm, wrong, *others)
    with pytest.raises(TypeError, match="machine code is called with"):  # an array of no dimensions is no number
        conclude(swarm, rows, rows, np.array(others[1]), *others[2:])


@pytest.mark.skipif(code_cache.not_compiled(), reason="Numba is switched off")
def test_min_and_max_are_of_numbers_alone_as_in_numba():
    def of_numbers(a, b):
        most = max
        return min(a, b, 2), max(a > b, b), most(a, b), most((a, b))

    def of_arrays(a, b):
        return min(np.array([a, b]), np.array([b, a]))

    def of_tuples(a, b):
        return max((a, b), (b, a))

    def of_nothing(a, b):
        return min(a, b, None)

    machine = numba.njit(pipeline_class=Whole)
    for pair in ((1, 3.5), (3, -1), (2.5, np.nan), (np.nan, 2.5), (True, 0)):
        assert repr(machine(of_numbers)(*pair)) == repr(numba.njit(of_numbers)(*pair))
    for wrong in (of_arrays, of_tuples, of_nothing):
        with pytest.raises(numba.TypingError, match="No implementation of function"):
            machine(wrong)(1.0, 2.0)


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
