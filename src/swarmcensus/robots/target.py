"""What is to be put onto a robot, checked: a brain, its sensor's accuracies, a target and a message format."""

import hashlib
import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path
from typing import Any

from swarmcensus.brains import FORMATS, Brain, Numbers, Value, rounded_to_single
from swarmcensus.robots.format_errors import least_wrong
from swarmcensus.runtime import log as written
from swarmcensus.runtime.reports import GATEWAY, OWN, USB
from swarmcensus.runtime.runtime import CHECKSUM, HEADER
from swarmcensus.studies import Setting, Study
from swarmcensus.support.errors import BrainError, OptionError, StudyError
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import option, option_conflict, wrong_option
from swarmcensus.translation import piece
from swarmcensus.worlds import parse_accuracy

SENT = FORMATS[1:]  # all but "double", which is a simulation's
HIGHEST_HZ = 1000.0
LOWEST_HZ = 0.001
USUAL_HZ = 10.0
ADDRESS = "an address"
FILL_IN = "FILL_IN"  # an accuracy that C does not compile with: it is not known before the calibration
WATCHERS = 47231  # the port of those who watch


@dataclass(frozen=True)
class Target:
    """What a brain's files are for: a kind of board with its radio, or a language.

    A target is a file in `robots/targets`, or of another package in the group `swarmcensus.targets`, which has a
    constant `TARGET`.
    """

    what: str  # in sentences: "UDP", "a Kilobot's infrared"
    files: "Callable[[Order], dict[str, str]]"  # the texts of all files by name
    largest: int | None = None  # bytes of a datagram; None where others make the datagrams
    numbers: range = range(0x10000)  # that a robot may have
    checked: bool = True  # whether a datagram carries our checksum
    precisions: tuple[str, ...] = ()  # of numbers, the usual one first; none where the board decides
    refuses: Mapping[str, str] = field(default_factory=dict)  # options that mean nothing here, and why
    may_replace: tuple[str, ...] = ()  # patterns of names of files that the folder may hold already
    adds: bool = False  # whether the folder may hold any other files: those of the same names have to be the same
    takes_study: bool = False  # whether the files have a study's arena
    flash: str = ""  # a command of a shell that puts robot $1 onto its board, at the port $2 or the address $3
    fetch: str = ""  # one that gets its log as logs/robot-$1.log
    reports: tuple[str, ...] = ()  # links to those who watch: ADDRESS, GATEWAY, USB
    counts: Mapping[str, str] = field(default_factory=dict)  # files of a program that counts readings, and its pieces
    moves: bool = True  # whether the program moves the robot, as a brain that steers asks
    measure: "Callable[[Order, Mapping[str, str]], tuple[int | None, int | None]]" = lambda *_: (None, None)  # of flash
    # and RAM, in bytes. Raises InputError if there is too little


@dataclass(frozen=True)
class Order:
    """A robot to be made. `b` and `w` are None where the target does not need them, or the study says them."""

    brain: Brain  # with its number formats
    target: Target
    name: str  # of the target
    b: float | None
    w: float | None
    hz: float
    robot: int | None  # its number; None takes the chip's
    log: int | None = None  # bytes of the robot's log at the most; None: it keeps none
    setting: Setting | None = None  # of the arena: one of a study
    seed: int = 0  # of the study
    where: str = "study"  # the study's file, for messages
    folder: Path = Path()  # where the files will be
    report: tuple[str, int] | str | None = None  # where those who watch are; None: nobody does
    calibrate: bool = False  # whether it counts readings first; b and w may be unknown then

    @property
    def period(self) -> int:
        """Milliseconds a tick."""
        return max(1, round(1000.0 / self.hz))

    @property
    def datagram_bytes(self) -> int | None:
        """The size of a datagram; None where others make it."""
        return None if self.target.largest is None else datagram_bytes(self.brain, self.target.checked)

    @property
    def mark(self) -> int:
        """32 bits that another brain or format hardly has too."""
        return mark_of(self.brain)

    @property
    def counting(self) -> dict[str, str]:
        """The texts of the program that counts readings for a calibration, by the names of files; none if not asked."""
        return {name: piece(source) for name, source in self.target.counts.items()} if self.calibrate else {}


