"""The finite floor: by hand, by listing all floors, by brute force, and against SciPy's bivariate normal."""

import itertools

import numpy as np
import pytest

from swarmcensus import theory

B, W = 0.9, 0.7
K = B + W - 1


def exactly(visits, floors, truth):
    """The mean of (estimate - truth)^2 over equally likely floors, and over all readings: none is drawn."""
    total, readings = 0.0, sum(visits)
    for colours in floors:
        shown = np.repeat(colours, visits)
        told = np.where(shown, B, 1 - W)  # the chance of black
        mean, variance = (told.mean() - 1 + W) / K, (told * (1 - told)).sum() / readings**2 / K**2
        target = np.mean(colours) if truth == "floor" else truth
        total += variance + (mean - target) ** 2
    return total / len(floors)


def test_floors_with_so_many_black_tiles():
    """All floors of 6 tiles with 2 black ones."""
    visits, floors = [3, 1, 0, 2, 0, 1], []
    for black in itertools.combinations(range(6), 2):
        floors.append([m in black for m in range(6)])
    c = theory.concentration(visits)
    assert c == pytest.approx((9 + 1 + 4 + 1) / 49)
    found = theory.floor_variance(7, c, 6, 2 / 6, B, W, drawn="exactly")
    assert found == pytest.approx(exactly(visits, floors, "floor"), rel=1e-12)
    assert found == pytest.approx(exactly(visits, floors, 2 / 6), rel=1e-12)


def test_floors_of_tiles_drawn_one_by_one():
    """All floors of 5 tiles, each as likely: f = 1/2."""
    visits, floors = [3, 1, 0, 2, 1], list(itertools.product([False, True], repeat=5))
    c = theory.concentration(visits)
    for truth, target in (("floor", "floor"), ("nominal", 0.5)):
        found = theory.floor_variance(7, c, 5, 0.5, B, W, truth=truth)
        assert found == pytest.approx(exactly(visits, floors, target), rel=1e-12)


def test_each_reading_on_a_tile_of_its_own_is_the_robots_bound():
    found = theory.floor_variance(50, 1 / 50, 10**9, 0.3, B, W)
    assert found == pytest.approx(float(theory.robot_bound(50, 0.3, B, W)), rel=1e-6)
    assert theory.tiles_variance(1 / 40, 0.3, 40, truth="floor") == 0.0
    assert theory.tiles_variance(1.0, 0.3, 1, drawn="exactly") == 0.0


def test_readings_that_fall_anywhere():
    """The concentration of 30 readings on 12 tiles, 20,000 times: within 5 sd."""
    rng = np.random.default_rng(2)
    found = [theory.concentration(np.bincount(rng.integers(12, size=30), minlength=12)) for _ in range(20_000)]
    assert np.mean(found) == pytest.approx(float(theory.even_concentration(30, 12)), abs=5 * np.std(found) / 141)
