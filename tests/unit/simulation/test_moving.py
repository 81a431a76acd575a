"""Robots that move: the physics by its own laws, the radio by brute force, and one walk with many states."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import stats

import swarmcensus as sc
from swarmcensus.engine import constants, motion
from swarmcensus.engine.addresses import address
from swarmcensus.results.replaying import recording
from swarmcensus.simulation import metrics
from swarmcensus.simulation.walking import Walk
from swarmcensus.worlds import arena
from swarmcensus.worlds.bodies import Body
from tests.support.small import beliefs_of, called

GO = np.zeros(1, np.uint8)
KEY = address(5, "walk")
STUDY = """
seed = 3
trials = 2
[swarm]
brain = ["minimalistic", "legacy"]
robots = [1, 8]
accuracy = [0.7, "U(0.525, 0.975)"]
[world]
topology = "moving"
density = [1, 6]
fill_ratio = 0.55
link_success = [1.0, 0.5]
[world.body]
message_delay = 0
[schedule]
ticks = 120
[measure]
checkpoints = [10, 120]
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


def test_crowds_stay_apart_too():
    body = Body()
    density = arena.largest_density(25, body)
    side, begin, chunks = walked(25, density, 300)
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


@pytest.mark.interpreted
def test_contact_beyond_listed_neighbours():
    """Robot 1, between 0 and 2, is pushed into 2, which was too far away to be listed with it."""
    body = Body(speed=0.01).numbers[0]
    state = np.zeros((constants.STATE, 3))
    state[constants.X] = 0.0, 0.01, 0.2
    close, pushed = np.array([[0, 1]], np.uint32), np.zeros(3)
    assert called(motion.part)(state, body, 10.0, close, 1, pushed, 0) == 1
    assert state[constants.X, 1] == pytest.approx(0.01 + body.radius - 0.005)
    assert pushed[1] > body.step + body.radius / 10
    close = np.array([[0, 1], [1, 2]], np.uint32)
    sweep = 1
    while sweep < motion.SWEEPS:
        sweep = called(motion.part)(state, body, 10.0, close, 2, pushed, sweep)
    assert np.diff(state[constants.X]).min() > 2 * body.radius - 2e-6


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


@pytest.mark.parametrize(("robots", "density"), [(25, 1.0), (25, 10.0), (70, 6.0)])
@pytest.mark.parametrize("sight", [True, False])
def test_links_are_those_of_brute_force(robots, density, sight):
    """Range and line of sight; 70 robots use the grid, 25 do not."""
    body = Body(line_of_sight=sight)
    _, _, chunks = walked(robots, density, 60, body)
    (chunk,) = chunks
    for k in range(0, 60, 7):
        assert links_of(chunk, k, robots) == links_by_brute_force(chunk.poses[k, :, :2], body)


def random_body(random, small):
    """Bodies of all sizes and speeds in arenas from sparse to crowded; small steps are those lists outlive."""
    robots = int(random.integers(2, 61))
    radio, tick = 10.0 ** random.uniform(-2, 2), 10.0 ** random.uniform(-2, 1)
    radius = radio * 10.0 ** random.uniform(-3, 0)
    step = radio * (0.05 / random.integers(4, 12) * random.uniform(0.98, 1.0) if small else random.uniform(0.02, 0.5))
    body = Body(
        speed=step / tick,
        turn_speed=random.uniform(0, 0.1) * radius / tick,
        wheel_distance=radius,
        radius=radius,
        tick=tick,
        wheel_lag=random.choice([0.0, 0.1, 1.0]),
        straight_mean=10.0 ** random.uniform(0, 2.5),
        proximity_range=random.choice([0.0, radius]),
        proximity_near=0.3 * radius,
        tile=radio / 50,
        radio_range=radio,
        line_of_sight=bool(random.integers(2)),
    )
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


def test_placement_is_uniform():
    """Coordinates and headings of lone robots: Kolmogorov-Smirnov, 0.1 % level each, fixed seed."""
    begins = []
    for trial in range(800):
        side, begin, _ = walked(1, 0.5, 1, trial=trial)
        begins.append(begin[0])
    x, y, heading = np.array(begins).T
    room = side / 2 - Body().radius
    for values, half in ((x, room), (y, room), (heading, math.pi)):
        assert stats.kstest(values, stats.uniform(-half, 2 * half).cdf).pvalue > 1e-3


