"""What all searches share: the mission, its worst cases, and simulations of a number of robots for some time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.runs import Hardware, Progress, predicted_seconds
from swarmcensus.search.planning.areas import Unreachable, check_network
from swarmcensus.search.planning.mission import FEWEST_TRIALS, Mission
from swarmcensus.search.planning.predictions import (
    MOST_READINGS,
    REFERENCE,
    Prediction,
    inner_fill_ratios,
    least_deviation,
    predict,
    readings_needed,
    worst_fill_ratios,
)
from swarmcensus.search.planning.simulating import Case, Curve, Show, curves, study_of
from swarmcensus.support.formatting import counted
from swarmcensus.support.seeds import seed_for

MOST_SECONDS = 3600.0  # predicted, on one core, for one run
SIZES = 5  # swarm sizes of a trade-off
CONFIRMED = 3  # fill ratios that are simulated in all trials, of those that may be the worst


def cases_to_confirm(cases: Sequence[Case]) -> list[Case]:
    """The cases at the first `CONFIRMED` fill ratios of `cases`, which has the worst first."""
    fill_ratios = list(dict.fromkeys(case.fill_ratio for case in cases))[:CONFIRMED]
    return [case for case in cases if case.fill_ratio in fill_ratios]


@dataclass
class Search:
    """A mission in one world, and the cases to simulate; the first case's fill ratio is the worst by theory."""

    mission: Mission
    hardware: Hardware
    show: Show
    cases: list[Case] = field(init=False)
    inner: list[float] = field(init=False)  # fill ratios that are neither theory's worst nor an end of the range
    worst: dict[str, list[Case]] = field(default_factory=dict)  # each brain's possible worst cases, the worst first
    checked: set[int] = field(default_factory=set)  # sizes of swarms with connected networks

    def __post_init__(self) -> None:
        """Find the cases."""
        sized, lies = self.mission.sized(REFERENCE), self.mission.lies
        self.inner = inner_fill_ratios(sized)
        fill_ratios = worst_fill_ratios(sized) + self.inner
        self.cases = [Case(fill_ratio, lie) for fill_ratio in fill_ratios for lie in lies or (None,)]

    @property
    def tried_sizes(self) -> list[int]:
        """The swarm sizes of a trade-off; a single one if the mission gives a number of robots."""
        return [*np.unique(np.geomspace(*self.mission.sizes, SIZES).round().astype(int)).tolist()]

    def predict(self, robots: int) -> Prediction:
        """Theory's prediction for so many robots, in rounds; infinite if no number of readings is enough."""
        self.check_network(robots)
        mission = self.mission.sized(robots)
        return predict(mission, robots, readings_needed(mission, self.cases[0].fill_ratio))

    def check_network(self, robots: int) -> None:
        """Raise Unreachable if so many robots have no connected network."""
        if robots not in self.checked and not self.mission.moves:
            check_network(self.mission, robots)
            self.checked.add(robots)

    def check_reach(self, robots: int) -> None:
        """Raise Unreachable if no number of readings is enough, for example on too small a floor."""
        mission, fill_ratio = self.mission.sized(robots), self.cases[0].fill_ratio
        if math.isfinite(readings_needed(mission, fill_ratio)):
            return
        goal, side = mission.goal, mission.side
        if side is None or mission.on_floor:
            why = f"not even {MOST_READINGS:.0e} readings are enough with an accuracy of {mission.accuracy}"
            raise Unreachable(f"the goal cannot be reached, because {why}")
        percent_off = 100 * (1 - goal.normal_share(least_deviation(mission, fill_ratio), fill_ratio))
        far = f"more than {goal.wanted.error:g} from it" if goal.wanted.error is not None else "in another bin"
        raise Unreachable(
            f"the goal cannot be reached, because in so small an area, {side:.3g} m x {side:.3g} m, "
            f"{percent_off:.2g} % of floors with f = {fill_ratio:g} "
            f'have a share of black of their own that is {far}: compare estimates with it by measure.truth = "floor"'
        )

    def run(
        self, robots: int, brains: Sequence[Brain], cases: Sequence[Case], times: Sequence[int], trials: int,
        fresh: bool = False,
    ) -> dict[str, list[Curve]]:  # fmt: skip
        """Run `trials` trials, or fewer if they would take too long: each brain's curves, one for each case.

        `fresh` trials are others than those of the search, and independent of those of other sizes.
        Raises Unreachable if `FEWEST_TRIALS` would take too long.
        """
        self.check_network(robots)
        mission = self.mission
        seed = mission.study.seed
        if fresh:
            seed = seed_for(seed, f"fresh trials of {robots} robots", command="plan")
        study = study_of(mission, robots, brains, cases, times, trials, seed)
        most = int(MOST_SECONDS / predicted_seconds(study, study.settings()) * trials)
        if most < FEWEST_TRIALS:
            alone = self.predict(robots).minutes(mission).mixed
            raise Unreachable(
                f"{FEWEST_TRIALS} trials of {counted(robots, 'robot')} would take over an hour of a core: wish for "
                f"less; theory alone says {alone:.3g} minutes"
            )
        if most < trials:
            study = study_of(mission, robots, brains, cases, times, most, seed)
        what = "first look" if trials < mission.study.trials else "confirming"
        stage = f"{what}: {counted(robots, 'robot')}, up to {times[-1] * mission.round_minutes:.3g} min"

        def show(progress: Progress) -> None:  # the number of later steps depends on this one's result
            self.show(replace(progress, stage=stage, part="this step"))

        by_brain: dict[str, list[Curve]] = {brain.label: [] for brain in brains}
        for curve in curves(mission, study, self.hardware, show):
            by_brain[curve.brain].append(curve)
        return by_brain
