"""Who reads standard output: people on a terminal, or programs in a file or a pipe."""

import os
import sys

from swarmcensus.support.errors import InputError

AS_TERMINAL = "SWARMCENSUS_TERMINAL"  # environment: columns of the terminal that a file or a pipe is treated as
MOST = 1_000_000  # columns


def is_terminal() -> bool:
    """Whether people read standard output: it is a terminal, or SWARMCENSUS_TERMINAL is set. Raises InputError."""
    return terminal_columns() is not None or sys.stdout.isatty()


def terminal_columns() -> int | None:
    """The columns that SWARMCENSUS_TERMINAL asks for, or None. Raises InputError."""
    text = os.environ.get(AS_TERMINAL, "")
    if text and not (text.isdecimal() and len(text) <= 7 and 0 < int(text) <= MOST):
        should = "should be a number of columns, such as 100"
        raise InputError(f"{AS_TERMINAL}={text}: {should}", key=AS_TERMINAL, value=text)
    return int(text) if text else None
