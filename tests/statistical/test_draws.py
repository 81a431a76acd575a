"""me.luck as a law: uniform, and independent of all else that chance gives.

Each test states its error rate: the chance that a right simulator fails it, were the seed not fixed.
"""

from itertools import combinations

import numpy as np
import pytest
from scipy import stats

from swarmcensus.engine.constants import DRAW_ALONE, DRAW_ALONE_FUSE, DRAW_FUSE, DRAW_OBSERVE, DRAW_STEER
from swarmcensus.simulation.reference import own_draws
from swarmcensus.studies import addresses
from tests.support.second import OURS, RANDOM, brain, changed, fixed, moving
from tests.support.small import SEED
from tests.support.trials import record_ride, record_trial

ROUNDS, ROBOTS = 1000, 6
P = 1e-4  # of each comparison


def uniform(values):
    """Kolmogorov and Smirnov's p."""
    return stats.kstest(np.ravel(values), "uniform").pvalue


def together(one, other, cells=8):
    """The p of a chi-square test that pairs of uniform numbers fill a grid of cells x cells evenly."""
    found, *_ = np.histogram2d(np.ravel(one), np.ravel(other), bins=cells, range=[[0, 1], [0, 1]])
    return stats.chisquare(found.ravel()).pvalue


def apart(values, which):
    """The p of a test that numbers have one distribution, whatever else happens: `which` of a few things."""
    values, which = np.ravel(values), np.ravel(which)
    parts = [values[which == one] for one in np.unique(which)]
    table = [np.histogram(part, bins=10, range=(0, 1))[0] for part in parts if len(part) > 200]
    assert len(table) > 1
    return stats.chi2_contingency(np.array(table)).pvalue


@pytest.fixture(scope="module")
def trials():
    """Two robots a link: on a line of six whose ends hear one message a round; the first rounds of two trials."""
    pairs = {"name": "pairs", "edges": [[0, 1], [2, 3], [4, 5]]}
    (setting,) = fixed(brain(RANDOM), robots=ROBOTS, rounds=ROUNDS, topology=pairs)
    found = [record_trial(setting, SEED, trial) for trial in (0, 1)]
    return [({name: fields[name][1:] for name in OURS}, blacks[1:]) for fields, _, blacks in found]


@pytest.mark.parametrize("name", OURS)
def test_a_calls_numbers_are_uniform_and_independent(trials, name):
    """Of the bits after the first twenty, which adversaries see, other calls, rounds, robots, trials and readings.

    These are 15 comparisons, 0.15 %; correlations of rounds are within 4 standard errors, 0.02 %.
    """
    (fields, blacks), (second, _) = trials
    values, other = fields[name], fields[OURS[OURS.index(name) - 1]]
    beside = [(values[:, i], values[:, j]) for i, j in combinations(range(ROBOTS), 2)]
    assert 0.0 < values.min() < values.max() < 1.0
    found = {
        "all bits": uniform(values), "the other bits": uniform(values * 2.0**20 % 1.0),
        "another call": together(values, other), "another trial": together(values, second[name]),
        "other robots": together(*map(np.concatenate, zip(*beside[::5], strict=True))),
        "the next robot in another call": together(values[:, 0::2], other[:, 1::2]),
        "own readings": apart(values, blacks),
        "a neighbour's readings": apart(values, blacks[:, [1, 0, 3, 2, 5, 4]]),
        "readings before": apart(values[1:], blacks[:-1]), "readings after": apart(values[:-1], blacks[1:]),
    }  # fmt: skip
    for lag in (1, 2, 7):
        found[f"{lag} rounds before"] = together(values[:-lag], values[lag:])
        found[f"another call {lag} rounds before"] = together(other[:-lag], values[lag:])
        assert abs(np.corrcoef(values[:-lag].ravel(), values[lag:].ravel())[0, 1]) < 4 / np.sqrt(values[lag:].size)
    assert {what: p for what, p in found.items() if p <= P} == {}


