"""What a terminal of 80 columns shows."""

import importlib
import inspect
import io
import re

import pytest

from swarmcensus.cli import messages
from swarmcensus.cli.commands import main
from swarmcensus.cli.help import COMMANDS
from swarmcensus.support import terminal
from swarmcensus.support.errors import STOPPED, STOPPING
from swarmcensus.support.printed_tables import ASKED, REST, Column, Table


def test_help_has_a_line_for_each_command(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["--help"]) == main([]) == 0
    out = capsys.readouterr().out
    assert out == 2 * out[: len(out) // 2]
    lines = out[: len(out) // 2].splitlines()
    for name, command in COMMANDS.items():
        assert f"{name} {command.text}" in [" ".join(line.split()) for line in lines]
        module, _, function = command.function.partition(".")
        run = getattr(importlib.import_module(f"swarmcensus.cli.commands.{module}"), function)
        assert inspect.getdoc(run).partition("\n")[0] == command.text
    assert max(map(len, lines)) <= 80


def test_help_has_the_words_of_errors_and_fits_a_page(monkeypatch, capsys, refused):
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["reproduce", "--help"]) == 0
    assert re.match(
        r"Usage: swarmcensus reproduce \[WHAT\] \[OPTIONS\]\n.*\n  WHAT  ", capsys.readouterr().out, re.DOTALL
    )
    assert "RESULTS.nc is missing" in refused("show")
    assert main(["plan", "--help"]) == 0
    assert len(capsys.readouterr().out.splitlines()) <= 55


@pytest.mark.parametrize("set_", [True, False])
def test_no_color_leaves_nothing_bold(set_, monkeypatch):
    if set_:
        monkeypatch.setenv("NO_COLOR", "1")
    out = io.StringIO()
    monkeypatch.setenv("TERM", "xterm-256color")
    console = terminal.console(file=out, force_terminal=True, width=40)
    terminal.show(Table.of_rows({"head": False}, [["cell"]]), console)
    assert ("\x1b" in out.getvalue()) is not set_


class Terminal(io.StringIO):
    """A stream that is a terminal."""

    def isatty(self):
        return True


def test_warnings_and_errors_end_lines_between_words(monkeypatch):
    monkeypatch.setenv("COLUMNS", "16")
    text, error = "warning: a path/that/is/long stays whole", Terminal()
    assert messages._between_words(text, error).split("\n") == ["warning: a", "path/that/is/long", "stays whole"]
    assert messages._between_words(text, io.StringIO()) == text
    monkeypatch.setattr("sys.stderr", error)
    assert main(["show", "none.nc"]) == 2
    assert max(map(len, error.getvalue().splitlines())) <= 16


def test_columns_of_0_are_no_width(monkeypatch):
    monkeypatch.setenv("COLUMNS", "0")
    monkeypatch.delenv("SWARMCENSUS_TERMINAL")
    monkeypatch.setattr("sys.stdout", Terminal())
    assert terminal.console().width == 80


def printed(columns, width):
    out = io.StringIO()
    terminal.show(Table(columns), terminal.console(file=out, width=width))
    return " ".join(out.getvalue().splitlines()[0].split())


def test_columns_that_say_nothing_are_left_out():
    columns = [Column("name", ["a", "b"], number=False), Column("K", ["-", "-"]), Column("error", ["1", "-"])]
    never = Column("time", ["never", "never"], intervals=["always", "always"])
    assert printed(columns, 80) == printed([*columns, never], 80) == "name error"
    assert printed([columns[0], never], 80) == "name time [95 %]"


def test_what_was_asked_for_and_what_tells_rows_apart_stay_longest():
    columns = [
        Column("name", ["a"], number=False),
        Column("K", ["1"], rank=REST),
        Column("error", ["3"], rank=ASKED, intervals=["[1, 4]"]),
        Column("right", ["2"], rank=REST, intervals=["[1, 3]"]),
    ]
    assert printed(columns, 60) == "name K error [95 %] right [95 %]"
    assert printed(columns, 32) == "name K error [95 %] right"
    assert printed(columns, 24) == "name K error [95 %]"
    assert printed(columns, 20) == "name error [95 %]"
    assert printed(columns, 12) == "name error"
    rows = [{"first value": 0.12345678, "second": 123.456, "what": "a long text " * 4}]
    for width, shown in ((80, ["0.1235", "123.5", "a"]), (25, ["0.1235", "123.5"]), (10, ["0.1235"])):
        out = io.StringIO()
        terminal.show(Table.of(rows), terminal.console(file=out, width=width))
        assert out.getvalue().splitlines()[-1].split()[:3] == shown  # whole numbers, or none
    columns = [Column("f", ["0.55"]), Column("n", ["7"]), Column("K", ["142.5"], rank=ASKED)]
    assert (printed(columns, 20), printed(columns, 10)) == ("f n K", "f K")


def test_a_folder_that_an_output_makes_is_named(here, capsys):
    assert main(["new", "brain", "deep/mine.py"]) == 0
    assert capsys.readouterr().err.endswith("made the folder deep\n")


@pytest.mark.parametrize("raised", [AttributeError, KeyboardInterrupt])
def test_a_stop_is_no_defect(raised, here, monkeypatch, capsys):
    """A library that is imported may turn Ctrl-C into another exception."""
    monkeypatch.setattr(STOPPING, "is_set", lambda: True)
    monkeypatch.setattr("swarmcensus.cli.app.app", lambda: exec("raise raised", {"raised": raised}))
    assert main(["doctor"]) == STOPPED
    assert capsys.readouterr().err == "swarmcensus: stopped\n"


def test_an_optional_argument_may_stand_behind_options(here, refused):
    assert main(["new", "study", "--quiet", "mine.toml"]) == 0
    assert (here / "mine.toml").exists()
    assert "b.toml is an argument too many" in refused("run", "a.toml", "--quiet", "b.toml")
