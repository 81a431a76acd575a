"""The program that a shell starts, tuned to start and end quickly.

In a command of half a second, garbage collection during imports took an eighth of the time, and deallocating modules at
the end a quarter, which is needless because the process ends.
"""

import _thread
import atexit
import codecs
import gc
import os
import signal
import sys
import threading
from types import FrameType
from typing import NoReturn

from swarmcensus.support.errors import STOPPED, STOPPING

ENDING = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
SOON = 0.05  # seconds, after which a callback has most likely ended
OBJECTS = 200_000  # new objects before garbage is collected: more than imports make

_received: list[int] = []  # of ENDING


def program() -> NoReturn:
    """Run the command line and end the process."""
    gc.set_threshold(OBJECTS)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else the shell asked to ignore it
        signal.signal(signal.SIGINT, _stop)
    for number in ENDING:
        if signal.getsignal(number) is signal.SIG_DFL:  # under nohup, SIGHUP stays ignored
            signal.signal(number, _stop)
    sys.unraisablehook = _stop_later
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # a shell closed it
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 - as long as the process
    os.environ["MPLBACKEND"] = "agg"  # figures are files, and matplotlib refuses to load with an unknown backend
    codecs.register_error("swarmcensus", _escaped)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="swarmcensus")  # type: ignore[union-attr]
    try:
        from swarmcensus.cli.commands import main

        code = main()
    except KeyboardInterrupt:  # before the command began
        print("swarmcensus: stopped", file=sys.stderr)
        code = STOPPED
    if _received:
        code = 128 + _received[0]  # as shells say it of a program that did not catch the signal
    others = (thread for thread in threading.enumerate() if thread is not threading.main_thread())
    if any(not thread.daemon for thread in others):  # the interpreter has to wait for them
        sys.exit(code)
    for number in (signal.SIGINT, *ENDING):
        signal.signal(number, signal.SIG_IGN)  # the process is ending already
    atexit._run_exitfuncs()
    try:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    except (OSError, ValueError):  # the reader of our output has gone
        sys.exit(code)
    os._exit(code)


def _stop(number: int, frame: FrameType | None) -> None:
    """End the command in good order, and the processes that it began: raise KeyboardInterrupt.

    A library that is being imported may turn it into another exception.
    """
    STOPPING.set()
    _received.extend([number] * (number in ENDING))
    signal.default_int_handler(number, frame)


def _stop_later(ignored: "sys.UnraisableHookArgs") -> None:
    """Stop again soon if a stop came where nothing can be raised, as in a callback of the compiler."""
    if not (STOPPING.is_set() and issubclass(ignored.exc_type, KeyboardInterrupt)):
        sys.__unraisablehook__(ignored)
        return
    again = threading.Timer(SOON, _thread.interrupt_main)
    again.daemon = True
    again.start()


def _escaped(error: UnicodeError) -> tuple[str, int]:
    """Letters that the encoding of standard output or error lacks, as JSON escapes them: \\u00e9 for é."""
    assert isinstance(error, UnicodeEncodeError)
    units = error.object[error.start : error.end].encode("utf-16-be", "surrogatepass").hex()
    return "".join(f"\\u{units[k : k + 4]}" for k in range(0, len(units), 4)), error.end
