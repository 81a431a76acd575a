"""A folder of robots' logs as what a page may show: the day as it was, and the same day under another brain."""

import threading
from dataclasses import replace
from pathlib import Path

from swarmcensus import brains
from swarmcensus.basics.errors import InputError
from swarmcensus.brains import Brain
from swarmcensus.brains.packing import Numbers
from swarmcensus.reliving.clocks import Clock
from swarmcensus.reliving.folders import ABOUT, OWN, Day, read_day
from swarmcensus.reliving.lives import relive_all
from swarmcensus.reliving.minds import format_of
from swarmcensus.reliving.others import OtherDay, under
from swarmcensus.reliving.traces import MOST_VALUES, as_logged
from swarmcensus.simulation.inputs import inputs_of
from swarmcensus.studies.settings import Setting
from swarmcensus.studies.study import Study
from swarmcensus.watching.logged import Logged


class LoggedDay:
    """A day, the study and the setting that it was of, and its minds, which were lived again."""

    def __init__(self, folder: Path, given: tuple[Path, ...] = ()) -> None:
        """Read a folder; `given` are other brains. Raises InputError."""
        self.day = read_day(folder)
        self.study = study_of(self.day)
        planned = setting_of(self.day, self.study)
        self.clock = Clock(self.day.members)
        rounds = max(self.clock.rounds, 1)
        if rounds * planned.robots > MOST_VALUES:
            raise InputError(f"{folder}: its logs span {rounds:,} ticks, too many to keep: is one damaged?")
        self.planned_rounds = planned.rounds
        self.setting = replace(planned, rounds=rounds)
        strangers = [member.number for member in self.day.members if member.number >= planned.robots]
        if strangers:
            raise InputError(
                f"{folder}: a log is of robot {strangers[0]}, and the {planned.robots} robots of its study are "
                f"numbered from 0"
            )
        self.brains = {brain.label: brain for brain in (self._other(path) for path in given)}
        self.lives = relive_all(self.day, keep=True)
        self._lived = {self.setting.brain: as_logged(self.day, self.lives)}
        self._lock = threading.Lock()  # two pages wait for one life of the day, and do not live it twice

    def life(self, setting: Setting, seed: int, trial: int) -> Logged:
        """The day under the brain of a setting. Raises InputError if that brain cannot live it."""
        # networks and sensors are those of the study, however long the logs are
        given = inputs_of(replace(setting, rounds=self.planned_rounds), seed, trial)
        return Logged(setting, given, self.day, self.under(setting.brain), self.clock)

    def under(self, brain: Brain) -> OtherDay:
        """What robots believed, remembered and said under a brain. Raises InputError if it cannot live the day."""
        with self._lock:
            if brain not in self._lived:
                self._lived[brain] = under(self.day, brain, clock=self.clock, keep=True)
            return self._lived[brain]

    def _other(self, path: Path) -> Brain:
        brain = brains.load(path)
        if brain.name == self.day.brain.name and brain.sha256 != self.day.brain.sha256:
            brain = replace(brain, name=f"{brain.name} (--brain)")
        return brain


def study_of(day: Day) -> Study:
    """The study that a day was of, with the brain as its folder has it. Raises InputError."""
    text = day.about.get("study")
    if not isinstance(text, str):
        raise InputError(
            f"{day.folder}: watch needs {ABOUT} with the study of the day, as swarmcensus swarm writes it; "
            f"`swarmcensus relive` needs only logs"
        )
    own = day.brain.as_written
    named = day.about.get("brain", {}).get("file", OWN)
    known = {own.name: own, str(named): own}
    where = f"{day.folder / ABOUT}: study"
    return Study.parse(text, where=where, context={"base": None, "brains": known, "kept": True})


def setting_of(day: Day, study: Study) -> Setting:
    """The setting of the day, with the number formats of its logs. Raises InputError."""
    number, settings = day.about.get("setting", 0), study.settings()
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < len(settings):
        raise InputError(f"{day.folder / ABOUT}: setting = {number!r}: should be from 0 to {len(settings) - 1}")
    setting, first = settings[number], day.members[0].log.states[0]
    if setting.body is not None:
        raise InputError(f"{day.folder / ABOUT}: study: its robots move, and logs do not say where they were")
    numbers = Numbers("single" if first.single else "double", format_of(day.brain, first), first.feedback)
    return replace(setting, brain=setting.brain.with_numbers(numbers))
