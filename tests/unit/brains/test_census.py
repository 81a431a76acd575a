"""census: each equation by hand, weights by brute force, the noise, and that it errs as the best and without a tail."""

import math

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from tests.support.small import study_of

CENSUS = brains.load("census")
DO = CENSUS.functions
STILL, MIXED, BEGUN = -1.0, -2.0, -3.0
Z, CONFIRM, LONE = (CENSUS.parameters[name] for name in ("z", "confirm", "lone"))
NEVER = {"file": "census", "z": 1e6, "confirm": 1e6, "lone": 1e6}  # finds no change


def robots(number, b=0.8, w=0.7, **fields):
    """Robots that hear nobody yet."""
    made = [CENSUS.robot(b, w) for _ in range(number)]
    for name, me in enumerate(made):
        for field, value in {"name": float(name), "luck": 0.3, **fields}.items():
            setattr(me, field, value)
    return made


def round_of(swarm, readings, heard):
    """One round: readings are (blacks, looks) of each robot, `heard` has for each robot those that it hears."""
    for me, (blacks, looks) in zip(swarm, readings, strict=True):
        DO.observe(me, blacks, looks)
    said = [DO.broadcast(me) for me in swarm]
    for k, me in enumerate(swarm):
        for j in heard[k]:
            DO.receive(me, said[j])
        DO.fuse(me)


def ring(number, before=1, after=1):
    return [[(k + step) % number for step in (*range(-before, 0), *range(1, after + 1))] for k in range(number)]


# ---- each equation by hand
def test_a_message_has_the_sums_without_gain_running_means_and_what_is_known_of_the_network():
    """k = 0.5: three of four black add 0.5 (3 - 4 0.3) = 0.9 to s, and 0.25 4 = 1 to v."""
    (me,) = robots(1)
    DO.observe(me, 3.0, 4.0)
    assert DO.broadcast(me) == pytest.approx((0.9, 1.0, 0.9, 0.0, 0.0, 0.9, 1.0, 1.0))  # e = v: all of the reading
    sums = {"s": 59.1, "v": 119.0, "rounds": 10.0, "unit": 30.0, "marks": 7.0, "first": 3.0, "level": 0.25}
    (me,) = robots(1, **sums, short=0.5, chance=0.02, sign=-1.0, noise=0.1)
    DO.observe(me, 3.0, 4.0)
    short, chance = 0.5 + 0.4 / 10, 0.02 - (0.4 + 0.02) / 10  # the gain is 3; v = 40, so that e = 10
    assert DO.broadcast(me) == pytest.approx((20.0, 40.0, short, chance, 0.1, 0.9, 1.0, 0.25))
    for rounds, marks, due in ((1.0, 7.0, 7.0), (9.0, STILL, STILL), (9.0, MIXED, MIXED)):
        me.rounds, me.marks = rounds, marks
        assert DO.broadcast(me)[-1] == due


def test_the_estimate_is_averaged_with_what_all_voices_read():
    """r = 4 / 8 of four voices; v^2 / (n A) = 100 / (4 2), against 8: 12.5 and 8. The prior weighs 1 / (16 v)."""
    (me,) = robots(1, marks=STILL, squares=2.0, heard=3.0, own_s=1.5, own_v=3.0, heard_own_s=2.5, heard_own_v=5.0)
    DO.make_estimate(me, 4.0, 10.0)
    mixed = (4.0 + 0.003125) / 10.00625
    assert me.x == pytest.approx((12.5 * mixed + 8.0 * 0.5) / 20.5)
    for state, begun in ((9.0, 0.0), (STILL, 1.0)):  # with momentum, or while the floor may have changed
        me.marks, me.begun = state, begun
        DO.make_estimate(me, 4.0, 10.0)
        assert me.x == pytest.approx(mixed)


@pytest.mark.parametrize(("least", "fields"), [
    (Z**2, {"heard_s": 1.0, "heard_short": 0.5}),
    (LONE**2, {"heard_s": 1.0, "heard_short": 1.5}),  # nobody else sees it
    (CONFIRM**2, {"heard": 3.0, "begun": 4.0}),
    (CONFIRM**2 + 2.7726, {"heard": 7.0, "begun": 2.0}),  # 2 ln 4
    (Z**2, {"heard": 1e9, "begun": 1.0}),  # never more than for a change that nobody else found
])  # fmt: skip
@pytest.mark.parametrize("state", [MIXED, STILL])
def test_what_shows_a_change(least, fields, state):
    for times in (0.99, 1.01):
        (me,) = robots(1, marks=state, lives=8.0, noise=0.1, **fields)
        noise = 0.1 if state == STILL else 0.08 / (1.0 + me.heard)  # one round mixes all
        me.short = 0.5 - math.sqrt(times * least * noise / 100.0)
        assert DO.has_changed(me, 0.5, 400.0) == (times > 1.0)


