"""The program's commands: found, parsed, called and answered; and the words of what the parser refuses.

A command is a function with the mark of `command`. Its parameters are its arguments and options, its docstring is
their help. What it returns, an `Answer`, is printed here. All modules of commands are imported for each help text, so
that their own imports wait until a command runs.
"""

import contextlib
import functools
import importlib
import inspect
import pkgutil
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, NoReturn, TypeVar

from cyclopts import App, ArgumentCollection, Group, Parameter
from cyclopts.exceptions import (
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    RepeatArgumentError,
    UnknownOptionError,
)

from swarmcensus.cli.output import give, speaking
from swarmcensus.cli.parameters import FILE, OPTIONS, OUTPUT, WHOLE, exclusive
from swarmcensus.support.answers import FORMATS
from swarmcensus.support.errors import OptionError
from swarmcensus.support.files import check_output
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import shell_options
from swarmcensus.support.version import __version__

C = TypeVar("C", bound=Callable[..., Any])
MEANT = {"studies": "list studies", "completion": "doctor --completion", "translate": "deploy"}  # no commands
HELP = ("--help", "-h")
KEYWORD = inspect.Parameter.KEYWORD_ONLY


class Topic(Enum):
    """What a command is about: the title under which the help lists it."""

    STUDIES = "studies"
    BRAINS = "brains"
    MISSIONS = "missions"
    ROBOTS = "robots"
    LOOK = "to look at"
    SETUP = "setup"


@dataclass(frozen=True)
class Command:
    """A command: the function that runs it, its name, its topic and place there, and whether it answers by a table."""

    run: Callable[..., Any]
    name: str
    topic: Topic
    place: int
    table: bool

    @property
    def text(self) -> str:
        """What it does, in a line."""
        return (self.run.__doc__ or "").strip().partition("\n")[0]


def command(topic: Topic, place: int, name: str = "", table: bool = False) -> Callable[[C], C]:
    """The mark of a function that is a command. `table` is whether its answer is a table, which a pipe gets as TSV."""

    def marked(run: C) -> C:
        run.command = Command(run, name or run.__name__, topic, place, table)  # type: ignore[attr-defined]
        return run

    return marked


class UsageError(OptionError):
    """Arguments that the parser refuses; `program` is the command that they were given to, "swarmcensus run"."""

    def __init__(self, message: str, program: str, **fields: Any) -> None:
        """Keep the command too."""
        super().__init__(message, **fields)
        self.program = program


@functools.cache
def commands() -> dict[str, Command]:
    """All commands by name, topic by topic."""
    package = importlib.import_module("swarmcensus.cli.commands")
    modules = [
        importlib.import_module(f"{package.__name__}.{one.name}") for one in pkgutil.iter_modules(package.__path__)
    ]
    found = [one.command for module in modules for one in vars(module).values()
             if isinstance(getattr(one, "command", None), Command) and one.__module__ == module.__name__]  # fmt: skip
    found.sort(key=lambda one: ([*Topic].index(one.topic), one.place, one.name))
    return {one.name: one for one in found}


VOLUME = exclusive()
OF_ALL = {  # options of all commands
    "json": (bool, "print one JSON document on stdout, and nothing else", Parameter()),
    "save": (Path | None, f"write the answer too, as its ending says: {', '.join(FORMATS)}", FILE),
    "quiet": (bool, "print only answers and errors", Parameter.combine(VOLUME, Parameter(alias="-q"))),
    "verbose": (bool, "also report each step on stderr", Parameter.combine(VOLUME, Parameter(alias="-v"))),
}  # fmt: skip
OF_TABLES = {  # options of those whose answer is a table
    "limit": (int | None, "maximum number of rows, 0 for all (default: 40; with --json and in a pipe: all)", WHOLE),
    "columns": (str | None, "columns to print, such as brain,final_error", Parameter(metavar="NAMES")),
}  # fmt: skip


def app() -> App:
    """All commands and their options."""
    usual = Parameter(negative="", show_default=False, allow_repeating=False)
    top = App(
        name="swarmcensus", help="Robot swarms with lying sensors agree on how much of a floor is black.",
        help_epilogue="'swarmcensus COMMAND --help' shows the options of a command. To begin: swarmcensus reproduce",
        version=__version__, version_flags=["--version"], help_flags=HELP, help_format="plaintext",
        default_parameter=usual, group_parameters=OPTIONS, group_arguments=Group("arguments", sort_key=1),
        print_error=False, exit_on_error=False, result_action="return_value", suppress_keyboard_interrupt=False,
    )  # fmt: skip
    topics = {topic: Group(topic.value, sort_key=k) for k, topic in enumerate(Topic)}
    for place, (name, one) in enumerate(commands().items()):
        top.command(_with_output(one), name=name, group=topics[one.topic], sort_key=place, help_epilogue="")
    return top


def arguments_of(name: str) -> ArgumentCollection:
    """The arguments and options of a command."""
    top = app()
    _, path, _ = top.parse_commands([name])
    with top.app_stack(path):
        return path[-1].assemble_argument_collection(parse_docstring=True)


