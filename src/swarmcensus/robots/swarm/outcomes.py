"""What came of a swarm: errors, messages, and what it cost."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarmcensus.robots.swarm.plans import SwarmPlan
from swarmcensus.robots.swarm.reports import RobotState, share_heard, total
from swarmcensus.robots.target import datagram_bytes
from swarmcensus.support.answers import Answer
from swarmcensus.support.bins import right_bin
from swarmcensus.support.documents import json_value
from swarmcensus.support.formatting import counted

SILENCE = 3.0  # seconds in addition to a period; robots report some times a second, or each tick


@dataclass(repr=False)
class Outcome(Answer):
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
    ticks: tuple[int, ...]  # that all robots reported to have lived

    @property
    def code(self) -> int:  # type: ignore[override]
        """1 if a robot died by itself, or none is at work."""
        return int(bool(self.died) or not self.at_work)

    @property
    def fields(self) -> dict[str, Any]:  # type: ignore[override]
        """The same numbers."""
        return {**json_value(self)}


def outcome_of(
    plan: SwarmPlan, robots: Sequence[RobotState], processor_seconds: float, seconds: float, now: float = 0.0
) -> Outcome:
    """The outcome of what is known of robots at the end; one that has long said nothing is not at work."""
    heard_from = now - SILENCE - plan.period / 1000.0
    estimates = np.array(
        [k.last.estimate if k.last and k.state == "runs" and k.seen >= heard_from else np.nan for k in robots]
    )
    honest = np.array([member.honest for member in plan.members])
    known = estimates[honest & np.isfinite(estimates)]
    low, high = right_bin(plan.setting.fill_ratio, plan.study.measure.bins)
    arrived = total(robots, "lost") + total(robots, "heard") + total(robots, "late")
    found = Outcome(
        len(robots), int(np.isfinite(estimates).sum()),
        float(np.abs(known - plan.setting.fill_ratio).mean()) if known.size else np.nan,
        float(((known >= low) & (known < high)).mean()) if known.size else np.nan,
        share_heard(robots), total(robots, "lost") / arrived if arrived else 0.0,
        total(robots, "missed"), total(robots, "undone"), total(robots, "unwritten"),
        processor_seconds, processor_seconds / seconds if seconds > 0 else np.nan,
        {number: one.why for number, one in enumerate(robots) if one.state == "died"}, tuple(estimates.tolist()),
        tuple(one.count("ticks") for one in robots),
    )  # fmt: skip
    found.title = plan.title
    found.sentences = _sentences(plan, found, known.size, "robot" if honest.all() else "honest robot")
    return found


def _sentences(plan: SwarmPlan, found: Outcome, number: int, kind: str) -> list[str]:
    """The end of a run in words; errors are of so many robots of a kind."""
    brain, size = plan.setting.brain, datagram_bytes(plan.setting.brain)
    none = f"unknown: no {kind} was at work at the end"
    error = f"{found.mean_error:.4f}, the mean over the {counted(number, kind)} at work at the end"
    right = f"right     {100 * found.right:.1f} % of them in the right of {plan.study.measure.bins} bins"
    heard = f"{100 * found.heard:.2f} % of the messages that the air did not lose; it lost {100 * found.lost:.1f} %"
    return [
        f"robots    {found.at_work} of {found.robots} at work at the end",
        f"error     {error if number else none}", *[right] * bool(number),
        f"message   {counted(brain.message_bytes, 'byte')}, in a datagram of {size}",
        *[f"heard     {heard}"] * (not np.isnan(found.heard)),
        f"missed    {counted(found.missed, 'tick')} for which there was no time",
        f"processor {found.processor_seconds:.1f} s of all robots, {found.cores:.2f} cores",
        *[f"undone    {counted(found.undone, 'call')} of brains that failed"] * bool(found.undone),
        *[f"unwritten {counted(found.unwritten, 'part')} of logs and memories: is the disk full?"]
        * bool(found.unwritten),
        *(f"robot {number} died by itself, {why}" for number, why in found.died.items()),
    ]  # fmt: skip
