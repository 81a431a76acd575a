"""The program's commands: parsed, called and answered; their help, and the words of what the parser refuses.

A command is a function that `help.COMMANDS` names. Its parameters are its arguments and options, its docstring is their
help. What it returns, an `Answer`, is printed here. Only the module of the command that runs is imported.
"""

import contextlib
import functools
import importlib
import inspect
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, NoReturn, get_args

from cyclopts import App, ArgumentCollection, Parameter
from cyclopts.argument import Argument
from cyclopts.exceptions import (
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    RepeatArgumentError,
    UnknownOptionError,
)

from swarmcensus.cli.help import COMMANDS, HELP, UsageError, page
from swarmcensus.cli.messages import speaking
from swarmcensus.cli.output import give
from swarmcensus.cli.parameters import OPTIONS, path, takes, whole
from swarmcensus.support.answers import FORMATS
from swarmcensus.support.files import check_output
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import shell_options
from swarmcensus.support.version import __version__

MEANT = {"studies": "list studies", "completion": "doctor --completion", "translate": "deploy"}  # no commands


OF_ALL = {  # options of all commands
    "json": Annotated[bool, Parameter(help="print one JSON document on stdout, and nothing else")],
    "save": Annotated[Path | None, takes(path, "FILE", f"write the answer too: {', '.join(FORMATS)}")],
    "quiet": Annotated[bool, Parameter(alias="-q", help="print only answers and errors")],
}
OF_TABLES = {  # options of those whose answer is a table
    "limit": Annotated[int | None, takes(whole(0), "N", "most rows, 0 for all (default: 40; in JSON and pipes all)")],
    "columns": Annotated[str | None, Parameter(metavar="NAMES", help="columns to print, such as brain,final_error")],
}


def app(*names: str) -> App:
    """These commands and their options."""
    top = App(
        name="swarmcensus", version=__version__, version_flags=["--version"], help_flags=HELP,
        default_parameter=Parameter(negative="", allow_repeating=False), group_parameters=OPTIONS,
        print_error=False, exit_on_error=False, result_action="return_value", suppress_keyboard_interrupt=False,
    )  # fmt: skip
    for name in names:
        top.command(_with_output(name), name=name)
    return top


def arguments_of(name: str) -> ArgumentCollection:
    """The arguments and options of a command."""
    top = app(name)
    _, path, _ = top.parse_commands([name])
    with top.app_stack(path):
        return path[-1].assemble_argument_collection(parse_docstring=True)


def _with_output(name: str) -> Callable[..., Any]:
    """The function of a command, with the options of its output too."""
    module, _, function = COMMANDS[name].function.partition(".")
    run = getattr(importlib.import_module(f"swarmcensus.cli.commands.{module}"), function)
    signature = inspect.signature(run)
    added = []
    for option, kind in (OF_ALL | (OF_TABLES if COMMANDS[name].table else {})).items():
        usual = False if get_args(kind)[0] is bool else None
        added.append(inspect.Parameter(option, inspect.Parameter.KEYWORD_ONLY, annotation=kind, default=usual))

    @functools.wraps(run)
    def called(*arguments: Any, **options: Any) -> Any:
        return run(*arguments, **{k: v for k, v in options.items() if k in signature.parameters})

    called.__signature__ = signature.replace(parameters=[*signature.parameters.values(), *added])  # type: ignore[attr-defined]
    called.__annotations__ = {name: one.annotation for name, one in called.__signature__.parameters.items()}  # type: ignore[attr-defined]
    return called


def value_of(argument: Argument) -> str:
    """What stands for the value of an argument or option in help and errors; nothing if it takes none."""
    return "" if argument.is_flag() else argument.parameter.metavar or argument.field_info.name.upper()


def meaning_of(argument: Argument) -> str:
    """What an argument or option means, and its choices unless the text names them all."""
    text, choices = argument.parameter.help or "", argument.get_choices(force=True) or ()
    return "; ".join([text, *[f"one of {', '.join(choices)}"] * any(choice not in text for choice in choices)])


def usage_of(name: str) -> str:
    """How a command is called."""
    words = ["swarmcensus", name]
    for one in arguments_of(name):
        if one.is_positional_only() and one.show:
            words.append(value_of(one) if one.required else f"[{value_of(one)}]")
        elif one.required:
            words.append(f"{one.name} {value_of(one)}")
    return " ".join([*words, "[OPTIONS]"])


