"""The parser, which suggests what was probably meant, the types of option values, and options of several commands."""

import argparse
import math
import re
import shlex
from collections.abc import Callable, Sequence
from enum import Enum
from pathlib import Path
from typing import Any, NamedTuple, NoReturn, TypeVar

from swarmcensus.support.errors import OptionError
from swarmcensus.support.hints import did_you_mean

T = TypeVar("T")
FORMATS = ("float32", "float16", "ratio16", "ratio8")  # of messages that have bytes
DIGITS = 18  # of a number, so that it fits into 64 bits


class Group(Enum):
    """What a command is about, with the title under which the help lists it."""

    STUDIES = "studies"
    BRAINS = "brains"
    MISSIONS = "missions"
    ROBOTS = "robots"
    LOOK = "to look at"
    SETUP = "setup"


def no_options(_: argparse.ArgumentParser) -> None:
    """Add no options."""


class Command(NamedTuple):
    """A command: its name, a line of help, its group and place there, what runs it, and what adds its options.

    `json` is whether it has --json, and `table` whether its answer is a table, which a pipe gets tab-separated.
    """

    name: str
    text: str
    group: Group
    place: int
    run: Callable[[argparse.Namespace], int]
    add_options: Callable[[argparse.ArgumentParser], None] = no_options
    json: bool = True
    table: bool = False


class UsageError(OptionError):
    """Arguments that the parser refuses; `program` is the command that they were given to, "swarmcensus run"."""

    def __init__(self, message: str, program: str = "swarmcensus", **fields: Any) -> None:
        """Keep the command too."""
        super().__init__(message, **fields)
        self.program = program


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one sentence, and suggest what was probably meant."""

    def __init__(self, *arguments: Any, **more: Any) -> None:
        """Refuse shortened options: a later option could change their meaning."""
        super().__init__(*arguments, **{"allow_abbrev": False, **more})
        for name in (None, "store"):
            self.register("action", name, _Once)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Refuse unknown arguments here, because this command's options are known and one can be suggested."""
        self.given = [argument for argument in args or [] if argument.startswith("--")]
        self.stored: set[str] = set()  # options with a value that were met already
        parsed, rest = super().parse_known_args(args, namespace)
        if len(rest) == 1 and not rest[0].startswith("-"):  # an optional argument that stands behind options
            late = [
                a for a in self._positionals._group_actions if a.nargs == "?" and getattr(parsed, a.dest) is a.default
            ]
            if late:
                setattr(parsed, late[0].dest, self._get_values(late[0], rest))
                rest = []
        if rest:
            unknown = next((argument for argument in rest if argument.startswith("-")), rest[0])
            name = unknown.partition("=")[0]
            if name in self._option_string_actions:
                self.error(f"{_shown(name)} stands after --, where only names of files do: options come before it")
            hint = did_you_mean(name, (o for o in self._option_string_actions if o.startswith("--")))
            what = "is no option of this command" if unknown.startswith("-") else "is an argument too many"
            if not unknown.startswith("-") and "--show" in self._option_string_actions:
                wanted = "--check" if unknown.endswith(".py") else "--show"
                hint = f"did you mean '{self.prog} {wanted} {_shown(unknown)}'?"
            self.error(f"{_shown(name)} {what}: {hint or self._help()}")
        return parsed, rest

    def error(self, message: str) -> NoReturn:
        """Print argparse's message as one sentence that names the option, its value and what is right."""
        for said, ours in WORDS:
            message = re.sub(said, ours, message)
        if message.endswith(MISSING):
            what, several = message.removesuffix(f" {MISSING}").split(", "), "are missing"
            if len(what) > 1 and not what[0].startswith("one of "):
                message = f"{', '.join(what[:-1])} and {what[-1]} {several}"
            options = [option for option in self._option_string_actions if option.startswith("--")]
            names = (argument.partition("=")[0] for argument in self.given)
            unknown = (name for name in names if name not in options)
            hint = next(filter(None, (did_you_mean(name, options) for name in unknown)), "")
            message = f"{message}: {hint or self._help()}"
        message = " ".join(message.split())
        option = OPTION.match(message)
        raise UsageError(
            message, key=option and option[1].replace("-", "_"), value=option and option[2], program=self.prog
        )

    def _help(self) -> str:
        return f"'{self.prog} --help' shows what there is"

    def _get_value(self, action: argparse.Action, text: str) -> Any:
        """Name a value of a wrong type in its error."""
        try:
            return super()._get_value(action, text)  # type: ignore[misc]
        except argparse.ArgumentError as error:
            right = "a whole number" if action.type is int else "a number" if action.type is float else ""
            what = f"should be {right}" if right else error.message
            raise argparse.ArgumentError(action, f"{_shown(text)}: {what}") from None

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """List the choices, and suggest the one that was probably meant."""
        if action.choices is not None and value not in action.choices:
            choices = [str(choice) for choice in action.choices]
            right = " or ".join(filter(None, (", ".join(choices[:-1]), choices[-1])))
            known = MEANT.get(value, "") if action.metavar == "COMMAND" else ""
            hint = f"did you mean {known!r}? " if known else did_you_mean(str(value), choices)
            text = f"{_shown(value)}: {hint}should be {right}"
            raise argparse.ArgumentError(action, text)


