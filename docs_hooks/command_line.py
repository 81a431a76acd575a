"""The page of the command line gets all commands and options, made from the parser when the site is built."""

import argparse
import os
import re
from collections.abc import Iterator
from typing import TypeAlias
from unittest import mock

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

from swarmcensus.cli.commands import commands, parser
from swarmcensus.cli.options import Group

PAGE = "reference/command-line.md"
Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"
WIDTH = "88"  # of usage, so that it fits beside the contents


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Add all commands to their page."""
    return f"{markdown}\n{reference()}" if page.file.src_uri == PAGE else markdown


def reference() -> str:
    """All commands and options, as Markdown."""
    [listed] = (a for a in parser()._actions if isinstance(a, argparse._SubParsersAction))
    return "\n".join(["## All commands", *(line for group in Group for line in _group(group, listed))])


def _group(group: Group, listed: Commands) -> Iterator[str]:
    """The commands of a group, in a table, then one by one."""
    names = [name for name, command in commands().items() if command.group is group]
    yield from [
        "",
        f"### {group.value.capitalize()} {{ #group-{group.name.lower()} }}",
        "",
        "| command | what it does |",
        "|---|---|",
    ]
    yield from (f"| [`{name}`](#{name}) | {_told(commands()[name].text)} |" for name in names)
    for name in names:
        command = listed.choices[name]
        yield from ["", f"#### {name}", "", str(command.description), "", "```text", _usage(command), "```"]
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
