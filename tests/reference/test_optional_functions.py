"""Swarms that use all of the contract's optional functions live the life of the reference, in every kind of world."""

import numpy as np
import pytest

from swarmcensus.engine.constants import CHANGED, DECIDED_IN, DECISION, DONE_ESTIMATE, DONE_IN, HEARD, SENT
from swarmcensus.simulation import metrics, sampling
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import Metrics, run_batch
from tests.reference import rounds as reference, walks as reference_walks
from tests.support.lives import local_curves
from tests.support.second import ADDS, ALL, STEER, TALKS, agreed, brain, first, fixed, moving
from tests.support.small import FAULTS, GO, PASSING, SEED, failing, heard_in
from tests.support.trials import record_ride, record_trial

SOME = [{"robots": 0.4, "brain": brain(TALKS, "talks.py"), "honest": False}]
CASES = {
    "all": (ALL, {"robots": [1, 5], "topology": ["full", "ring", "line", "scale-free"]}),
    "all, lossy": (ALL, {"robots": 6, "topology": ["full", "scale-free"], "link_success": 0.6, "faults": FAULTS}),
    "all, 260": (ALL, {"robots": 260, "rounds": 3, "looks": 4, "topology": ["ring", "full"]}),
    "adds": (ADDS, {"robots": [1, 6], "topology": ["full", "ring", "scale-free"], "looks": 3}),
    "adds, lossy": (ADDS, {"robots": 6, "topology": ["full", "line"], "link_success": 0.6}),
    "adds, failing": (ADDS, {"robots": 6, "topology": ["full", "ring"], "faults": FAULTS}),
    "all, passing": (ALL, {"robots": 6, "topology": ["full", "line"], "link_success": [1.0, 0.6], "faults": PASSING}),
    "adds, passing and late": (
        ADDS,
        {"robots": 6, "topology": ["full", "ring"], "faults": PASSING, "message_delay": [0, 2]},
    ),
    "all, late": (ALL, {"topology": ["full", "ring"], "message_delay": [1, 3]}),
    "all, late and lossy": (
        ALL,
        {"topology": ["full", "line"], "message_delay": 2, "link_success": 0.6, "faults": FAULTS},
    ),
    "adds, late": (ADDS, {"robots": [1, 6], "topology": ["full", "scale-free"], "message_delay": [2, 7]}),
    "adds, late, 260": (ADDS, {"robots": 260, "rounds": 5, "topology": ["full", "ring"], "message_delay": 2}),
    "adds, late and lossy": (
        ADDS,
        {"robots": 6, "topology": ["full", "line"], "link_success": 0.6, "message_delay": 3},
    ),
    "adds, late and failing": (ADDS, {"robots": 6, "topology": ["full", "ring"], "faults": FAULTS, "message_delay": 1}),
    "mixed, late": (ALL, {"robots": 7, "topology": ["full", "ring"], "members": SOME, "message_delay": 2}),
    "mixed": (ALL, {"robots": 7, "topology": ["full", "ring", "scale-free"], "members": SOME}),
    "mixed, lossy": (ALL, {"robots": 7, "topology": ["full", "ring"], "members": SOME, "link_success": 0.6}),
    "mixed, 300": (ALL, {"robots": 300, "rounds": 3, "topology": "line", "members": SOME, "faults": FAULTS[::2]}),
}
RIDES = {
    "all": (ALL, {}),
    "all, late and lossy": (ALL, {"body": {"message_delay": 3}, "link_success": 0.7, "faults": FAULTS}),
    "all, steering": (ALL + STEER, {}),
    "all, passing": (ALL, {"faults": [*PASSING, {"at": 2, "robots": 3, "stop": "moving", "until": 9}]}),
    "all, steering, passing": (ALL + STEER, {"faults": [{"at": 2, "robots": 3, "stop": "moving", "until": 9}]}),
    "adds": (ADDS, {"body": {"message_delay": 1}}),
    "adds, failing": (ADDS, {"faults": FAULTS}),
    "mixed": (ALL, {"members": SOME, "body": {"message_delay": 2}}),
}
MEASURE = Metrics(0.01, 10, (2, 3))


