"""What all searches share: the mission, its worst fill ratios, and runs of so many robots for so long."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from swarmcensus.brains import Brain
from swarmcensus.planning.mission import FEWEST_TRIALS, Mission
from swarmcensus.planning.starts import Start, start_of
from swarmcensus.planning.trying import Curve, Show, affordable, curves, study_of
from swarmcensus.planning.wishes import capacity
from swarmcensus.runs.working import Progress

MOST_ROBOTS = 1000  # that are looked for where the mission says no number
MOST_SECONDS = 3600.0  # of one core, predicted, for one run


BEGUN = Progress(0, 0, 0.0, 0.0)


class TooLong(Exception):
    """A run would take longer than anybody waits."""


@dataclass
class Search:
    """A mission, threads, whom to tell, fill ratios of which the first is theory's worst, and the readings it takes."""

    mission: Mission
    jobs: int
    show: Show
    fill_ratios: list[float]
    readings: float
    worst: dict[str, list[float]] = field(default_factory=dict)  # fill ratios that may be it, by brain, as simulated
    so_far: Progress = BEGUN  # of all runs: what is told goes on from there

    @property
    def sizes(self) -> tuple[int, int]:
        """The least and the largest swarm."""
        if self.mission.free.robots is not None:
            return self.mission.free.robots
        return 1, min(MOST_ROBOTS, capacity(self.mission)) if self.mission.moves else MOST_ROBOTS

    def start(self, robots: int) -> Start:
        """What theory says of so many robots, in rounds."""
        return start_of(self.mission, robots, self.readings)

    def run(
        self, robots: int, brains: Sequence[Brain], fill_ratios: Sequence[float], times: Sequence[int], trials: int
    ) -> list[Curve]:
        """Run so many trials, or fewer where they would take too long. Raises TooLong where that is next to none."""
        mission = self.mission
        study = study_of(mission, robots, brains, fill_ratios, times, trials, mission.seed)
        most = affordable(study, MOST_SECONDS)
        if most < FEWEST_TRIALS:
            raise TooLong
        if most < trials:
            study = study_of(mission, robots, brains, fill_ratios, times, most, mission.seed)
        label = f"{robots:,} robots, up to {times[-1] * mission.round_minutes:.3g} min"
        ended = before = self.so_far

        def show(told: Progress) -> None:
            nonlocal ended
            ended = replace(
                told,
                done=before.done + told.done,
                total=before.done + told.total,
                work_done=before.work_done + told.work_done,
                work_total=before.work_done + told.work_total,
                note=told.note or (label if told.done == 0 else ""),
            )
            self.show(ended)

        found = curves(mission, study, self.jobs, show)
        self.so_far = ended
        return found
