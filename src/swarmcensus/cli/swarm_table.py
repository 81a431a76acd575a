"""What the command `swarm` shows: a table while a swarm runs, lines in a pipe, and a summary at the end."""

import argparse
import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from swarmcensus.cli.output import say
from swarmcensus.support.formatting import counted

if TYPE_CHECKING:
    from rich.table import Table

    from swarmcensus.robots import Known, Outcome, RunningSwarm, SwarmPlan

LINES = 10  # of a run in a pipe
EVENTS = 3  # that are shown in a terminal
COLUMNS = (
    "robot", "", "tick", "estimate", "decision", "heard", "lost", "stale", "refused", "missed", "undone",
)  # fmt: skip
GIVEN_UP = ("undone", "stale", "missed", "refused", "decision", "lost", "heard", "tick")  # in this order where narrow


@contextlib.contextmanager
def showing(plan: "SwarmPlan", options: argparse.Namespace) -> "Iterator[Callable[[RunningSwarm], None]]":
    """A callback that shows a swarm: a live table in a terminal, else a line now and then; with --quiet nothing."""
    if options.quiet:
        yield lambda _: None
    elif sys.stderr.isatty():
        from rich.live import Live

        from swarmcensus.support.terminal import console

        out = console(stderr=True)
        with Live(console=out, transient=True, auto_refresh=False) as live:
            yield lambda swarm: live.update(screen(swarm, out.width, out.height), refresh=True)
    else:
        lines = _Lines(plan.seconds / LINES)
        yield lines.show


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
            say(f"{swarm.seconds:.1f} s: {', '.join(_parts(swarm))}")


def _parts(swarm: "RunningSwarm") -> list[str]:
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


def screen(swarm: "RunningSwarm", width: int, height: int) -> "Table":
    """The state of the swarm for a terminal of this size; the cursor needs one line."""
    from rich.table import Table
    from rich.text import Text

    plan = swarm.plan
    done = max((known.last.round for known in swarm.robots if known.last), default=0)
    round_ = f"round {max(0, min(done, plan.setting.rounds)):,} of {plan.setting.rounds:,}"
    top = [f"{plan.study.name}: {plan.setting.brain.name}, {plan.setting}"]
    top += _filled([round_, *_parts(swarm)], width)
    top += swarm.happened[-EVENTS:]
    room = height - 1 - len(top) - 1  # the last for the heads of columns
    shown = len(swarm.robots) if len(swarm.robots) <= room else max(0, room - 1)
    out = Table.grid()
    for line in top[: max(1, height - 1)]:
        out.add_row(Text(line, overflow="ellipsis", no_wrap=True))
    if shown:
        out.add_row(_robots(swarm, shown, width))
    if 0 < shown < len(swarm.robots):
        out.add_row(Text(f"... and {len(swarm.robots) - shown:,} more"))
    return out


def _filled(parts: list[str], width: int) -> list[str]:
    """The parts in lines of this width, separated by commas."""
    lines = parts[:1]
    for part in parts[1:]:
        joined = f"{lines[-1]}, {part}"
        lines = [*lines[:-1], joined] if len(joined) <= width else [*lines, part]
    return lines


def _robots(swarm: "RunningSwarm", shown: int, width: int) -> "Table":
    """A row for each of the first robots, with the columns for which there is room."""
    from swarmcensus.support.printed_tables import Column
    from swarmcensus.support.terminal import console, fitted

    rows = [_row(number, known) for number, known in enumerate(swarm.robots[:shown])]
    columns = []
    for name, *cells in zip(COLUMNS, *rows, strict=True):
        idle = not set(cells) - {"", "0"}  # columns without events are left out first
        late = GIVEN_UP[::-1].index(name) + 1 + len(GIVEN_UP) * idle if name in GIVEN_UP else 0
        columns.append(Column(name, cells, name != "", late))
    return fitted(columns, console(width=width))[0]


def _row(number: int, known: "Known") -> list[str]:
    state = "" if known.state == "runs" else known.state
    if known.last is None:
        return [str(number), state, *[""] * (len(COLUMNS) - 2)]
    last = known.last
    decision = "" if last.decision < 0 else f"{last.decision:g}"
    counts = (known.count(name) for name in ("heard", "lost", "stale", "refused", "missed", "undone"))
    return [str(number), state, f"{last.ticks:,}", f"{last.estimate:.3f}", decision, *(f"{n:,}" for n in counts)]


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
    said["memory"] = f"{outcome.memory / 1e6:,.0f} MB of all robots at the peak"
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
