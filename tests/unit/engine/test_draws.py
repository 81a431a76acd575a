"""What is drawn: each number where the docs say it is drawn, and on just what they say it depends."""

import itertools
import math
from dataclasses import replace
from functools import partial

import numba
import numpy as np
import pytest
from scipy import stats

from swarmcensus.engine.addresses import address
from swarmcensus.engine.changes import renew, source_of
from swarmcensus.engine.compiler import compile_world
from swarmcensus.engine.draws import COLUMNS, LOW, PART
from swarmcensus.engine.layout import Sensors
from swarmcensus.engine.random import block, counter, words
from swarmcensus.simulation import sampling
from swarmcensus.simulation.trials import record_readings
from swarmcensus.studies import addresses
from swarmcensus.worlds.bodies import Body
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.changes import Change
from swarmcensus.worlds.faults import Fault, stops
from swarmcensus.worlds.sensors import parse_accuracy, parse_assumed
from tests.reference import rounds as reference
from tests.support.second import ALL, RANDOM, brain
from tests.support.small import SEED, heard_in, moving_of, settings_of
from tests.support.trials import record_trial


# ---- random numbers
def test_the_reference_is_threefry():
    """The published vectors of Threefry-2x64 with 13 rounds, and the engine's cipher on any counter."""
    zero, one = (0, 0), (2**32 - 1, 2**32 - 1)
    assert reference.threefry((0, 0), zero, zero) == (0xF167B032C3B480BD, 0xE91F9FEE4B7A6FB5)
    assert reference.threefry((2**64 - 1,) * 2, one, one) == (0xCCDEC5C917A874B1, 0x4DF53ABCA26CEB01)
    key = address(SEED, "anything")
    for high, low in (((0, 1), (2, 3)), ((7, 2**32 - 1), (2**31, 0))):
        found = block(key[0], key[1], np.uint64(counter(*high)), np.uint64(counter(*low)))
        assert tuple(map(int, found)) == reference.threefry(reference.key_of(key), high, low)


@pytest.mark.parametrize(("first", "size"), [(0, 1), (0, 4), (0, 5), (2, 3), (6, 2)])
def test_each_robot_has_words_of_its_own(first, size):
    key, out = address(SEED, "words"), np.zeros(size, np.uint64)
    words(key, 4, 9, 3, first, size, out)
    assert out.tolist() == [reference.robots_word(key, 4, 9, first + i, part=3) for i in range(size)]


def test_an_address_is_of_all_that_it_is_made_of():
    given = ((1, "a", {"x": 1}), (2, "a", {"x": 1}), (1, "b", {"x": 1}), (1, "a", {"x": 2}), (1, "a", {"y": 1}))
    keys = [address(seed, name, **numbers) for seed, name, numbers in given]
    assert len({key.tobytes() for key in keys}) == len(keys)
    assert (address(1, "a", x=1, y=2) == address(1, "a", y=2, x=1)).all()
    assert [(key.dtype, key.shape) for key in keys] == [(np.dtype(np.uint64), (2,))] * len(keys)


READINGS, LOSSES, WALK, FLOOR, DRAWS = "readings_key", "losses_key", "walk_key", "floor_key", "draw_keys"
KEYS = (READINGS, LOSSES, WALK, FLOOR, DRAWS)
CHANGES = {  # what is changed, and whose numbers are others then
    "robots": (7, {*KEYS}),
    "density": (3.0, {*KEYS}),
    "fill_ratio": (0.3, {READINGS, FLOOR}),
    "change": (Change(0.55, 0.1, 3), set()),  # from what there is now: it begins as the same world
    "change's begin": (Change(0.3, 0.55, 3), {READINGS, FLOOR}),
    "accuracy": (parse_accuracy(0.9), {READINGS}),
    "accuracy's drift": (parse_accuracy({"start": 0.7, "drift": -0.01}), set()),
    "observations_per_round": (2, {READINGS}),
    "link_success": (0.25, {LOSSES}),
    "rounds": (99, set()),
    "assumed_accuracy": (parse_accuracy(0.9), set()),
    "brain": (brain(ALL), set()),
    "faults": ((Fault(at=3, robots=1, stop="sensing"),), set()),
    "body": (Body(speed=0.1, tile=0.05), {WALK}),
    "body's tile": (Body(tile=0.06), {WALK, FLOOR}),
    "body's radio": (Body(tile=0.05, message_delay=3), set()),
}


