"""The compiled engine against the oracle, against CPython, and against itself in other batches."""

from dataclasses import replace

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.simulation.trials import Metrics, run_batch
from swarmcensus.summaries.replaying import recording
from tests.support.small import FAILS, beliefs_of, study_of

GO = np.zeros(1, np.uint8)
MEASURE = Metrics(0.01, 10, (10, 60))


@pytest.fixture(scope="module")
def mixed():
    study = study_of(
        ["minimalistic", "legacy"], robots=[1, 2, 9], accuracy=[0.6, 1.0, {"black": 0.9, "white": "N(0.7, 0.1)"}],
        rounds=12, looks=[1, 37], trials=2, seed=11, topology=["full", "ring", "line", "scale-free"],
        fill_ratio=[0.0, 0.55], link_success=[1.0, 0.5],
    )  # fmt: skip
    return study, sc.run(study, jobs=2)


@pytest.mark.parametrize(
    ("compiled", "step"),
    [
        pytest.param(True, 11, id="compiled"),
        pytest.param(True, 5, id="more compiled", marks=pytest.mark.long),
        pytest.param(False, 23, id="CPython"),
    ],
)
def test_run_equals_inference_from_its_observations(mixed, compiled, step):
    """Bit for bit; but to rounding in a full network, where the engine adds in another order."""
    study, results = mixed
    for k, setting in list(enumerate(study.settings()))[::step]:
        if setting.link_success < 1.0:
            continue
        readings, edges = recording(results, k, 1)
        beliefs, looks = beliefs_of(setting, study, 1), setting.observations_per_round
        trace = sc.infer(readings, edges, beliefs, looks, setting.brain, compiled=compiled)
        again = sc.replay(results, k, 1)
        for name in (*setting.brain.memory, "estimate"):
            if setting.topology.name == "full":
                assert trace[name].values == pytest.approx(again[name].values, rel=1e-12, abs=1e-12)
            else:
                assert (trace[name].values == again[name].values).all()


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


def test_a_brain_that_divides_by_zero_is_named(tmp_path):
    (tmp_path / "bad.py").write_text(FAILS)
    study = study_of(str(tmp_path / "bad.py"), robots=3, accuracy=0.8, rounds=70, trials=1, fill_ratio=0.5)
    with pytest.raises(sc.InputError, match=r"bad.py' fails in trial 0 of ring.*ZeroDivisionError"):
        sc.run(study)
