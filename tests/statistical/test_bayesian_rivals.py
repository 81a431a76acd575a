"""The Bayesian rivals' chances: false alarms and delays of the detector, soft feedback's lots, what feedback gains.

Each test states its error rate: the chance that a right simulator fails it, were the seed not fixed.
"""

from fractions import Fraction

import numpy as np
import pytest

from swarmcensus import brains
from tests.support.small import SEED

CHANGING = brains.load("changing-floor")
ALARM = 4.05  # between two values that the sums can take: rounding then decides nothing
RUNS = 400


def run_length(mean, f, slack):
    """How many observations of a floor f a CUSUM of both sides takes to its alarm: the chain of its states, solved."""
    up = {1: 1 - mean - slack, 0: -mean - slack}
    down = {1: mean - 1 - slack, 0: mean - slack}
    places, todo, rows = {(Fraction(0), Fraction(0)): 0}, [(Fraction(0), Fraction(0))], []
    while todo:
        state = todo.pop()
        for colour, chance in ((1, f), (0, 1 - f)):
            to = tuple(max(Fraction(0), x + step[colour]) for x, step in zip(state, (up, down), strict=True))
            if max(to) > ALARM:
                continue
            if to not in places:
                places[to] = len(places)
                todo.append(to)
            rows.append((places[state], places[to], float(chance)))
    chain = np.eye(len(places))
    for here, there, chance in rows:
        chain[here, there] -= chance
    return np.linalg.solve(chain, np.ones(len(places)))[0]


def simulated(mean, f, seed=SEED):
    """Run lengths of the brain's detector, whose earlier observations were so many that their mean is known."""
    used = CHANGING.with_parameters({"detect": 1.0, "every": 1.0, "alarm": ALARM})
    random = np.random.default_rng(seed)
    found = []
    for _ in range(RUNS):
        me = used.robot(0.9, 0.9)
        me.size, me.t, me.n = 1.0, 1e15, 1e15 * mean
        length = 1
        me.seen = float(random.random() < f)
        while not used.functions.detects(me):
            me.seen = float(random.random() < f)
            length += 1
        found.append(length)
    return np.array(found)


@pytest.mark.long(but_every=4)
@pytest.mark.long(only=["0.5-0.5"])
@pytest.mark.parametrize(
    ("mean", "f"), [("0.5", "0.5"), ("0.6", "0.6"), ("0.7", "0.3"), ("0.9", "0.1"), ("0.6", "0.4")]
)
def test_false_alarms_and_delays_of_the_detector(mean, f):
    """Mean run lengths within four standard errors of theory: 0.006 % each."""
    exact = run_length(Fraction(mean), Fraction(f), Fraction("0.1"))
    found = simulated(float(mean), float(f))
    error = found.std(ddof=1) / np.sqrt(RUNS)
    assert abs(found.mean() - exact) < 4.0 * error
    if mean == f:  # a detector with another slack is told apart
        assert abs(found.mean() - run_length(Fraction(mean), Fraction(f), Fraction("0.12"))) > 4.0 * error
