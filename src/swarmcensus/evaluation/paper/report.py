"""What `reproduce` finds out: claims as rows and as a table, and the text of claims.json."""

import json
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from swarmcensus.evaluation.paper.evaluations import PAPER, Evaluation, PaperFigure
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
from swarmcensus.support.answers import Answer
from swarmcensus.support.files import data_path
from swarmcensus.support.formatting import counted, decimals_for, rounded
from swarmcensus.support.printed_tables import Column, Table
from swarmcensus.support.version import __version__

SIGNS = {HOLDS: "✓", PARTLY: "~", FAILS: "✗", UNDECIDED: "?", UNMEASURED: "–", YES: "✓", NO: "✗", NEITHER: "?"}
EXAMPLES = 2  # settings against a claim that are printed


@dataclass(repr=False)
class Reproduction(Answer):
    """What `reproduce` made: datasets by study, figures with their files, claims as measured, seconds by stage.

    Without a folder `out` there are no figures, files and page. `again` is the command line that makes it again.

    Seconds are wall-clock time. Those of "simulate" are of all runs on these datasets together; the other stages are
    done again each time, "compile" only where there is something to run.
    """

    out: Path | None
    again: str
    datasets: Mapping[str, xr.Dataset]
    figures: Sequence[tuple[PaperFigure, Sequence[Path]]]
    claims: Sequence[Outcome]
    seconds: Mapping[str, float]
    of: Evaluation = PAPER

    @property
    def title(self) -> str:  # type: ignore[override]
        """The evaluation."""
        return self.of.title

    @property
    def page(self) -> Path | None:
        """The page to open in a browser."""
        return None if self.out is None else self.out / "index.html"

    @property
    def files(self) -> dict[Path, str]:  # type: ignore[override]
        """The page, which leads to all others."""
        return {self.page: ""} if self.page else {}

    @property
    def others(self) -> list[Path]:
        """All other files that were written."""
        if self.out is None:
            return []
        data, drawn = [data_path(self.out, name) for name in self.datasets], [one for _, k in self.figures for one in k]
        return [*data, *drawn, *[self.out / "claims.json"] * bool(self.claims)]

    @property
    def sentences(self) -> list[str]:  # type: ignore[override]
        """How many claims have which verdict, and how many figures were drawn without claims."""
        if not self.claims:
            return [f"{counted(len(self.figures), 'figure')} drawn"]
        counts = Counter(one.verdict for one in self.claims)
        said = ", ".join(f"{verdict}: {counts[verdict]}" for verdict in VERDICTS[::-1] if counts[verdict])
        return [f"{counted(len(self.claims), 'claim')}; {said}"]

    @property
    def cautions(self) -> list[str]:  # type: ignore[override]
        """That there are too few trials for intervals."""
        fewest = min((data.sizes["trial"] for data in self.datasets.values()), default=intervals.FEWEST)
        need = f"intervals need {intervals.FEWEST} trials or more"
        few = f"{need}: {counted(fewest, 'trial')} cannot decide most claims"
        return [few] * (bool(self.claims) and fewest < intervals.FEWEST)

    @property
    def rows(self) -> list[dict[str, Any]]:  # type: ignore[override]
        """A row for each claim: its verdict, what its worst setting has, and how many settings say what."""
        found = []
        for one in self.claims:
            low, high = (one.worst and one.worst.interval) or (None, None)
            found.append({
                "id": one.claim.id, "title": one.claim.title, "verdict": one.verdict,
                "value": one.worst and one.worst.value, "value_low": low, "value_high": high,
                "setting": one.worst and one.worst.setting, "needed": one.claim.needed.words, **counts_of(one),
            })  # fmt: skip
        return found

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """What claims.json has: each claim in every setting."""
        return about(self.claims, self.datasets, self.of.source)

    def tables(self, limit: int) -> list[Table]:
        """One table, in which long texts are folded."""
        if not self.claims:
            return []
        verdicts, titles, worst = zip(*map(_texts, self.claims), strict=True)
        columns = [
            Column("verdict", verdicts, number=False, name="verdict"),
            Column("claim", titles, number=False, name="title"),
            Column("worst setting [95 %], needed", worst, number=False, name="value"),
        ]
        return [Table(columns, folds=True).first(limit)]


