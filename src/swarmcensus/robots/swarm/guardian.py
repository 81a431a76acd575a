"""Ends the robots of a command that was killed. Plain Python, run by itself: it lives as long as the command's pipe.

A line is a process that has started, or with a minus sign one that has ended.
"""

import contextlib
import os
import signal
import sys


def main() -> None:
    """Note who runs until the pipe closes, then end them, also those that are stopped."""
    running: set[int] = set()
    for line in sys.stdin:
        number = int(line)
        if number > 0:
            running.add(number)
        else:
            running.discard(-number)
    for number in running:
        with contextlib.suppress(OSError):  # it has ended
            os.killpg(number, signal.SIGKILL)


if __name__ == "__main__":
    main()
