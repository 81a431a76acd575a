"""One trial a stretch at a time; test_recorded.py compares it with what `replay` shows."""

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.simulation import living
from swarmcensus.simulation.living import Stepped

NETWORK = {"topology": "ring", "fill_ratio": 0.6}
MOVING = {"topology": "moving", "density": 3.0, "fill_ratio": 0.6}
CASES = {
    "lossy": ({}, {**NETWORK, "topology": "scale-free", "link_success": 0.5}, {}),
    "silent": ({"brain": "voter"}, {**NETWORK, "topology": "full", "link_success": 0.7}, {}),
    "moving late": ({}, {**MOVING, "body": {"message_delay": 3}}, {}),
    "moving silent": ({"brain": "voter"}, MOVING, {}),
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


@pytest.mark.parametrize("name", CASES)
def test_it_can_be_looked_at_in_any_order(name, short):
    study = study_of(*CASES[name])
    life = Stepped(study.settings()[0], study.seed, 1)
    once = [life.at(k) for k in range(5)]
    for k in (3, 0, 4, 1, 1, 2, 0):
        again = life.at(k)
        for name, value in vars(again).items():
            if isinstance(value, np.ndarray):
                np.testing.assert_array_equal(value, getattr(once[k], name))


def test_what_is_kept_does_not_grow(short):
    study = study_of({}, MOVING, {}, rounds=2000)
    life = Stepped(study.settings()[0], study.seed, 1)
    for k in range(100):
        life.at(k)
    assert sum(part.bytes for part in life._kept.values()) <= living.KEPT_BYTES or len(life._kept) == 1
    assert len(life._copies) <= max(1, living.KEPT_BYTES // sum(array.nbytes for array in life._world.arrays))


def test_a_way_is_gone_step_by_step(short):
    life = Stepped(study_of({}, NETWORK, {}).settings()[0], 5, 1)
    assert [life.approach(3) for _ in range(4)] == [False, False, False, True]
    assert life.approach(3)
