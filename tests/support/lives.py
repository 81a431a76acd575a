"""Small swarms on fixed networks in the engine and by brute force."""

from dataclasses import replace

import numpy as np
import pytest

from swarmcensus.engine.constants import HEARD, SENT
from swarmcensus.simulation import metrics, sampling
from swarmcensus.simulation.trials import Metrics, record_readings, run_batch
from swarmcensus.support.quantities import half_width
from tests.reference import rounds as reference
from tests.support.small import GO, SEED, failing, heard_in
from tests.support.trials import record_trial

MEASURE = Metrics(0.02, 10, (2, 8))


def lived(setting, trial=1):
    """A trial in the engine and by brute force: estimates, and messages sent and heard of the honest."""
    _, estimates, blacks = record_trial(setting, SEED, trial)
    states = reference.fixed(setting, SEED, trial, failing(setting, trial), heard_in(setting, trial), blacks)
    batch = run_batch(setting, SEED, trial, 1, MEASURE, GO)
    honest = sampling.groups(setting, SEED, trial, 1)[0] == 0
    assert estimates == pytest.approx(np.array(states.estimates), abs=1e-12)
    assert batch.final[0] == pytest.approx(np.array(states.estimates[-1])[honest], abs=1e-12)
    assert batch.agreement[0] == metrics.agreement(estimates[:, honest], MEASURE.delta)
    reached = [checkpoint for checkpoint in MEASURE.checkpoints if checkpoint < len(estimates)]
    assert batch.disagreement[: len(reached), 0].tolist() == half_width(estimates[reached][:, honest]).tolist()
    assert batch.counts[0, SENT].tolist() == np.array(states.sent)[honest].tolist()
    assert batch.counts[0, HEARD].tolist() == np.array(states.heard)[honest].tolist()
    return batch, honest


def local_curves(setting, trial):
    """Estimates of robots that hear nobody, after each single observation; faults count in rounds."""
    failed, looks = failing(setting, trial), setting.observations_per_round
    readings = record_readings(setting, SEED, trial)
    for i, spells in enumerate(failed.sensing):
        for since, until in spells:
            readings[(since - 1) * looks : (until - 1) * looks, i] = np.nan
    lone = reference.States(setting, SEED, trial, reference.failures(replace(setting, faults=()), [], trial), True)
    for step, row in enumerate(readings, start=1):
        lone.live(step, row.tolist(), 1, [[] for _ in row])
    return np.array(lone.estimates)