def test_all_purposes_are_independent():
    """Observing, fusing, steering and the two of a robot alone, and robots side by side: 21 grids, 0.21 %."""
    (setting,) = fixed(brain(RANDOM))
    keys = addresses.draw_keys(setting, SEED)
    purposes = (DRAW_OBSERVE, DRAW_FUSE, DRAW_STEER, DRAW_ALONE, DRAW_ALONE_FUSE)
    words = {p: np.array([own_draws(keys, 0, tick, p, 8) for tick in range(1, 1001)]) for p in purposes}
    values = {p: (found >> np.uint64(12)) / 2.0**52 for p, found in words.items()}
    for p in purposes:
        assert uniform(values[p]) > P
        assert together(values[p][:, :-1], values[p][:, 1:]) > P
    for one, other in combinations(purposes, 2):
        assert together(values[one], values[other]) > P
    keyed = np.array([own_draws(addresses.draw_keys(setting, SEED + 1), 0, t, DRAW_FUSE, 8) for t in range(1, 1001)])
    assert together(values[DRAW_FUSE], (keyed >> np.uint64(12)) / 2.0**52) > P


def test_a_random_choice_is_fair():
    """One of eight neighbours kept by lot, whatever their number and order: chi-square of who, 0.02 %."""
    hears = "message):\n    me.heard += 1.0\n    if me.luck * me.heard < 1.0:\n        me.kept = message[0]"
    kept = changed(
        ("MEMORY = {", 'MEMORY = {"heard": 0.0, "kept": -1.0, "last": -1.0, '),
        ("return (estimate(me),)", "return (me.name,)"), ("message):\n    pass", hears),
        ("def fuse(me):\n    pass", "def fuse(me):\n    me.last = me.kept\n    me.heard = 0.0"),
    )  # fmt: skip
    (setting,) = fixed(brain(kept), robots=9, rounds=2000, topology="full")
    fields, *_ = record_trial(setting, SEED, 0)
    for robot in (0, 5):
        found = np.bincount(fields["last"][1:, robot].astype(int), minlength=9)
        assert found[robot] == 0
        assert stats.chisquare(np.delete(found, robot)).pvalue > P


@pytest.mark.long
@pytest.mark.parametrize("topology", ["line", "full"])
def test_losses_are_independent_of_draws(topology):
    """Which messages get through depends on the same addresses, under another key: 0.08 % in all."""
    counts = ("me.heard = me.luck", "me.heard = me.luck\n    me.ears += 1.0")
    ears = changed(counts, ("MEMORY = {", 'MEMORY = {"ears": 0.0, '), source=RANDOM)
    (setting,) = fixed(brain(ears), robots=2, rounds=6000, topology=topology, link_success=0.5)
    fields, *_ = record_trial(setting, SEED, 0)
    heard = np.diff(fields["ears"], axis=0)
    assert set(np.unique(heard)) == {0.0, 1.0}
    for name in ("seen", "fused"):
        assert apart(fields[name][1:], heard) > P
    assert uniform(fields["heard"][1:][heard == 1]) > P
    assert apart(fields["heard"][1:-1][heard[:-1] == 1], heard[1:][heard[:-1] == 1]) > P


@pytest.mark.long
def test_walks_are_independent_of_draws():
    """Whether a robot turns or goes straight, whether it looks, and on which tile it stands: 0.12 % in all."""
    ride = record_ride(moving(brain(RANDOM), robots=12, ticks=1500, density=3), SEED, 0)
    steps = np.linalg.norm(np.diff(ride.poses[..., :2], axis=0), axis=2)
    goes, looked = steps > 0.7 * steps.max(), ride.looked[1:]
    for name, mine in (("fused", np.ones_like(looked)), ("seen", looked)):
        values = ride.fields[name][1:]
        assert uniform(values[mine]) > P
        assert apart(values[mine], goes[mine]) > P
        assert apart(values[mine], ride.colours[1:][mine]) > P
        assert apart(values[looked], ride.readings[1:][looked]) > P
    assert together(ride.fields["fused"][1:][looked], ride.fields["seen"][1:][looked]) > P
    assert apart(ride.fields["fused"][1:], looked) > P
    heard = ride.fields["heard"]
    assert uniform(heard[1:][heard[1:] != heard[:-1]]) > P