def test_a_lone_robots_free_walk():
    """Mean squared displacement against the exact one of the same run-and-turn process: 4 standard errors.

    Moves alternate at random: a turn of n = 0 ... 10 ticks (0: a tick of standing) either way, or a run of
    floor(Exp(15)) ticks, one at least; no wheel lag here.
    """
    body = Body(wheel_lag=0.0)
    ticks, lag, robots = 4000, 100, 12
    squares = []
    for trial in range(robots):
        _, _, chunks = walked(1, 1e-5, ticks, body, trial)  # an arena of hundreds of metres
        xy = poses_of(chunks)[:, 0, :2]
        squares.append(np.sum((xy[lag:] - xy[:-lag]) ** 2, axis=1).mean())
    expected = run_and_turn(body, lag)
    assert abs(np.mean(squares) - expected) < 4 * np.std(squares) / np.sqrt(robots - 1)


def run_and_turn(body, lag):
    """The stationary process's mean squared displacement, from its velocity correlation by a Markov chain.

    States: the remaining ticks of a run, of a turn left or right, or a tick of standing. The chain is weighted
    by exp(i angle) of each tick's turn, which gives E[cos] of the heading's change between any two ticks.
    """
    angle = 2 * body.turn_speed * body.tick / body.wheel_distance
    longest = 400
    run = np.array([math.exp(-k / 15) - math.exp(-(k + 1) / 15) for k in range(longest)])
    run[1] += run[0]
    run[0] = 0.0
    states = (
        [("run", k) for k in range(1, longest)]
        + [(s, k) for s in ("left", "right") for k in range(1, 11)]
        + [("stand", 1)]
    )
    index = {s: k for k, s in enumerate(states)}
    first = np.zeros(len(states))
    for k in range(1, longest):
        first[index["run", k]] = 0.5 * run[k]
    for s in ("left", "right"):
        for k in range(1, 11):
            first[index[s, k]] = 0.25 / 11
    first[index["stand", 1]] = 0.5 / 11
    first /= first.sum()
    chain = np.zeros((len(states), len(states)))
    for (kind, k), n in index.items():
        if k == 1:
            chain[n] = first
        else:
            chain[n, index[kind, k - 1]] = 1.0
    weights = np.array([{"run": 0, "stand": 0, "left": 1, "right": -1}[kind] * angle for kind, _ in states])
    moving = np.array([kind == "run" for kind, _ in states], float)
    stationary = np.array([1.0] * len(states))
    for _ in range(600):
        stationary = stationary / stationary.sum() @ chain
    stationary /= stationary.sum()
    # correlation of steps m ticks apart: start moving, then turn along the way, then move
    state = (stationary * moving).astype(complex)
    correlation = [stationary @ moving]
    for _ in range(1, lag):
        state = (state @ chain) * np.exp(1j * weights)
        correlation.append(float(np.real(state @ moving)))
    step = body.speed * body.tick
    return step**2 * (lag * correlation[0] + 2 * sum((lag - m) * correlation[m] for m in range(1, lag)))


@pytest.fixture(scope="module")
def moving():
    study = sc.Study.parse(STUDY)
    return study, sc.run(study, jobs=2)


def test_run_equals_replay_and_inference(moving):
    study, results = moving
    for k, setting in enumerate(study.settings()):
        trace = sc.replay(results, k, 1)
        curves = trace["estimate"].values
        index = metrics.convergence(curves)
        n = setting.robots
        assert (results["convergence_round"].values[k, 1, :n] == index).all()
        assert (results["final_estimate"].values[k, 1, :n] == curves[-1]).all()
        for c, checkpoint in enumerate((10, 120)):
            assert results["correct"].values[k, c, 1] == metrics.correct(curves[checkpoint], 0.55)
        if setting.link_success == 1.0:
            readings, messages = recording(results, k, 1)
            again = sc.infer(readings, messages, beliefs_of(setting, study, 1), 1, setting.brain, compiled=k % 8 != 0)
            assert (again["estimate"].values == curves).all()


def test_minds_share_walks_and_differ(moving):
    study, results = moving
    alike = [k for k, s in enumerate(study.settings()) if s.robots == 8 and s.density == 6.0]
    one, other = sc.replay(results, alike[0], 0), sc.replay(results, alike[-1], 0)
    assert one["position"].equals(other["position"])
    assert not one["estimate"].equals(other["estimate"])


def test_jobs_and_subsets_give_the_same_bits(moving):
    study, results = moving
    assert sc.run(study, jobs=1).equals(results)
    part = sc.run(sc.Study.parse(STUDY.replace("[1, 6]", "[6]").replace('["minimalistic", "legacy"]', '"legacy"')))
    kept = (results["density"] == 6.0).values & (results["brain"] == "legacy").values
    for name in ("convergence_round", "final_estimate", "correct"):
        assert np.array_equal(part[name].values, results[name].values[kept], equal_nan=True)


