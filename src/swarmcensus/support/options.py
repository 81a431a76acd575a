"""Names of options in messages: `--against` for the command line, `against=` for Python."""

import contextlib
import os
import shlex
from collections.abc import Collection, Iterator, Sequence
from contextvars import ContextVar
from pathlib import Path

from swarmcensus.support.errors import OptionError

# of the command that runs: its options, and the words that the user wrote; None in Python
_COMMAND: ContextVar[tuple[Collection[str], Sequence[str]] | None] = ContextVar("command", default=None)


@contextlib.contextmanager
def shell_options(options: Collection[str], words: Sequence[str] = ()) -> Iterator[None]:
    """In this block, messages are for the command line; `options` are those of the current command, of these words."""
    before = _COMMAND.set((options, words))
    try:
        yield
    finally:
        _COMMAND.reset(before)


def continuing(*without: str) -> str:
    """The command that goes on with what this one has begun, without some options; empty in Python."""
    _, words = _COMMAND.get() or ((), ())
    dropped = ("--fresh", *(f"--{option}=" for option in without))
    words = [word for word in words if not word.startswith(dropped)]
    at = {k + j for k, word in enumerate(words) if word.removeprefix("--") in without for j in (0, 1)}
    return command("swarmcensus", *(word for k, word in enumerate(words) if k not in at)) if words else ""


def in_shell() -> bool:
    """Whether messages are for the command line."""
    return _COMMAND.get() is not None


def command(*words: object) -> str:
    """A command to be copied into a shell, quoted for the shells of this system; no path is taken for an option."""
    texts = [f"./{word}" if isinstance(word, Path) and str(word).startswith("-") else str(word) for word in words]
    if os.name != "nt":
        return shlex.join(texts)
    from subprocess import list2cmdline  # slow to import

    return list2cmdline(texts)


def option(name: str, value: object = None) -> str:
    """An option as the user would write it: `--against swift`, or `against='swift'` in Python; True is a flag.

    If the command has no such option, but draws figures, the text is `--option against=swift`.
    """
    if (current := _COMMAND.get()) is None:
        return f"{name}=" if value is None else f"{name}={value!r}"
    options, _ = current
    if isinstance(value, dict):
        from swarmcensus.support.toml_text import to_toml_value  # pydantic is slow to import

        value = to_toml_value(value)
    value = f"{value:g}" if isinstance(value, float) else value
    if name not in options and name.removesuffix("s") in options:  # several in Python, repeated in a shell
        name = name.removesuffix("s")
    if name not in options and "option" in options:
        return f"--option {command(f'{name}={value}') if value is not None else f'{name}='}"
    flag = f"--{name.replace('_', '-')}"
    return flag if value is None or value is True else f"{flag} {command(value)}"


def wrong_option(name: str, value: object, what: object) -> OptionError:
    """The error of an option: `--target radar: should be udp`, or `target='radar': should be udp` in Python."""
    none = "" if value is not None or in_shell() else "None"
    return OptionError(f"{option(name, value)}{none}: {what}", key=name, value=value)


def option_conflict(name: str, value: object, why: str) -> OptionError:
    """The error of an option that does not go with others: `--limit 9 does not go with --json`."""
    return OptionError(f"{option(name, value)} {why}", key=name, value=value)
