"""What a command prints: answers and names of files on stdout, messages on stderr, as --quiet and --verbose ask.

All packages log to the logger `swarmcensus` and below: INFO is printed by default, DEBUG only with --verbose.
"""

import argparse
import contextlib
import logging
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swarmcensus.runs.collect import Progress

LOG = logging.getLogger("swarmcensus")
WROTE = LOG.getChild("wrote")


class _Voice(logging.Handler):
    """Prints to the current sys.stdout and sys.stderr, which a progress bar replaces by its own."""

    def __init__(self, json: bool) -> None:
        super().__init__()
        self.json = json

    def emit(self, record: logging.LogRecord) -> None:
        to_files = record.name == WROTE.name and not self.json
        print(record.getMessage(), file=sys.stdout if to_files else sys.stderr, flush=not to_files)


@contextlib.contextmanager
def speaking(options: argparse.Namespace) -> Iterator[None]:
    """Print messages and warnings as the options ask while the block lasts; with --quiet neither."""
    level = logging.ERROR if options.quiet else logging.DEBUG if options.verbose else logging.INFO
    voice, before = _Voice(options.json), LOG.level
    LOG.setLevel(level)
    LOG.addHandler(voice)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("default", UserWarning)
            warnings.showwarning = lambda message, *_, **__: LOG.warning("warning: %s", message)
            yield
    finally:
        LOG.removeHandler(voice)
        LOG.setLevel(before)


def say(line: str) -> None:
    """Print a message on stderr; not with --quiet."""
    LOG.info("%s", line)


def wrote(line: object) -> None:
    """Print the name of a written file on stdout; not with --quiet, and with --json on stderr."""
    WROTE.info("%s", line)


def answer(kind: str, about: Mapping[str, Any]) -> None:
    """Print the document of --json on stdout."""
    from swarmcensus.basics.documents import document

    print(document(kind, about))


@contextlib.contextmanager
def reporting(label: str) -> "Iterator[Callable[[Progress], None]]":
    """A callback for `run` that shows its progress; with --quiet it shows nothing."""
    if not LOG.isEnabledFor(logging.INFO):
        yield lambda _: None
        return
    from swarmcensus.runs.progress import bar_or_lines as shown

    with shown(label) as show:
        yield show
