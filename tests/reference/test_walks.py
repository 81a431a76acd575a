"""Small swarms that move against the reference: their bodies, then their states."""

import math
from itertools import pairwise

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus.engine.addresses import address
from swarmcensus.simulation import metrics
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import Metrics
from swarmcensus.simulation.walking import Walk
from swarmcensus.worlds.bodies import Body
from tests.reference import rounds as reference, walks as reference_walks
from tests.support.small import FAULTS, GO, SEED, failing, moving_of
from tests.support.steering import WANTS, steered_in
from tests.support.trials import record_ride

# ---- bodies
KEEN = {"proximity_range": 0.3, "proximity_near": 0.1, "avoid_within": 60.0, "avoid_above": 0.05}
BODIES = {
    "default": ({}, 6, 8.0, 25),
    "alone": ({}, 1, 20.0, 30),
    "crowd": ({"straight_mean": 2.0, "turn_most": 3}, 9, 40.0, 20),
    "blind radio": ({"line_of_sight": False, "wheel_lag": 0.6, "tile": 0.03, "sensor": (-0.02, 0.03)}, 7, 30.0, 12),
    "fast": ({"speed": 0.9, "turn_speed": 0.3, "radio_range": 0.5, "straight_mean": 5.0}, 5, 5.0, 20),
    "stuck": ({"turn_speed": 0.0005, "straight_mean": 100.0}, 3, 35.0, 75),
    "keen eyes": (KEEN, 5, 20.0, 15),
    "eyes all round": ({"avoid_within": 180.0}, 9, 30.0, 20),
    "lazy": ({"turn_most": 0, "straight_mean": 1.0}, 3, 6.0, 15),
    "leaping": ({"speed": 9.0, "straight_mean": 60.0}, 9, 45.0, 8),
    "many": ({}, 50, 20.0, 2),
    "many, far apart": ({"speed": 0.9}, 60, 2.0, 5),
}


@pytest.mark.parametrize("name", BODIES)
def test_robots_walk_as_in_the_reference(name):
    """Poses to a nanometre; who looks, on which tile, and who hears whom, exactly."""
    changes, robots, density, ticks = BODIES[name]
    body, trial, key = Body(**changes), 2, address(SEED, "walk", name=name)
    side = math.sqrt(robots * math.pi * body.radio_range**2 / density)
    lame, stands = np.full((3, robots), 1 << 62), [[(7, 1 << 62)], *([] for _ in range(robots - 1))]
    lame[0, 0] = 7
    chunks = list(Walk(robots, side, body, key, trial, GO, poses=True, stops=lame).chunks(ticks))
    swarm = reference_walks.placed(robots, side, body, key, trial)
    if robots > 48:  # numbered by strips as wide as robots reach, and from left to right within
        swarm.sort(key=lambda me: (math.floor(me.place.imag / body.reach), me.place.real))
    begin = [(me.place.real, me.place.imag, math.atan2(me.heading.imag, me.heading.real)) for me in swarm]
    assert chunks[0].begin == pytest.approx(np.array(begin), abs=1e-9)
    tick = 0
    for chunk in chunks:
        assert chunk.tick == tick + 1
        for k in range(len(chunk.looked)):
            tick += 1
            now = reference_walks.step(swarm, side, body, key, trial, tick, stands, [None] * robots)
            assert chunk.poses[k] == pytest.approx(np.array(now.poses), abs=1e-9)
            assert chunk.looked[k].tolist() == now.looked
            assert chunk.tiles[k].tolist() == [list(tile) for tile in now.tiles]
            ends = chunk.heard[k * robots : (k + 1) * robots + 1]
            assert [chunk.senders[a:b].tolist() for a, b in pairwise(ends)] == now.heard
    assert tick == ticks


# ---- states
MOVES = [
    {},
    {"robots": 1, "density": 2.0},
    {"accuracy": {"black": "U(0.6, 0.9)", "white": "N(0.7, 0.1)"}, "link_success": 0.6, "body": {"message_delay": 0}},
    {"faults": [*FAULTS, {"at": 4, "robots": 2, "stop": "moving"}], "body": {"message_delay": 3}, "brain": "legacy"},
    {"accuracy": {"black": 0.9, "white": 0.6}, "density": 30.0, "body": {"line_of_sight": False, "message_delay": 2}},
    {"accuracy": {"black": "U(0.6, 0.9)", "white": 0.7}, "faults": FAULTS[1:2], "link_success": 0.5, "density": 20.0},
    {"fill_ratio": {"from": 0.9, "to": 0.2, "at": 6}, "accuracy": {"start": 0.9, "drift": -0.1, "least": 0.55}},
    {"fill_ratio": {"from": 0.1, "to": 0.8, "at": 4, "until": 11}, "accuracy": {"start": "U(0.6, 0.8)", "drift": 0.03}},
]


