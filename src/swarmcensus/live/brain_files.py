"""Brain files that are read again when they are saved, so that a page shows what is being edited."""

import threading
from collections.abc import Iterable
from pathlib import Path

from swarmcensus import brains
from swarmcensus.brains import Brain
from swarmcensus.support.errors import InputError
from swarmcensus.support.plugins import read_source


class BrainFiles:
    """The brains that were given as paths, as their files are now; a broken file keeps its last working brain."""

    def __init__(self, given: Iterable[Brain] = ()) -> None:
        """Note which files there are."""
        self.version = 0  # counts the files that were saved
        self._brains = {brain.name: brain.as_written for brain in given if brain.name not in brains.PLUGINS}
        self._saved = {name: _stamp(brain.path) for name, brain in self._brains.items()}
        self._errors: dict[str, str] = {}
        self._gone: dict[str, set[str]] = {}
        self._lock = threading.Lock()

    def latest(self, brain: Brain) -> Brain:
        """A brain as its file is now, with the same parameters as far as the file still has them."""
        now = self._brains.get(brain.name)
        if now is None or now.source == brain.source:
            return brain
        lengths = {name: brains.length(value) for name, value in now.parameters.items()}
        still = {name: value for name, value in brain.overrides if lengths.get(name) == brains.length(value)}
        return now.with_parameters(still).with_numbers(brain.numbers)

    def watches(self, brain: Brain) -> bool:
        """Whether a brain is one of these files."""
        return brain.name in self._brains

    def has_lost(self, brain: str, parameter: str) -> bool:
        """Whether the file of this name once had a parameter, and has none now."""
        return parameter in self._gone.get(brain, ()) and parameter not in self._brains[brain].parameters

    def look(self, shown: Iterable[Brain]) -> str:
        """Read again what was saved since the last look; returns what is wrong with the files of `shown`, or ""."""
        with self._lock:
            for name, known in self._brains.items():
                saved = _stamp(known.path)
                if saved != self._saved[name]:
                    self._saved[name] = saved
                    self.version += self._read(name, known)
            return next((self._errors[brain.name] for brain in shown if brain.name in self._errors), "")

    def _read(self, name: str, known: Brain) -> bool:
        """Read a file; returns whether its brain is another one now."""
        try:
            brain = brains.parse(read_source("brain", known.path), name, known.path)
        except InputError as error:
            self._errors[name] = str(error)
            return False
        self._errors.pop(name, None)
        self._gone[name] = self._gone.get(name, set()) | known.parameters.keys()
        self._brains[name] = brain
        return brain.source != known.source


def _stamp(path: Path) -> tuple[int, int]:
    """What changes when a file is saved; (0, 0) while there is none."""
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_mtime_ns, found.st_size