@pytest.mark.parametrize("what", CHANGES)
def test_draws_depend_on_just_what_they_are_said_to_depend_on(what):
    setting = moving_of(link_success=0.5, brain=brain(RANDOM))
    value, others = CHANGES[what]
    changed = replace(setting, **{what.partition("'")[0]: value})
    for key in KEYS:
        same = getattr(addresses, key)(setting, SEED) == getattr(addresses, key)(changed, SEED)
        assert same.all() == (key not in others), key
        assert (getattr(addresses, key)(setting, SEED) != getattr(addresses, key)(setting, SEED + 1)).all()
    alone = [addresses.draw_keys(one, SEED, alone=True) for one in (setting, changed)]
    assert (alone[0] == alone[1]).all() == (what != "robots")


def test_purposes_share_no_numbers():
    setting = moving_of(link_success=0.5, brain=brain(RANDOM))
    keys = [getattr(addresses, key)(setting, SEED) for key in (READINGS, LOSSES, WALK, FLOOR)]
    keys += [addresses.readings_key(setting, SEED, "order"), *addresses.draw_keys(setting, SEED).reshape(2, 2)]
    assert len({key.tobytes() for key in keys}) == len(keys)
    ring, line = settings_of(topology=["ring", "line"], link_success=0.5, brain=brain(RANDOM))
    for key in (LOSSES, DRAWS):
        assert (getattr(addresses, key)(ring, SEED) != getattr(addresses, key)(line, SEED)).all()
    for same in (addresses.readings_key, partial(addresses.draw_keys, alone=True)):
        assert (same(ring, SEED) == same(line, SEED)).all()


# ---- readings
@numba.njit
def made(sensors):
    source = source_of(sensors)
    renew(source, 1, 0, sensors.b.size)
    return source.tables


def tables_of(b, w, fill_ratio, looks):
    """The alias rows of robots of these accuracies, on a floor that stays."""
    course, key = np.array([fill_ratio, fill_ratio, 1.0, 1.0]), np.zeros(2, np.uint64)
    return made(Sensors(b, w, np.zeros((3, 0)), course, looks, key, key))


def shares_of(row):
    """The probabilities of the columns of an alias row."""
    shares = np.zeros(COLUMNS)
    for column in range(COLUMNS):
        kept = float(row[column] & ~LOW) / 2.0**64
        shares[column] += kept / COLUMNS
        shares[int(row[column] & LOW)] += (1 - kept) / COLUMNS
    return shares


def picked(row, word):
    """What a word picks from an alias row: four bits pick the column, sixty decide for it or its alias."""
    column = word >> 60
    return column if word << 4 & reference.MASK < int(row[column]) & ~15 else int(row[column]) & 15


