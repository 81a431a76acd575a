"""Calibration: intervals cover, both tests keep their level, and the added error is that of simulated swarms.

A bound of five standard errors is missed by a correct program in less than one of a million seeds.
"""

import itertools
import math

import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus import theory
from swarmcensus.robots import calibrating
from swarmcensus.robots.calibrating import Side, chi_squared_p, difference, drawn
from swarmcensus.robots.strips import LEVEL, Part, dependence, dependences
from tests.support.small import study_of


def covered(b, right, readings, effective):
    ends = [Side(int(k), readings, effective).interval for k in right]
    return np.mean([low <= p <= high for p, (_, low, high) in zip(b, ends, strict=True)])


def test_intervals_cover():
    chance = np.random.default_rng(1)
    b = chance.uniform(0.6, 0.99, 4000)
    share = covered(b, chance.binomial(500, b), 500, 500)
    assert abs(share - 0.95) < 5 * math.sqrt(0.95 * 0.05 / b.size) + 0.002  # Wilson's is no exact interval


def chains(chance, p, correlation, readings):
    """Readings (robot, reading), of which a share p says black: each is the one before with this probability."""
    fresh = chance.random((len(p), readings)) >= correlation
    fresh[:, 0] = True
    drawn = chance.random((len(p), readings)) < p[:, np.newaxis]
    last = np.maximum.accumulate(np.where(fresh, np.arange(readings), 0), axis=1)
    return np.take_along_axis(drawn, last, axis=1)


def parts_of(seen):
    changes = np.count_nonzero(np.diff(seen.astype(np.int8), axis=1), axis=1)
    pairs = enumerate(zip(seen, changes, strict=True))
    return [Part(k, "black", row.size, int(row.sum()), int(c)) for k, (row, c) in pairs]


@pytest.mark.parametrize("correlation", [0.3, 0.7])
def test_dependent_readings_count_as_fewer(correlation):
    """Without their effective number, intervals would cover far less."""
    chance = np.random.default_rng(2)
    b = chance.uniform(0.7, 0.95, 1500)
    seen = chains(chance, b, correlation, 1000)
    p, found = dependence(parts_of(seen))
    assert p < LEVEL
    assert found == pytest.approx(correlation, abs=0.02)
    scale = (1 - found) / (1 + found)
    right = seen.sum(axis=1)
    assert abs(covered(b, right, 1000, 1000 * scale) - 0.95) < 5 * math.sqrt(0.95 * 0.05 / b.size)
    assert covered(b, right, 1000, 1000) < 0.88


@pytest.mark.long(but_every=3)
@pytest.mark.parametrize(("robots", "readings", "spread"), [
    (20, 1000, 0.005), (10, 1000, 0.01), (5, 1000, 0.01), (20, 200, 0.02), (20, 1000, 0.0),
])  # fmt: skip
def test_intervals_of_drawn_shares_cover_each_robots_own(robots, readings, spread):
    """Over robots of 1,500 calibrations; the standard error over calibrations is 0.3 %."""
    chance, found = np.random.default_rng(8), []
    for _ in range(1500):
        b = chance.normal(0.9, spread, robots)
        right = chance.binomial(readings, b)
        ends = np.array([side.interval for side in drawn([Side(int(k), readings, readings) for k in right])])
        found.append(np.mean((ends[:, 1] <= b) & (b <= ends[:, 2])))
    assert np.mean(found) > 0.93
    assert np.std(found) / math.sqrt(1500) < 0.0032


@pytest.mark.long(only=["0.999"])
@pytest.mark.parametrize("b", [0.85, 0.999])
def test_both_tests_keep_their_level(b):
    """Of 1,500 calibrations of ten equal robots with independent readings."""
    chance, wrong = np.random.default_rng(3), np.zeros(3)
    for _ in range(1500):
        seen = chains(chance, np.full(10, b), 0.0, 300)
        sides = [Side(int(k), 300, 300) for k in seen.sum(axis=1)]
        parts = parts_of(seen)
        wrong += dependence(parts)[0] < LEVEL, chi_squared_p(*difference(sides)) < LEVEL, bool(dependences(parts).alone)
    assert (wrong / 1500 < LEVEL + 4 * math.sqrt(LEVEL / 1500)).all()  # 4 standard errors: 3 in 100,000 seeds
    assert b > 0.9 or (wrong > 1).all()


