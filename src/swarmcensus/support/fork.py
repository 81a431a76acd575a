"""Background work in a forked process, for work that holds Python's lock, such as drawing or compiling."""

import contextlib
import ctypes
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from swarmcensus.support.cores import cores

Result = TypeVar("Result")
WAIT_SECONDS = 0.5
PDEATHSIG = 1  # of <linux/prctl.h>


def in_background(
    work: Callable[[], Result], meanwhile: Callable[[], object] = lambda: None, bounds: tuple[float, int] | None = None,
    if_killed: Callable[[], Result] | None = None,
) -> Callable[[], Result]:  # fmt: skip
    """Start some work; returns a function that waits for it, and returns its result or raises its error.

    While waiting, the function calls `meanwhile` every half second. `bounds` are the seconds of the processor after
    which the system kills the copy, and the bytes by which it may grow; then the result is that of `if_killed`, else
    of the work here. With one core, unless there are bounds, or if this process cannot safely be forked, the function
    does the work itself, without bounds: locks of other threads would stay locked in the copy.
    """
    # daemonic processes may have no children
    can_fork = threading.active_count() == 1 and not multiprocessing.current_process().daemon
    if sys.platform != "linux" or (cores() < 2 and not bounds) or not can_fork:
        return work
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    copy = context.Process(target=_send_result, args=(work, sender, os.getpid(), bounds), daemon=True)
    try:
        copy.start()
    except OSError:  # no more processes, or too little memory
        receiver.close()
        return work
    finally:
        sender.close()

    def wait() -> Result:
        try:
            while not receiver.poll(WAIT_SECONDS):
                meanwhile()
            succeeded, result = receiver.recv()
        except (EOFError, pickle.UnpicklingError):  # the copy was killed
            return (if_killed or work)()
        except KeyboardInterrupt:  # the copy may not receive the signal
            copy.terminate()
            raise
        finally:
            receiver.close()
            copy.join()
        if succeeded:
            return result  # type: ignore[no-any-return]
        raise result

    return wait


def end_with(parent: int) -> None:
    """Let this process end as soon as its parent does, however that ends; called by the child."""
    with contextlib.suppress(AttributeError, OSError):  # Linux ends it also in machine code that never returns
        ctypes.CDLL(None).prctl(PDEATHSIG, int(signal.SIGKILL))

    def look() -> None:
        while os.getppid() == parent:
            time.sleep(WAIT_SECONDS)
        os._exit(1)

    threading.Thread(target=look, daemon=True).start()


def bound_memory(room: int) -> None:
    """Let this process grow by at most so many bytes, if the system can tell its size."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        _, most = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + room, most))


def _send_result(work: Callable[[], Any], sender: Any, parent: int, bounds: tuple[float, int] | None) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # what a command does at its end is not for its copies
    end_with(parent)
    if bounds:
        signal.signal(signal.SIGPROF, signal.SIG_DFL)  # ends the process in C, too, where Python handles no signals
        signal.setitimer(signal.ITIMER_PROF, bounds[0])
        bound_memory(bounds[1])
    try:
        outcome = True, work()
    except KeyboardInterrupt:  # the waiting process is interrupted too
        return
    except Exception as error:
        outcome = False, error
    sender.send(outcome)
