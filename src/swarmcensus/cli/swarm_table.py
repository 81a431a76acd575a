"""What the command `swarm` shows: a table while a swarm runs, lines in a pipe, and a summary at the end."""

import argparse
import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from swarmcensus.cli.output import say

if TYPE_CHECKING:
    from rich.table import Table

    from swarmcensus.swarm.outcomes import Outcome
    from swarmcensus.swarm.plans import Plan
    from swarmcensus.swarm.reports import Known
    from swarmcensus.swarm.running import Swarm

ROWS = 30  # robots that are shown one by one
LINES = 10  # of a run in a pipe
COLUMNS = (
    ("robot", True), ("", False), ("tick", True), ("estimate", True), ("decision", True), ("heard", True),
    ("lost", True), ("stale", True), ("refused", True), ("missed", True), ("undone", True),
)  # fmt: skip


@contextlib.contextmanager
def showing(plan: "Plan", options: argparse.Namespace) -> "Iterator[Callable[[Swarm], None]]":
    """A callback that shows a swarm: a live table in a terminal, else a line now and then; with --quiet nothing."""
    if options.quiet:
        yield lambda _: None
    elif sys.stderr.isatty():
        from rich.live import Live

        from swarmcensus.basics.terminal import console

        with Live(console=console(stderr=True), transient=True, auto_refresh=False) as live:
            yield lambda swarm: live.update(_screen(swarm), refresh=True)
    else:
        lines = _Lines(plan.seconds / LINES)
        yield lines.show


class _Lines:
    """Says what happens, and how the swarm is, a few times in a run."""

    def __init__(self, every: float) -> None:
        self.every, self.next, self.told = every, every, 0

    def show(self, swarm: "Swarm") -> None:
        for event in swarm.happened[self.told :]:
            say(event)
        self.told = len(swarm.happened)
        if swarm.seconds >= self.next:
            self.next += self.every
            say(headline(swarm))


def headline(swarm: "Swarm") -> str:
    """How the swarm is, in a line."""
    from swarmcensus.swarm.reports import share_heard

    now = [known for known in swarm.robots if known.state == "runs" and known.last]
    told = f"{swarm.seconds:.1f} s: {len(now)} of {len(swarm.robots)} at work"
    if not now:
        return told
    low, middle, high = np.quantile([known.last.estimate for known in now if known.last], [0.05, 0.5, 0.95])
    heard = share_heard(swarm.robots)
    talk = "" if np.isnan(heard) else f", {heard:.1%} heard"
    return f"{told}, estimates {middle:.3f}, 90 % of them from {low:.3f} to {high:.3f}{talk}"


def _screen(swarm: "Swarm") -> "Table":
    from rich.table import Table
    from rich.text import Text

    from swarmcensus.basics.terminal import table

    out = Table.grid()
    plan = swarm.plan
    done = max((known.last.round for known in swarm.robots if known.last), default=0)
    out.add_row(Text(f"{plan.study.name}: {plan.setting}", overflow="ellipsis", no_wrap=True))
    out.add_row(Text(f"round {max(0, min(done, plan.setting.rounds)):,} of {plan.setting.rounds:,}, {headline(swarm)}"))
    out.add_row(table(COLUMNS, (_row(number, known) for number, known in enumerate(swarm.robots[:ROWS]))))
    if len(swarm.robots) > ROWS:
        out.add_row(Text(f"... and {len(swarm.robots) - ROWS:,} more"))
    for event in swarm.happened[-3:]:
        out.add_row(Text(event))
    return out


def _row(number: int, known: "Known") -> list[str]:
    state = "" if known.state == "runs" else known.state
    if known.last is None:
        return [str(number), state, *[""] * (len(COLUMNS) - 2)]
    last = known.last
    decision = "" if last.decision < 0 else f"{last.decision:g}"
    counts = (known.count(name) for name in ("heard", "lost", "stale", "refused", "missed", "undone"))
    return [str(number), state, f"{last.ticks:,}", f"{last.estimate:.3f}", decision, *(f"{n:,}" for n in counts)]


def summary(plan: "Plan", outcome: "Outcome") -> list[str]:
    """The end of a run, as lines."""
    honest = sum(member.honest for member in plan.members)
    whose = "" if honest == len(plan.members) else f" of {honest} honest ones"
    lines = [
        f"{'robots':<10}{outcome.at_work} of {outcome.robots} at work at the end",
        f"{'error':<10}{outcome.mean_error:.4f}, the mean over robots{whose}",
        f"{'right':<10}{outcome.right:.1%} of robots in the right of {plan.study.measure.bins} bins",
        f"{'heard':<10}{outcome.heard:.2%} of the messages that the air did not lose; it lost {outcome.lost:.1%}",
        f"{'missed':<10}{outcome.missed:,} ticks for which there was no time",
        f"{'processor':<10}{outcome.processor_seconds:.1f} s of all robots, {outcome.cores:.2f} cores",
        f"{'memory':<10}{outcome.memory / 1e6:,.0f} MB of all robots at the peak",
    ]
    lines += [f"robot {number} died by itself, {why}" for number, why in outcome.died.items()]
    return lines
