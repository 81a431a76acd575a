"""Rules on precision: trials of a setting are added until a confidence interval is narrow enough."""

import re
from collections.abc import Iterator
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from swarmcensus.support import intervals
from swarmcensus.support.hints import did_you_mean_any
from swarmcensus.support.quantities import PER_TRIAL, QUANTITIES, stored
from swarmcensus.support.toml_types import TomlTable

EARLY = 20  # trials: a look after this many has half the error rate of a late look
GROWTH = 1.25  # ratio of trials from look to look: at most a quarter of trials are more than needed
VARIABLES = tuple(name for name, quantity in stored("always").items() if quantity.dims != PER_TRIAL)
WORDS = (*VARIABLES, "median", "mean")
RULE = re.compile(
    rf"\s*(?:(?P<variable>{'|'.join(name for name in VARIABLES if name != 'correct')})|correct@(?P<checkpoint>\d+))\s+"
    r"(?P<statistic>median|mean)\s*(?:\+-|±)\s*(?P<width>(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?)\s*"
)
FORM = '"convergence_error median +- 0.001", or of convergence_round, final_estimate or correct@100, median or mean'

Fewest = Annotated[int, Field(strict=True, ge=intervals.FEWEST, lt=2**31)]


def look_level(trials: int) -> float:
    """The level of an interval after `trials` trials, such that 95 % of the intervals that end a run hold.

    A run is more likely to stop at an interval with an underestimated spread. This matters with few trials only, as
    the spread of many is well known (Chow and Robbins, 1965). So early looks use a higher level. `EARLY` comes from
    benchmarks/intervals.py.
    """
    return 1 - (1 - intervals.LEVEL) * trials / (trials + EARLY)


class Until(TomlTable):
    """A rule that adds trials until a 95 % interval is narrow enough.

    The interval is looked at after `at_least` trials, and again each time a quarter has been added. The level allows
    for these repeated looks. The number of trials depends on their results alone, not on how they were distributed.
    """

    until: str
    """The measure and its half-width, as "convergence_error median +- 0.001"."""
    at_least: Fewest = 30
    """Trials before the first look."""
    at_most: Fewest = 1000
    """Trials after which the run ends in any case."""

    @model_validator(mode="after")
    def _right(self) -> Self:
        found = RULE.fullmatch(self.until)
        if found is None or float(found["width"]) <= 0.0:
            hint = did_you_mean_any(re.findall("[A-Za-z_]+", self.until), WORDS)
            raise ValueError(f"until = {self.until!r}: {hint}should be such as {FORM}")
        if self.at_most < self.at_least:
            raise ValueError(f"at_most = {self.at_most} is less than at_least = {self.at_least}")
        return self

    def _part(self, name: str) -> str | None:
        found = RULE.fullmatch(self.until)
        assert found is not None
        return found[name]

    @property
    def checkpoint(self) -> int | None:
        """The round of a rule on `correct`, at which decisions are counted."""
        return int(text) if (text := self._part("checkpoint")) else None

    @property
    def variable(self) -> str:
        """The variable of the dataset that the rule is on."""
        return self._part("variable") or "correct"

    def stages(self) -> Iterator[int]:
        """The numbers of trials after which the interval is looked at, up to `at_most`."""
        trials = self.at_least
        while trials < self.at_most:
            yield trials
            trials = int(trials * GROWTH) + 1
        yield self.at_most

    def interval(self, values: NDArray[np.float64]) -> tuple[float, float]:
        """The interval of the statistic of `values` (trial, robot); (trial, 1) for a rule on `correct`.

        NaN if a value is missing.
        """
        statistic, share = str(self._part("statistic")), QUANTITIES[self.variable].share
        return intervals.estimate(values, statistic, share, look_level(len(values)))[1:]

    def half_width(self, values: NDArray[np.float64]) -> float:
        """Half the width of `interval`."""
        low, high = self.interval(values)
        return (high - low) / 2.0

    def holds(self, half_width: float) -> bool:
        """Whether this half-width is small enough for the rule."""
        return half_width <= float(str(self._part("width")))