class _Once(argparse._StoreAction):
    """Stores what an option holds, and refuses a second one: of two, argparse would silently take the last."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        if option_string and self.dest in parser.stored:
            name = self.metavar
            right = f": join conditions, as in {name} and {name}" if name == "EXPR" else ""
            right = f": name all behind one, as in {option_string} {name} {name}" if self.nargs else right
            raise argparse.ArgumentError(self, f"is given twice{right or ', and holds one value'}")
        if option_string:
            parser.stored.add(self.dest)
        super().__call__(parser, namespace, values, option_string)


MISSING = "is missing"
MEANT = {"studies": "list studies", "completion": "doctor --completion", "translate": "deploy"}  # no commands
OPTION = re.compile(r"--([a-z-]+)(?: (\S+):)?")  # the beginning of a message about an option, with or without its value
WORDS = (  # argparse's wording, and ours
    (r"(?s)^argument ([^:]*/)?([^:]+): not allowed with argument ([^:]*/)?(.+)$", r"\2 does not go with \4"),
    (r"(?s)^argument ([^:]*/)?([^:]+): ignored explicit argument (.*)$", r"\2 takes no value, but has \3"),
    (r"(?s)^argument ([^:]*/)?([^:]+): expected (at least )?one argument$", r"\2: a value is missing after it"),
    (r"(?s)^argument ([^:]*/)?(?:\S+\|\S+: |([^:]+): )", r"\2 "),
    (r"(?s)^the following arguments are required: (.+)$", rf"\1 {MISSING}"),
    (r"(?s)^one of the arguments (.+) is required$", rf"one of \1: {MISSING}"),
)


def _shown(text: object) -> str:
    """A value as it would be typed; a long one is cut."""
    return shlex.quote(str(text)[:40])


def add_output_options(sub: argparse.ArgumentParser, json: bool, table: bool) -> None:
    """Add --quiet and --verbose, and --json if the command prints an answer.

    `table` is whether the answer is a table, which is tab-separated in a file or a pipe.
    """
    sub.set_defaults(json=False, table=table)
    text = "in a file or a pipe the table is tab-separated columns with all digits"
    group = sub.add_argument_group("output", text if table else None)
    if json:
        group.add_argument("--json", action="store_true", help="print one JSON document on stdout, and nothing else")
    volume = group.add_mutually_exclusive_group()
    volume.add_argument("-q", "--quiet", action="store_true", help="print only answers and errors")
    volume.add_argument("-v", "--verbose", action="store_true", help="also report each step on stderr")


def width(text: str) -> float | str:
    """A number, or the name of a width. Raises ArgumentTypeError."""
    try:
        return float(text)
    except ValueError:
        if text.isalpha() and text not in ("nan", "inf"):
            return text
        raise argparse.ArgumentTypeError("should be a number of inches, or column, double or slide") from None


def label(text: str) -> tuple[str, str]:
    """A brain's name and its label, as OLD=NEW. Raises ArgumentTypeError."""
    old, equals, new = text.partition("=")
    if not (old and equals and new.strip()):
        raise argparse.ArgumentTypeError("should be such as mine.py='My brain'")
    return old, new.strip()


def name_list(text: str) -> list[str]:
    """Names separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def part_of_trials(text: str) -> tuple[int, int]:
    """A part of the trials, as 1/4. Raises ArgumentTypeError."""
    k, slash, n = text.partition("/")
    if not (slash and k.isdecimal() and n.isdecimal() and len(text) <= DIGITS):
        raise argparse.ArgumentTypeError("should be such as 1/4")
    return int(k), int(n)


def round_or_time(text: str) -> Any:
    """A whole number from 0, or a time with a unit. Raises ArgumentTypeError."""
    from swarmcensus.support.times import parse_time

    if text.strip()[-1:].isalpha():  # a unit
        try:
            return parse_time(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
    return _whole(text, 0)


def positive(text: str) -> int:
    """A whole number from 1. Raises ArgumentTypeError."""
    return _whole(text, 1)


def from_zero(text: str) -> int:
    """A whole number from 0. Raises ArgumentTypeError."""
    return _whole(text, 0)


def _whole(text: str, least: int) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= DIGITS and int(text) >= least):
        raise argparse.ArgumentTypeError(f"should be a whole number from {least}")
    return int(text)


def number(text: str) -> float:
    """A finite number. Raises ArgumentTypeError."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError("should be a number")
    return value


def share(text: str) -> float:
    """A number from 0 to 1. Raises ArgumentTypeError."""
    value = number(text)
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError("should be a share, from 0 to 1")
    return value


