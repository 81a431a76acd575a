"""How messages call what was asked for: as an option of a shell's command, or as an argument of a Python function."""

import contextlib
import shlex
from collections.abc import Collection, Iterator
from contextvars import ContextVar

_OPTIONS: ContextVar[Collection[str] | None] = ContextVar("options", default=None)


@contextlib.contextmanager
def shell_options(options: Collection[str]) -> Iterator[None]:
    """While the block lasts, a shell asks, by a command that has these options."""
    before = _OPTIONS.set(options)
    try:
        yield
    finally:
        _OPTIONS.reset(before)


def in_shell() -> bool:
    """Whether a shell asks."""
    return _OPTIONS.get() is not None


def option(name: str, value: object = None) -> str:
    """An option as whoever asks would write it: `--against swift`, or `against='swift'`; True is a flag.

    What a command has no option for, one that draws is given by `--set against=swift`.
    """
    options = _OPTIONS.get()
    if options is None:
        return f"{name}=" if value is None else f"{name}={value!r}"
    if name not in options and "set" in options:
        return f"--set {shlex.quote(f'{name}={value}') if value is not None else f'{name}='}"
    flag = f"--{name.replace('_', '-')}"
    return flag if value is None or value is True else f"{flag} {shlex.quote(str(value))}"