def test_a_robot_that_stands_still_counts_alone():
    """It hides no longer, and robots are not said to differ: of 300 calibrations in fewer than 5 %."""
    chance, found, differ = np.random.default_rng(9), [], 0
    for _ in range(300):
        seen = chains(chance, np.full(10, 0.85), 0.0, 500)
        seen[3] = chains(chance, np.array([0.85]), 0.9, 500)[0]
        parts = parts_of(seen)
        found.append(dependences(parts))
        scales = [found[-1].alone.get(part.robot, found[-1].share) for part in parts]
        sides = [Side(part.black, 500, 500 * scale) for part, scale in zip(parts, scales, strict=True)]
        differ += chi_squared_p(*difference(sides)) < LEVEL
    assert np.mean([3 in one.alone for one in found]) > 0.99
    assert np.mean([one.share == 1.0 for one in found]) > 0.95
    assert differ < 15


def test_the_exact_test_is_that_of_all_orders():
    orders = [np.array(one) for one in set(itertools.permutations([1] * 3 + [0] * 4))]
    changes = np.array([np.count_nonzero(np.diff(one)) for one in orders])
    for seen in range(1, 7):
        assert dependence([Part(1, "black", 7, 3, seen)])[0] == pytest.approx((changes <= seen).mean())


def test_p_values_are_those_of_chi_squared():
    for freedom in (3, 10, 38, 198):
        for quantile in (0.5, 0.9, 0.99, 0.999):
            statistic = stats.chi2.ppf(quantile, freedom)
            assert chi_squared_p(statistic, freedom) == pytest.approx(1 - quantile, rel=0.2)


@pytest.mark.parametrize("right", [100, 180, 200])
@pytest.mark.parametrize("width", [0.02, 0.1])
def test_so_many_readings_more_make_an_interval_as_narrow(right, width):
    more = Side(right, 200, 200).more(width)
    for extra, is_narrow in ((more, True), (max(0, more - 3), more == 0)):
        n = 200 + extra
        _, low, high = calibrating.share_interval(right * n / 200, n)
        assert (high - low <= width) == is_narrow


@pytest.mark.long(only=["0.9"])
@pytest.mark.parametrize("f", [0.2, 0.9])
def test_the_added_error_is_that_of_simulated_swarms(f):
    """Sensors are drawn about what robots assume; the rest of the error is that of robots who know theirs.

    Of squared errors over 600 trials, a sixth is five standard errors.
    """
    known = [(0.9, 0.03, 0.8, 0.02), (0.8, 0.02, 0.9, 0.03), (0.7, 0.03, 0.75, 0.03)]
    b, eb, w, ew = np.array(known).T

    def table(scale):
        pairs = zip(("black", "white"), ((b, eb), (w, ew)), strict=True)
        return {c: f"M({','.join(f'{x},{scale * e}' for x, e in zip(*pair, strict=True))})" for c, pair in pairs}

    world = {"topology": "full", "fill_ratio": f, "assumed_accuracy": table(0.0)}
    study = study_of("commons", 3, [table(1.0), table(0.0)], rounds=100, looks=1000, trials=600, seed=4, **world)
    results = sc.run(study)
    wrong, right = ((results["final_estimate"][k] - f) ** 2 for k in (0, 1))
    added = math.sqrt(float(wrong.mean() - right.mean()))
    weights = theory.information(f, b, w)
    each = theory.calibration_error(f, b, w, eb, ew)
    expected = float(np.hypot.reduce(weights * each) / weights.sum())
    assert added == pytest.approx(expected, rel=0.09)
    shown = sc.explain(results).frame["calibration"]
    assert shown[0] == pytest.approx(expected, rel=0.09)
    assert shown[1] < 1e-12
