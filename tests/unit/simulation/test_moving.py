"""Robots that move: the physics by its own laws, the radio by brute force, and one walk with many states."""

import re

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import swarmcensus as sc
from swarmcensus.engine.addresses import address
from swarmcensus.simulation.walking import Walk
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body

GO = np.zeros(1, np.uint8)
KEY = address(5, "walk")
STUDY = """
seed = 3
trials = 2
swarm = {brain = ["minimalistic", "legacy"], robots = [1, 8], accuracy = [0.7, "U(0.525, 0.975)"]}
world = {topology = "moving", density = [1, 6], fill_ratio = 0.55, body = {message_delay = 0}}
schedule = {ticks = 120}
measure = {checkpoints = [10, 120]}
"""


def walked(robots, density, ticks, body=Body(), trial=0):  # noqa: B008 - a frozen model
    side = arena.side(robots, density, body)
    chunks = list(Walk(robots, side, body, KEY, trial, GO, poses=True).chunks(ticks))
    return side, chunks[0].begin, chunks


def poses_of(chunks):
    return np.concatenate([c.poses for c in chunks])


def gaps(xy):
    d = np.hypot(*(xy[:, :, np.newaxis] - xy[:, np.newaxis]).transpose(3, 0, 1, 2))
    return d + np.where(np.eye(d.shape[1]), np.inf, 0.0)


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 60), st.floats(0.2, 20.0), st.floats(0.0, 0.3), st.floats(0.0, 0.3), st.integers(0, 1000))
def test_nobody_is_inside_a_wall_or_another(robots, density, speed, turn_speed, trial):
    """At any tick's end, by more than a millimetre."""
    body = Body(speed=speed, turn_speed=turn_speed)
    if density > arena.largest_density(robots, body):
        return
    side, begin, chunks = walked(robots, density, 60, body, trial)
    xy = np.concatenate([begin[np.newaxis], poses_of(chunks)])[..., :2]
    assert np.abs(xy).max() <= side / 2 - body.radius + 1e-3
    assert gaps(xy).min() >= 2 * body.radius - 1e-3


@settings(max_examples=25, deadline=None)
@given(st.integers(8, 25), st.floats(0.1, 0.7), st.floats(0.0, 20.0), st.integers(0, 1000))
def test_robots_that_leap_come_to_lie_apart(robots, crowd, speed, trial):
    """In a tick they may leap right into one another or, several of them, into one corner: 2 % of the radius stays."""
    body = Body(speed=speed, proximity_range=0.0)
    _, _, chunks = walked(robots, crowd * arena.largest_density(robots, body), 40, body, trial)
    assert gaps(poses_of(chunks)[..., :2]).min() >= 1.98 * body.radius


def links_by_brute_force(xy, body):
    """Pairs in range with no third disc across the segment between them, by distances to the segment."""
    found = set()
    for i, j in zip(*np.nonzero(np.triu(gaps(xy[np.newaxis])[0] < body.radio_range)), strict=True):
        others = np.delete(xy, [i, j], axis=0) - xy[i]
        line = xy[j] - xy[i]
        along = np.clip(others @ line / (line @ line), 0, 1)
        if not body.line_of_sight or (np.hypot(*(others - np.outer(along, line)).T) >= body.radius).all():
            found.add((int(i), int(j)))
    return found


def links_of(chunk, k, robots):
    """The links of the k-th tick of a chunk, each once; every one is heard both ways."""
    starts = chunk.heard[k * robots : (k + 1) * robots + 1]
    pairs = [(i, j) for i in range(robots) for j in chunk.senders[starts[i] : starts[i + 1]].tolist()]
    assert pairs == sorted({*pairs, *((j, i) for i, j in pairs)})
    return {(i, j) for i, j in pairs if i < j}


def random_body(random, small):
    """Bodies of all sizes and speeds in arenas from sparse to crowded; small steps are those lists outlive."""
    robots = int(random.integers(2, 61))
    radio, tick = 10.0 ** random.uniform(-2, 2), 10.0 ** random.uniform(-2, 1)
    radius = radio * 10.0 ** random.uniform(-3, 0)
    step = radio * (0.05 / random.integers(4, 12) * random.uniform(0.98, 1.0) if small else random.uniform(0.02, 0.5))
    body = Body(
        speed=step / tick, turn_speed=random.uniform(0, 0.1) * radius / tick, wheel_distance=radius,
        radius=radius, tick=tick, wheel_lag=random.choice([0.0, 0.1, 1.0]),
        straight_mean=10.0 ** random.uniform(0, 2.5), proximity_range=random.choice([0.0, radius]),
        proximity_near=0.3 * radius, tile=radio / 50, radio_range=radio,
        line_of_sight=bool(random.integers(2)),
    )  # fmt: skip
    return robots, min(10.0 ** random.uniform(-0.5, 1), 0.6 * arena.largest_density(robots, body)), body


@pytest.mark.long(but=["False"])
@pytest.mark.parametrize("small", [True, False])
def test_no_link_is_missing_at_any_body(small):
    """Nor is there one too many; fixed seed, some 37,000 links."""
    random = np.random.default_rng(8)
    for trial in range(15):
        robots, density, body = random_body(random, small)
        for chunk in walked(robots, density, 50, body, trial)[2]:
            for k, pose in enumerate(chunk.poses):
                assert links_of(chunk, k, robots) == links_by_brute_force(pose[:, :2], body), (trial, body)


@pytest.mark.parametrize(("change", "said"), [
    (("density = [1, 6], ", ""), "world.density is missing"),
    (("[1, 6]", "[1, 600]"), "world.density = 600.0"),
    (("[1, 6]", "[0]"), "world.density[0] = 0"),
    (("message_delay = 0", "message_delay = -1"), "world.body.message_delay = -1"),
    (("message_delay = 0", "sped = 1"), "unknown key world.body.sped: did you mean 'speed'"),
    (('"moving"', '"ring"'), "world.density"),
    (("measure = {", "measure = {local = true, "), "measure.local = true"),
])  # fmt: skip
def test_what_is_wrong_is_named(change, said):
    assert change[0] in STUDY
    with pytest.raises(sc.InputError, match=re.escape(said)):
        sc.Study.parse(STUDY.replace(*change, 1))