def check(setting, trial, states, fields, estimates, batch, close):
    """What a trial shows and what a batch counts is what the reference's states have come to."""
    assert estimates == pytest.approx(np.array(states.estimates), rel=close, abs=close)
    for i, (own, me) in enumerate(zip(states.brains, states.states, strict=True)):
        for name in own.memory:
            here = fields[name][-1, i]
            if here.ndim:  # longer, where another brain's is
                assert np.isnan(here[own.lengths[name] :]).all()
                here = here[: own.lengths[name]]
            assert here == pytest.approx(getattr(me, name), rel=1e-9, abs=close)
    honest = np.array([not setting.members or k == 0 for k in sampling.groups(setting, SEED, trial, 1)[0]])
    assert batch.counts[0, SENT].tolist() == np.array(states.sent)[honest].tolist()
    assert batch.counts[0, HEARD].tolist() == np.array(states.heard)[honest].tolist()
    decisions, done = np.array(states.decisions), np.array(states.done)
    own, curves = decisions[:, honest], np.array(states.estimates)[:, honest]
    before = np.vstack([np.full(own.shape[1], -1.0), own])
    told = batch.verdicts[0]
    assert told[:, DECISION].tolist() == own[-1].tolist()
    assert told[:, DECIDED_IN].tolist() == first(own, lambda one: one >= 0).tolist()
    last = len(own) - first((before[1:] != before[:-1])[::-1], bool) + 1.0
    assert told[:, CHANGED].tolist() == np.where(np.isfinite(last), last, np.inf).tolist()
    ends = first(done[:, honest], bool)
    assert told[:, DONE_IN].tolist() == ends.tolist()
    for i, end in enumerate(ends):
        now = told[i, DONE_ESTIMATE]
        assert np.isnan(now) if np.isinf(end) else now == pytest.approx(curves[int(end), i], abs=close)
    assert tuple(batch.consensus[0, :2]) == agreed(own)
    assert (fields["decided"][1:] == decisions).all()
    assert (fields["is_done"][1:] == done).all()
    ends = np.array(states.intervals)
    for name, due in zip(("interval_low", "interval_high"), np.moveaxis(ends, -1, 0), strict=True):
        assert fields[name] == pytest.approx(due, rel=close, abs=close, nan_ok=True)
    low, high = np.moveaxis(ends[list(MEASURE.checkpoints)][:, honest], -1, 0)
    held = (low <= setting.fill_ratio) & (setting.fill_ratio <= high)
    assert batch.intervals[0, :, 0].tolist() == held.mean(axis=1).tolist()
    assert batch.intervals[1, :, 0] == pytest.approx((high - low).mean(axis=1), rel=1e-12)


@pytest.mark.long(
    only=["adds", "adds, late, 260", "all, 260", "mixed, late", "adds, passing and late", "all, late and lossy",
          "adds, late and failing"]
)  # fmt: skip
@pytest.mark.parametrize("name", CASES)
def test_on_fixed_networks(name):
    source, case = CASES[name]
    for setting in fixed(brain(source), **case):
        fields, estimates, blacks = record_trial(setting, SEED, 1)
        states = reference.fixed(setting, SEED, 1, failing(setting, 1), heard_in(setting, 1), blacks)
        batch = run_batch(setting, SEED, 1, 1, MEASURE, GO)
        reordered = setting.topology.name == "full" and setting.additive
        check(setting, 1, states, fields, estimates, batch, 1e-12 if reordered else 0.0)


@pytest.mark.long(only=["all, steering", "all, steering, passing"])
@pytest.mark.parametrize("name", RIDES)
def test_on_the_move(name):
    source, case = RIDES[name]
    setting = moving(brain(source), **case)
    ride, (batch,) = record_ride(setting, SEED, 1), run_ride([setting], SEED, 1, MEASURE, GO)
    life = reference_walks.lives(setting, SEED, 1, failing(setting, 1))
    made = np.array(life.readings)
    if "is_done" in ride.fields:
        made[ride.fields["is_done"][:-1] == 1.0] = np.nan
        assert not (ride.looked[1:] & (ride.fields["is_done"][:-1] == 1.0)).any()
    assert np.array(ride.readings[1:]) == pytest.approx(made, nan_ok=True)
    check(setting, 1, life.states, ride.fields, ride.estimates, batch, 0.0)


@pytest.mark.parametrize("source", [ALL, ADDS], ids=["all", "adds"])
def test_alone(source):
    """The local estimate, observation by observation: nobody is heard, whoever is done looks no more."""
    for setting in fixed(brain(source), robots=5, rounds=4, looks=3, members=SOME if source == ALL else ()):
        curves = local_curves(setting, 1)
        batch = run_batch(setting, SEED, 1, 1, Metrics(0.01, 10, ()), GO, local=True)
        honest = [not setting.members or k == 0 for k in sampling.groups(setting, SEED, 1, 1)[0]]
        assert (batch.final[0] == curves[-1][honest]).all()
        assert (batch.convergence[0] == metrics.convergence(curves)[honest]).all()
