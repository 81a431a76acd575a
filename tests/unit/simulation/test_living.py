"""One trial a stretch at a time: anywhere in it, what `replay` shows, to the same bits."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.simulation import living
from swarmcensus.simulation.living import LiveTrial

NETWORK = {"topology": "ring", "fill_ratio": 0.6}
MOVING = {"topology": "moving", "density": 3.0, "fill_ratio": 0.6}
LIARS = [{"robots": 0.25, "brain": "shouter", "honest": False}]
LATE = {"body": {"message_delay": 3}}
FAULT = [{"at": 20, "robots": 0.5, "stop": ["talking", "sensing"]}]
CASES = {
    "network": ({}, NETWORK, {}),
    "lossy": ({}, {**NETWORK, "topology": "scale-free", "link_success": 0.5}, {}),
    "full": ({"brain": "commons"}, {**NETWORK, "topology": "full"}, {}),
    "silent": ({"brain": "voter"}, {**NETWORK, "topology": "full", "link_success": 0.7}, {}),
    "late": ({}, {**NETWORK, "message_delay": 2}, {}),
    "changing": ({}, {**NETWORK, "fill_ratio": {"from": 0.8, "to": 0.2, "at": 30}}, {}),
    "liars": ({}, NETWORK, {"members": LIARS}),
    "failing": ({}, NETWORK, {"faults": FAULT}),
    "moving": ({}, MOVING, {}),
    "moving lossy": ({"brain": "commons"}, {**MOVING, "link_success": 0.5}, {}),
    "moving late": ({}, {**MOVING, **LATE}, {}),
    "moving silent": ({"brain": "voter"}, MOVING, {}),
    "moving liars": ({}, MOVING, {"members": LIARS}),
    "moving failing": ({}, MOVING, {"faults": FAULT}),
    "moving steering": ({"brain": "leaver"}, MOVING, {}),
    "moving floor": ({}, {**MOVING, "floor": {"clusters": 0.3}}, {}),
}


def study_of(swarm, world, more, rounds=90):
    moves = world["topology"] == "moving"
    length = {"ticks": rounds} if moves else {"rounds": rounds}
    robots = {"robots": 8, "accuracy": "U(0.6, 0.9)"}
    return sc.Study(trials=2, seed=5, swarm=robots | swarm, world=world, schedule=length, **more)


@pytest.fixture
def short(monkeypatch):
    """Stretches of twenty rounds, and room for two of them and for few copies."""
    monkeypatch.setattr(living, "MOST_ROUNDS", 20)
    monkeypatch.setattr(living, "KEPT_BYTES", 40_000)


@pytest.mark.long(only=["moving steering", "liars", "moving liars"])
@pytest.mark.parametrize("name", CASES)
def test_it_is_what_is_replayed(name, short):
    study = study_of(*CASES[name])
    results = sc.run(study, jobs=1)
    trace = sc.replay(results, 0, 1)
    life = LiveTrial(study.settings()[0], study.seed, 1)
    parts = [life.start, *(life.at(k) for k in range(5))]
    assert [len(part.estimates) for part in parts] == [1, 20, 20, 20, 20, 10]
    assert np.concatenate([part.estimates for part in parts]).tolist() == trace["estimate"].values.tolist()
    liars = trace["honest"].values == 0 if "honest" in trace else np.zeros(8, np.bool_)
    sent, heard = parts[-1].messages[-1]
    if not liars.any():  # messages of results are those of the honest
        assert sent == results["messages_sent"].sel(setting=0, trial=1).sum()
        assert heard == results["messages_heard"].sel(setting=0, trial=1).sum()
    if "moving" in name:
        poses = np.concatenate([part.poses for part in parts])
        assert poses[..., :2].tolist() == trace["position"].values.tolist()
        assert poses[..., 2].tolist() == trace["heading"].values.tolist()
        for mine, theirs in (("readings", "reading"), ("colours", "tile")):
            np.testing.assert_array_equal(np.concatenate([getattr(p, mine) for p in parts]), trace[theirs].values)


@pytest.mark.parametrize("name", ["lossy", "silent", "moving late", "moving silent"])
def test_it_can_be_looked_at_in_any_order(name, short):
    study = study_of(*CASES[name])
    life = LiveTrial(study.settings()[0], study.seed, 1)
    once = [life.at(k) for k in range(5)]
    for k in (3, 0, 4, 1, 1, 2, 0):
        again = life.at(k)
        for value, before in zip(vars(again).values(), vars(once[k]).values(), strict=True):
            np.testing.assert_array_equal(value, before)


def test_what_is_kept_does_not_grow(short):
    study = study_of({}, MOVING, {}, rounds=2000)
    life = LiveTrial(study.settings()[0], study.seed, 1)
    for k in range(100):
        life.at(k)
    assert sum(part.bytes for part in life._kept.values()) <= living.KEPT_BYTES or len(life._kept) == 1
    assert len(life._copies) <= max(1, living.KEPT_BYTES // sum(array.nbytes for array in life._world.arrays))


def test_a_way_is_gone_step_by_step(short):
    life = LiveTrial(study_of({}, NETWORK, {}).settings()[0], 5, 1)
    assert [life.approach(3) for _ in range(4)] == [False, False, False, True]
    assert life.approach(3)
