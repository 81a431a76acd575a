"""A folder of robots' logs as a page shows it."""

import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

from swarmcensus.brains import Numbers
from swarmcensus.robots import (
    ABOUT,
    OWN,
    Clock,
    GrowingRecording,
    Logged,
    Recording,
    format_of,
    may_grow,
    read_recording,
    relive_all,
)
from swarmcensus.studies import Setting, Study
from swarmcensus.support.errors import InputError

NEXT = 0.1  # seconds from one look at growing logs to the next
LATER = 1.0  # the same while no robot is at work
LAST = 3  # the last rounds of a recording: robots with a tick in them were at work at its end


class LoggedRecording:
    """A recording, its study and setting, and the states of its robots, computed again; logs may still grow."""

    def __init__(self, folder: Path) -> None:
        """Read a folder. Raises InputError."""
        self._growing = GrowingRecording(folder) if may_grow(folder) else None
        while self._growing is not None and self._growing.is_behind:
            self._growing.go_on()
        known = self._growing
        self.recording = known.recording if known else read_recording(folder)
        self.clock = known.clock if known else Clock(self.recording.members)
        self.study = study_of(self.recording)
        self.setting = setting_of(self.recording, self.study)
        self._check()
        self.lives = known.lives if known else relive_all(self.recording, keep=True)
        self.trace = Logged(self.recording, self.lives, self.clock, self.setting, self._at_work())
        self._lock = threading.Lock()  # so that two pages do not read the same blocks twice

    @property
    def rounds(self) -> int:
        """The number of rounds in the logs."""
        return max(self.clock.rounds, 1)

    @property
    def grows(self) -> bool:
        """Whether the swarm that writes the logs still runs."""
        return self.may_grow and bool(self._at_work())

    @property
    def may_grow(self) -> bool:
        """Whether the swarm has not ended."""
        return self._growing is not None

    def news(self, since: int) -> dict[str, Any]:
        """Follow the logs; returns what is new for a page that has the version `since`.

        That is the version, the first round that has `changed`, how many `rounds` there are, and seconds to `wait`
        until the page should ask again; None: nothing more comes. Raises InputError.
        """
        with self._lock:
            if self._growing is not None:
                self._follow(self._growing)
            wait = None
            if self._growing is not None:
                wait = 0.0 if self._growing.is_behind else NEXT if self.grows else LATER
            changed = self.trace.since(since)
            return {"version": self.trace.version, "changed": changed, "rounds": self.trace.rounds, "wait": wait}

    def _follow(self, growing: GrowingRecording) -> None:
        """Take what a running swarm has appended to its logs."""
        new = growing.go_on()
        self.recording, self.lives = growing.recording, growing.lives
        self._check()
        if growing.has_ended:
            self._growing = None
        self.trace.grow(self.recording, self.lives, new, growing.moved, self._at_work())

    def _at_work(self) -> frozenset[int]:
        """The robots at work now, or at the end: they believe what their last ticks led to."""
        return self._growing.at_work() if self._growing is not None else at_the_end(self.recording, self.clock)

    def _check(self) -> None:
        """Raise InputError if logs do not fit their study."""
        folder, robots = self.recording.folder, self.setting.robots
        strangers = [member.number for member in self.recording.members if member.number >= robots]
        if strangers:
            numbered = f"the {robots} robots of its study are numbered from 0"
            raise InputError.of(folder, f"a log is of robot {strangers[0]}, and {numbered}")


def at_the_end(recording: Recording, clock: Clock) -> frozenset[int]:
    """The robots at work when a recording ended: by swarm.json, or else those with a tick in its last rounds."""
    result = recording.about.get("result")
    estimates = result.get("estimates") if isinstance(result, dict) else None
    if isinstance(estimates, list):
        return frozenset(number for number, estimate in enumerate(estimates) if estimate is not None)
    return frozenset(m.number for m in recording.members if clock.last(m.number) > clock.rounds - LAST)


def study_of(recording: Recording) -> Study:
    """The study that a recording was of, with the brain as its folder has it. Raises InputError."""
    text = recording.about.get("study")
    if not isinstance(text, str):
        needs = f"watch needs {ABOUT} with the study of the recording, as swarmcensus swarm writes it"
        raise InputError.of(recording.folder, f"{needs}; `swarmcensus relive` needs only logs")
    own = recording.brain.as_written
    named = recording.about.get("brain", {}).get("file", OWN)
    known = {own.name: own, str(named): own}
    where = f"{recording.folder / ABOUT}: study"
    return Study.parse(text, where=where, context={"base": None, "brains": known, "kept": True})


def setting_of(recording: Recording, study: Study) -> Setting:
    """The setting of the recording, with the number formats of its logs; its fill ratio is NaN where nobody knows it.

    Raises InputError.
    """
    number, settings = recording.about.get("setting", 0), study.settings()
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < len(settings):
        should = f"setting = {number!r}: should be from 0 to {len(settings) - 1}"
        raise InputError.of(recording.folder / ABOUT, should, key="setting", value=number)
    setting, first = settings[number], recording.members[0].log.states[0]
    if setting.body is not None:
        raise InputError.of(recording.folder / ABOUT, "study: its robots move, and logs do not say where they were")
    numbers = Numbers("single" if first.single else "double", format_of(recording.brain, first), first.feedback)
    truth = setting.fill_ratio if recording.fill_ratio is not None else float("nan")
    return replace(setting, brain=setting.brain.with_numbers(numbers), fill_ratio=truth)
