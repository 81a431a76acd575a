"""The page of the command line gets all commands and options, made from their functions when the site is built."""

import re
from collections.abc import Iterator

from cyclopts.argument import Argument
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

from swarmcensus.cli.app import OF_ALL, OF_TABLES, Topic, arguments_of, commands

PAGE = "reference/command-line.md"


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Add all commands to their page."""
    return f"{markdown}\n{reference()}" if page.file.src_uri == PAGE else markdown


def reference() -> str:
    """All commands and options, as Markdown."""
    return "\n".join(["## All commands", *(line for topic in Topic for line in _of_topic(topic))])


def _of_topic(topic: Topic) -> Iterator[str]:
    """The commands of a topic, in a table, then one by one."""
    found = [command for command in commands().values() if command.topic is topic]
    yield from ["", f"### {topic.value.capitalize()} {{ #group-{topic.name.lower()} }}", ""]
    yield from ["| command | what it does |", "|---|---|"]
    yield from (f"| [`{one.name}`](#{one.name}) | {_cell(one.text)} |" for one in found)
    for one in found:
        every = [
            each for each in arguments_of(one.name) if each.show and each.field_info.name not in OF_ALL | OF_TABLES
        ]
        arguments = [each for each in every if each.is_positional_only()]
        options = [each for each in every if not each.is_positional_only()]
        words = [_value(each) if each.required else f"[{_value(each)}]" for each in arguments]
        words += [f"{each.name} {_value(each)}" for each in options if each.required]
        usage = " ".join(["swarmcensus", one.name, *words, "[OPTIONS]"])
        yield from ["", f"#### {one.name}", "", one.text, "", "```text", usage, "```"]
        for title, several in (("argument", arguments), ("option", options)):
            if several:
                yield from ["", f"| {title} | meaning |", "|---|---|", *map(_row, several)]


def _value(argument: Argument) -> str:
    """What stands for the value of an argument or option, or nothing if it takes none."""
    return "" if argument.is_flag() else argument.parameter.metavar or argument.field_info.name.upper()


def _row(argument: Argument) -> str:
    value = _value(argument)
    names = [value] if argument.is_positional_only() else [f"{name} {value}".rstrip() for name in argument.names]
    text, choices = argument.parameter.help or "", argument.get_choices(force=True) or ()
    words = ["required"] * (argument.required and not argument.is_positional_only()) + [_cell(text)]
    words += [f"one of {', '.join(choices)}"] * any(choice not in text for choice in choices)
    return f"| {', '.join(f'`{name}`' for name in names)} | {'; '.join(words)} |"


def _cell(text: str) -> str:
    """Text for a cell: a quoted command as code, no bar, no mark-up."""
    text = re.sub(r"(?<!\w)'([^']+)'(?!\w)", r"`\1`", text)  # and no apostrophe
    return re.sub(r"(?<!`)([<>*_])(?![^`]*`)", r"\\\1", text).replace("|", "\\|")