@pytest.mark.interpreted
@pytest.mark.parametrize("looks", [1, PART - 1, PART, PART + 1, 2 * PART, 2 * PART + 4])
def test_black_counts_are_binomial_and_addressed(looks):
    """Each robot's own accuracies, each part of a long round, each round and trial."""
    (setting,) = settings_of(robots=5, looks=looks, rounds=3, accuracy={"black": "U(0.7, 0.9)", "white": "U(0.4, 0.8)"})
    for trial in (0, 1):
        b, w = (side[0] for side in sampling.accuracies(setting, SEED, trial, 1)[:2])
        tables = tables_of(b, w, 0.55, looks)
        sizes = [PART] * (looks // PART) + [looks % PART] * (looks % PART > 0)
        assert len(tables) == len(set(sizes))
        _, _, blacks = record_trial(setting, SEED, trial)
        for i in range(5):
            p = b[i] * 0.55 + (1 - w[i]) * 0.45
            rows = {size: tables[0 if size == PART else -1, i] for size in sizes}
            for size, row in rows.items():
                assert shares_of(row) == pytest.approx(stats.binom.pmf(np.arange(COLUMNS), size, p), abs=1e-14)
            key = addresses.readings_key(setting, SEED)
            for tick in range(1, 4):
                drawn = (reference.robots_word(key, trial, tick, i, part) for part in range(len(sizes)))
                assert blacks[tick, i] == sum(picked(rows[size], word) for size, word in zip(sizes, drawn, strict=True))


@pytest.mark.interpreted
@pytest.mark.parametrize("looks", [3, PART + 2])
@pytest.mark.parametrize("change", [{"at": 3}, {"at": 2, "until": 4}], ids=["switch", "drift"])
@pytest.mark.parametrize(("accuracy", "members"), [
    (0.8, []), ({"start": 0.8, "drift": -0.07, "least": 0.6}, []), ({"start": "U(0.6, 0.8)", "drift": 0.1}, []),
    (0.8, [{"robots": 2, "accuracy": {"start": "U(0.7, 0.8)", "drift": -0.2}}]),
    ({"start": 0.8, "drift": -0.07}, [{"robots": 2, "accuracy": {"black": 0.9, "white": 0.6}}]),
])  # fmt: skip
def test_counts_follow_the_floor_and_the_sensors_of_the_round(accuracy, members, change, looks):
    """In each round those of tables that stand for its own fill ratio and accuracies."""
    world = {"rounds": 5, "trials": 2, "members": members, "fill_ratio": {"from": 0.9, "to": 0.2} | change}
    (setting,) = settings_of(robots=5, accuracy=accuracy, looks=looks, **world)
    sizes = [PART] * (looks // PART) + [looks % PART]
    for trial in (0, 1):
        b, w = (np.broadcast_to(side[0], 5) for side in sampling.accuracies(setting, SEED, trial, 1)[:2])
        who = sampling.groups(setting, SEED, trial, 1)[0]
        _, _, blacks = record_trial(setting, SEED, trial)
        assert (record_readings(setting, SEED, trial).reshape(5, looks, 5).sum(axis=1) == blacks[1:]).all()
        for tick, i in itertools.product(range(1, 6), range(5)):
            now = [reference.accuracy_in(setting, who[i], side[i], tick) for side in (b, w)]
            tables = tables_of(*(np.array([side]) for side in now), reference.fill_ratio_in(setting, tick), looks)
            key = addresses.readings_key(setting, SEED)
            words_ = [reference.robots_word(key, trial, tick, i, part) for part in range(len(sizes))]
            pairs = zip(sizes, words_, strict=True)
            drawn = [picked(tables[0 if size == PART else -1, 0], word) for size, word in pairs]
            assert blacks[tick, i] == sum(drawn)


# ---- what is drawn once a trial
def test_uniform_spreads_are_of_trial_and_robot():
    key, out = address(SEED, "spread"), np.empty((2, 5))
    compile_world().draw_uniform(key, 3, 0.2, 0.7, out)
    expected = [[0.2 + 0.5 * reference.unit(reference.robots_word(key, 3 + t, 0, i)) for i in range(5)] for t in (0, 1)]
    assert out == pytest.approx(np.array(expected), rel=1e-12)


@pytest.mark.parametrize(("mean", "sd"), [(0.7, 0.1), (0.95, 0.3), (0.05, 0.004), (0.5, 5.0)])
def test_normal_spreads_are_drawn_by_rejection(mean, sd):
    """From U(low, high), with the density of the normal distribution over its peak as the chance to be taken."""
    key, out = address(SEED, "spread"), np.empty((2, 6))
    compile_world().draw_normal(key, 3, mean, sd, out)
    low, high = max(0.0, mean - 9 * sd), min(1.0, mean + 9 * sd)
    for t in (0, 1):
        for i in range(6):
            for attempt in range(1000):
                a, b = map(reference.unit, reference.threefry(reference.key_of(key), (3 + t, attempt), (0, i)))
                x = low + (high - low) * a
                if b < stats.norm.pdf(x, mean, sd) / stats.norm.pdf(mean, mean, sd):
                    break
            assert out[t, i] == pytest.approx(x, rel=1e-12)


def accuracies(text="U(0.5, 0.9)", seed=SEED, purpose="accuracy", robots=6, first=0):
    return parse_accuracy(text).draw(seed, purpose, first, 2, robots)


def test_errors_of_belief_are_drawn_where_the_docs_say():
    """Uniform ones from one number, normal ones by Box and Muller's transform of two."""
    for text, f in (
        ("U(-0.2,0.1)", lambda u, v: -0.2 + 0.3 * u),
        ("N(0.05,0.02)", lambda u, v: 0.05 + 0.02 * math.sqrt(-2 * math.log(1 - u)) * math.cos(2 * math.pi * v)),
    ):
        keys = [address(SEED, f"error {part}", error=text, robots=6) for part in (0, 1)]
        for t in (0, 1):
            for i in range(6):
                uv = (reference.unit(reference.robots_word(key, 4 + t, 0, i)) for key in keys)
                assert errors(text, first=4)[0][t, i] == pytest.approx(f(*uv), rel=1e-9)
    drawn = parse_assumed({"error": 0.1}).draw(SEED, 0, 2, 6, (np.full((2, 1), 0.7),) * 2)
    assert [v.shape for v in drawn] == [(2, 1)] * 2
    assert errors("0.1")[0].ravel() == pytest.approx([0.1, 0.1])


def errors(text, seed=SEED, robots=6, first=0, true=0.5):
    assumed = parse_assumed({"error": text}).draw(seed, first, 2, robots, (np.full((2, 1), true),) * 2)
    return assumed[0] - true, assumed[1] - true


@pytest.mark.parametrize("robots", [1, 2, 3, 9])
def test_scale_free_networks_are_grown_robot_by_robot(robots):
    (setting,) = settings_of(robots=robots, topology="scale-free")
    links = sampling.links(setting, SEED, 3, 3)
    for t in range(3):
        ours = slice(links.starts[t], links.starts[t + 1])
        pairs = list(zip(links.receivers[ours].tolist(), links.senders[ours].tolist(), strict=True))
        assert pairs == [(i, j) for i, heard in enumerate(heard_in(setting, 3 + t)) for j in heard]
    assert links.starts[-1] == len(links.receivers) == len(links.senders)


# ---- faults
def failed_by(stops_of_trial, part, at):
    return set(np.flatnonzero(stops_of_trial[part] == at).tolist())


def test_each_robot_fails_as_often_as_any_other():
    """Of 100 trials, by chi-square at the 0.1 % level; and afresh for another trial, seed and size of the swarm."""
    faults = (Fault(at=4, robots=3, stop="moving"),)
    picks = [tuple(sorted(failed_by(stops(faults, SEED, trial, 10), 0, 4))) for trial in range(100)]
    assert len(set(picks)) > 50  # of 120
    counts = np.bincount(np.concatenate(picks), minlength=10)
    # without return, within a trial: the variance is 9/10 . 7/9 ... of the multinomial one, (n - k) / (n - 1)
    assert stats.chi2.sf(((counts - 30) ** 2 / 30).sum() / (7 / 10) * (9 / 10), 9) > 1e-3
    assert picks != [tuple(sorted(failed_by(stops(faults, SEED + 1, t, 10), 0, 4))) for t in range(100)]
    of_eleven = [tuple(sorted(failed_by(stops(faults, SEED, t, 11), 0, 4))) for t in range(100)]
    assert np.mean([one == other for one, other in zip(picks, of_eleven, strict=True)]) < 0.2


def test_the_first_of_faults_counts_for_each_part():
    times = ((9, ["sensing", "moving"]), (4, "sensing"), (6, "sensing"))
    every = tuple(Fault(at=at, robots=1.0, stop=stop) for at, stop in times)
    assert stops(every, SEED, 0, 3).tolist() == [[9] * 3, [4] * 3, [1 << 62] * 3]
    assert stops((), SEED, 0, 3).shape == (3, 0)
    assert stops((Fault(at=2, robots=0, stop="talking"),), SEED, 0, 2).tolist() == [[1 << 62] * 2] * 3


@pytest.mark.parametrize(("said", "count"), [(3, 3), (9, 8), (0.5, 4), (1.0, 8), (1, 1), (0.3, 2)])
def test_how_many_of_eight_fail(said, count):
    assert Fault(at=1, robots=said, stop="sensing").count(8) == count


# ---- floors
def test_noise_is_of_trial_and_tile():
    key = address(SEED, "floor")
    tiles = np.array([[[0, 0], [-3, 5]], [[5, -3], [2, 2]]], np.int32)
    for trial in (0, 4):
        expected = [[reference.tile_unit(key, trial, 0, *tile)[0] for tile in row] for row in tiles.tolist()]
        assert (Chance(key, trial).noise(tiles) == np.array(expected)).all()


def test_fields_are_weighted_sums_of_nodes():
    """Those that are kept and those that are not: three nodes each way on either side of the arena's centre are."""
    key, trial, apart = address(SEED, "floor"), 3, 2
    weights = np.random.default_rng(1).normal(size=(apart, 4))
    tiles = np.array([[[x, y] for x in range(-9, 10, 3)] for y in (-8, -1, 0, 5)], np.int32)
    nodes = np.empty((6, 6))
    module = compile_world("scores")
    module.fill_nodes(key, trial, -3, nodes)

    def node(column, row):
        u, v = reference.tile_unit(key, trial, 1, column, row)
        return math.sqrt(-2 * math.log(1 - u)) * math.cos(2 * math.pi * v)

    assert nodes == pytest.approx(np.array([[node(c, r) for c in range(-3, 3)] for r in range(-3, 3)]), rel=1e-12)
    out = np.empty(tiles.shape[:2])
    module.field(tiles, key, trial, -3, nodes, weights, out)
    expected = np.zeros(out.shape)
    for (i, j), a, b in itertools.product(np.ndindex(out.shape), range(4), range(4)):
        x, y = tiles[i, j].tolist()
        weight = weights[y % apart, b] * weights[x % apart, a]
        expected[i, j] += weight * node(x // apart + a - 1, y // apart + b - 1)
    assert out == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_chance_is_of_key_and_trial():
    """And begins again whenever it is asked, in all of its forms."""
    keys = address(SEED, "floor"), address(SEED, "topology")
    chances = [Chance(key, trial) for key in keys for trial in (0, 1, 2**31 - 1)]
    for draw in (lambda c: c.uniform(3), lambda c: c.generator().random(3), lambda c: c.generator().permutation(20)):
        assert len({tuple(draw(chance)) for chance in chances}) == len(chances)
        assert (draw(chances[0]) == draw(Chance(keys[0], 0))).all()
