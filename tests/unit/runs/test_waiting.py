"""What a person sees who waits for the compiler: one line with a count, whatever the number of brains."""

import io
import sys
import threading

import pytest

from swarmcensus.runs import progress
from swarmcensus.runs.collect import Progress
from swarmcensus.support.readers import AS_TERMINAL


class Terminal(io.StringIO):
    """A terminal of 100 columns, as far as a bar is concerned."""

    def isatty(self):
        return True


def waited(show, kinds=60):
    """Show how so many kinds of swarms are compiled, and then a trial that is run."""
    for k in range(kinds):
        show(Progress(0, 0, 0.0, 0.0, f"compiling {k + 1} of {kinds}: voter"))
    show(Progress(0, 1, 0.0, 1.0))
    show(Progress(1, 1, 1.0, 1.0))


@pytest.mark.parametrize("asked", ["", "FORCE_COLOR", "TTY_COMPATIBLE"])  # as continuous integration does
def test_compiling_many_brains_without_a_terminal(asked, monkeypatch, capsys):
    monkeypatch.delenv(AS_TERMINAL)
    monkeypatch.setenv(asked or "NOTHING", "1")
    with progress.bar_or_lines("board") as show:
        waited(show)
    assert capsys.readouterr().err.splitlines() == ["board: compiling 1 of 60: voter", "board: 0 of 1 trial, starting"]
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    with progress.bar_or_lines("board") as show:
        waited(show)
    assert "board: compiling 37 of 60: voter" in capsys.readouterr().err.splitlines()


def test_compiling_bar_on_a_terminal(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv(AS_TERMINAL, "100")
    monkeypatch.setenv("TERM", "xterm")
    before = threading.active_count()
    with progress.bar_or_lines("board") as show:
        assert threading.active_count() == before  # a process with threads cannot be copied, and would compile alone
        waited(show)
    seen = terminal.getvalue()
    assert all(f"compiling {k} of 60: voter" in seen for k in range(1, 61))
    assert "60 trials" not in seen
