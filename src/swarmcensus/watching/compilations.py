"""What Numba compiles in this process right now, and for whom: so that a page which waits can say what it waits for."""

import contextlib
import threading
from collections.abc import Iterator

from numba.core import event

from swarmcensus.studies.settings import Setting


class Compilations(event.Listener):  # type: ignore[misc]
    """What is compiled now; Numba compiles for one thread at a time."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.now = ""
        self._thread = threading.local()

    @contextlib.contextmanager
    def of(self, setting: Setting) -> Iterator[None]:
        """Say that what this thread compiles in a block is for a setting."""
        self._thread.setting, self._thread.depth = setting, 0
        try:
            yield
        finally:
            self._thread.setting = None

    def on_start(self, told: event.Event) -> None:
        """Note what is compiled: of functions that need others the outermost."""
        setting = getattr(self._thread, "setting", None)
        if setting is None:
            return
        self._thread.depth += 1
        if self._thread.depth == 1:
            of_brain = told.data["dispatcher"].py_func.__module__.endswith(".phases")
            name = " and ".join(dict.fromkeys(brain.name for brain in setting.crew)) if of_brain else "the engine"
            self.now = f"{name} for {'robots that move' if setting.body else 'fixed networks'}"

    def on_end(self, told: event.Event) -> None:
        """Note that it is done."""
        if getattr(self._thread, "setting", None) is None:
            return
        self._thread.depth -= 1
        if self._thread.depth == 0:
            self.now = ""


COMPILATIONS = Compilations()
event.register("numba:compile", COMPILATIONS)  # type: ignore[no-untyped-call]