def order_of(
    brain: Brain, name: str, target: Target, *, accuracy: Any = None,
    message: str | None = None, precision: str | None = None, hz: float | None = None,
    parameters: Mapping[str, Any] | None = None, robot: int | None = None, log: int | None = None,
    study: Study | None = None, where: str = "study", calibrate: bool = False,
    report: str | None = None,
) -> Order:  # fmt: skip
    """Check what is asked of a target, and add what the study says, and what is usual. Raises InputError."""
    asked: dict[str, Any] = {"accuracy": accuracy, "precision": precision, "hz": hz, "robot": robot, "log": log}
    for key, why in target.refuses.items():
        if asked[key] is not None:
            raise option_conflict(key, asked[key], f"does not go with {option('target', name)}: {why}")
    for key in ("hz", "robot", "log"):
        if asked[key] is not None and not isinstance(asked[key], Real):
            raise wrong_option(key, asked[key], "should be a number")
    if study is not None and not target.takes_study:
        raise option_conflict("study", study.name, f"does not go with {option('target', name)}: it has no arena")
    setting = None if study is None else setting_of(study, brain, where)
    feedback, values = True, dict(parameters or {})
    if setting is not None:
        numbers = setting.brain.numbers
        message = message or (numbers.message if numbers.message in SENT else None)
        precision, feedback = precision or numbers.precision, numbers.feedback
        values = (dict(setting.brain.overrides) if setting.brain.sha256 == brain.sha256 else {}) | values
    message = message or least_wrong(brain, fitting(brain, target))
    if message not in SENT:
        raise wrong_option("message", message, f"{did_you_mean(str(message), SENT)}should be one of {', '.join(SENT)}")
    if precision is not None and precision not in target.precisions:
        raise wrong_option("precision", precision, f"{target.what} has {' or '.join(target.precisions)}")
    b, w = _sides(accuracy) if accuracy is not None else (None, None)
    if calibrate and not target.counts:
        raise option_conflict("calibrate", None, f"does not go with {option('target', name)}: it has no such program")
    is_link = report in (GATEWAY, USB)
    if report is not None and (report if is_link else ADDRESS) not in target.reports:
        links = " or ".join(target.reports) or "nobody"
        raise option_conflict("report", report, f"does not go with {option('target', name)}: it reports to {links}")
    if b is None and study is None and "accuracy" not in target.refuses and not calibrate:
        raise OptionError(
            f"{option('accuracy')} is missing: how often the sensor is right, such as 0.9", key="accuracy"
        )
    hz = USUAL_HZ if hz is None else float(hz)
    check_hz(hz)
    if robot is not None and robot not in target.numbers:
        raise wrong_option("robot", robot, f"should be from {target.numbers[0]} to {target.numbers[-1]}")
    check_is_no_bound(brain)
    precision = precision or next(iter(target.precisions), "double")
    try:
        brain = brain.with_parameters(values).with_numbers(Numbers(precision, message, feedback))  # type: ignore[arg-type]
    except ValueError as error:
        raise OptionError(f"{option('parameters')}: {error}", key="parameters") from None
    _check_size(brain, target)
    brain = replace(brain, name=Path(brain.name).name)  # the robot's files lie elsewhere
    seed = 0 if study is None else study.seed
    where_to = watcher_of(report) if report and not is_link else report
    return Order(brain, target, name, b, w, hz, robot, log, setting, seed, where, Path(), where_to, calibrate)


def watcher_of(text: str, name: str = "report") -> tuple[str, int]:
    """The address and port of those who watch, as 192.168.1.2 or 192.168.1.2:47231. Raises InputError."""
    host, _, port = text.partition(":")
    if (
        not re.fullmatch(r"[\w.-]+", host)
        or not (port or str(WATCHERS)).isdigit()
        or not 0 < int(port or WATCHERS) <= 0xFFFF
    ):
        raise wrong_option(name, text, f"should be an address, such as 192.168.1.2 or 192.168.1.2:{WATCHERS}")
    return host, int(port or WATCHERS)


