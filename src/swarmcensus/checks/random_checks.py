"""Checks of brains with random numbers (luck): states need not be equal, but their distributions."""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import chain, cycle, islice, product
from typing import Any

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.checks.sample_states import (
    SEED,
    Draws,
    Violation,
    call,
    calls,
    copy_of,
    hear,
    line_of,
    long_lives,
    messages,
    numbers_in,
    sample,
    short_lives,
)

DRAWS = 400  # from each of two distributions
FALSE_ALARM = 1e-9  # probability of a wrong fault in one comparison; a check makes thousands
SIZES = (2, 3, 9, 17, 40, 120)  # messages that come together
LOOKS = (10, 20, 200, 2000)  # readings of one colour, in each of these ways:
PARTS = {"one by one": (1,), "in two parts": (7, 10**9), "in parts of 1 to 400": (1, 2, 7, 40, 400)}
ONE_BY_ONE = 20
STATES = 24  # states that are examined, out of all histories
Numbers = dict[str, np.ndarray]


def any_order(brain: Brain) -> None:
    """The same messages in two orders, then `fuse`: each number has the same distribution. Raises Violation."""
    random = np.random.default_rng(SEED)
    spoken = [message for _, message in messages(brain, extreme=False)]
    if not spoken:
        return
    young, old = islice(short_lives(brain), 0, 50 * STATES // 2, 50), islice(long_lives(brain), 0, 3 * STATES // 2, 3)
    for k, (where, me) in enumerate(chain(young, old)):
        heard = sample(random, spoken, SIZES[k % len(SIZES)])
        laws = [_law(brain, partial(_after_messages, brain, where, me, order)) for order in (heard, heard[::-1])]
        name = _first_difference(*laws)
        if name:
            raise Violation(
                f"{line_of(brain, 'receive')}, with fuse after it, gives me.{name} another distribution, "
                f"{_law_text(laws[0][name])}, from the messages {heard} than from the same in reverse order, "
                f"{_law_text(laws[1][name])}: the order of messages should not matter ({where})"
            )


def readings_add_up(brain: Brain, starts: Iterable[tuple[str, Any, tuple[tuple[int, int], ...]]]) -> None:
    """Readings of one colour at once and in parts: each number has the same distribution. Raises Violation."""
    for where, start, _ in islice(starts, 0, 8 * STATES, 8):
        for black, looks in product((1.0, 0.0), LOOKS):
            once = _law(brain, partial(after_readings, brain, where, start, [(looks * black, looks)]))
            for how, sizes in PARTS.items():
                way = [(size * black, float(size)) for size in split(looks, sizes)]
                if len(way) > max(ONE_BY_ONE, looks // 20):
                    continue
                laws = [once, _law(brain, partial(after_readings, brain, where, start, way))]
                field = _first_difference(*laws)
                if not field:
                    continue
                raise Violation(
                    f"{line_of(brain, 'observe')} gives me.{field} another distribution, {_law_text(laws[0][field])}, "
                    f"from {looks} readings at once than from the same {how}, {_law_text(laws[1][field])} ({where})"
                )


def split(looks: int, sizes: tuple[int, ...]) -> list[int]:
    """Parts with these sizes in turn."""
    parts: list[int] = []
    for size in cycle(sizes):
        if not looks:
            break
        parts.append(min(size, looks))
        looks -= parts[-1]
    return parts


def _after_messages(brain: Brain, where: str, me: Any, order: list[Any], draws: np.random.Generator) -> Any:
    state = copy_of(brain, me)
    hear(brain, where, state, order, draws)
    call(brain, where, "fuse", state, draws=draws)
    return state


def after_readings(brain: Brain, where: str, me: Any, way: Sequence[tuple[float, float]], draws: Draws = None) -> Any:
    """A copy of a state after readings: how many of each part are black, and how many there are."""
    state = copy_of(brain, me)
    calls(brain, where, "observe", state, [(float(blacks), float(looks)) for blacks, looks in way], draws)
    return state


def _law(brain: Brain, lived: Callable[[np.random.Generator], Any]) -> Numbers:
    """Each number in memory, in many states that differ only in their random numbers."""
    draws = np.random.default_rng(SEED)
    states = [dict(numbers_in(brain, lived(draws))) for _ in range(DRAWS)]
    return {name: np.array([state[name] for state in states], np.float64) for name in states[0]}


def _first_difference(first: Numbers, second: Numbers) -> str | None:
    """The first number whose two distributions differ, by the asymptotic Smirnov test of two samples; else None."""
    beyond = math.sqrt(-math.log(FALSE_ALARM / 2.0) / DRAWS)
    for name, law in first.items():
        values = np.sort(np.concatenate([law, second[name]]))
        values = values + 1e-9 * np.maximum(1.0, abs(values))  # numbers that differ by rounding count as equal
        shares = [np.searchsorted(np.sort(each), values, side="right") / DRAWS for each in (law, second[name])]
        if np.abs(shares[0] - shares[1]).max() > beyond:
            return name
    return None


def _law_text(law: np.ndarray) -> str:
    return f"of mean {law.mean():.3g} and standard deviation {law.std():.3g}"
