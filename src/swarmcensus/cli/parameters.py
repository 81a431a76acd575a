"""What options take: types of values, each an annotation, and options that several commands have with one meaning."""

import glob
import importlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from cyclopts import Group, Parameter
from cyclopts.exceptions import CoercionError

from swarmcensus.support.errors import OptionError

T = TypeVar("T")
OPTIONS = Group("options")
DIGITS = 18  # of a number, so that it fits into 64 bits


def takes(read: Callable[[str], Any], metavar: str, text: str | None = None, *, several: bool = False) -> Parameter:
    """The annotation of an option: how a text is read, what stands for it in the help, and what the option means.

    `read` raises ValueError, which says what would be right. With `several` the option may be repeated.
    """

    def convert(_: Any, tokens: Sequence[Any]) -> Any:
        values = []
        for token in tokens:
            try:
                values.append(read(token.value))
            except ValueError as error:
                raise CoercionError(str(error), token=token) from None
        return values if several else values[0]

    more: dict[str, Any] = {"help": text + "; may be repeated" * several} if text else {}
    return Parameter(converter=convert, metavar=metavar, n_tokens=1, allow_repeating=several or None, **more)


def path(text: str) -> Path:
    """The path of a file or folder; an empty text would be this folder to Path."""
    if not text:
        raise ValueError("should name a file or folder")
    return Path(text)


def whole(least: int) -> Callable[[str], int]:
    """Reads a whole number from `least`."""

    def read(text: str) -> int:
        if not (text.isascii() and text.isdigit() and len(text) <= DIGITS and int(text) >= least):
            raise ValueError(f"should be a whole number from {least}")
        return int(text)

    return read


