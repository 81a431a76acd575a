"""What came of a swarm: errors, messages, and what it cost."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from swarmcensus.robots.swarm.plans import SwarmPlan
from swarmcensus.robots.swarm.reports import RobotState, share_heard, total
from swarmcensus.robots.target import datagram_bytes
from swarmcensus.support.answers import Answer
from swarmcensus.support.bins import right_bin
from swarmcensus.support.formatting import counted

SILENCE = 3.0  # seconds in addition to a period; robots report some times a second, or each tick


def outcome_of(
    plan: SwarmPlan, robots: Sequence[RobotState], processor_seconds: float, seconds: float, now: float = 0.0
) -> Answer:
    """The outcome of what is known of robots at the end; one that has long said nothing is not at work.

    Means are over honest robots that were at work; `right` is the share of them in the right bin, `lost` that of
    messages that the air lost, `heard` that of the others that were heard. The code is 1 if a robot died by itself, or
    none is at work.
    """
    heard_from = now - SILENCE - plan.period / 1000.0
    estimates = np.array(
        [k.last.estimate if k.last and k.state == "runs" and k.seen >= heard_from else np.nan for k in robots]
    )
    honest = np.array([member.honest for member in plan.members])
    known = estimates[honest & np.isfinite(estimates)]
    low, high = right_bin(plan.setting.fill_ratio, plan.study.measure.bins)
    lost = total(robots, "lost")
    arrived, at_work = lost + total(robots, "heard") + total(robots, "late"), int(np.isfinite(estimates).sum())
    died = {number: one.why for number, one in enumerate(robots) if one.state == "died"}
    found = {
        "robots": len(robots), "at_work": at_work,
        "mean_error": float(np.abs(known - plan.setting.fill_ratio).mean()) if known.size else np.nan,
        "right": float(((known >= low) & (known < high)).mean()) if known.size else np.nan,
        "heard": share_heard(robots), "lost": lost / arrived if arrived else 0.0,
        **{name: total(robots, name) for name in ("missed", "undone", "unwritten")},
        "processor_seconds": processor_seconds, "cores": processor_seconds / seconds if seconds > 0 else np.nan,
        "died": died, "estimates": estimates.tolist(), "ticks": [one.count("ticks") for one in robots],
    }  # fmt: skip
    sentences = _sentences(plan, found, known.size, "robot" if honest.all() else "honest robot")
    return Answer(title=plan.title, sentences=sentences, fields=found, code=int(bool(died) or not at_work))


def _sentences(plan: SwarmPlan, found: Mapping[str, Any], number: int, kind: str) -> list[str]:
    """The end of a run in words; errors are of so many robots of a kind."""
    brain, size = plan.setting.brain, datagram_bytes(plan.setting.brain)
    none = f"unknown: no {kind} was at work at the end"
    error = f"{found['mean_error']:.4f}, the mean over the {counted(number, kind)} at work at the end"
    right = f"right     {100 * found['right']:.1f} % of them in the right of {plan.study.measure.bins} bins"
    heard = (
        f"{100 * found['heard']:.2f} % of the messages that the air did not lose; it lost {100 * found['lost']:.1f} %"
    )
    return [
        f"robots    {found['at_work']} of {found['robots']} at work at the end",
        f"error     {error if number else none}", *[right] * bool(number),
        f"message   {counted(brain.message_bytes, 'byte')}, in a datagram of {size}",
        *[f"heard     {heard}"] * (not np.isnan(found['heard'])),
        f"missed    {counted(found['missed'], 'tick')} for which there was no time",
        f"processor {found['processor_seconds']:.1f} s of all robots, {found['cores']:.2f} cores",
        *[f"undone    {counted(found['undone'], 'call')} of brains that failed"] * bool(found['undone']),
        *[f"unwritten {counted(found['unwritten'], 'part')} of logs and memories: is the disk full?"]
        * bool(found['unwritten']),
        *(f"robot {number} died by itself, {why}" for number, why in found['died'].items()),
    ]  # fmt: skip
