"""Compares ways to live: they lead to the same state but for rounding, or with luck, to the same distribution."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.checks.sample_states import CLOSE, SEED, Draws, difference, number_at, numbers_in

DRAWS = 400  # from each of two distributions
FALSE_ALARM = 1e-9  # probability of a wrong fault in one comparison; a check makes thousands

Way = Callable[[Draws], Any]  # to a state, with these random numbers
Law = dict[str, np.ndarray]  # each number of a state, in many states that differ only in their random numbers


def odd_one(
    brain: Brain, function: str, ways: Sequence[Way], close: float = CLOSE, absolute: float = 0.0
) -> tuple[int, str, str, str] | None:
    """Which way leads elsewhere than the first, in which number, and both values in words; None if none does.

    The ways differ in calls of one `function` of the brain.
    """
    if function in brain.uses.random:
        laws = [_law(brain, way) for way in ways]
        for k, law in enumerate(laws):
            if name := _first_difference(laws[0], law):
                return k, name, _law_text(laws[0][name]), _law_text(law[name])
        return None
    states = [way(None) for way in ways]
    for k, state in enumerate(states):
        if name := difference(brain, states[0], state, close, absolute):
            return k, name, *(repr(number_at(one, name)) for one in (states[0], state))  # type: ignore[return-value]
    return None


def _law(brain: Brain, way: Way) -> Law:
    draws = np.random.default_rng(SEED)
    states = [dict(numbers_in(brain, way(draws))) for _ in range(DRAWS)]
    return {name: np.array([state[name] for state in states], np.float64) for name in states[0]}


def _first_difference(first: Law, second: Law) -> str | None:
    """The first number with two distributions that differ, by the asymptotic Smirnov test of two samples, or None."""
    beyond = math.sqrt(-math.log(FALSE_ALARM / 2.0) / DRAWS)
    for name, law in first.items():
        values = np.sort(np.concatenate([law, second[name]]))
        values = values + 1e-9 * np.maximum(1.0, abs(values))  # numbers that differ by rounding count as equal
        shares = [np.searchsorted(np.sort(each), values, side="right") / DRAWS for each in (law, second[name])]
        if np.abs(shares[0] - shares[1]).max() > beyond:
            return name
    return None


def _law_text(law: np.ndarray) -> str:
    return f"a number of mean {law.mean():.3g} and standard deviation {law.std():.3g}"
