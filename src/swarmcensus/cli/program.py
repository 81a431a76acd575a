"""The program as a shell starts it: quick to begin, and quick to leave.

In half a second of work an eighth went into looking for circles among objects that imports make, and a quarter into
taking modules apart that end with the process anyway.
"""

import atexit
import gc
import os
import signal
import sys
import threading
from typing import NoReturn

from swarmcensus.basics.errors import STOPPED

OBJECTS = 200_000  # more than imports make: from so many new ones on circles are looked for


def program() -> NoReturn:
    """Run the command line and end the process."""
    gc.set_threshold(OBJECTS)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # a shell closed it
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 - as long as the process
    try:
        from swarmcensus.cli.commands import main

        code = main()
    except KeyboardInterrupt:  # before the command began
        print("swarmcensus: stopped", file=sys.stderr)
        code = STOPPED
    if any(not one.daemon for one in threading.enumerate() if one is not threading.main_thread()):  # who is waited for
        sys.exit(code)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends already
    atexit._run_exitfuncs()
    try:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    except (OSError, ValueError):  # nobody reads any more
        sys.exit(code)
    os._exit(code)
