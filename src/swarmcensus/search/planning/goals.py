"""The goal of a mission, which tells which estimates are right; and checks that its keys do not contradict."""

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmcensus.brains import Adversary, lying_brain
from swarmcensus.support.bins import right_bin
from swarmcensus.support.errors import StudyError

POINTS = 51  # fill ratios of the range that are examined
NORMAL = NormalDist()


@dataclass(frozen=True)
class Goal:
    """Estimates within a half-width of the truth, or in its bin, for a share `confidence` of the robots."""

    half_width: float | None
    bins: int | None
    margin: float  # least distance of fill ratios from the edges between bins
    confidence: float

    def region(self, truth: float) -> tuple[float, float]:
        """The interval of right estimates; it is unbounded on a side where estimates are cut to 0 or 1."""
        if self.bins is not None:
            return right_bin(truth, self.bins)
        assert self.half_width is not None
        low, high = truth - self.half_width, truth + self.half_width
        return (-math.inf if low <= 0.0 else low), (math.inf if high >= 1.0 else high)

    def right(self, estimates: NDArray[np.float64], truths: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which estimates (..., trial, robot) are right, given the truth of each trial (trial,)."""
        if self.bins is not None:
            ends = np.array([right_bin(float(truth), self.bins) for truth in np.nan_to_num(truths)])
            low, high = ends[:, 0, np.newaxis], ends[:, 1, np.newaxis]
            return np.asarray((estimates >= low) & (estimates < high))
        return np.asarray(np.abs(estimates - truths[:, np.newaxis]) <= self.half_width)

    def normal_share(self, sd: float, truth: float) -> float:
        """The share of right robots, if estimates are normal about the truth and cut to [0, 1]."""
        low, high = self.region(truth)
        if sd == 0.0:
            return 1.0
        return NORMAL.cdf((high - truth) / sd) - NORMAL.cdf((low - truth) / sd)

    def candidates(self, low: float, high: float) -> NDArray[np.float64]:
        """Fill ratios of a range at least `margin` away from all edges, with both ends and those closest to edges."""
        fill_ratios = np.linspace(low, high, POINTS)
        if self.bins is None:
            return np.unique(fill_ratios)
        edges = np.arange(1, self.bins) / self.bins
        near = np.concatenate([edges - self.margin, edges + self.margin])
        fill_ratios = np.unique(np.concatenate([fill_ratios, near[(near >= low) & (near <= high)]]))
        distance = np.abs(fill_ratios[:, np.newaxis] - edges).min(axis=1)
        return np.asarray(fill_ratios[distance >= self.margin - 1e-12])

    def __str__(self) -> str:
        """The goal in words."""
        if self.half_width is not None:
            return f"within {self.half_width:g} of the truth"
        aside = f", {self.margin:g} or further from its edges" if self.margin else ""
        return f"in the right half{aside}" if self.bins == 2 else f"in the right one of {self.bins} bins{aside}"


def check_consistency(mission: Any) -> None:
    """Raise StudyError if keys contradict one another, or the goal can never be reached."""
    wanted, known, free = mission.wanted, mission.known, mission.free
    if (wanted.half_width is None) == (wanted.right is None):
        either = 'wanted: should have a half_width, such as 0.02, or right, such as "majority" or 10 bins'
        raise StudyError(either + (", and not both" if wanted.right is not None else ""), key="wanted")
    margin = f"{wanted.margin:g}"
    if wanted.margin and wanted.right is None:
        raise StudyError.at("wanted.margin", margin, "it goes with right, because a half_width has no edges")
    if free.robots is None and free.minutes is None:
        either = "should have robots, or minutes, or both: a number or a range, such as [10, 100]"
        raise StudyError(f"free: {either}", key="free")
    for accuracy in known.accuracy:
        if accuracy.drift is not None:
            raise StudyError("known.accuracy: a plan is for sensors that do not drift", key="known.accuracy")
        if accuracy.is_blind:
            why = f"an accuracy of {accuracy} says the same of black and white"
            raise StudyError(f"the goal cannot be reached, because {why}", key="known.accuracy", value=accuracy)
    numbers = [each.black.numbers[0] for each in known.accuracy if each.white is None and each.black.is_number]
    if numbers and min(numbers) < 0.5 < max(numbers):
        ends = f"between {min(numbers):g} and {max(numbers):g} lies 0.5"
        same = "at which a sensor says the same of black and white"
        raise StudyError(f"known.accuracy: {ends}, {same}", key="known.accuracy")
    for brain in mission.brains if wanted.half_width is not None else ():
        if brain.is_opinion:
            opinions = "its robots have opinions of 0 or 1, so it needs right"
            raise StudyError.at("free.brain", brain.name, opinions)
    for key, values in (
        ("known.accuracy", known.accuracy),
        ("known.lie", [lie.label for lie in known.lie or ()]),
        ("free.brain", [brain.label for brain in mission.brains]),
        ("free.topology", free.topology),
        ("free.density", free.density or ()),
    ):
        texts = [str(value) for value in values]
        for text in texts:
            if texts.count(text) > 1:
                raise StudyError(f"{key}: {text} is there twice", key=key, value=text)
    low, high = known.fill_ratio
    if not mission.goal.candidates(low, high).size:
        none = f"wanted.margin = {margin} leaves no fill ratio from {low:g} to {high:g} for {wanted.right!r}"
        raise StudyError(none, key="wanted.margin", value=wanted.margin)
    if wanted.right is not None and wanted.margin == 0.0:
        edges = np.arange(1, mission.goal.bins) / mission.goal.bins
        on_edges = edges[(edges >= low) & (edges <= high)]
        if on_edges.size:
            raise StudyError(
                f"the goal cannot be reached, because f may be {on_edges[0]:g}, on the edge between two bins: "
                "say how far off it is (wanted.margin), or narrow known.fill_ratio",
                key="wanted.margin",
            )


def check_liars(mission: Any) -> None:
    """Raise StudyError if nobody can lie, if no honest robot works, or if an adversary does not fit a brain."""
    known, free = mission.known, mission.free
    if known.lie is not None and not known.lying:
        share = "no robot lies: give the share of robots that may lie as known.lying"
        raise StudyError(f"known.lie: {share}", key="known.lie")
    for entry in known.lie or ():
        if not isinstance(entry, Adversary):
            a_brain = "that is a brain, and not an adversary, such as shouter"
            raise StudyError.at("known.lie", entry.name, a_brain)
    if known.lying + known.failing >= 1.0:
        both = f"known.lying = {known.lying:g} and known.failing = {known.failing:g}"
        less = "leave no robot that works and is honest: together they should be less than 1"
        raise StudyError(f"{both} {less}", key="known.lying", value=known.lying)
    if known.lying and free.robots is not None and free.robots[1] == 1:
        raise StudyError.at("known.lying", f"{known.lying:g}", "a swarm of one robot has no liars")
    for brain in mission.brains if known.lying else ():
        for lie in mission.lies if not brain.is_oracle else ():
            try:
                lying_brain(lie, brain)
            except ValueError as error:
                raise StudyError.at("known.lie", lie.label, error) from None