def test_a_robot_that_begins_again_counts_only_those_that_have():
    first, other = robots(2, s=50.0, v=100.0, rounds=50.0, unit=50.0, marks=STILL, short=0.8, noise=1e-4, lives=8.0)
    round_of([first], [(0.0, 0.0)], [[]])
    assert (first.marks, first.s, first.v, first.x) == (BEGUN, 0.8, 1.0, pytest.approx(0.782, abs=0.001))
    round_of([first, other], [(0.0, 0.0), (0.0, 0.0)], [[1], []])
    assert (first.s, first.v) == (0.8, 1.0)
    first.s, first.v = 24.0, 30.5
    round_of([first], [(0.0, 0.0)], [[]])
    assert first.marks == STILL


@pytest.mark.parametrize(("heard", "kept", "noise"), [(1, 10.0, 0.125), (3, 1.0, 0.02)])
def test_a_robot_that_loses_neighbours_keeps_the_gain_and_learns_the_noise_again(heard, kept, noise):
    """In sums of 500 the gain is 10. It heard two robots; hearing three, it gives up momentum alone."""
    sums = {"s": 250.0, "v": 500.0, "unit": 500.0, "rounds": 50.0, "first": 2.0, "level": 1 / 3, "lives": 8.0}
    swarm = robots(4, **sums, short=0.5, noise=0.02, marks=7.0)
    round_of(swarm, [(0.0, 0.0)] * 4, [range(1, 1 + heard), [0, 2], [1, 3], [2, 0]])
    me = swarm[0]
    assert (me.marks, DO.gain(me)) == (STILL, 1.0)
    assert (me.s, me.v, me.noise) == pytest.approx((25.0 * kept, 50.0 * kept, noise))


def test_sums_of_marks_that_are_equal_by_chance_do_not_end_momentum():
    swarm = robots(3, s=1.0, v=2.0, unit=2.0, rounds=2.0, first=2.0, level=1 / 3, marks=9.0)
    swarm[0].marks = MIXED
    round_of(swarm, [(2.0, 4.0)] * 3, [[1, 2], [0, 2], [0, 1]])
    assert all(me.marks > 0.0 and me.level == 1 / 3 for me in swarm)


# ---- brute force
@pytest.mark.parametrize("who", [0, 1])
def test_all_readings_weigh_alike_in_a_star(who):
    """The ratio is the share of one robot's readings in the sums: without weights 0.38 of the hub, 0.13 of a leaf."""
    swarm = robots(6, 1.0, 1.0, z=1e6, confirm=1e6, lone=1e6)
    for _ in range(200):
        round_of(swarm, [(4.0 * (k == who), 4.0) for k in range(6)], [range(1, 6), *[[0]] * 5])
    assert [me.x for me in swarm] == pytest.approx([1 / 6] * 6, abs=0.01)
    assert [me.v / DO.gain(me) for me in swarm] == pytest.approx([800.0] * 6, rel=0.02)


@pytest.mark.long(but_every=3)
@pytest.mark.parametrize(("before", "after", "loses"), [(1, 1, False), (1, 1, True), (1, 0, True)])
def test_weights_of_all_readings_by_matrices(before, after, loses):
    """With momentum on a steady ring, or without; if nobody hears its own news, A is the sum of its squared weights."""
    random, number, rounds = np.random.default_rng(1), 30, 25
    swarm, links = robots(number, 1.0, 1.0, z=1e6, confirm=1e6, lone=1e6), ring(number, before, after)
    matrix = np.eye(number) * (before + after if loses else 1)
    for me, heard in zip(matrix, links, strict=True):
        me[heard] = 1.0
    matrix /= matrix.sum(1, keepdims=True)
    if loses:
        for me in swarm:  # they know of a change of the network
            me.marks, me.rounds, me.unit = STILL, 1.0, 1.0
    sent, said = np.zeros((2, number, rounds, number))  # weights of each reading in each sum
    readings = random.integers(0, 5, (rounds, number)).astype(float)
    for t in range(rounds):
        sent[:, t] += np.eye(number)
        mean = np.tensordot(matrix, sent, 1)
        g = 0.9 if t > 1 and not loses else 0.0
        sent, said = mean + g * (mean - said), sent
        round_of(swarm, [(n, 4.0) for n in readings[t]], links)
    s, v = np.tensordot(mean, readings, 2), 4.0 * mean.sum((1, 2))
    if not loses:
        assert [me.x for me in swarm] == pytest.approx(s / v, rel=1e-3)  # the prior weighs less
    own = [4.0 * np.sum(mean[k, :, k] ** 2) for k in range(number)]
    if loses:
        assert [me.v for me in swarm] == pytest.approx(v)
        assert all(me.squares <= due + 1e-12 for me, due in zip(swarm, own, strict=True))
    if after == 0:
        assert [me.squares for me in swarm] == pytest.approx(own)


