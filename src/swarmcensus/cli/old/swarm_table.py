"""What the command `swarm` shows: lines while a swarm runs, and a summary at the end."""

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from swarmcensus.cli.output import say
from swarmcensus.support.formatting import counted

if TYPE_CHECKING:
    from swarmcensus.robots import Outcome, RunningSwarm, SwarmPlan

LINES = 10  # of a run


def showing(plan: "SwarmPlan", options: argparse.Namespace) -> "Callable[[RunningSwarm], None]":
    """A callback that shows a swarm by a line now and then; with --quiet nothing."""
    return (lambda _: None) if options.quiet else _Lines(plan.seconds / LINES).show


class _Lines:
    """Prints events, and a few times in a run the state of the swarm."""

    def __init__(self, every: float) -> None:
        self.every, self.next, self.printed = every, every, 0

    def show(self, swarm: "RunningSwarm") -> None:
        for event in swarm.happened[self.printed :]:
            say(event)
        self.printed = len(swarm.happened)
        if swarm.seconds >= self.next:
            self.next += self.every
            say(f"{swarm.seconds:.1f} s: {', '.join(state_of(swarm))}")


def state_of(swarm: "RunningSwarm") -> list[str]:
    """The state of the swarm, in parts of a line."""
    from swarmcensus.robots import share_heard

    now = [number for number, known in enumerate(swarm.robots) if known.state == "runs" and known.last]
    parts = [f"{len(now)} of {len(swarm.robots)} at work"]
    members = swarm.plan.members
    counts = [known.last.estimate for n in now if (known := swarm.robots[n]).last and members[n].honest]
    if counts:
        low, middle, high = np.quantile(counts, [0.05, 0.5, 0.95])
        what = "estimates" if all(member.honest for member in members) else "honest estimates"
        parts.append(f"{what} {middle:.3f}, 90 % from {low:.3f} to {high:.3f}")
    heard = share_heard(swarm.robots)
    return parts if np.isnan(heard) else [*parts, f"{100 * heard:.1f} % heard"]


def summary(plan: "SwarmPlan", outcome: "Outcome") -> list[str]:
    """The end of a run, as lines."""
    from swarmcensus.robots import datagram_bytes

    brain = plan.setting.brain
    said = {"robots": f"{outcome.at_work} of {outcome.robots} at work at the end", **_errors(plan, outcome)}
    said["message"] = f"{counted(brain.message_bytes, 'byte')}, in a datagram of {datagram_bytes(brain)}"
    if not np.isnan(outcome.heard):
        lost = f"it lost {100 * outcome.lost:.1f} %"
        said["heard"] = f"{100 * outcome.heard:.2f} % of the messages that the air did not lose; {lost}"
    said["missed"] = f"{counted(outcome.missed, 'tick')} for which there was no time"
    said["processor"] = f"{outcome.processor_seconds:.1f} s of all robots, {outcome.cores:.2f} cores"
    if outcome.undone:
        said["undone"] = f"{counted(outcome.undone, 'call')} of brains that failed"
    if outcome.unwritten:
        said["unwritten"] = f"{counted(outcome.unwritten, 'part')} of logs and memories: is the disk full?"
    lines = [f"{what:<10}{text}" for what, text in said.items()]
    return lines + [f"robot {number} died by itself, {why}" for number, why in outcome.died.items()]


def _errors(plan: "SwarmPlan", outcome: "Outcome") -> dict[str, str]:
    """The errors of robots, and which robots are counted."""
    honest = "" if all(member.honest for member in plan.members) else "honest "
    pairs = zip(plan.members, outcome.estimates, strict=True)
    number = sum(member.honest and bool(np.isfinite(estimate)) for member, estimate in pairs)
    if not number:
        return {"error": f"unknown: no {honest}robot was at work at the end"}
    who = f"the mean over the {counted(number, honest + 'robot')} at work at the end"
    return {
        "error": f"{outcome.mean_error:.4f}, {who}",
        "right": f"{100 * outcome.right:.1f} % of them in the right of {plan.study.measure.bins} bins",
    }
