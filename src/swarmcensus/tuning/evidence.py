"""The evidence for a search's result: the tuned brain against the original, on trials that the search never saw."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from swarmcensus.basics.formatting import counted, decimals_for, grouped, rounded
from swarmcensus.brains import Brain
from swarmcensus.brains.packing import PLAIN
from swarmcensus.comparing.cells import p_equals
from swarmcensus.comparing.comparison import Comparison, compare_dataset
from swarmcensus.comparing.verdicts import win_shares
from swarmcensus.results.summaries import is_idle
from swarmcensus.studies.settings import Setting

BETTER, WORSE, LEVEL, NONE = "better", "worse", "not told apart", "not compared"


@dataclass(frozen=True)
class Evidence:
    """The comparison of the tuned brain with the original, and `all_brains`, that of all brains of the study.

    `all_brains` is None if the study has no others. Both are None if the search ended at the original values, and `why`
    gives the reason.
    """

    tuned: str
    before: str
    comparison: Comparison | None
    all_brains: Comparison | None
    why: str = ""

    @property
    def verdict(self) -> str:
        """Whether the tuned brain is "better" than the original over all worlds, "worse", or "not told apart".

        It is "not compared" if the values stay as they were.
        """
        if self.comparison is None:
            return NONE
        [contest] = self.comparison.contests
        if contest.met.sum() > 1:
            apart, ahead = bool(contest.duels_apart[0]), float(contest.ahead[0])
        else:
            apart, ahead = bool(contest.apart[0, 0]), float(contest.tests.balance[0, 0]) * (-1 if contest.low else 1)
        if not apart or not ahead:
            return LEVEL
        return BETTER if (ahead > 0) == self._first else WORSE

    @property
    def _first(self) -> bool:
        """Whether the tuned brain is the first of the pair."""
        assert self.comparison is not None
        return self.comparison.contenders[0] == self.tuned

    @property
    def sentences(self) -> list[str]:
        """One sentence on all worlds, one on each world, and one on the study's other brains."""
        if self.comparison is None:
            return [f"{self.why}: the values stay as they were, and there is nothing to compare: {self.before}"]
        measure = self.comparison.measures[0]
        pairs = self.comparison.pairs.to_dict("records")
        phrase = {LEVEL: "is not told apart from", BETTER: "is better than", WORSE: "is worse than"}[self.verdict]
        over = ""
        for row in self.comparison.duels.to_dict("records"):
            better, worse = self.comparison.contests[0].shares(0)
            shares_text = win_shares(better, worse) if self._first else win_shares(worse, better)
            over = f" over all {counted(len(pairs), 'world')}: {shares_text}, p {p_equals(row['p_holm'])}"
        only_world = "" if over else f": {self._of_world(pairs[0])}" if pairs else ""
        lines = [f"{measure.full_label}: {self.tuned} {phrase} {self.before}{over}{only_world}"]
        if over:
            lines += [
                f"world {row['world']}{_world_text(self.comparison, row)}: {self._of_world(row)}" for row in pairs
            ]
        if self.all_brains is not None:
            lines += [
                f"beside the study's others: {line}" for line in self.all_brains.verdict[:2] if "cost" not in line
            ]
        return lines

    def _of_world(self, row: dict[str, Any]) -> str:
        """A phrase such as "median of differences -0.0021 [-0.0030, -0.0011], better in 83% of 30 trials, p < 0.001".

        Differences of shares are in percentage points, because tables show shares in percent.
        """
        assert self.comparison is not None
        measure = self.comparison.measures[0]
        times = (1.0 if self._first else -1.0) * (100.0 if measure.share else 1.0)
        ends = sorted((times * row["difference_low"], times * row["difference_high"]))
        difference = times * row["difference"] + 0.0
        unit = " percentage points" if measure.share else f" {measure.unit}" if measure.unit != "1" else ""
        if np.isfinite([difference, *ends]).all():
            text = " ".join(rounded(difference, ends[0], ends[1], decimals_for(ends[1] - ends[0])))
        else:
            text = f"{difference:.3g}"
        superiority = row["superiority"] if self._first else 1 - row["superiority"]
        apart = "" if row["told_apart"] else ", not told apart"
        return (
            f"{measure.statistic} of differences {text}{unit}, better in {superiority:.0%} of {row['trials']:,} "
            f"trials, p {p_equals(row['p_holm'])}{apart}"
        )


def evidence_of(
    data: xr.Dataset, settings: list[Setting], tuned: Brain, before: Brain, metric: str, searched: Collection[str]
) -> Evidence:
    """Compare the two brains in the results of an evaluation with these settings, and then all of its brains.

    Names of both contain all searched parameters, also those whose value did not change.
    """
    shown = {before.name: searched}
    rows = [k for k, setting in enumerate(settings) if setting.brain.with_numbers(PLAIN) in (tuned, before)]
    comparison = compare_dataset(data.isel(setting=rows), metric, None, None, shown)
    names = _contender_names(data, settings, rows, comparison, (tuned, before))
    all_brains = compare_dataset(data, metric, None, None, shown) if len(rows) < len(settings) else None
    return Evidence(*names, comparison, all_brains)


def _contender_names(
    data: xr.Dataset, settings: list[Setting], rows: list[int], comparison: Comparison, pair: tuple[Brain, Brain]
) -> tuple[str, str]:
    """The comparison's names of the two brains of `pair`."""
    numbers = data["setting"].values[rows].tolist()
    brain_of = {number: settings[k].brain.with_numbers(PLAIN) for number, k in zip(numbers, rows, strict=True)}
    names_by_brain: dict[Brain, str] = {}
    for world in comparison.settings.tolist():
        names_by_brain |= {
            brain_of[number]: name for number, name in zip(world, comparison.contenders, strict=True) if number >= 0
        }
    return names_by_brain[pair[0]], names_by_brain[pair[1]]


def _world_text(comparison: Comparison, row: dict[str, Any]) -> str:
    """A world's coordinates that differ among worlds, in parentheses."""
    world = comparison.grid.worlds[row["world"]]
    phrase = ", ".join(f"{name} {grouped(value)}" for name, value in world.items() if not is_idle(value))
    return f" ({phrase})" if phrase else ""
