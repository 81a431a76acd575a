"""How a run shows its progress: a bar on a terminal, plain lines elsewhere."""

import contextlib
import logging
import math
import sys
import time
from collections.abc import Iterator
from typing import Any

from swarmcensus.runs.collect import Progress, Report
from swarmcensus.support.formatting import counted

LOG = logging.getLogger(__name__)
LINE_SECONDS = 5.0  # between plain lines
FRAME_SECONDS = 0.1  # between redraws of a bar


@contextlib.contextmanager
def bar_or_lines(label: str) -> Iterator[Report]:
    """A callback for `run` that shows trials done, their rate and the time left: a bar on a terminal, else lines."""
    from swarmcensus.support.terminal import console

    out = console(stderr=True)
    if not out.is_terminal:
        yield _plain_lines(label)
        return
    from rich.markup import escape
    from rich.progress import BarColumn, Progress as Bar, TextColumn

    columns: tuple[Any, ...] = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=None),
        TextColumn("{task.fields[said]}"),
    )
    # no thread redraws it: a process with several threads cannot be forked, and compiling forks
    bar = Bar(*columns, console=out, transient=True, auto_refresh=False)
    task = bar.add_task(escape(label), total=None, said="")
    pace, drawn = _Pace(), -math.inf

    def show(progress: Progress) -> None:
        nonlocal drawn
        bar.start()  # not before: what was asked for may be refused
        what = progress.note or progress.stage or label  # one of them, to fit into 80 columns
        count = f"{progress.done:,} of {counted(progress.total, 'trial')}" * bool(progress.total)
        said, total = "  ".join((count, *pace.of(progress))), progress.total or None
        bar.update(task, description=escape(what), total=total, completed=progress.done, said=said)
        if progress.note or time.monotonic() - drawn >= FRAME_SECONDS:
            bar.refresh()
            drawn = time.monotonic()

    try:
        yield show
    finally:
        bar.stop()


@contextlib.contextmanager
def showing(progress: Report | bool, label: str) -> Iterator[Report]:
    """What an argument `progress` means: a function that is called, or True for a bar on a terminal.

    By True a notebook shows lines, seconds apart. By False, and elsewhere, nothing is shown.
    """
    if callable(progress):
        yield progress
    elif progress and (in_notebook() or (sys.stderr is not None and sys.stderr.isatty())):
        with bar_or_lines(label) as show:
            yield show
    else:
        yield lambda _: None


def in_notebook() -> bool:
    """Whether this process runs a notebook."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return hasattr(shell, "kernel")


def _plain_lines(label: str) -> Report:
    last, pace, before = time.monotonic(), _Pace(), (False, "")

    def show(progress: Progress) -> None:
        nonlocal last, before
        now, speed, this = time.monotonic(), pace.of(progress), (bool(progress.note), progress.stage)
        if this != before or now - last >= LINE_SECONDS:
            last = now
            print(_line(label, progress, speed), file=sys.stderr, flush=True)
        before = this

    return show


def _line(label: str, progress: Progress, speed: tuple[str, str]) -> str:
    """How far a run is, in a line."""
    trials = f"{progress.done:,} of {counted(progress.total, 'trial')}, " if progress.total else ""
    how = ", ".join(filter(None, [progress.note, *speed])) or "starting"
    return f"{label}: {f'{progress.stage}: ' * bool(progress.stage)}{trials}{how}"


class _Pace:
    """The rate of a run's trials and the time left, measured since the start of its present part.

    Trials found on disk took no time, and compiling says nothing about the speed of trials.
    """

    def __init__(self) -> None:
        self.started = self.begun = time.monotonic()
        self.work = 0.0  # that was done when this was last asked for
        self.found: tuple[int, float] | None = None  # trials and work that were done then

    def of(self, progress: Progress) -> tuple[str, str]:
        """Both as text; before anything is done, for how long it has been running, if for a second."""
        now = time.monotonic()
        if self.found is None or progress.work_done < self.work or progress.note:
            self.begun, self.found = now, None if progress.note else (progress.done, progress.work_done)
        self.work, ran = progress.work_done, now - self.begun
        if self.found is None or self.work <= self.found[1] or not ran:
            return clock(ran) * (ran >= 1.0), ""
        trials, work = progress.done - self.found[0], self.work - self.found[1]
        left = clock(ran * (progress.work_total - self.work) / work) + " left"
        if progress.part:
            left += f" of {progress.part}, {clock(now - self.started)} so far"
        return f"{trials / ran:,.0f}/s" if trials >= ran else f"{60.0 * trials / ran:.2g}/min", left


@contextlib.contextmanager
def log_compilation(name: str, what: str = "replay") -> Iterator[None]:
    """Log that `name` is compiled for `what`, if it is compiled and not found in the cache."""
    from numba.core import event

    class Announcer(event.Listener):  # type: ignore[misc]
        announced = False

        def on_start(self, event: object) -> None:
            if not self.announced:
                LOG.info("compiling what %s needs for %s, once on this machine", what, name)
            self.announced = True

        def on_end(self, event: object) -> None:
            pass

    with event.install_listener("numba:compile", Announcer()):
        yield


def clock(seconds: float) -> str:
    """Seconds as 1:02:03, or 2:03."""
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
