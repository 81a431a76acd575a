"""The answer of a command: printed, saved, and followed by the names of files and the next command.

A table is laid out for people on a terminal. In a file or a pipe it is tab-separated columns: a line of names, then a
line for each row, with all digits; other messages and names of files are then on stderr.
"""

import codecs
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from swarmcensus.cli.messages import LOG, say, wrote
from swarmcensus.support.answers import Answer
from swarmcensus.support.options import continuing, option_conflict, wrong_option
from swarmcensus.support.readers import is_terminal


def give(answer: Answer | str, name: str, options: Mapping[str, Any], missing: Iterable[Path]) -> int:
    """Print the answer of a command as its options ask, name the folders that it made, and return the exit code.

    A text is a program or a document, which is printed as it is.
    """
    if isinstance(answer, str):
        for option in ("json", "save"):
            if options.get(option):
                raise option_conflict(option, None, "does not go with an option that prints a program or a document")
        sys.stdout.write(answer)
    else:
        answer.command = name
        _print(answer, options)
        if save := options.get("save"):
            if save.resolve() in [file.resolve() for file in answer.files]:
                raise wrong_option("save", save, "this command has just written it: name another file")
            answer.save(save, options.get("limit") or 0, _columns(options))
            wrote(save)
        for file, text in answer.files.items():
            wrote(f"{file}: {text}" if text else file)
        if answer.next:
            say(f"next: {answer.next}")
    for folder in missing:
        if folder.is_dir():  # a mistyped path should not make one silently
            say(f"made the folder {folder}")
    sys.stdout.flush()  # a full disk is reported here
    return 0 if isinstance(answer, str) else answer.code


def _columns(options: Mapping[str, Any]) -> list[str]:
    return [one.strip() for one in (options.get("columns") or "").split(",") if one]


def _print(answer: Answer, options: Mapping[str, Any]) -> None:
    """JSON if it is asked for, on a terminal tables for people, and elsewhere rows for programs."""
    limit, columns = options.get("limit"), _columns(options)
    if options["json"]:
        ascii_only = codecs.lookup(sys.stdout.encoding or "ascii").name != "utf-8"
        print(answer.to_json(limit or 0, columns, ascii_only))
    elif is_terminal():
        from swarmcensus.support.terminal import console

        answer.print_on(
            console(), limit, columns, "--columns chooses, --json has all",
            f"show all: {continuing('limit')} --limit 0",
        )  # fmt: skip
    elif answer.rows:
        print(answer.to_tsv(limit or 0, columns), end="")
        for sentence in answer.sentences:
            say(sentence)
        for caution in answer.cautions:
            LOG.warning("caution: %s", caution)
    else:
        for line in answer.said:
            print(line)
