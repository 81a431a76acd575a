"""What is to happen to a swarm while it runs: `--fault "5s kill 3"`, read and checked."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option

ACTIONS = ("kill", "restart", "stop", "continue", "partition", "heal", "start")
ALONE = ("heal",)  # these name no robots
SECONDS = {"ms": 0.001, "s": 1.0, "min": 60.0, "h": 3600.0}
FORM = re.compile(r"(\d+(?:\.\d+)?)\s*(ms|s|min|h|rounds?)?\s+([A-Za-z]+)(?:\s+([\d,\- ]*\d))?(\s+blank)?")
RIGHT = '"5s kill 3", with a time in s or rounds, one of ' + ", ".join(ACTIONS) + ", and robots such as 3 or 0-9,12"

POSSIBLE = {  # actions, and what a robot may do then
    "start": ("has not started",),
    "continue": ("is stopped",),
    "restart": ("runs", "is killed", "is stopped"),
    "kill": ("runs", "is stopped"),
    "stop": ("runs",),
}


class ProcessFault(NamedTuple):
    """Something that happens to robots."""

    seconds: float  # since the swarm's start
    action: str
    robots: tuple[int, ...]
    blank: bool  # whether a restarted robot has lost its memory
    text: str

    @property
    def what(self) -> str:
        """The fault without its time."""
        return self.text[self.text.index(self.action) :]


def faults_of(texts: Sequence[str], robots: int, period: int, seconds: float) -> list[ProcessFault]:
    """Faults in the order of their times. Raises InputError, naming the one that is wrong.

    `period` is in milliseconds. `seconds` is how long the swarm runs.
    """
    faults = [_fault(text, robots, period) for text in texts]
    for fault in faults:
        if not fault.seconds < seconds:
            raise wrong_option("fault", fault.text, f"the swarm ends at {seconds:g} s")
    faults.sort(key=lambda fault: fault.seconds)
    _check_order(faults)
    return faults


def _fault(text: str, robots: int, period: int) -> ProcessFault:
    match = FORM.fullmatch(" ".join(text.split()))
    if match is None:
        raise wrong_option("fault", text, f"should be such as {RIGHT}")
    number, unit, action, who, blank = match.groups()
    if action not in ACTIONS:
        raise wrong_option("fault", text, f"{did_you_mean(action, ACTIONS)}should be one of {', '.join(ACTIONS)}")
    if (who is None) != (action in ALONE):
        raise wrong_option(
            "fault", text, f"{action} names {'no robots' if action in ALONE else 'robots, such as 3 or 0-9'}"
        )
    if blank and action != "restart":
        raise wrong_option("fault", text, "blank goes with restart")
    seconds = float(number) * (SECONDS[unit] if unit in SECONDS else period / 1000.0)
    chosen = _robots(who or "", robots, text)
    if action == "partition" and len(chosen) == robots:
        raise wrong_option("fault", text, "these are all robots, and nobody is left to be cut off from")
    return ProcessFault(seconds, action, chosen, bool(blank), text)


def _robots(who: str, robots: int, text: str) -> tuple[int, ...]:
    """The robots that a text such as "0-9,12" names."""
    chosen: set[int] = set()
    for part in filter(None, re.split(r"[, ]+", who)):
        match = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", part)
        if match is None:
            raise wrong_option("fault", text, f"{part} should be a robot or a range of them, such as 0-9")
        first, last = int(match[1]), int(match[2] or match[1])
        if not first <= last < robots:
            order = ", the lower number first" if match[2] else ""
            raise wrong_option("fault", text, f"robot {part} should be from 0 to {robots - 1}{order}")
        chosen.update(range(first, last + 1))
    return tuple(sorted(chosen))


def _check_order(faults: Sequence[ProcessFault]) -> None:
    """Raise InputError for what cannot happen then, such as healing what is whole."""
    gone: dict[int, str] = dict.fromkeys(late_starters(faults), "has not started")
    is_cut = False
    for fault in faults:
        for robot in fault.robots:
            state = gone.get(robot, "runs")
            if state not in POSSIBLE.get(fault.action, (state,)):
                raise wrong_option("fault", fault.text, f"robot {robot} {state} then")
            if fault.action in ("start", "continue", "restart"):
                gone.pop(robot, None)
            elif fault.action in ("kill", "stop"):
                gone[robot] = "is killed" if fault.action == "kill" else "is stopped"
        if fault.action == "heal" and not is_cut:
            raise wrong_option("fault", fault.text, "nothing is parted then")
        is_cut = fault.action == "partition" or (is_cut and fault.action != "heal")


def late_starters(faults: Sequence[ProcessFault]) -> set[int]:
    """The robots that do not start with the others."""
    return {robot for fault in faults if fault.action == "start" for robot in fault.robots}
