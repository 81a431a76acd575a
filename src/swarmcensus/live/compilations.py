"""What Numba is compiling in this process, and for which swarm, so that a waiting page can say so."""

import contextlib
import threading
from collections.abc import Iterator

from numba.core import event

from swarmcensus.studies import Setting


class Compilations(event.Listener):  # type: ignore[misc]
    """What is being compiled, as text in `now`; Numba compiles for one thread at a time."""

    def __init__(self) -> None:
        """Start with nothing being compiled."""
        self.now = ""
        self._thread = threading.local()

    @contextlib.contextmanager
    def of(self, *settings: Setting) -> Iterator[None]:
        """Note that this thread compiles for settings while the block lasts."""
        self._thread.settings, self._thread.depth = settings, 0
        try:
            yield
        finally:
            self._thread.settings = ()

    def on_start(self, started: event.Event) -> None:
        """Note what is being compiled: the outermost function, if it needs others."""
        settings: tuple[Setting, ...] = getattr(self._thread, "settings", ())
        if not settings:
            return
        self._thread.depth += 1
        if self._thread.depth == 1:
            of_brain = started.data["dispatcher"].py_func.__module__.endswith(".brain_calls")
            names = dict.fromkeys(brain.name for one in settings for brain in one.brains)
            name = " and ".join(names) if of_brain else "the engine"
            self.now = f"{name} for {'robots that move' if settings[0].body else 'fixed networks'}"

    def on_end(self, ended: event.Event) -> None:
        """Note that it is compiled."""
        if not getattr(self._thread, "settings", ()):
            return
        self._thread.depth -= 1
        if self._thread.depth == 0:
            self.now = ""


COMPILATIONS = Compilations()
event.register("numba:compile", COMPILATIONS)  # type: ignore[no-untyped-call]
