"""What happens to robots of a swarm while it runs: the `[[faults]]` of its study, as events in the order of time."""

from collections.abc import Sequence
from typing import NamedTuple

from swarmcensus.studies import Setting
from swarmcensus.support.errors import StudyError

UNTIL = {"kill": "start", "stop": "continue", "cut": "join", "mute": "speak"}  # what ends an event
HOLDS = {"kill": "process", "restart": "process", "stop": "process", "mute": "radio"}  # what a fault has of a robot
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
    """The events of a trial, in the order of time.

    A fault does nothing to robots that an earlier one has killed or stopped, until that one ends. Raises StudyError if
    all robots would be cut off.
    """
    begins, ends = [], []
    for n, fault in enumerate(setting.faults):
        robots = tuple(sorted(fault.failing(n, seed, trial, setting.robots).tolist()))
        if fault.do == "cut" and len(robots) == setting.robots:
            why = "these are all robots: nobody is left to be cut off from"
            raise StudyError.at(f"faults[{n}].robots", setting.robots, why)
        for what in [fault.do] if fault.do else ["mute"] * ("talking" in fault.stop):
            begins.append(Event(fault.at, what, robots, fault.blank, n))
            if fault.until is not None:
                ends.append(Event(fault.until, UNTIL[what], robots, fault.blank, n))
    events, holder = [], dict[tuple[str, int], int]()  # which fault holds a robot's process or radio
    for event in sorted([*ends, *begins], key=lambda event: event.round):  # what ends in a round does so first
        begin = next((what for what, end in UNTIL.items() if end == event.what), event.what)
        held = HOLDS.get(begin)
        if held and begin == event.what:
            robots = tuple(robot for robot in event.robots if (held, robot) not in holder)
            if begin != "restart":
                holder |= {(held, robot): event.fault for robot in robots}
        elif held:
            robots = tuple(robot for robot in event.robots if holder.get((held, robot)) == event.fault)
            for robot in robots:
                del holder[held, robot]
        else:
            robots = event.robots
        if robots:
            events.append(event._replace(robots=robots))
    return events


def late_starters(events: Sequence[Event]) -> set[int]:
    """The robots that do not start with the others."""
    return {robot for event in events if (event.round, event.what) == (1, "kill") for robot in event.robots}
