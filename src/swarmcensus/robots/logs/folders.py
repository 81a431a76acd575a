"""A folder of robots' logs: who the robots were, which brain each had, and what is known of the recording."""

import functools
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, Field, FiniteFloat, ValidationError

from swarmcensus import brains
from swarmcensus.brains import Brain
from swarmcensus.robots.logs.logs import RobotLog, read_log
from swarmcensus.support.errors import InputError, ResultsError
from swarmcensus.support.files import check_no_log
from swarmcensus.support.plugins import digest, name_what_runs, read_source
from swarmcensus.support.texts import read_text
from swarmcensus.support.toml_types import table_error

ABOUT = "swarm.json"
OWN = "brain.py"
HASH = "sha256"


@dataclass(frozen=True)
class LoggedRobot:
    """One robot: its log, the brain that it ran, and whether it was honest."""

    number: int
    log: RobotLog
    brain: Brain
    honest: bool = True
    is_swarm: bool = True  # whether its brain is that of most robots


@dataclass(frozen=True)
class Recording:
    """All robots of a folder, by their numbers, and what is known of their world."""

    folder: Path
    title: str  # the folder's name
    brain: Brain  # of the honest robots, with its parameters
    members: tuple[LoggedRobot, ...]
    fill_ratio: float | None
    bins: int
    delta: float
    seed: int
    trial: int
    about: Mapping[str, Any]  # the rest of swarm.json
    absent: tuple[str, ...]  # logs that swarm.json names and that are not there, or hold nothing

    @functools.cached_property
    def kinds(self) -> dict[str, list[int]]:
        """The numbers of the honest robots by the labels of their brains."""
        kinds: dict[str, list[int]] = {}
        for member in self.members:
            if member.honest:
                kinds.setdefault(member.brain.label, []).append(member.number)
        return kinds


def read_recording(folder: Path, brain_file: str | Path | None = None, fill_ratio: float | None = None) -> Recording:
    """Read a folder. `brain_file` is the brain of robots whose brain the folder does not hold. Raises InputError."""
    of = Folder(folder, brain_file, fill_ratio)
    logs, absent = [], []
    for name in of.names():
        try:
            logs.append(read_log(folder / name))
        except InputError as error:
            absent.append(str(error))
    if not logs:
        raise ResultsError.of(folder, f"no robot's log can be read: {absent[0]}") if absent else without_logs(folder)
    return of.recording(logs, absent)


class Folder:
    """A folder of logs, before they are read."""

    def __init__(self, path: Path, brain_file: str | Path | None = None, fill_ratio: float | None = None) -> None:
        """Read what swarm.json says. Raises InputError."""
        check_no_log(path)
        if not path.is_dir():
            raise ResultsError.of(path, "should be a folder of robots' logs")
        self.path, self.brain_file = path, brain_file
        self.about = about_of(path)
        self.fill_ratio = self.about.get("fill_ratio") if fill_ratio is None else fill_ratio
        self._entries = {str(entry["log"]): entry for entry in self.about.get("robots", [])}
        brain = self.about.get("brain", {})
        self._own, self._name = str(brain.get("file", OWN)), str(brain.get("name", ""))
        self._values = {k: tuple(v) if isinstance(v, list) else v for k, v in brain.get("parameters", {}).items()}
        self._brains: dict[str, Brain] = {}  # by the names of files and of shipped brains

    def names(self) -> list[str]:
        """The logs that swarm.json names, and others that are there."""
        there = [path.name for path in logs_in(self.path)]
        return list(dict.fromkeys([*self._entries, *there]))

    def recording(self, logs: Sequence[RobotLog], absent: Sequence[str] = ()) -> Recording:
        """The recording of these logs. Raises InputError."""
        numbers = [log.number for log in logs]
        twice = next((number for number in numbers if numbers.count(number) > 1), None)
        if twice is not None:
            raise ResultsError.of(self.path, f"two logs are of robot {twice}: each robot has one")
        members = sorted((self._member(log) for log in logs), key=lambda member: member.number)
        swarm = next((member.brain for member in members if member.is_swarm), members[0].brain)
        about, known = self.about, self.fill_ratio
        return Recording(
            self.path, self.path.resolve().name, swarm, tuple(members),
            None if known is None else float(known), int(about.get("bins", 10)), float(about.get("delta", 0.01)),
            int(about.get("seed", 0)), int(about.get("trial", 0)), about, tuple(absent),
        )  # fmt: skip

    def _member(self, log: RobotLog) -> LoggedRobot:
        entry = self._entries.get(log.path.name, {})
        of_swarm = str(entry.get("brain", self._own)) == self._own
        brain = self._of_swarm(log) if of_swarm else self._of_file(str(entry["brain"]))
        return LoggedRobot(log.number, log, brain, bool(entry.get("honest", True)), of_swarm)

    def _of_swarm(self, log: RobotLog) -> Brain:
        """The brain of the honest robots: a file that is given, the folder's, or the shipped one that the log names."""
        if self.brain_file is None and (self.path / self._own).is_file():
            return self._of_file(self._own)
        if self.brain_file is not None:
            name, which = OWN, self.brain_file
        else:
            mark = log.states[0].brain.hex()
            name = which = _shipped_with(mark) or ""
            if not name:
                raise ResultsError.of(
                    log.path,
                    f"the robot's brain has a hash that begins with {mark}, and no shipped brain has it: "
                    f"put its file into the folder as {OWN}, or name it with --brain-file",
                )
        if name not in self._brains:
            self._brains[name] = self._with_values(brains.load(which))
        return self._brains[name]

    def _of_file(self, name: str) -> Brain:
        """The brain in a file of the folder."""
        if name not in self._brains:
            path = self.path / name
            source = read_source("brain", path)
            shipped = _shipped_with(digest(source))
            if shipped is None:
                name_what_runs("brain", path)
            own = self._name if name == self._own else ""
            label = own or shipped or (Path(name).stem if name == OWN else name)
            brain = brains.parse(source, label, path)
            self._brains[name] = self._with_values(brain) if name == self._own else brain
        return self._brains[name]

    def _with_values(self, brain: Brain) -> Brain:
        try:
            return brain.with_parameters(self._values)
        except ValueError:  # another brain was given: its own values are right for it
            return brain


