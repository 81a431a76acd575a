"""Theory's starts of a plan: against brute force, exact laws and the limits that they must keep."""

import math

import numpy as np
import pytest

from swarmcensus import theory
from swarmcensus.search.planning.mission import missions_of
from swarmcensus.search.planning.predictions import (
    least_deviation,
    meeting_factors,
    meeting_rate,
    predict,
    readings_needed,
    tiles_of,
    variance,
    worst_fill_ratios,
)
from swarmcensus.studies.assignments import with_values
from swarmcensus.worlds.bodies import Body


def mission(**values):
    given = {"side": 3, "accuracy": 0.7, "robots": 10}
    given |= {} if "right" in values else {"error": 0.05}
    [found] = missions_of(with_values({}, given | values))
    return found


def on_network(topology, **values):
    given = {"accuracy": 0.7, "robots": 20, "topology": topology, "observations_per_round": 4}
    given |= {} if "right" in values else {"error": 0.05}
    [found] = missions_of(with_values({}, given | values))
    return found


def test_factor_of_random_pairwise_means():
    """The squares of weights of a tick's readings, of 40 swarms, whose mean is known to 2 %."""
    robots, rate, ticks, swarms = 20, 0.05, 300, 40
    rng, squares = np.random.default_rng(1), 0.0
    for _ in range(swarms):
        weights = np.eye(robots)
        for _ in range(ticks):
            squares += (weights**2).sum() / robots / swarms
            for _ in range(rng.poisson(robots * rate / 2)):
                pair = rng.choice(robots, 2, replace=False)
                weights[pair] = weights[pair].mean(axis=0)
    assert squares / ticks**2 == pytest.approx(meeting_factors(robots, rate, ticks), rel=0.06)


def test_the_rate_of_meetings_is_that_of_a_gas_of_discs():
    body = Body(turn_most=0, straight_mean=1e9)  # straight on for ever
    by_hand = 2 * 0.7 * (29 / 100) * 4 / math.pi * 0.14 * 0.1
    assert meeting_rate(30, 10.0, body) == pytest.approx(by_hand)
    assert meeting_rate(1, 10.0, body) == 0.0


@pytest.mark.parametrize(("f", "b", "w"), [(0.5, 0.7, 0.7), (0.3, 0.9, 0.6)])
def test_readings_needed_hold_in_the_exact_law(f, b, w):
    """Of a robot alone on a floor without end: the exact law has steps, which 0.5 points allow for."""
    found = on_network("ring", accuracy={"black": b, "white": w}, fill_ratio=f)
    needed = readings_needed(found, f)
    by_hand = (b + w - 1) * f + 1 - w
    by_hand = by_hand * (1 - by_hand) / (b + w - 1) ** 2 * (1.959964 / 0.05) ** 2
    assert needed == pytest.approx(by_hand, rel=1e-4)
    law = theory.error_law(theory.local_law(math.ceil(needed), f, b, w), f)
    assert law.at_most(0.05) == pytest.approx(0.95, abs=0.005)


def test_the_worst_fill_ratio_is_found_by_brute_force():
    found = on_network("ring", accuracy={"black": 0.9, "white": 0.6}, fill_ratio={"worst": [0.2, 0.8]})
    every = np.linspace(0.2, 0.8, 601)
    needs = [readings_needed(found, float(f)) for f in every]
    first, *others = worst_fill_ratios(found)
    assert readings_needed(found, first) >= 0.9999 * max(needs)
    assert set(others) <= {0.2, 0.8}
    bins = on_network("ring", right=10, margin=0.03)
    edge = np.abs(worst_fill_ratios(bins)[0] * 10 - np.round(worst_fill_ratios(bins)[0] * 10)) / 10
    assert edge == pytest.approx(0.03)


def test_mixing_on_a_network_is_that_of_theory():
    found = on_network("ring")
    needed = readings_needed(found, 0.5)
    start = predict(found, 20, needed)
    matrix = theory.mixing_matrix("ring", 20)
    rounds = np.arange(1, 400)
    enough = 4 / theory.variance_factors(matrix, rounds)[:, 0] >= needed
    first = int(rounds[enough.argmax()])
    assert first <= start.mixed <= 1.1 * first + 1
    assert start.alone == pytest.approx(needed / 4)
    assert start.pooled == pytest.approx(needed / 4 / 20)
    everyone = predict(on_network("full"), 20, needed)
    assert everyone.mixed == pytest.approx(everyone.pooled, rel=0.1)


def test_robots_that_fail_make_a_smaller_swarm():
    fault = {"at": 1, "robots": 0.5, "stop": "sensing"}
    whole, half = (predict(mission(faults=faults), 10, 1000.0) for faults in ([], [fault]))
    assert half.pooled == pytest.approx(2 * whole.pooled)
    assert half.mixed > whole.mixed


def test_floor_limit_applies_to_the_nominal_fill_ratio():
    nominal = mission(truth="nominal", side=1)
    assert least_deviation(nominal, 0.5) == pytest.approx(math.sqrt(0.25 / round(tiles_of(nominal))), rel=1e-6)
    assert least_deviation(mission(side=1), 0.5) < 1e-6
    assert variance(nominal, 0.5, 100.0) > variance(mission(side=1), 0.5, 100.0)
    unequal = on_network("ring", accuracy="U(0.6,0.9)")
    told = np.mean(theory.information(0.5, np.linspace(0.6, 0.9, 2001)))
    assert variance(unequal, 0.5, 10.0) == pytest.approx(1 / told / 10, rel=0.05)


@pytest.mark.parametrize("topology", ["ring", "full", "moving"])
def test_mixing_without_messages(topology):
    found = mission(link_success=0.0) if topology == "moving" else on_network(topology, link_success=0.0)
    start = predict(found, 10, 1000.0)
    assert start.mixed == start.alone > start.pooled
    heard = mission() if topology == "moving" else on_network(topology)
    assert predict(heard, 10, 1000.0).mixed < start.alone