def test_a_message_takes_its_time():
    """What a robot uses at tick k its neighbours computed delay ticks earlier; its own values are of tick k."""
    for delay in (0, 1, 3):
        study = sc.Study.parse(
            STUDY.replace("message_delay = 0", f"message_delay = {delay}").replace('"U(0.525, 0.975)"', "0.8")
        )
        results = sc.run(study)
        k = next(k for k, s in enumerate(study.settings()) if s.robots == 8 and s.density == 6.0)
        trace = sc.replay(results, k, 0, links=True)
        alpha, beta = trace["alpha"].values, trace["beta"].values
        expected = np.zeros_like(beta)
        for tick, i, j in trace["link"].values:
            if tick >= delay:
                expected[tick, i] += alpha[tick - delay, j]
                expected[tick, j] += alpha[tick - delay, i]
        heard = trace["neighbours"].values > 0
        heard[:delay] = False
        assert beta[heard] == pytest.approx(expected[heard], rel=1e-12)
        # with nobody in reach the last social values stay
        alone = ~heard[1:]
        assert (beta[1:][alone] == beta[:-1][alone]).all()


def test_a_replay_holds_every_link():
    """As recorded, at a speed at which lists are nearly worn out when they are made anew."""
    study = sc.Study.parse(
        STUDY.replace('["minimalistic", "legacy"]', '"minimalistic"').replace("robots = [1, 8]", "robots = 60")
        .replace('[0.7, "U(0.525, 0.975)"]', "0.7").replace("[1, 6]", "1").replace("[1.0, 0.5]", "1.0")
        .replace("message_delay = 0", "speed = 0.087\nradius = 0.007\nstraight_mean = 300\nproximity_range = 0")
    )  # fmt: skip
    results = sc.run(study)
    for trial in range(2):
        trace = sc.replay(results, 0, trial, links=True)
        links = {tuple(link) for link in trace["link"].values.tolist()}
        body = study.settings()[0].body
        expected = {
            (k, *pair) for k, xy in enumerate(trace["position"].values) if k for pair in links_by_brute_force(xy, body)
        }
        assert links == expected


def test_readings_come_from_the_tile_under_the_sensor(moving):
    """The tile is where the pose puts the sensor, its colour is one for all visits, and readings err at rate 1 - b."""
    study, results = moving
    k = next(k for k, s in enumerate(study.settings()) if s.robots == 8 and str(s.accuracy) == "0.7")
    wrong = looks = 0
    for trial in range(2):
        trace = sc.replay(results, k, trial)
        x, y = trace["position"].values[1:].transpose(2, 0, 1)
        c, s = np.cos(trace["heading"].values[1:]), np.sin(trace["heading"].values[1:])
        column = np.floor((x + 0.0614 * c - 0.01 * s) / 0.01).astype(int)
        row = np.floor((y + 0.0614 * s + 0.01 * c) / 0.01).astype(int)
        colours: dict[tuple[int, int], set[float]] = {}
        for key, colour in zip(
            zip(column.ravel(), row.ravel(), strict=True), trace["tile"].values[1:].ravel(), strict=True
        ):
            colours.setdefault(key, set()).add(colour)
        assert sum(len(c) > 1 for c in colours.values()) <= 0.002 * len(colours)  # arctan2 rounds at tile borders
        looked = trace["looked"].values[1:] == 1
        assert np.isnan(trace["reading"].values[1:][~looked]).all()
        wrong += (trace["reading"].values[1:] != trace["tile"].values[1:])[looked].sum()
        looks += looked.sum()
    assert abs(wrong / looks - 0.3) < 4 * np.sqrt(0.21 / looks)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("density = [1, 6]", ""), "world.density is missing"),
        (("[1, 6]", "[1, 600]"), "world.density = 600.0"),
        (("[1, 6]", "[0]"), "world.density[0] = 0"),
        (("message_delay = 0", "message_delay = -1"), "world.body.message_delay = -1"),
        (("message_delay = 0", "sped = 1"), "unknown key world.body.sped: did you mean 'speed'"),
        (('"moving"', '"ring"'), "world.density"),
        (("[measure]", "[measure]\nlocal = true"), "measure.local = true"),
    ],
)
def test_what_is_wrong_is_named(change, said):
    assert change[0] in STUDY
    with pytest.raises(sc.InputError) as caught:
        sc.Study.parse(STUDY.replace(*change, 1))
    assert said in str(caught.value)