def logs_in(folder: Path) -> list[Path]:
    """The logs in a folder, by name; none if it is no folder."""
    files = folder.iterdir() if folder.is_dir() else ()
    return sorted(path for path in files if path.suffix.lower() == ".log" and path.is_file())


def without_logs(folder: Path) -> ResultsError:
    """The error of a folder that holds no log."""
    return ResultsError.of(folder, "it holds no log: should be a folder with files such as robot-0.log")


def _shipped_with(mark: str) -> str | None:
    """The name of the shipped brain with a hash that begins with `mark`."""
    hashes = {name: digest(read_source("brain", brains.find(name))) for name in brains.shipped()}
    return next((name for name, whole in hashes.items() if whole.startswith(mark)), None)


def hash_of(about: Mapping[str, Any]) -> str:
    """The hash of what swarm.json says, which its writer adds."""
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()


def about_of(folder: Path) -> dict[str, Any]:
    """The content of a folder's swarm.json; empty if there is none. Raises InputError."""
    path = folder / ABOUT
    if not path.exists():
        return {}
    try:
        content = json.loads(read_text(path, kind=ResultsError, most=None))
        _About.model_validate(content)
    except ValidationError as error:
        raise table_error(error, str(path), _About, content) from None
    except (ValueError, RecursionError) as error:
        raise ResultsError.of(path, f"cannot be read as JSON: {error}") from None
    if content.pop(HASH, None) not in (None, hash_of(content)):
        raise ResultsError.of(path, f"damaged or edited since it was written; without {HASH!r} it is taken as it is")
    return content  # type: ignore[no-any-return]


def _in_folder(name: str) -> str:
    """A name that does not lead out of the folder. Raises ValueError."""
    if not re.fullmatch(r"[^/\\\0]+", name) or name in (".", ".."):
        raise ValueError("should be the name of a file in the folder")
    return name


Name = Annotated[str, AfterValidator(_in_folder)]


Moment = Annotated[float, Field(ge=0.0, lt=2.0**53)]  # ms since 1970


class _AboutRobot(BaseModel, strict=True):
    log: Name
    number: int | None = None
    brain: Name = OWN


class _AboutBrain(BaseModel, strict=True):
    file: Name = OWN
    parameters: dict[str, Any] = {}


class _About(BaseModel, strict=True):
    """What is used of swarm.json."""

    format: Literal[1]
    robots: list[_AboutRobot] = []
    brain: _AboutBrain = _AboutBrain()
    fill_ratio: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    delta: FiniteFloat = 0.01
    bins: int = 10
    seed: int = 0
    trial: int = 0
    setting: int = 0
    started: Moment | None = None
    ended: Moment | None = None
