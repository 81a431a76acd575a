"""The reference of the command line, made from its parser when the site is built."""

import argparse
import os
import re
from collections.abc import Iterator
from typing import TypeAlias
from unittest import mock

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from swarmcensus.cli.commands import parser

URI = "reference/command-line.md"
Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"
WIDTH = "88"  # of usage, so that it fits beside the contents


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the page."""
    files.append(File.generated(config, URI, content=page()))
    return files


def page() -> str:
    """All commands and options, as Markdown."""
    top = parser()
    [commands] = (a for a in top._actions if isinstance(a, argparse._SubParsersAction))
    return "\n".join(["# Command line", "", *_opening(top, commands), *_sections(commands)])


def _opening(top: argparse.ArgumentParser, commands: Commands) -> list[str]:
    rows = [f"| [`{one.dest}`](#{one.dest}) | {_told(str(one.help))} |" for one in commands._choices_actions]
    return [
        str(top.description),
        "",
        "`swarmcensus COMMAND --help` shows the same in a terminal, and `swarmcensus doctor --completion bash` prints "
        "a script that makes a shell complete it. The exit code is 0, 2 for wrong input, and 130 after Ctrl-C.",
        "",
        "| command | what it does |",
        "|---|---|",
        *rows,
    ]


def _sections(commands: Commands) -> Iterator[str]:
    for name, command in commands.choices.items():
        yield from ["", f"## {name}", "", str(command.description), "", "```text", _usage(command), "```"]
        given = [a for a in command._actions if not a.option_strings and a.help]
        options = [a for a in command._actions if a.option_strings and a.dest != "help"]
        for title, actions in (("argument", given), ("option", options)):
            if actions:
                yield from ["", f"| {title} | meaning |", "|---|---|", *(_row(command, one) for one in actions)]


def _usage(command: argparse.ArgumentParser) -> str:
    with mock.patch.dict(os.environ, {"COLUMNS": WIDTH, "NO_COLOR": "1"}):
        return command.format_usage().removeprefix("usage: ").replace("\n       ", "\n").rstrip()


def _row(command: argparse.ArgumentParser, action: argparse.Action) -> str:
    formatter = command._get_formatter()
    value = "" if action.nargs == 0 else " " + formatter._format_args(action, _default_metavar(action))
    names = ", ".join(f"`{name}{value}`" for name in action.option_strings or [""]).replace("` ", "`")
    words = [_told(formatter._expand_help(action))] if action.help else []
    return f"| {names} | {'; '.join(['required'] * (action.required and bool(action.option_strings)) + words)} |"


def _default_metavar(action: argparse.Action) -> str:
    return action.dest.upper() if action.option_strings else action.dest


def _told(text: str) -> str:
    """Text for a cell: a quoted command as code, no bar, no mark-up."""
    text = re.sub(r"(?<!\w)'([^']+)'(?!\w)", r"`\1`", text)  # and no apostrophe
    return re.sub(r"(?<!`)([<>*_])(?![^`]*`)", r"\\\1", text).replace("|", "\\|")