def _with_output(one: Command) -> Callable[..., Any]:
    """The function with the options of its output too."""
    signature = inspect.signature(one.run)
    added = []
    for name, (kind, text, more) in (OF_ALL | (OF_TABLES if one.table else {})).items():
        groups: Any = more.group or (OUTPUT,)
        said = Parameter(help=text, group=(OUTPUT, *groups[1:]))
        usual = False if kind is bool else None
        added.append(inspect.Parameter(name, KEYWORD, annotation=Annotated[kind, more, said], default=usual))

    @functools.wraps(one.run)
    def called(*arguments: Any, **options: Any) -> Any:
        return one.run(*arguments, **{k: v for k, v in options.items() if k in signature.parameters})

    called.__signature__ = signature.replace(parameters=[*signature.parameters.values(), *added])  # type: ignore[attr-defined]
    called.__annotations__ = {name: one.annotation for name, one in called.__signature__.parameters.items()}  # type: ignore[attr-defined]
    return called


def execute(words: Sequence[str]) -> int:
    """Run one command, print its answer and return its exit code. Raises InputError."""
    top = app()
    name = words[0] if words and words[0] in commands() else ""
    program = f"swarmcensus {name}".strip()
    try:
        run, bound, _ = top.parse_args(words, print_error=False, exit_on_error=False)
    except CycloptsError as error:
        _refuse(error, words, program)
    if not hasattr(run, "command"):  # help, the version, or names for a shell, whose marks must not be escaped
        with contextlib.redirect_stdout(getattr(sys.stdout, "unescaped", sys.stdout)):
            run(*bound.args, **bound.kwargs)
        return 0
    for option, value in bound.arguments.items():
        if value == "":
            raise UsageError(f"--{option.replace('_', '-')} '': should not be empty", program, key=option, value="")
    bound.apply_defaults()
    options = dict(bound.arguments)
    with shell_options(options, words), speaking(run.command.table, options):
        given = [value for value in options.values() if isinstance(value, Path)]
        given += [
            path for value in options.values() if isinstance(value, list) for path in value if isinstance(path, Path)
        ]
        others = [path for path in given if path is not options["save"]]
        check_output("save", options["save"], tuple(FORMATS), *others)  # before a long run
        missing = dict.fromkeys(path.parent for path in given if not path.parent.exists())
        found, code = run(*bound.args, **bound.kwargs), 0
        for answer in found if isinstance(found, Iterator) else [found]:  # a command may go on after its answer
            code = give(answer, name, options, missing)
        return code


def _refuse(error: CycloptsError, words: Sequence[str], program: str) -> NoReturn:
    """Raise UsageError: one sentence that names the option, its value and what would be right."""
    shows = f"'{program} --help' shows what there is"
    called = program.partition(" ")[2]
    options = [name for one in arguments_of(called) for name in one.names] if called else []
    token = getattr(error, "token", None)
    option = (token and token.keyword) or (error.argument and error.argument.name) or ""
    if error.argument and not option.startswith("-"):
        option = str(error.argument.parameter.metavar or option)
    value = token.value if token else None
    match error:
        case UnknownOptionError():
            option = (option or str(value)).partition("=")[0]
            why = f"is no option of this command: {did_you_mean(option, options) or shows}"
            if option in options:
                why = "stands after --, where only names of files do: options come before it"
            text = f"{_shown(option)} {why}"
        case RepeatArgumentError():
            text = f"{option} is given twice, and holds one value"
        case MissingArgumentError() if option in words:
            text = f"{option}: a value is missing after it (one that begins with - is written {option}=VALUE)"
        case MissingArgumentError():
            given = (word.partition("=")[0] for word in words if word.startswith("--"))
            hints = (did_you_mean(one, options) for one in given if one not in options)  # it may be misspelt
            text = f"{option} is missing: {next(filter(None, hints), shows)}"
        case CoercionError() if error.argument and error.argument.hint is bool:
            text = f"{option} takes no value, but has {value!r}"
        case CoercionError():
            choices = error.argument.get_choices(force=True) if error.argument else None
            listed = choices and f"{did_you_mean(str(value), choices)}should be {_either(choices)}"
            text = f"{option} {_shown(value)}: {listed or error.msg or 'should be another value'}"
        case _ if error.unused_tokens and not called:
            meant = MEANT.get(error.unused_tokens[0], "")
            hint = f"did you mean {meant!r}? " if meant else did_you_mean(error.unused_tokens[0], commands())
            text = f"COMMAND {_shown(error.unused_tokens[0])}: {hint}should be {_either(commands())}"
        case _ if error.unused_tokens:
            text = f"{_shown(error.unused_tokens[0])} is an argument too many: {shows}"
        case _:
            text = str(getattr(error, "exception_message", "")) or str(error)
    raise UsageError(" ".join(text.split()), program, key=option.lstrip("-").replace("-", "_") or None, value=value)


def _either(names: Any) -> str:
    *first, last = map(str, names)
    return " or ".join(filter(None, (", ".join(first), last)))


def _shown(text: object) -> str:
    """A value as it would be typed; a long one is cut."""
    return shlex.quote(str(text)[:40])