@pytest.mark.parametrize("case", MOVES, ids=range(len(MOVES)))
def test_swarms_that_move_live_the_life_of_the_reference(case):
    setting = moving_of(**case)
    for trial in (0, 2):
        same_life(setting, trial)


def same_life(setting, trial):
    ride = record_ride(setting, SEED, trial)
    life = reference_walks.lives(setting, SEED, trial, failing(setting, trial))
    assert ride.poses == pytest.approx(np.array([life.begin, *(now.poses for now in life.ticks)]), abs=1e-9)
    assert (ride.looked[1:] == np.array([now.looked for now in life.ticks])).all()
    assert not ride.looked[0].any()
    assert (ride.colours[1:] == np.array(life.colours)).all()
    assert np.array_equal(ride.readings[1:], np.array(life.readings), equal_nan=True)
    assert np.isnan(ride.readings[0]).all()
    assert np.isnan(ride.colours[0]).all()
    hears = [(k, i, heard) for k, now in enumerate(life.ticks, 1) for i, heard in enumerate(now.heard)]
    links = [(k, i, j) for k, i, heard in hears for j in heard if i < j]
    assert ride.links.tolist() == [list(link) for link in links]
    assert (ride.estimates == np.array(life.estimates)).all()
    told = [reference.fill_ratio_in(setting, tick) for tick in range(1, setting.rounds + 1)]
    (batch,) = run_ride([setting], SEED, trial, Metrics(0.02, 5, (2, 99)), GO)  # test_recorded.py compares all of it
    index = metrics.convergence(ride.estimates, 0.02)
    assert (batch.error[0] == metrics.error_at(ride.estimates, index, told[-1])).all()
    assert batch.correct[0, 0] == metrics.correct(ride.estimates[2], told[1], 5)
    assert np.isnan(batch.correct[1]).all()
    if trial == 0:
        assert run_ride([setting], SEED, trial, Metrics(0.02, 5, ()), np.ones(1, np.uint8)) is None


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return steered_in(tmp_path_factory.mktemp("brains"))


@pytest.mark.interpreted
@pytest.mark.parametrize(("want", "body"), [
    *((want, {}) for want in ("NEVER", "ABSURD", "CIRCLE", "STRAIGHT", "SEEN")), ("CIRCLE", {"speed": 0.0}),
    ("CIRCLE", {"turn_speed": 0.0}), ("STRAIGHT", {"turn_speed": 0.0}), ("SPIN", {"speed": 0.0}),
])  # fmt: skip
def test_swarms_that_steer_live_the_life_of_the_reference(want, body, folder, monkeypatch):
    """With a fault of their wheels, wheels that cannot do all, and a floor painted beforehand or as they go."""
    setting = moving_of(
        brain=str(folder / "steered.py"), accuracy={"black": 0.8, "white": WANTS[want]}, ticks=12,
        faults=[{"at": 9, "robots": 2, "stop": "moving"}, FAULTS[0]], link_success=0.8, body={"wheel_lag": 0.3} | body,
    )  # fmt: skip
    same_life(setting, 0)
    if want == "SEEN":
        changes = {"from": 0.3, "to": 0.8, "at": 3, "until": 9}
        for change in (changes, changes | {"from": 0.9}, {"from": 0.9, "to": 0.1, "at": 5}):
            drifting = {"start": WANTS[want], "drift": -0.02, "least": 0.1}
            for accuracy in ({"black": 0.8, "white": WANTS[want]}, drifting):
                brain = str(folder / "steered.py")
                same_life(moving_of(brain=brain, ticks=12, fill_ratio=change, accuracy=accuracy), 0)
        monkeypatch.setattr("swarmcensus.simulation.rides.MOST_TILES", 0)
        same_life(setting, 1)


def test_settings_that_share_a_walk_are_lived_together():
    rows = ((0.7, 0.55, "minimalistic"), (0.9, 0.55, "legacy"), (0.7, 0.2, "minimalistic"))
    settings = [moving_of(accuracy=a, fill_ratio=f, brain=brain) for a, f, brain in rows]
    measure = Metrics(0.02, 5, (3,))
    together = run_ride(settings, SEED, 1, measure, GO)
    for setting, batch in zip(settings, together, strict=True):
        (alone,) = run_ride([setting], SEED, 1, measure, GO)
        for name in ("convergence", "error", "final", "correct", "true_fill_ratio"):
            assert np.array_equal(getattr(batch, name), getattr(alone, name))
        assert batch.kept is None
    assert together[0].true_fill_ratio == together[1].true_fill_ratio != together[2].true_fill_ratio


def test_robots_that_find_no_room_are_said_to():
    with pytest.raises(sc.InputError, match=r"^9 robots find no room in a square of 0\.35 m$"):
        Walk(9, 0.35, Body(), address(SEED, "walk"), 0, GO)
