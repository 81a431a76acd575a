"""What came of a swarm: errors, messages, and what it cost."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarmcensus.robots.swarm.plans import SwarmPlan
from swarmcensus.robots.swarm.reports import Known, share_heard, total
from swarmcensus.support.bins import right_bin

SILENCE = 3.0  # seconds in addition to a period; robots report some times a second, or each tick


@dataclass(frozen=True)
class Outcome:
    """The end of a run; means are over honest robots that were at work then."""

    robots: int
    at_work: int
    mean_error: float
    right: float  # share of robots in the right bin
    heard: float  # share of messages heard, of those that should have been
    lost: float  # share of messages lost in the air
    missed: int  # ticks
    undone: int  # calls of brains that failed
    unwritten: int  # parts of logs and savings of memories that the disk did not take
    processor_seconds: float
    cores: float
    died: dict[int, str]  # robots that died by themselves, and why
    estimates: tuple[float, ...]  # of all robots; NaN for those not at work


def outcome_of(
    plan: SwarmPlan, robots: Sequence[Known], processor_seconds: float, seconds: float, now: float = 0.0
) -> Outcome:
    """The outcome of what is known of robots at the end; one that has long said nothing is not at work."""
    heard_from = now - SILENCE - plan.period / 1000.0
    estimates = np.array(
        [k.last.estimate if k.last and k.state == "runs" and k.seen >= heard_from else np.nan for k in robots]
    )
    honest = np.array([member.honest for member in plan.members])
    counted = estimates[honest & np.isfinite(estimates)]
    low, high = right_bin(plan.setting.fill_ratio, plan.study.measure.bins)
    arrived = total(robots, "lost") + total(robots, "heard") + total(robots, "late")
    return Outcome(
        robots=len(robots),
        at_work=int(np.isfinite(estimates).sum()),
        mean_error=float(np.abs(counted - plan.setting.fill_ratio).mean()) if counted.size else np.nan,
        right=float(((counted >= low) & (counted < high)).mean()) if counted.size else np.nan,
        heard=share_heard(robots),
        lost=total(robots, "lost") / arrived if arrived else 0.0,
        missed=total(robots, "missed"),
        undone=total(robots, "undone"),
        unwritten=total(robots, "unwritten"),
        processor_seconds=processor_seconds,
        cores=processor_seconds / seconds if seconds > 0 else np.nan,
        died={number: known.why for number, known in enumerate(robots) if known.state == "died"},
        estimates=tuple(estimates.tolist()),
    )
