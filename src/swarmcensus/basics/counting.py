"""Counts as people read them: "1 setting", "1,000 settings"."""

from numbers import Integral
from typing import Any


def counted(count: int, what: str) -> str:
    """So many of what is called so: in the plural unless it is one, with commas between thousands."""
    return f"{count:,} {what}" if count == 1 else f"{count:,} {what}s"


def grouped(value: Any) -> str:
    """A value as text: a whole number with commas between thousands."""
    return f"{value:,}" if isinstance(value, Integral) else str(value)
