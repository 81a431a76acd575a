"""Background work in a forked process, for work that holds Python's lock, such as drawing or compiling."""

import multiprocessing
import os
import pickle
import sys
import threading
from collections.abc import Callable
from typing import Any, TypeVar

Result = TypeVar("Result")
WAIT_SECONDS = 0.5


def in_background(work: Callable[[], Result], meanwhile: Callable[[], object] = lambda: None) -> Callable[[], Result]:
    """Start some work; returns a function that waits for it, and returns its result or raises its error.

    While waiting, the function calls `meanwhile` every half second. With one core, or if this process cannot safely be
    forked, the function does the work itself: locks of other threads would stay locked in the copy.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    # daemonic processes may have no children
    can_fork = threading.active_count() == 1 and not multiprocessing.current_process().daemon
    if sys.platform != "linux" or cores < 2 or not can_fork:
        return work
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    copy = context.Process(target=_send_result, args=(work, sender), daemon=True)  # ends with this process
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
            return work()
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


def _send_result(work: Callable[[], Any], sender: Any) -> None:
    try:
        outcome = True, work()
    except KeyboardInterrupt:  # the waiting process is interrupted too
        return
    except Exception as error:
        outcome = False, error
    sender.send(outcome)