def assignment(text: str) -> tuple[str, str]:
    """A name and a text, as NAME=VALUE. Raises ArgumentTypeError."""
    name, equals, value = text.partition("=")
    if not (equals and name.strip() and value.strip()):
        raise argparse.ArgumentTypeError("should be NAME=VALUE")
    return name.strip(), value.strip()


def parameter(text: str) -> tuple[str, float | tuple[float, ...]]:
    """A name and a number or a vector, as memory=50 or weights=0.5,0.3,0.2. Raises ArgumentTypeError."""
    name, value = assignment(text)
    try:
        numbers = tuple(float(part) for part in value.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError("should be NAME=VALUE, with commas between the numbers of a vector") from None
    return name, numbers if len(numbers) > 1 else numbers[0]


def once(option: str, pairs: Sequence[tuple[str, T]]) -> dict[str, T]:
    """The values of an option that is repeated, by name. Raises InputError for a name that is given twice."""
    values = dict(pairs)
    if len(values) < len(pairs):
        name = next(name for k, (name, _) in enumerate(pairs) if name in dict(pairs[:k]))
        raise OptionError(f"--{option} {name}: the name is given twice", key=option)
    return values


def port(text: str) -> int:
    """A port, or 0 for a free one. Raises ArgumentTypeError."""
    if not (text.isascii() and text.isdigit() and len(text) <= 5 and int(text) <= 65_535):
        raise argparse.ArgumentTypeError("should be a port, from 1 to 65535, or 0 for a free one")
    return int(text)


REPEATED = {"action": "append", "default": []}
SHARED: dict[str, dict[str, Any]] = {  # options that several commands have, with one meaning
    "bins": {"type": int, "help": "bins of decisions (default: as in the study); needs estimates kept at checkpoints"},
    "brain_file": {
        "type": Path, "metavar": "FILE", **REPEATED,
        "help": "the file of a brain, adversary or metric of your own that the results were made with; may be repeated",
    },
    "delta": {
        "type": float,
        "help": "tolerance of convergence (default: as in the study); needs estimates kept at checkpoints",
    },
    "device": {
        "choices": ("cpu", "gpu", "auto"), "default": "cpu", "metavar": "WHERE",
        "help": "what runs networks: cpu (default), gpu (a graphics card), or auto, whichever is faster",
    },
    "fill_ratio": {"type": share, "metavar": "F", "help": "how much of the floor is black"},
    "fresh": {"action": "store_true", "help": "start over instead of continuing what --out holds"},
    "hz": {"type": number, "help": "ticks a second"},
    "host": {
        "default": "127.0.0.1", "metavar": "ADDRESS", "help": "address to listen on (default: this machine only)"
    },
    "jobs": {"type": positive, "help": "number of threads (default: one per core); results do not depend on it"},
    "label": {
        "type": label, "metavar": "OLD=NEW", **REPEATED,
        "help": "what to call a brain, such as mine.py='My brain'; may be repeated",
    },
    "message": {
        "choices": FORMATS, "metavar": "FORMAT", "help": "format of messages: float32, float16, ratio16 or ratio8",
    },
    "no_browser": {"action": "store_true", "help": "only print the address of the page"},
    "parameter": {
        "type": parameter, "metavar": "NAME=VALUE", **REPEATED,
        "help": "value of a parameter of the brain, such as every=10, or weights=0.5,0.3,0.2 for a vector; may be "
        "repeated",
    },
    "plot": {"type": Path, "metavar": "FILE.png|svg|pdf", "help": "draw a figure"},
    "port": {"type": port, "help": "port of the page (default: a free one)"},
    "precision": {
        "choices": ("double", "single"), "metavar": "WHICH", "help": "precision of numbers: double or single",
    },
    "schema": {"action": "store_true", "help": "print the JSON schema of such files, for editors"},
    "seed": {"type": from_zero, "help": "seed of all random numbers (default: as in the study)"},
    "setting": {"type": from_zero, "metavar": "N", "help": "number of the setting, as 'show' prints it"},
    "trial": {"type": from_zero, "metavar": "N", "help": "number of the trial, from 0"},
    "trials": {"type": positive, "help": "trials per setting (default: as in the study)"},
    "where": {
        "metavar": "EXPR",
        "help": "only these settings, such as 'topology == \"ring\" and robots == 100'",
    },
}  # fmt: skip

OF_RUNS = ("jobs", "device", "trials", "seed", "fresh")  # of all commands that run studies and write their results


def add_shared(sub: "argparse._ActionsContainer", *names: str, required: bool = False, **notes: str) -> None:
    """Add options that several commands have; a note says more of one here, such as its default."""
    for name in (*names, *notes):
        settings = dict(SHARED[name])
        if name in notes:
            usual = " (default: as in the study)"
            settings["help"] = settings["help"].replace(usual, "") + f" ({notes[name]})"
        if required:
            settings["required"] = True
        sub.add_argument(f"--{name.replace('_', '-')}", **settings)