def number(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or "_" in text:
        raise ValueError("should be a number")
    return value


def share(text: str) -> float:
    """A number from 0 to 1."""
    value = number(text)
    if not 0.0 <= value <= 1.0:
        raise ValueError("should be a share, from 0 to 1")
    return value


def part_of_trials(text: str) -> tuple[int, int]:
    """A part of the trials, as 1/4."""
    k, slash, n = text.partition("/")
    if not (slash and text.isascii() and k.isdecimal() and n.isdecimal() and len(text) <= DIGITS):
        raise ValueError("should be such as 1/4")
    return int(k), int(n)


def round_or_time(text: str) -> Any:
    """A whole number from 0, or a time with a unit."""
    from swarmcensus.support.times import parse_time

    return parse_time(text) if text.strip()[-1:].isalpha() else whole(0)(text)


def assignment(text: str, should: str = "should be NAME=VALUE") -> tuple[str, str]:
    """A name and a text, as NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not (equals and name.strip() and value.strip()):
        raise ValueError(should)
    return name.strip(), value.strip()


def toml_value(text: str) -> Any:
    """A value in the syntax of study files."""
    from swarmcensus.studies import read_value  # pydantic is slow to import

    return read_value(text)


def value_of_key(text: str) -> tuple[str, Any]:
    """A key of a study and its value, in the file's own syntax; None for KEY=, which takes the key out."""
    key, equals, value = text.partition("=")
    if not (equals and key.strip()):
        raise ValueError("should be KEY=VALUE, such as density=2 or world.density=2")
    return key.strip(), toml_value(value.strip())


def label(text: str) -> tuple[str, str]:
    """A brain's name and its label, as OLD=NEW."""
    return assignment(text, "should be such as mine.py='My brain'")


def parameter(text: str) -> tuple[str, float | tuple[float, ...]]:
    """A name and a number or a vector, as memory=50 or weights=0.5,0.3,0.2."""
    name, value = assignment(text)
    try:
        numbers = tuple(number(part) for part in value.split(","))
    except ValueError:
        raise ValueError("should be NAME=VALUE, with commas between the numbers of a vector") from None
    return name, numbers if len(numbers) > 1 else numbers[0]


def port(text: str) -> int:
    """A port, or 0 for a free one."""
    if not (text.isascii() and text.isdigit() and len(text) <= 5 and int(text) <= 65_535):
        raise ValueError("should be a port, from 1 to 65535, or 0 for a free one")
    return int(text)


def once(option: str, pairs: Sequence[tuple[str, T]]) -> dict[str, T]:
    """The values of an option that is repeated, by name. Raises InputError for a name that is given twice."""
    values = dict(pairs)
    if len(values) < len(pairs):
        name = next(name for k, (name, _) in enumerate(pairs) if name in dict(pairs[:k]))
        raise OptionError(f"--{option} {name}: the name is given twice", key=option)
    return values


def values_of(set: Sequence[tuple[str, Any]], **options: Any) -> dict[str, Any]:
    """The values of --set by key. Raises InputError for a key that an option of its own gives too."""
    values = once("set", set)
    for name in (one for one, value in options.items() if value is not None and one in values):
        raise OptionError(f"--{name} and --set {name} are one key: give it once", key=name)
    return values


def exclusive() -> Parameter:
    """The mark of options of which only one may be given."""

    def check(given: Any) -> None:
        names = [one.name for one in given if one.tokens]
        if len(names) > 1:
            raise ValueError(f"{names[1]} does not go with {names[0]}")

    return Parameter(group=(OPTIONS, Group(show=False, validator=check)))


def known(module: str, or_file: bool = False) -> Parameter:
    """Shells offer the names that a module of plugins finds, and perhaps files."""

    def offered(context: Any) -> list[str]:
        files = glob.glob(f"{glob.escape(context.incomplete)}*") if or_file else []
        return [*importlib.import_module(f"swarmcensus.{module}").PLUGINS.names, *files]

    return Parameter(completer=offered)


# ---- types of values: `Annotated[Path, FILE]`; an option says what it means in the docstring of its command

FILE, FOLDER = takes(path, "FILE"), takes(path, "FOLDER")
WHOLE, COUNT = takes(whole(0), "N"), takes(whole(1), "N")
NUMBER, SHARE = takes(number, "X"), takes(share, "SHARE")
WHEN = takes(round_or_time, "K|TIME")
ASSIGNMENTS = takes(assignment, "NAME=VALUE", several=True)
NAME = Parameter(metavar="NAME")
NAMES = Parameter(metavar="NAME", allow_repeating=True)
BRAIN = Parameter.combine(Parameter(metavar="BRAIN"), known("brains.brain", or_file=True))
FORMATS = Literal["float32", "float16", "ratio16", "ratio8"]  # of messages that have bytes

# ---- options of several commands, with what they mean

Results = Annotated[Path, takes(path, "RESULTS.nc", "a results file, as 'run' writes it")]
StudyFile = Annotated[Path, takes(path, "STUDY.toml", "a study file ('new study' writes one)")]
KEY = takes(
    value_of_key,
    "KEY=VALUE",
    "a key of the study, as in a file: density=2, 'accuracy={black = 0.8, white = 0.9}'; KEY= takes it out",
    several=True,
)
Set = Annotated[Sequence[tuple[str, Any]], KEY]
Where = Annotated[str | None, takes(str, "EXPR", "only these settings: 'topology == \"ring\" and robots == 100'")]
Setting = Annotated[int | None, takes(whole(0), "N", "number of the setting, as 'show' prints it")]
OWN_FILE = takes(path, "FILE", "your brain, adversary or metric that the results were made with", several=True)
BrainFiles = Annotated[Sequence[Path], OWN_FILE]
LABEL = takes(label, "OLD=NEW", "what to call a brain, such as mine.py='My brain'", several=True)
Labels = Annotated[Sequence[tuple[str, str]], LABEL]
PARAMETER = takes(parameter, "NAME=VALUE", "of the brain, such as every=10, or weights=0.5,0.3,0.2", several=True)
Parameters = Annotated[Sequence[tuple[str, Any]], PARAMETER]
Jobs = Annotated[int | None, takes(whole(1), "N", "threads (default: cores); no result depends on it")]
Device = Annotated[Literal["cpu", "gpu", "auto"], Parameter(help="cpu (default), gpu, or auto: whichever is faster")]
Trials = Annotated[int | None, takes(whole(1), "N", "trials per setting (default: as in the study)")]
Seed = Annotated[int | None, takes(whole(0), "N", "seed of all random numbers (default: as in the study)")]
Fresh = Annotated[bool, Parameter(help="start over instead of continuing what --out holds")]
Port = Annotated[int | None, takes(port, "PORT", "port of the page (default: a free one)")]
NoBrowser = Annotated[bool, Parameter(help="only print the address of the page")]
Host = Annotated[str, Parameter(metavar="ADDRESS", help="address to listen on (default: this machine only)")]


@Parameter(name="*")
@dataclass(frozen=True)
class Hardware:
    """The options that say what runs trials."""

    jobs: Jobs = None
    device: Device = "cpu"


USUAL = Hardware()
