"""What a command says while it runs: messages on stderr and names of files on stdout, as --quiet asks.

All packages log to the logger `swarmcensus` and below: INFO is printed.
"""

import contextlib
import logging
import shutil
import sys
import textwrap
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TextIO

from swarmcensus.support.control_characters import printable
from swarmcensus.support.readers import is_terminal

if TYPE_CHECKING:
    from swarmcensus.runs import Progress

LOG = logging.getLogger("swarmcensus")
WROTE = LOG.getChild("wrote")


class _Voice(logging.Handler):
    """Prints to the current sys.stdout and sys.stderr, which a progress bar replaces by its own."""

    def __init__(self, data: bool) -> None:
        """`data` is whether programs read stdout, so that nothing but the answer is printed there."""
        super().__init__()
        self.data = data
        self.seen: set[str] = set()  # warnings of matplotlib, which repeats them with each text that it draws

    def emit(self, record: logging.LogRecord) -> None:
        line, to_files = record.getMessage(), record.name == WROTE.name and not self.data
        if record.name.startswith("matplotlib"):
            line = f"warning: {line}"
            if line in self.seen:
                return
            self.seen.add(line)
        stream = sys.stdout if to_files else sys.stderr
        if line.startswith("warning: "):  # other lines may hold commands, to be copied
            line = _between_words(line, stream)
        # a progress bar would interpret escape sequences as its own
        print(printable(line), file=stream, flush=not to_files)


def complain(line: str, code: int = 2) -> int:
    """Print an error on stderr, on one line unless a terminal is too narrow, and return the exit code."""
    with contextlib.suppress(OSError):  # the terminal was closed
        print(_between_words(" ".join(line.split("\n")), sys.stderr), file=sys.stderr)
    return code


def _between_words(text: str, stream: TextIO) -> str:
    """Text in lines of a terminal that end between words; what has no spaces, such as a path, stays whole."""
    if not stream.isatty():
        return text
    columns = shutil.get_terminal_size().columns
    lines = (textwrap.wrap(line, columns, break_long_words=False, break_on_hyphens=False) for line in text.split("\n"))
    return "\n".join("\n".join(line) for line in lines)


@contextlib.contextmanager
def speaking(table: bool, options: Mapping[str, Any]) -> Iterator[None]:
    """Print messages and warnings as the options ask while the block lasts; with --quiet neither."""
    level = logging.ERROR if options["quiet"] else logging.INFO
    voice, before = _Voice(options["json"] or (table and not is_terminal())), LOG.level
    LOG.setLevel(level)
    voice.setLevel(level)
    for log in (LOG, logging.getLogger("matplotlib")):
        log.addHandler(voice)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("default", UserWarning)
            warnings.showwarning = lambda message, *_, **__: LOG.warning("warning: %s", message)
            yield
    finally:
        for log in (LOG, logging.getLogger("matplotlib")):
            log.removeHandler(voice)
        LOG.setLevel(before)


def say(line: str) -> None:
    """Print a message on stderr; not with --quiet."""
    LOG.info("%s", line)


def wrote(line: object) -> None:
    """Print the name of a written file on stdout; not with --quiet, and on stderr if programs read stdout."""
    WROTE.info("%s", line)


@contextlib.contextmanager
def progress_bar(label: str) -> "Iterator[Callable[[float, float], None]]":
    """A callback that shows on a terminal how much of a whole is done; with --quiet it shows nothing."""
    from rich.progress import Progress as Bar

    from swarmcensus.support.terminal import console

    out = console(stderr=True)
    silent = not (out.is_terminal and LOG.isEnabledFor(logging.INFO))
    with Bar(console=out, transient=True, disable=silent) as bar:
        task = bar.add_task(label, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


@contextlib.contextmanager
def reporting(label: str) -> "Iterator[Callable[[Progress], None]]":
    """A callback for `run` that shows its progress; with --quiet it shows nothing."""
    if not LOG.isEnabledFor(logging.INFO):
        yield lambda _: None
        return
    from swarmcensus.runs import bar_or_lines as shown

    with shown(label) as show:
        yield show