def _texts(outcome: Outcome) -> tuple[str, str, str]:
    """The verdict, the claim with some settings against it, and the worst setting with what is needed, in lines."""
    claim, worst = outcome.claim, outcome.worst
    against = [f"{d.setting}: {d.made_of}" for d in outcome.details if d.verdict == NO and d.made_of][:EXAMPLES]
    values = [" ".join(value_and_interval(worst)).strip(), claim.needed.words] if worst else []
    if outcome.verdict != HOLDS or outcome.count(NEITHER) or outcome.left_out:
        values.append(tally(outcome))
    return f"{SIGNS[outcome.verdict]} {outcome.verdict}", "\n".join([claim.title, *against]), "\n".join(values)


def value_and_interval(detail: Detail) -> tuple[str, str]:
    """A value and its interval as text, to two digits of the interval's width: "0.0413", "[0.0391, 0.0429]"."""
    if detail.interval is None or not all(map(math.isfinite, detail.interval)):
        return f"{detail.value:.3g}", ""
    low, high = detail.interval
    return rounded(detail.value, low, high, decimals_for(high - low))


def counts_of(outcome: Outcome) -> dict[str, int]:
    """The number of settings by what they say."""
    return {said: outcome.count(said) for said in (YES, NO, NEITHER)} | {"left_out": len(outcome.left_out)}


def tally(outcome: Outcome) -> str:
    """The same in words, such as "30 yes, 3 neither, 1 left out"."""
    return ", ".join(f"{n} {said.replace('_', ' ')}" for said, n in counts_of(outcome).items() if n)


def as_json(claims: Sequence[Outcome], datasets: Mapping[str, xr.Dataset], source: str) -> str:
    """The text of claims.json. Equal datasets give equal bytes."""
    entries = {"format": "swarmcensus claims 1", **about(claims, datasets, source)}
    text = json.dumps(entries, indent=1, allow_nan=False, ensure_ascii=False)
    return re.sub(r"{[^{}]*}", lambda found: re.sub(r"\n *", " ", found[0]), text) + "\n"  # a setting is one line


def about(claims: Sequence[Outcome], datasets: Mapping[str, xr.Dataset], source: str) -> dict[str, Any]:
    """Each claim with its statistic, threshold, value, interval, verdict and settings.

    `source` is what was published. Settings in the range `right` speak for a claim, those outside `tolerated` against
    it; null is no bound. `interval` is null if the value is exact. Value and interval of a claim are those of its worst
    setting.
    """
    texts = ("id", "title", "sentence", "section", "statistic")
    sizes = {name: {"seed": int(one.attrs["seed"]), "trials": one.sizes["trial"]} for name, one in datasets.items()}
    how = {"unit": "trial", "resamples": intervals.RESAMPLES, "level": intervals.LEVEL, "seed": intervals.SEED}
    return {
        "paper": source, "version": __version__, "studies": sizes, "bootstrap": how,
        "margins": {"ordering": MARGIN, "much": MUCH},
        "claims": [
            {
                **{key: getattr(one.claim, key) for key in texts}, "threshold": one.claim.needed.words,
                "right": _numbers(one.claim.needed.right), "tolerated": _numbers(one.claim.needed.tolerated),
                "verdict": one.verdict, **_values(one.worst), "left_out": [*one.left_out], "note": one.note,
                "explanation": one.explanation,
                "settings": [{**_values(d), "verdict": d.verdict, "made_of": d.made_of} for d in one.details],
            }
            for one in claims
        ],
    }  # fmt: skip


def _numbers(values: Sequence[float]) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values]


def _values(detail: Detail | None) -> dict[str, Any]:
    if detail is None:
        return {"setting": None, "value": None, "interval": None}
    interval = None if detail.interval is None else _numbers(detail.interval)
    return {"setting": detail.setting, "value": _numbers([detail.value])[0], "interval": interval}