def help_of(name: str) -> str:
    """The page of a command."""
    blocks: dict[str, dict[str, str]] = {"arguments": {}, "options": {}, "output": {}}
    for one in arguments_of(name):
        if one.is_positional_only() and one.show:
            blocks["arguments"][value_of(one)] = meaning_of(one)
        elif one.show:
            block = blocks["output" if one.field_info.name in OF_ALL | OF_TABLES else "options"]
            block[f"{', '.join(one.names)} {value_of(one)}".rstrip()] = meaning_of(one)
    return page(usage_of(name), COMMANDS[name].text, {title: block for title, block in blocks.items() if block})


def execute(words: Sequence[str]) -> int:
    """Run one command, print its answer and return its exit code. Raises InputError."""
    first, *others = words
    if first in COMMANDS and {*others} & {*HELP}:
        print(help_of(first))
        return 0
    if first not in COMMANDS and not first.startswith(("-", "__")):
        hint = f"did you mean {MEANT[first]!r}? " if first in MEANT else did_you_mean(first, COMMANDS)
        raise UsageError(f"COMMAND {_quote(first)}: {hint}should be {_either(COMMANDS)}", value=first)
    try:
        # a shell that completes words asks for those of `__complete COMMAND ...`
        run, bound, _ = app(*(name for name in words[:2] if name in COMMANDS)).parse_args(words)
    except CycloptsError as error:
        _refuse(error, words)
    if run.__module__.startswith("cyclopts"):  # the version, or names with marks for a shell: not escaped
        with contextlib.redirect_stdout(getattr(sys.stdout, "unescaped", sys.stdout)):
            run(*bound.args, **bound.kwargs)
        return 0
    for option, value in bound.arguments.items():
        if value == "":
            raise UsageError(f"--{option.replace('_', '-')} '': should not be empty", key=option, value="")
    bound.apply_defaults()
    options = dict(bound.arguments)
    with shell_options(options, words), speaking(COMMANDS[first].table, options):
        paths = [one for value in options.values() for one in (value if isinstance(value, list) else [value])
                 if isinstance(one, Path)]  # fmt: skip
        inputs = [one for one in paths if one is not options["save"]]
        check_output("save", options["save"], tuple(FORMATS), *inputs)  # before a long run
        missing = dict.fromkeys(one.parent for one in paths if not one.parent.exists())
        answers, code = run(*bound.args, **bound.kwargs), 0
        for answer in answers if isinstance(answers, Iterator) else [answers]:  # some commands go on after it
            code = give(answer, first, options, missing)
    return code


def _refuse(error: CycloptsError, words: Sequence[str]) -> NoReturn:
    """Raise UsageError: one sentence that names the option, its value and what would be right."""
    known = [*arguments_of(words[0])] if words[0] in COMMANDS else []
    options = [name for one in known for name in one.names]
    shows = f"'{' '.join(['swarmcensus', *words[: bool(known)]])} --help' shows what there is"
    token = getattr(error, "token", None)
    option = (token and token.keyword) or (error.argument and error.argument.name) or ""
    if error.argument and not option.startswith("-"):
        option = value_of(error.argument)
    value = token.value if token else None
    match error:
        case UnknownOptionError():
            option = (option or str(value)).partition("=")[0]
            where = "one setting is --where 'setting == N'" if option == "--setting" and "--where" in options else ""
            text = f"{_quote(option)} is no option of this command: {where or did_you_mean(option, options) or shows}"
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
            text = f"{option} {_quote(value)}: {listed or error.msg or 'should be another value'}"
        case _ if error.unused_tokens:
            text = f"{_quote(error.unused_tokens[0])} is an argument too many: {shows}"
        case _:
            text = str(getattr(error, "exception_message", "")) or str(error)
    raise UsageError(" ".join(text.split()), key=option.lstrip("-").replace("-", "_") or None, value=value)


def _either(names: Any) -> str:
    *first, last = map(str, names)
    return " or ".join(filter(None, (", ".join(first), last)))


def _quote(text: object) -> str:
    """A value as it would be typed; a long one is cut."""
    return shlex.quote(str(text)[:40])