def report_bytes(brain: Brain, heard: int = 0) -> int:
    """The size of a tick's report with so many messages heard."""
    own = OWN + 7 + sum(map(struct.calcsize, (written.OPENING, written.ENDING))) + brain.message_bytes
    return own + heard * (struct.calcsize(written.FROM) + brain.message_bytes)


def _sides(accuracy: Any) -> tuple[float, float]:
    """b and w of the robot's sensor. Raises InputError."""
    try:
        parsed = parse_accuracy(accuracy)
        sides = parsed.side("black"), parsed.side("white")
    except ValueError as error:
        raise wrong_option("accuracy", accuracy, error) from None
    if parsed.is_blind:
        raise wrong_option("accuracy", accuracy, "such a sensor says the same of black and white")
    return sides


def setting_of(study: Study, brain: Brain, where: str) -> Setting:
    """The study's first setting with this brain, or of all if it names no brain. Raises InputError."""
    settings = study.settings()
    own = next((setting for setting in settings if setting.brain.sha256 == brain.sha256), None)
    if own is None and "brain" in study.swarm.model_fields_set:
        names = ", ".join(dict.fromkeys(setting.brain.name for setting in settings))
        what = f"swarm.brain = {names}: should have the brain that is deployed, {brain.name}"
        raise StudyError.within(where, what, "swarm.brain", names)
    return own or settings[0]


def check_hz(hz: float, highest: float = HIGHEST_HZ) -> None:
    """Raise InputError unless a robot can make so many ticks a second."""
    if not LOWEST_HZ <= hz <= highest:
        raise wrong_option("hz", hz, f"should be ticks a second, from {LOWEST_HZ:g} to {highest:g}")


def check_is_no_bound(brain: Brain) -> None:
    """Raise InputError for a brain that no robot can run."""
    if brain.is_oracle:
        raise BrainError(
            f"the brain {brain.name!r} is a bound: no robot hears all others and knows every sensor",
            key="brain", value=brain.name
        )  # fmt: skip


def _check_size(brain: Brain, target: Target) -> None:
    """Raise InputError if a brain's datagrams are too large for a target."""
    size = datagram_bytes(brain, target.checked)
    if target.largest is not None and size > target.largest:
        sizes = [f"{option('message', format_)} makes {bytes_}" for format_, bytes_ in fitting(brain, target).items()]
        raise BrainError(
            f"the brain {brain.name!r} sends datagrams of {size} bytes as {brain.numbers.message}, a header of "
            f"{HEADER} with them, and {target.what} holds {target.largest}: "
            f"{' and '.join(sizes) or 'no format makes it small enough'}",
            key="message", value=brain.numbers.message
        )  # fmt: skip


def in_single(values: Mapping[str, Value]) -> dict[str, Value]:
    """Values of parameters by name, numbers or vectors, as a robot has them in single precision."""
    return {
        name: tuple(map(rounded_to_single, value)) if isinstance(value, tuple) else rounded_to_single(value)
        for name, value in values.items()
    }


def mark_of(brain: Brain) -> int:
    """32 bits of a brain and its message format, which datagrams begin with."""
    return int(hashlib.sha256(f"{brain.sha256} {brain.numbers.message}".encode()).hexdigest()[:8], 16)


def datagram_bytes(brain: Brain, checked: bool = True) -> int:
    """The size of a brain's datagrams, with our checksum or without."""
    return HEADER + brain.message_bytes + (CHECKSUM if checked else 0)


def fitting(brain: Brain, target: Target) -> dict[str, int]:
    """The message formats in which a brain's datagrams fit a target, and their sizes."""
    sizes = {one: datagram_bytes(brain.with_numbers(Numbers(message=one)), target.checked) for one in SENT}  # type: ignore[arg-type]
    return {one: size for one, size in sizes.items() if target.largest is None or size <= target.largest}
