"""Numbers as text for people: "1,000 settings", "0.55", "[0.51, 0.59]"."""

import math
import re
from collections.abc import Iterable
from numbers import Integral
from typing import Any

CLOCK = "wall-clock time"
EXACT = 17  # significant digits that distinguish any two numbers
DECIMAL = re.compile(r"(?:(?<!\d)\d+)?\.\d+(?:e[-+]?\d+)?")


def distinct_texts(values: Iterable[float | str], digits: int = 4) -> list[str]:
    """Numbers, or texts with numbers in them, with `digits` significant digits, or more until different values differ.

    In texts, decimals are only ever shortened: "U(0.5499999999999999,0.95)" becomes "U(0.55,0.95)".
    """
    exact = list(values)
    for kept in range(digits, EXACT + 1):
        short = [_shorten(value, kept) for value in exact]
        if len(set(short)) == len(set(exact)):
            break
    return short


def _shorten(value: float | str, digits: int) -> str:
    if not isinstance(value, str):
        return f"{value:.{digits}g}"
    return DECIMAL.sub(lambda number: min(number[0], f"{float(number[0]):.{digits}g}", key=len), value)


def decimals_for(width: float, digits: int = 2) -> int:
    """How many decimals show `digits` significant digits of an interval's width."""
    return min(max(digits - 1 - math.floor(math.log10(width)), 0), 9) if 0 < width < math.inf else 3


def rounded(value: float, low: float, high: float, decimals: int, most: float = math.inf) -> tuple[str, str]:
    """A number and its interval as text; one with the value `most`, which nothing exceeds, has a lower end only."""
    text, first, last = (fixed(one, decimals) for one in (value, low, high))
    return text, f"[>= {first}]" if value >= most < math.inf else f"[{first}, {last}]"


def fixed(value: float, decimals: int = 0) -> str:
    """A number with so many decimals; without any, a half stays one, as of a median of whole numbers: 142.5."""
    half = math.isfinite(value) and value % 1 == 0.5  # :.0f would make 142.5 and 141.5 the same
    return f"{value:,.{max(decimals, int(half))}f}"


ONE_SIDED = "the same in all trials, so a lower end only (95 %), which counts trials and not robots"


def counted(count: int, noun: str) -> str:
    """A count with its noun: "1 setting", "1,000 settings"."""
    return f"{count:,} {noun}" if count == 1 else f"{count:,} {noun}s"


def elapsed(seconds: float) -> str:
    """How long something took, by the clock on the wall, which is what all times are that commands print."""
    return f"{seconds:.1f} s of {CLOCK}"


def short_repr(value: Any) -> str:
    """A value as Python writes it, in a line of 60 characters at most."""
    return shortened(" ".join(repr(value).split()))


def shortened(text: str) -> str:
    """A text of 60 characters at most, the last of which is … where some are left out."""
    return text if len(text) <= 60 else f"{text[:59]}…"


def grouped(value: Any) -> str:
    """A value as text; whole numbers have commas between thousands."""
    return f"{value:,}" if isinstance(value, Integral) else str(value)
