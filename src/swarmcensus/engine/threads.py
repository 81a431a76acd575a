"""Threads that Ctrl-C can leave behind: machine code that never returns must not keep a process from ending."""

import concurrent.futures
import contextvars
import ctypes
import functools
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, ParamSpec, TypeVar

import numpy as np

from swarmcensus.engine.code_cache import not_compiled

Result = TypeVar("Result")
Given = ParamSpec("Given")
NOBODY_WAITS = 1 << 62  # more than threads will ever come to wait
LOOK_SECONDS = 0.5  # between two looks at whether Ctrl-C was pressed, of which Windows needs some
STOP_SECONDS = 0.05  # between two looks at whether a team should stop
LEAVE_SECONDS = 0.5  # for threads to end, before they are left behind


class LeavableThreads(concurrent.futures.Executor):
    """Daemon threads that run what is submitted: unlike with ThreadPoolExecutor, nothing waits for one that hangs."""

    def __init__(self, count: int) -> None:
        """Start them."""
        self._work: queue.SimpleQueue[tuple[Future[Any], Callable[[], Any]] | None] = queue.SimpleQueue()
        self._threads = [threading.Thread(target=self._run, name="swarmcensus", daemon=True) for _ in range(count)]
        for thread in self._threads:
            thread.start()

    def submit(self, function: Callable[..., Result], /, *given: Any, **named: Any) -> Future[Result]:
        """Run a function as soon as a thread is free."""
        future: Future[Result] = Future()
        self._work.put((future, functools.partial(function, *given, **named)))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the threads once all submitted work is done, and wait for them, but not long."""
        for _ in self._threads:
            self._work.put(None)
        for thread in self._threads if wait else ():
            thread.join(LEAVE_SECONDS / len(self._threads))

    def _run(self) -> None:
        while (item := self._work.get()) is not None:
            future, work = item
            if future.set_running_or_notify_cancel():
                _fulfil(future, work)
            del future, work, item


def run_together(function: Callable[[int, int, int, np.ndarray], Result], count: int, stop: np.ndarray) -> list[Result]:
    """Call function(number, gate, here, halt) in `count` threads, and return what they return, in order.

    Each gets its number, the addresses of a C function that lets other threads run and of an int64 by which they wait
    for each other (`shared_trials.py`), and an array that becomes 1 when `stop` does, or when any of them raises an
    error: the others then wait no more, and stop, and the error is raised.
    """
    halt, here = np.zeros(1, np.uint8), np.zeros(1, np.int64)
    gate = ctypes.CFUNCTYPE(None)(lambda: time.sleep(0.0))
    address = ctypes.cast(gate, ctypes.c_void_p).value
    team = LeavableThreads(count)
    futures = [team.submit(function, number, address, here.ctypes.data, halt) for number in range(count)]
    team.shutdown(wait=False)
    while concurrent.futures.wait(futures, STOP_SECONDS, concurrent.futures.FIRST_EXCEPTION).not_done:
        if stop[0] or any(future.done() and future.exception() for future in futures):
            halt[0], here[0] = 1, NOBODY_WAITS
    return [future.result() for future in futures]


def interruptible(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """Make a function that runs machine code end with KeyboardInterrupt at once at Ctrl-C.

    Python hears of Ctrl-C in the main thread only, and between calls of machine code. So a call in the main thread runs
    in a thread of its own, which is left behind then.
    """

    @functools.wraps(function)
    def call(*given: Given.args, **named: Given.kwargs) -> Result:
        if threading.current_thread() is not threading.main_thread() or not_compiled():
            return function(*given, **named)
        future: Future[Result] = Future()
        work = functools.partial(contextvars.copy_context().run, function, *given, **named)
        thread = threading.Thread(target=_fulfil, args=(future, work), name="swarmcensus", daemon=True)
        thread.start()
        while not concurrent.futures.wait((future,), LOOK_SECONDS).done:
            pass
        thread.join()  # a process with several threads cannot be forked
        return future.result()

    return call


def _fulfil(future: Future[Any], work: Callable[[], Any]) -> None:
    try:
        future.set_result(work())
    except BaseException as error:
        future.set_exception(error)
