"""The first seconds of a trial, which CPython computes in another process while this one compiles.

CPython gives the same bits as machine code, only more slowly. So a page may have its frames from either.
"""

import contextlib
import functools
import os
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Sequence
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

from swarmcensus.engine import LeavableThreads, code_cache, compiler

if TYPE_CHECKING:  # imported late, so that the process starts before Numba is imported here
    from swarmcensus.studies import Setting

COMMAND = "from swarmcensus.live.interpreted import main; main()"


class Interpreter:
    """The process in which CPython runs the engine; it lasts as long as somebody waits for machine code."""

    def __init__(self) -> None:
        """Start with nobody waiting."""
        self._waiting = 0
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()

    @functools.cached_property
    def _asking(self) -> LeavableThreads:
        return LeavableThreads(1)

    def start(self) -> None:
        """Start the process, if there is none."""
        with self._lock, contextlib.suppress(OSError):  # without it a page waits for machine code
            if self._process is None:
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-W", "ignore", "-c", COMMAND],
                    env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.DEVNULL,
                    start_new_session=True,  # Ctrl-C is for this process; that one ends with it
                )

    def __enter__(self) -> None:
        """Wait for machine code: the process lasts at least until `__exit__`."""
        with self._lock:
            self._waiting += 1
        self.start()

    def __exit__(self, *_: object) -> None:
        """End the process, if nobody else waits."""
        with self._lock:
            self._waiting -= 1
            process, self._process = (None, self._process) if self._waiting else (self._process, None)
        if process:
            process.kill()  # it may be in a brain's endless loop
            process.communicate()

    def ask(self, *request: Any) -> Future[Any]:
        """Ask the process for something of a trace; the result is in a tuple, or None if it cannot tell."""
        return self._asking.submit(self._answer, request)

    def _answer(self, request: tuple[Any, ...]) -> Any:
        process = self._process
        if process is None or process.stdin is None or process.stdout is None:
            return None
        try:
            pickle.dump(request, process.stdin)
            process.stdin.flush()
            return pickle.load(process.stdout)
        except (OSError, EOFError, ValueError, pickle.UnpicklingError):  # it was ended
            return None


INTERPRETER = Interpreter()


def answer_of(trace: Any, what: str, given: tuple[Any, ...]) -> Any:
    """What a trace answers: an attribute, or what a method returns."""
    known = getattr(trace, what)
    return known(*given) if callable(known) else known


def needs_compiling(settings: "Sequence[Setting]") -> bool:
    """Whether machine code that these settings need is not on disk, so that a page would wait for it."""
    return not code_cache.not_compiled() and not all(map(_is_compiled, settings))


def _is_compiled(setting: "Setting") -> bool:
    steers = any(brain.steers for brain in setting.brains)
    use = ("living", "live") if not setting.body else ("steering", "live") if steers else ("riding", "ride")
    kind, mixed = "moving" if setting.body else "network", len(setting.brains) > 1
    return compiler.is_known(*use) and all(compiler.is_compiled(brain, kind, mixed) for brain in setting.brains)


def prepared() -> contextlib.AbstractContextManager[None]:
    """On a new installation, start the interpreter before it is known what will be watched."""
    new = not any(compiler.is_known(*entry) for entry in (("living", "live"), ("riding", "ride")))
    return INTERPRETER if new and not code_cache.not_compiled() else contextlib.nullcontext()


def main() -> None:
    """Answer requests until standard input ends, one after the other."""
    requests: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def read() -> None:
        with contextlib.suppress(EOFError):
            while True:
                requests.put(pickle.load(sys.stdin.buffer))
        os._exit(0)  # also from a brain's endless loop

    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a topology's file prints is no answer
    threading.Thread(target=read, daemon=True).start()
    from swarmcensus.simulation import Stepped

    @functools.lru_cache(maxsize=4)
    def trace(packed: bytes) -> Stepped:
        return Stepped(*pickle.loads(packed))

    while True:
        packed, what, given = requests.get()
        try:
            answer: Any = (answer_of(trace(packed), what, given),)
        except Exception:  # the other process computes it too, and reports it
            answer = None
        answers.write(pickle.dumps(answer))
        answers.flush()
