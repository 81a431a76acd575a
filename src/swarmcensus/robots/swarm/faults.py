"""What happens to robots of a swarm while it runs: the `[[faults]]` of its study, as events in the order of time."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from swarmcensus.studies import Setting
from swarmcensus.support.errors import StudyError

UNTIL = {"kill": "start", "stop": "continue", "cut": "join", "mute": "speak"}  # what ends an event
POSSIBLE = {  # events, and what a robot may do then
    "start": ("is killed",),
    "continue": ("is stopped",),
    "restart": ("runs", "is killed", "is stopped"),
    "kill": ("runs", "is stopped"),
    "stop": ("runs",),
}
AFTER = {"kill": "is killed", "stop": "is stopped"}  # what a robot does after an event; after others it runs
WORDS = {"cut": "cut off", "join": "rejoin", "mute": "silence", "speak": "let talk"}  # others say what they are
MOST_NAMED = 8  # robots in a message


class Event(NamedTuple):
    """Something that happens to robots."""

    round: int  # from 1; in the first, a robot that is killed does not start
    what: str  # what is done to them
    robots: tuple[int, ...]
    blank: bool  # whether a robot that starts has lost its memory
    fault: int  # the number of its table

    def __str__(self) -> str:
        """In words: "kill robots 3, 5"."""
        names = ", ".join(map(str, self.robots[:MOST_NAMED]))
        more = f" and {len(self.robots) - MOST_NAMED} more" * (len(self.robots) > MOST_NAMED)
        return f"{WORDS.get(self.what, self.what)} robot{'s' * (len(self.robots) > 1)} {names}{more}"


def events_of(setting: Setting, seed: int, trial: int) -> list[Event]:
    """The events of a trial, in the order of time. Raises StudyError for what cannot happen, as to a killed robot."""
    events = []
    for n, fault in enumerate(setting.faults):
        robots = tuple(sorted(fault.failing(n, seed, trial, setting.robots).tolist()))
        if fault.do == "cut" and len(robots) == setting.robots:
            why = "these are all robots: nobody is left to be cut off from"
            raise StudyError.at(f"faults[{n}].robots", setting.robots, why)
        for what in [fault.do] if fault.do else ["mute"] * ("talking" in fault.stop):
            events.append(Event(fault.at, what, robots, fault.blank, n))
            if fault.until is not None:
                events.append(Event(fault.until, UNTIL[what], robots, fault.blank, n))
    events.sort(key=lambda event: event.round)
    _check_order(events)
    return events


def _check_order(events: Iterable[Event]) -> None:
    states: dict[int, str] = {}
    for event in events:
        for robot in event.robots if event.what in POSSIBLE else ():
            state = states.get(robot, "runs")
            if state not in POSSIBLE[event.what]:
                end = "until" if event.what in UNTIL.values() else "at"
                why = f"robot {robot} {state} then: nobody can {event.what} it"
                raise StudyError.at(f"faults[{event.fault}].{end}", event.round, why)
            states[robot] = AFTER.get(event.what, "runs")


def late_starters(events: Sequence[Event]) -> set[int]:
    """The robots that do not start with the others."""
    return {robot for event in events if (event.round, event.what) == (1, "kill") for robot in event.robots}
