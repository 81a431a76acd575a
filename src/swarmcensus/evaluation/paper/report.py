"""Measured claims as JSON, and as a table for the terminal."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import xarray as xr

from swarmcensus.evaluation.paper.evidence import FAILS, HOLDS, NO, OPEN, UNMEASURED, YES, Detail, Outcome
from swarmcensus.support import intervals
from swarmcensus.support.formatting import decimals_for, rounded
from swarmcensus.support.version import __version__

if TYPE_CHECKING:
    from rich.console import Console

WORDS = {HOLDS: "holds", FAILS: "does not hold", OPEN: "not decided", UNMEASURED: "not measured"}
SIGNS = {HOLDS: "✓", FAILS: "✗", OPEN: "?", UNMEASURED: "–"}
COLOURS = {HOLDS: "bold blue", FAILS: "bold red", OPEN: "bold yellow", UNMEASURED: "dim"}


def measured(detail: Detail) -> tuple[str, str]:
    """A value and its interval as text, to two digits of the interval's width: "0.0413", "[0.0391, 0.0429]"."""
    if detail.interval is None:
        return f"{detail.value:.3g}", ""
    low, high = detail.interval
    return rounded(detail.value, low, high, decimals_for(high - low))


def kind(outcome: Outcome) -> str:
    """The verdict without the number of trials: a key of WORDS, SIGNS and COLOURS."""
    if outcome.holds is None:
        return UNMEASURED if outcome.verdict == UNMEASURED else OPEN
    return HOLDS if outcome.holds else FAILS


def tally(outcome: Outcome) -> str:
    """The number of settings by verdict, such as "30 yes, 3 undecided"."""
    return ", ".join(f"{outcome.count(verdict)} {verdict}" for verdict in (YES, NO, OPEN) if outcome.count(verdict))


def as_json(claims: Sequence[Outcome], datasets: Mapping[str, xr.Dataset], source: str) -> str:
    """The text of claims.json: each claim with its statistic, threshold, value, interval, verdict and settings.

    `source` is what was published. `right` is the range in which a claim holds, null for no bound; `interval` is null
    if the value is exact. Value and interval of a claim are those of its worst setting. Equal datasets give equal
    bytes.
    """
    texts = ("id", "title", "sentence", "section", "statistic", "threshold")
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
        "claims": [
            {
                **{key: getattr(outcome.claim, key) for key in texts},
                "right": _numbers(outcome.claim.right),
                "verdict": outcome.verdict,
                **_values(outcome.worst),
                "note": outcome.note,
                "explanation": outcome.explanation,
                "settings": [{**_values(detail), "verdict": detail.verdict} for detail in outcome.details],
            }
            for outcome in claims
        ],
    }
    return json.dumps(about, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


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
    table.add_column("worst setting [95 %]", no_wrap=True)
    for outcome in claims:
        verdict = WORDS[kind(outcome)]
        if not console.options.ascii_only:
            verdict = f"{SIGNS[kind(outcome)]} {verdict}"
        value = Text()
        if outcome.worst:
            value.append(" ".join(measured(outcome.worst)).strip())
            value.append(f"\nneeded: {outcome.claim.threshold}", "dim")
            if outcome.holds is not True:
                value.append(f"\n{tally(outcome)}")
        table.add_row(Text(verdict, COLOURS[kind(outcome)]), outcome.claim.title, value)
    console.print(table)
