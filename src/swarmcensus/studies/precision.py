"""Precision on demand: trials are added, setting by setting, until an interval is as narrow as was asked."""

import re
from collections.abc import Iterator
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from swarmcensus.basics.forms import Form
from swarmcensus.basics.hints import did_you_mean_any
from swarmcensus.statistics import intervals
from swarmcensus.vocabulary.quantities import PER_TRIAL, QUANTITIES, stored

EARLY = 20  # trials: a look at so many may err half as often as one that is the last
GROWTH = 1.25  # trials of a setting from look to look: at most a quarter are more than were needed
RULE = re.compile(
    r"\s*(?P<variable>[a-z_]+)(?:@(?P<checkpoint>\d+))?\s+(?P<statistic>median|mean)\s*(?:\+-|±)\s*"
    r"(?P<width>[0-9.]+(?:[eE][-+]?\d+)?)\s*"
)
VARIABLES = tuple(name for name, quantity in stored("always").items() if quantity.dims != PER_TRIAL)
WORDS = (*VARIABLES, "median", "mean")
FORM = '"convergence_error median +- 0.001", or of convergence_round, final_estimate or correct@100, median or mean'

Fewest = Annotated[int, Field(strict=True, ge=intervals.FEWEST, lt=2**31)]


def look_level(trials: int) -> float:
    """The level of the interval that is looked at after so many trials, so that 95 % of those that end a run hold.

    To stop where an interval happens to be narrow favours those of too small a spread. That is a matter of few
    trials, for the spread of many is known (Chow and Robbins, 1965), and so a look may err the less often the fewer
    they are. `EARLY` was chosen by benchmarks/intervals.py.
    """
    return 1 - (1 - intervals.LEVEL) * trials / (trials + EARLY)


def _pattern() -> str:
    """What a rule looks like, for schemas, which have no names in patterns."""
    plain = re.sub(r"\?P<\w+>", "", RULE.pattern)
    *every, last = VARIABLES
    return plain.replace(r"([a-z_]+)(?:@(\d+))?", rf"({'|'.join(every)}|{last}@\d+)")


class Until(BaseModel):
    """A rule: run trials until half the 95 % interval over trials is at most so wide, for all that it is looked at
    again and again.

    It is looked at after `at_least` trials and then whenever there are a quarter more, so that how many are run
    depends on the trials alone and not on who ran them.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)

    until: Annotated[str, Form(lambda inner: inner() | {"pattern": f"^{_pattern()}$"})]
    """What should be how precise, as "convergence_error median +- 0.001"."""
    at_least: Fewest = 30
    """Trials before the first look."""
    at_most: Fewest = 1000
    """Trials after which it ends at any rate."""

    @model_validator(mode="after")
    def _right(self) -> Self:
        found = RULE.fullmatch(self.until)
        good = found is not None and found["variable"] in VARIABLES
        good = good and (found["variable"] == "correct") == (found["checkpoint"] is not None)  # type: ignore[index]
        if not good or not self._number(found["width"]) > 0.0:  # type: ignore[index]
            hint = did_you_mean_any(re.findall("[A-Za-z_]+", self.until), WORDS)
            raise ValueError(f"until = {self.until!r}: {hint}should be such as {FORM}")
        if self.at_most < self.at_least:
            raise ValueError(f"at_most = {self.at_most} is less than at_least = {self.at_least}")
        return self

    @staticmethod
    def _number(text: str) -> float:
        try:
            return float(text)
        except ValueError:
            return 0.0

    def _part(self, name: str) -> str | None:
        found = RULE.fullmatch(self.until)
        assert found is not None
        return found[name]

    @property
    def checkpoint(self) -> int | None:
        """The round at which decisions are counted, of a rule on `correct`."""
        text = self._part("checkpoint")
        return None if text is None else int(text)

    @property
    def variable(self) -> str:
        """What the interval is of."""
        return str(self._part("variable"))

    def stages(self) -> Iterator[int]:
        """After how many trials the interval is looked at, in order; the last one is `at_most`."""
        trials = self.at_least
        while trials < self.at_most:
            yield trials
            trials = int(trials * GROWTH) + 1
        yield self.at_most

    def interval(self, values: NDArray[np.float64]) -> tuple[float, float]:
        """The interval of the statistic of `values` (trial, robot), (trial, 1) of a rule on `correct`.

        NaN where a value is missing.
        """
        statistic, share = str(self._part("statistic")), QUANTITIES[self.variable].share
        return intervals.estimate(values, statistic, share, look_level(len(values)))[1:]

    def half_width(self, values: NDArray[np.float64]) -> float:
        """Half the width of that interval."""
        low, high = self.interval(values)
        return (high - low) / 2.0

    def holds(self, half_width: float) -> bool:
        """Whether such an interval is narrow enough."""
        return half_width <= self._number(str(self._part("width")))
