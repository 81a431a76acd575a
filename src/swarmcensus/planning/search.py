"""What all searches share: the mission, its worst fill ratios, and runs of so many robots for so long."""

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from swarmcensus.basics.formatting import counted
from swarmcensus.basics.seeds import seed_for
from swarmcensus.brains import Brain
from swarmcensus.planning.areas import capacity, check_network, fewest
from swarmcensus.planning.mission import FEWEST_TRIALS, Mission
from swarmcensus.planning.predictions import (
    MOST_READINGS,
    REFERENCE,
    Start,
    between,
    limit_of,
    readings_needed,
    start_of,
    worst,
)
from swarmcensus.planning.simulating import Case, Curve, Show, affordable, curves, study_of
from swarmcensus.runs.collect import Progress

MOST_ROBOTS = 1000  # that are looked for where the mission says no number
MOST_SECONDS = 3600.0  # of one core, predicted, for one run
CONFIRMED = 3  # fill ratios of those that may be the worst, in all trials


LOG = logging.getLogger(__name__)
BEGUN = Progress(0, 0, 0.0, 0.0)


class Beyond(Exception):
    """Not even all readings in the world are enough, and why."""


class TooLong(Exception):
    """A run would take longer than anybody waits."""


def confirmed(cases: Sequence[Case]) -> list[Case]:
    """Of cases, the worst first, those at the few fill ratios that have all trials."""
    fill_ratios = list(dict.fromkeys(case.fill_ratio for case in cases))[:CONFIRMED]
    return [case for case in cases if case.fill_ratio in fill_ratios]


@dataclass
class Search:
    """A mission in one world, threads, whom to tell, and cases, of whose fill ratios the first is theory's worst."""

    mission: Mission
    jobs: int
    show: Show
    so_far: Progress = BEGUN  # of all runs: what is told goes on from there
    cases: list[Case] = field(init=False)
    inner: list[float] = field(init=False)  # fill ratios that are neither theory's worst nor an end of the range
    worst: dict[str, list[Case]] = field(default_factory=dict)  # cases that may be it, the worst first, by brain
    checked: set[int] = field(default_factory=set)  # sizes whose networks hang together

    def __post_init__(self) -> None:
        """Find the cases."""
        sized, lies = self.mission.sized(REFERENCE), self.mission.lies
        self.inner = between(sized)
        fill_ratios = worst(sized) + self.inner
        self.cases = [Case(fill_ratio, lie) for fill_ratio in fill_ratios for lie in lies or (None,)]

    @property
    def sizes(self) -> tuple[int, int]:
        """The least and the largest swarm."""
        if self.mission.free.robots is not None:
            return self.mission.free.robots
        if not self.mission.moves:
            return 1, MOST_ROBOTS
        if self.mission.density is not None:
            return fewest(self.mission), MOST_ROBOTS
        return 1, min(MOST_ROBOTS, capacity(self.mission))

    def start(self, robots: int) -> Start:
        """What theory says of so many robots, in rounds; infinite where no readings are enough."""
        self.check_network(robots)
        mission = self.mission.sized(robots)
        return start_of(mission, robots, readings_needed(mission, self.cases[0].fill_ratio))

    def check_network(self, robots: int) -> None:
        """Raise NoNetwork where so many robots cannot hear one another."""
        if robots not in self.checked and not self.mission.moves:
            check_network(self.mission, robots)
            self.checked.add(robots)

    def check_reach(self, robots: int) -> None:
        """Raise Beyond where the floor under so many robots is too small for the goal."""
        mission, fill_ratio = self.mission.sized(robots), self.cases[0].fill_ratio
        if math.isfinite(readings_needed(mission, fill_ratio)):
            return
        goal, side = mission.goal, mission.side
        if side is None or mission.on_floor:
            raise Beyond(f"not even {MOST_READINGS:.0e} readings are enough with an accuracy of {mission.accuracy}")
        off = 100 * (1 - goal.normal_share(limit_of(mission, fill_ratio), fill_ratio))
        far = f"more than {goal.half_width:g} from it" if goal.half_width is not None else "in another bin"
        raise Beyond(
            f"in so small an area, {side:.3g} m x {side:.3g} m, {off:.2g} % of floors with f = {fill_ratio:g} have a "
            f'share of black of their own that is {far}: hold estimates against it by wanted.truth = "floor"'
        )

    def run(
        self,
        robots: int,
        brains: Sequence[Brain],
        cases: Sequence[Case],
        times: Sequence[int],
        trials: int,
        fresh: bool = False,
    ) -> list[Curve]:
        """Run so many trials, or fewer where they would take too long; fresh ones have no part in what was chosen.

        Raises TooLong where that is next to none.
        """
        self.check_network(robots)
        mission = self.mission
        seed = seed_for(mission.seed, "fresh trials", command="plan") if fresh else mission.seed
        study = study_of(mission, robots, brains, cases, times, trials, seed)
        most = affordable(study, MOST_SECONDS)
        if most < FEWEST_TRIALS:
            raise TooLong
        if most < trials:
            study = study_of(mission, robots, brains, cases, times, most, seed)
        minutes = times[-1] * mission.round_minutes
        what = "first look" if trials < mission.trials else "confirming"
        stage = f"{what}: {counted(robots, 'robot')}, up to {minutes:.3g} min"
        ended = before = self.so_far

        def show(told: Progress) -> None:
            nonlocal ended
            ended = replace(
                told,
                done=before.done + told.done,
                total=before.done + told.total,
                work_done=before.work_done + told.work_done,
                work_total=before.work_done + told.work_total,
                stage=stage,
            )
            self.show(ended)

        found = curves(mission, study, self.jobs, show)
        self.so_far = ended
        for one in found:
            lie = f" among {one.case.lie.label}" if one.case.lie else ""
            right = f"{100 * one.at(-1).value:.1f} % of {counted(robots, 'robot')} are right after {minutes:.3g} min"
            LOG.debug("%s, f = %g%s: %s, in %s trials", one.brain, one.case.fill_ratio, lie, right, study.trials)
        return found
