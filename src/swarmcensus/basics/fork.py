"""Work beside one's own, in a copy of this process: for what Python does one by one, as drawing or compiling."""

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
    """Begin some work, and return what waits for it and gives its result, or raises what it raised.

    While it waits it calls `meanwhile` now and then.
    Where a process cannot safely be copied, or there is one core, the work is done only then, here: threads that
    others started may hold locks that no copy would ever see opened.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    alone = threading.active_count() == 1 and not multiprocessing.current_process().daemon  # which may have no children
    if sys.platform != "linux" or cores < 2 or not alone:
        return work
    context = multiprocessing.get_context("fork")
    mine, its = context.Pipe(duplex=False)
    copy = context.Process(target=_tell, args=(work, its), daemon=True)  # it ends where this process does
    try:
        copy.start()
    except OSError:  # no more processes, or too little memory
        mine.close()
        return work
    finally:
        its.close()

    def ended() -> Result:
        try:
            while not mine.poll(WAIT_SECONDS):
                meanwhile()
            good, result = mine.recv()
        except (EOFError, pickle.UnpicklingError):  # it was killed
            return work()
        finally:
            mine.close()
            copy.join()
        if good:
            return result  # type: ignore[no-any-return]
        raise result

    return ended


def _tell(work: Callable[[], Any], to: Any) -> None:
    try:
        told = True, work()
    except KeyboardInterrupt:  # the process that waits was told too
        return
    except Exception as error:
        told = False, error
    to.send(told)
