"""Measured claims as JSON, and as a table for the terminal."""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import xarray as xr

from swarmcensus.evaluation.paper.evidence import (
    FAILS,
    HOLDS,
    MARGIN,
    MUCH,
    NEITHER,
    NO,
    PARTLY,
    UNDECIDED,
    UNMEASURED,
    VERDICTS,
    YES,
    Detail,
    Outcome,
)
from swarmcensus.support import intervals
from swarmcensus.support.formatting import counted, decimals_for, rounded
from swarmcensus.support.version import __version__

if TYPE_CHECKING:
    from rich.console import Console

SIGNS = {HOLDS: "✓", PARTLY: "~", FAILS: "✗", UNDECIDED: "?", UNMEASURED: "–", YES: "✓", NO: "✗", NEITHER: "?"}
COLOURS = {
    HOLDS: "bold blue",
    PARTLY: "bold magenta",
    FAILS: "bold red",
    UNDECIDED: "bold yellow",
    UNMEASURED: "dim",
}
EXAMPLES = 2  # settings against a claim that are printed


def measured(detail: Detail) -> tuple[str, str]:
    """A value and its interval as text, to two digits of the interval's width: "0.0413", "[0.0391, 0.0429]"."""
    if detail.interval is None or not all(map(math.isfinite, detail.interval)):
        return f"{detail.value:.3g}", ""
    low, high = detail.interval
    return rounded(detail.value, low, high, decimals_for(high - low))


def tally(outcome: Outcome) -> str:
    """The number of settings by what they say, such as "30 yes, 3 neither, 1 left out"."""
    numbers = {said: outcome.count(said) for said in (YES, NO, NEITHER)} | {"left out": len(outcome.left_out)}
    return ", ".join(f"{number} {said}" for said, number in numbers.items() if number)


def as_json(claims: Sequence[Outcome], datasets: Mapping[str, xr.Dataset], source: str) -> str:
    """The text of claims.json: each claim with its statistic, threshold, value, interval, verdict and settings.

    `source` is what was published. Settings in the range `right` speak for a claim, those outside `tolerated` against
    it; null is no bound. `interval` is null if the value is exact. Value and interval of a claim are those of its worst
    setting. Equal datasets give equal bytes.
    """
    texts = ("id", "title", "sentence", "section", "statistic")
    about = {
        "format": "swarmcensus claims 1",
        "paper": source,
        "version": __version__,
        "studies": {
            name: {"seed": int(data.attrs["seed"]), "trials": data.sizes["trial"]} for name, data in datasets.items()
        },
        "bootstrap": {
            "unit": "trial",
            "resamples": intervals.RESAMPLES,
            "level": intervals.LEVEL,
            "seed": intervals.SEED,
        },
        "margins": {"ordering": MARGIN, "much": MUCH},
        "claims": [
            {
                **{key: getattr(outcome.claim, key) for key in texts},
                "threshold": outcome.claim.needed.words,
                "right": _numbers(outcome.claim.needed.right),
                "tolerated": _numbers(outcome.claim.needed.tolerated),
                "verdict": outcome.verdict,
                **_values(outcome.worst),
                "left_out": list(outcome.left_out),
                "note": outcome.note,
                "explanation": outcome.explanation,
                "settings": [
                    {**_values(detail), "verdict": detail.verdict, "made_of": detail.made_of}
                    for detail in outcome.details
                ],
            }
            for outcome in claims
        ],
    }
    text = json.dumps(about, indent=1, allow_nan=False, ensure_ascii=False)
    return re.sub(r"{[^{}]*}", lambda found: re.sub(r"\n *", " ", found[0]), text) + "\n"  # a setting is one line


def _numbers(values: Sequence[float]) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values]


def _values(detail: Detail | None) -> dict[str, Any]:
    if detail is None:
        return {"setting": None, "value": None, "interval": None}
    interval = None if detail.interval is None else _numbers(detail.interval)
    return {"setting": detail.setting, "value": _numbers([detail.value])[0], "interval": interval}


def show(claims: Sequence[Outcome], console: Console | None = None) -> None:
    """Print the claims as a table, 80 columns wide or more: verdict, claim and worst setting."""
    from rich.table import Table
    from rich.text import Text

    from swarmcensus.support import terminal

    console = console or terminal.console()
    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2, 0, 0))
    table.add_column("verdict", no_wrap=True)
    table.add_column("claim")
    table.add_column("worst setting [95 %], needed", no_wrap=True)
    for outcome in claims:
        verdict = outcome.verdict
        if not console.options.ascii_only:
            verdict = f"{SIGNS[verdict]} {verdict}"
        value = Text()
        if outcome.worst:
            value.append(" ".join(measured(outcome.worst)).strip())
            value.append(f"\n{outcome.claim.needed.words}", "dim")
            if outcome.verdict != HOLDS or outcome.count(NEITHER) or outcome.left_out:
                value.append(f"\n{tally(outcome)}")
        about = Text(outcome.claim.title)
        for detail in [detail for detail in outcome.details if detail.verdict == NO and detail.made_of][:EXAMPLES]:
            about.append(f"\n{detail.setting}: {detail.made_of}", "dim")
        table.add_row(Text(verdict, COLOURS[outcome.verdict]), about, value)
    console.print(table)
    counts = Counter(outcome.verdict for outcome in claims)
    several = {v: v.replace("holds", "hold").replace("does", "do") for v in VERDICTS}
    said = [f"{counts[v]} {v if counts[v] == 1 else several[v]}" for v in VERDICTS[::-1] if counts[v]]
    console.print(f"{counted(len(claims), 'claim')}: {', '.join(said)}")
