"""The page of the command line gets all commands and options, made from their functions when the site is built."""

import re
from collections.abc import Iterator

from cyclopts.argument import Argument
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

from swarmcensus.cli.app import OF_ALL, OF_TABLES, arguments_of, meaning_of, usage_of, value_of
from swarmcensus.cli.help import TOPICS

PAGE = "reference/command-line.md"


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Add all commands to their page."""
    return f"{markdown}\n{reference()}" if page.file.src_uri == PAGE else markdown


def reference() -> str:
    """All commands and options, as Markdown."""
    return "\n".join(["## All commands", *(line for topic in TOPICS for line in _of_topic(topic))])


def _of_topic(topic: str) -> Iterator[str]:
    """The commands of a topic, in a table, then one by one."""
    yield from ["", f"### {topic.capitalize()} {{ #group-{topic.split()[-1]} }}", ""]
    yield from ["| command | what it does |", "|---|---|"]
    yield from (f"| [`{name}`](#{name}) | {_cell(one.text)} |" for name, one in TOPICS[topic].items())
    for name, one in TOPICS[topic].items():
        yield from ["", f"#### {name}", "", one.text, "", "```text", usage_of(name), "```"]
        several = [each for each in arguments_of(name) if each.show and each.field_info.name not in OF_ALL | OF_TABLES]
        for title in ("argument", "option"):
            if found := [each for each in several if each.is_positional_only() == (title == "argument")]:
                yield from ["", f"| {title} | meaning |", "|---|---|", *map(_row, found)]


def _row(argument: Argument) -> str:
    value = value_of(argument)
    names = [value] if argument.is_positional_only() else [f"{name} {value}".rstrip() for name in argument.names]
    words = ["required"] * (argument.required and not argument.is_positional_only()) + [_cell(meaning_of(argument))]
    return f"| {', '.join(f'`{name}`' for name in names)} | {'; '.join(words)} |"


def _cell(text: str) -> str:
    """Text for a cell: a quoted command as code, no bar, no mark-up."""
    text = re.sub(r"(?<!\w)'([^']+)'(?!\w)", r"`\1`", text)  # and no apostrophe
    return re.sub(r"(?<!`)([<>*_])(?![^`]*`)", r"\\\1", text).replace("|", "\\|")
