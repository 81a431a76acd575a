"""How long the shipped brains live in single precision, as `python benchmarks/brains.py lives` found."""

import json
from pathlib import Path

TABLE = Path(__file__).with_suffix(".json")


def single_lives() -> dict[str, int | None]:
    """By brain, the reading at which single precision leaves double precision; None if none of those tried, to 2^26."""
    return json.loads(TABLE.read_text(encoding="utf-8"))  # type: ignore[no-any-return]
