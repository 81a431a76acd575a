"""Counts as people read them: "1 setting", "1,000 settings"."""

import math
import re
from collections.abc import Iterable
from numbers import Integral
from typing import Any

EXACT = 17  # digits that tell any two numbers apart
DECIMAL = re.compile(r"\d*\.\d+(?:e[-+]?\d+)?")


def distinct_texts(values: Iterable[float | str], digits: int = 4) -> list[str]:
    """Numbers, or texts with numbers in them, in so many significant digits, or as few more as tell them apart.

    In texts only decimals are touched, and only to become shorter: "U(0.5499999999999999,0.95)" is "U(0.55,0.95)".
    """
    exact = list(values)
    for kept in range(digits, EXACT + 1):
        short = [_rounded(value, kept) for value in exact]
        if len(set(short)) == len(set(exact)):
            break
    return short


def _rounded(value: float | str, digits: int) -> str:
    if not isinstance(value, str):
        return f"{value:.{digits}g}"
    return DECIMAL.sub(lambda found: min(found[0], f"{float(found[0]):.{digits}g}", key=len), value)


def decimals_for(width: float, digits: int = 2) -> int:
    """How many decimals show so many digits of an interval's width."""
    return min(max(digits - 1 - math.floor(math.log10(width)), 0), 9) if 0 < width < math.inf else 3


def rounded(value: float, low: float, high: float, decimals: int) -> tuple[str, str]:
    """A number and its interval as text."""
    return f"{value:,.{decimals}f}", f"[{low:,.{decimals}f}, {high:,.{decimals}f}]"


def counted(count: int, what: str) -> str:
    """So many of what is called so: in the plural unless it is one, with commas between thousands."""
    return f"{count:,} {what}" if count == 1 else f"{count:,} {what}s"


def grouped(value: Any) -> str:
    """A value as text: a whole number with commas between thousands."""
    return f"{value:,}" if isinstance(value, Integral) else str(value)