@pytest.mark.parametrize("late", [False, True])
def test_nothing_is_biased_by_losses_lateness_and_late_joiners(late):
    """Readings that are what is expected of f leave every ratio at f, whatever is heard, and when. All have momentum
    for ten rounds, unless some begin late; then messages of robots with and without it are mixed."""
    random = np.random.default_rng(1)
    swarm, f, old, mixed = robots(6, 0.9, 0.7), 0.3, [], False
    for t in range(60):
        looks = random.integers(1, 5, 6) * (np.arange(6) < (4 if late and t < 20 else 6))
        for me, n in zip(swarm, looks, strict=True):
            DO.observe(me, n * (0.9 * f + 0.3 * (1 - f)), float(n))
        old.append([DO.broadcast(me) for me in swarm])
        for k, me in enumerate(swarm):
            steady = t < 10
            for j in ring(6)[k] if steady else np.flatnonzero(random.random(6) < 0.3):
                if j != k:
                    DO.receive(me, old[-1 if steady else -1 - int(random.integers(0, 4))][j])
            DO.fuse(me)
            assert me.s == pytest.approx(f * me.v, abs=1e-9 * max(me.v, 1.0))
            assert me.own_s == pytest.approx(f * me.own_v)
            assert me.v == 0.0 or me.short == pytest.approx(f)
        mixed |= len({me.marks > 0.0 for me in swarm}) == 2
    assert mixed
    assert all(me.marks == STILL for me in swarm)


def test_robots_that_one_round_mixes_all_of_know_the_same():
    swarm = robots(5)
    everybody = [[j for j in range(5) if j != k] for k in range(5)]
    for t in range(4):
        round_of(swarm, [(2.0 + 0.1 * k, 4.0) for k in range(5)], everybody)
        assert len({round(me.x, 12) for me in swarm}) == 1
        assert all(me.marks == MIXED for me in swarm) == (t > 0)
    everybody[0] = everybody[0][1:]  # a message is lost
    for heard in (1, 5):
        round_of(swarm, [(1.0, 4.0)] * 5, everybody)
        assert [me.marks for me in swarm].count(STILL) == heard  # they hear of it


@pytest.mark.long
@pytest.mark.parametrize("f", [0.1, 0.55])
@pytest.mark.parametrize("topology", ["ring", "nobody"])
def test_noise_is_what_chance_does_to_the_short_ratio(topology, f):
    """What is counted as noise, against the variance of `short` times e, over 20,000 rounds: within 15 %."""
    number, looks, rounds = 8, 4, 20000
    readings = np.random.default_rng(7).random((rounds * looks, number)) < 0.8 * f + 0.1
    links = [[k, (k + 1) % number] for k in range(number)] if topology == "ring" else None
    brain = CENSUS.with_parameters({"z": 1e6, "confirm": 1e6, "lone": 1e6})
    found = sc.infer(readings.astype(float), links, 0.9, looks, brain)
    noise, seen, short = (found[field].values[..., 1000:, :] for field in ("noise", "seen", "short"))
    assert np.maximum(noise, seen).mean() == pytest.approx(np.mean((short - f) ** 2) * 100.0, rel=0.15)


# ---- swarms
@pytest.mark.parametrize("topology", ["ring", "full"])
def test_honest_robots_err_as_the_best_and_without_a_tail(topology):
    """In 19 of 20 trials or more, no robot finds a change where there is none: estimates are the same to the bit."""
    best = "swift" if topology == "ring" else "commons"
    study = study_of(["census", NEVER, best], 50, 0.625, rounds=400, trials=20, seed=4, topology=topology)
    found, never, other = sc.run(study)["final_estimate"].values
    assert (found == never).all(axis=-1).sum() >= 19
    errors, others = abs(found - 0.55), abs(other - 0.55)
    assert np.sqrt(np.mean(errors**2)) < 1.15 * np.sqrt(np.mean(others**2))
    assert errors.max() < 1.5 * others.max()


@pytest.mark.parametrize("topology", ["ring", "full"])
def test_all_robots_find_a_change_of_a_fifth(topology):
    change = {"from": 0.55, "to": 0.35, "at": 201}
    study = study_of("census", 30, 0.8, rounds=400, trials=20, seed=5, topology=topology, fill_ratio=change)
    (found,) = sc.run(study)["final_estimate"].values
    assert abs(found - 0.35).max() < 0.05
