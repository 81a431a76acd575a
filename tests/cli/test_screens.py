"""What a terminal of 80 columns shows."""

import contextlib
import importlib
import inspect
import io
import json
import logging
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rich.live import Live
from rich.text import Text

import swarmcensus as sc
from swarmcensus.cli import messages
from swarmcensus.cli.commands import main
from swarmcensus.cli.help import COMMANDS
from swarmcensus.support import terminal
from swarmcensus.support.control_characters import CONTROL, Escaping
from swarmcensus.support.documents import json_value
from swarmcensus.support.errors import STOPPED, STOPPING
from swarmcensus.support.formatting import fixed
from swarmcensus.support.printed_tables import ASKED, REST, Column, Table
from swarmcensus.support.readers import AS_TERMINAL
from swarmcensus.support.terminal import console
from tests.support.places import DOCS


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


def test_help_has_the_words_of_errors_and_fits_a_page(monkeypatch, capsys, accepted, refused):
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["reproduce", "--help"]) == 0
    usage = r"Usage: swarmcensus reproduce \[WHAT\] \[OPTIONS\]\n.*\n  WHAT  "
    assert re.match(usage, capsys.readouterr().out, re.DOTALL)
    assert "RESULTS.nc is missing" in refused("show")
    assert len(accepted("plan", "--help").out.splitlines()) <= 55


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
        Column("name", ["a"], number=False), Column("K", ["1"], rank=REST),
        Column("error", ["3"], rank=ASKED, intervals=["[1, 4]"]),
        Column("right", ["2"], rank=REST, intervals=["[1, 3]"]),
    ]  # fmt: skip
    for width, heads in ((60, "name K error [95 %] right [95 %]"), (32, "name K error [95 %] right"),
                         (24, "name K error [95 %]"), (20, "name error [95 %]"), (12, "name error")):  # fmt: skip
        assert printed(columns, width) == heads
    rows = [{"first value": 0.12345678, "second": 123.456, "what": "a long text " * 4}]
    for width, shown in ((80, ["0.1235", "123.5", "a"]), (25, ["0.1235", "123.5"]), (10, ["0.1235"])):
        out = io.StringIO()
        terminal.show(Table.of(rows), terminal.console(file=out, width=width))
        assert out.getvalue().splitlines()[-1].split()[:3] == shown  # whole numbers, or none
    columns = [Column("f", ["0.55"]), Column("n", ["7"]), Column("K", ["142.5"], rank=ASKED)]
    assert (printed(columns, 20), printed(columns, 10)) == ("f n K", "f K")


def test_a_folder_that_an_output_makes_is_named(here, accepted):
    assert accepted("new", "brain", "deep/mine.py").err.endswith("made the folder deep\n")


@pytest.mark.parametrize("raised", [AttributeError, KeyboardInterrupt])
def test_a_stop_is_no_defect(raised, here, monkeypatch, capsys):
    """A library that is imported may turn Ctrl-C into another exception."""
    monkeypatch.setattr(STOPPING, "is_set", lambda: True)
    monkeypatch.setattr("swarmcensus.cli.app.app", lambda: exec("raise raised", {"raised": raised}))
    assert (main(["doctor"]), capsys.readouterr().err) == (STOPPED, "swarmcensus: stopped\n")


def test_an_optional_argument_may_stand_behind_options(here, refused):
    assert main(["new", "study", "--quiet", "mine.toml"]) == 0
    assert (here / "mine.toml").exists()
    assert "b.toml is an argument too many" in refused("run", "a.toml", "--quiet", "b.toml")


# ---- how much commands say: one JSON document, nothing but answers, or all that goes on
STUDY = """
name = "two"
trials = 6
swarm = {robots = [6, 9], accuracy = 0.8, brain = ["minimalistic", "commons"]}
world = {topology = "ring", fill_ratio = 0.55}
schedule = {rounds = 30, observations_per_round = 5}
"""
PLAN = "plan --set robots=9 --set topology=ring --set accuracy=0.8 --set error=0.1 --set fill_ratio=0.5 --trials 50 "


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("said")
    (folder / "two.toml").write_text(STUDY)
    sc.run(sc.Study.load(folder / "two.toml"), jobs=1, out=folder / "two.nc")
    return folder


@pytest.fixture
def said(results, monkeypatch, capsys):
    """What a command prints: its code, standard output and standard error."""
    monkeypatch.chdir(results)

    def said(line):
        return main(line.split()), *capsys.readouterr()

    return said


@pytest.fixture
def both(said):
    """The document of a command, and the words of its table."""

    def both(line):
        code, out, _ = said(f"{line} --json")
        same, table, _ = said(line)
        assert code == same
        found = json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
        assert found["format"] == "swarmcensus answer 1"
        return found, table

    return both


def test_numbers_that_json_lacks_are_words():
    words = {"a": ["infinity", "-infinity", None, -2.0], "b": "-infinity"}
    assert json_value({"a": np.array([np.inf, -np.inf, np.nan, -2.0]), "b": -np.inf}) == words


def test_run_and_show_tell_the_same_summary(both):
    ran, _ = both("run two.toml")
    shown, table = both("show two.nc")
    own = ("command", "files", "next")
    assert {k: v for k, v in ran.items() if k not in own} == {k: v for k, v in shown.items() if k not in own}
    assert shown["trials_done"] == 24
    for row in shown["rows"]:
        start = rf"^ +{row['setting']} +{row['brain']} +{row['robots']} +{fixed(row['convergence_round'])} "
        assert re.search(start, table, re.MULTILINE)


def test_status_and_verify(both):
    found, _ = both("status two.nc")
    assert (found["trials_done"], found["trials_total"], found["settings_total"]) == (24, 24, 4)
    data = sc.load("two.nc")
    data["final_estimate"][2, 3, 1] = 0.125
    sc.save(data, "bad.nc")
    found, _ = both("verify bad.nc --all")
    assert (found["trials_checked"], found["labels"], found["seed"]) == (24, [], None)
    [one] = found["differences"]
    assert (one["setting"], one["trial"], one["variable"], one["stored"]) == (2, 3, "final_estimate", 0.125)


def test_a_wrong_column_costs_no_results(said):
    code, _, error = said("run two.toml --out columns.nc --columns final_eror")
    assert (code, Path("columns.nc").exists()) == (2, True)
    assert "--columns final_eror: did you mean 'final error'?" in error


def test_a_comparison(both):
    found, page = both("compare two.nc --by robots --metric final_error")
    assert {row["contender"] for row in found["worlds"]} == {"minimalistic", "commons"}
    assert found["pairs"][0]["unit"] == "1"
    assert [sentence for sentence in found["sentences"] if sentence not in page] == []
    for row in found["rows"]:
        assert re.search(rf"{row['contender']}\s+{row['worlds']}\s+{row['final_error_best']} ", page)


@pytest.mark.long(only=["list brains"])
@pytest.mark.parametrize("command", ["list", "list brains", "list studies"])
def test_lists(command, both):
    found, table = both(command)
    assert len(found["rows"]) > 30
    assert {row["name"] for row in found["rows"]} <= {*table.split()}
    for row in found["rows"]:
        if "memory_bytes" in row:
            assert re.search(rf"^{row['name']}\s+{row['memory_bytes']:,}\s+{row['message_bytes']:,}\s", table, re.M)


def test_quiet_says_nothing_but_answers_and_errors(said, tmp_path):
    for line in (f"merge two.nc --out {tmp_path}/m.nc", f"export two.nc --out {tmp_path}/q.csv"):
        assert said(f"{line} --quiet") == (0, "", "")
    Path("edge.toml").write_text(STUDY.replace("0.55", "0.5").replace("[6, 9]", "6"))
    assert "warning: " in said("run edge.toml")[2]
    for line, answer in (
        ("verify two.nc", "24 trials run again"), (f"{PLAN} --set brain=minimalistic", "mission: the shortest time"),
        ("run edge.toml --fresh", "final error"),
    ):  # fmt: skip
        code, out, error = said(f"{line} -q")
        assert (code, answer in out, error) == (0, True, "")
    assert said("show none.nc -q") == (2, "", "swarmcensus: results file none.nc: there is no such file\n")


def test_logging_is_restored_after_a_command(said):
    before = logging.getLogger("swarmcensus").handlers[:], logging.getLogger("swarmcensus").level
    said("show two.nc -q")
    assert (logging.getLogger("swarmcensus").handlers[:], logging.getLogger("swarmcensus").level) == before


@pytest.mark.long
@pytest.mark.interpreted
def test_summary_of_done_robots_and_faults(said, results):
    study = STUDY.replace('"commons"]', '"sure"]').replace("[6, 9]", "9").replace("rounds = 30", "rounds = 60")
    study += 'faults = [{at = 5, robots = 0.1, stop = "sensing", until = 9}, {at = 7, robots = 1, stop = "talking"},'
    study += '{at = 8, robots = {named = [2, 4]}, stop = "talking"}]\n'
    Path(results, "done.toml").write_text(study + 'members = [{robots = 1, brain = "shouter", honest = false}]\n')
    _, table, _ = said("run done.toml")
    _, out, _ = said("show done.nc --json")
    rows = {row["brain"]: row for row in json.loads(out)["rows"]}
    data = sc.load("done.nc")
    [k] = np.flatnonzero(data["brain"].values == "sure")
    assert rows["minimalistic"]["done"] is None
    assert rows["sure"]["done"] == np.isfinite(data["done_round"].values[k]).mean()
    assert f" {100 * rows['sure']['done']:.1f}\n" in table
    assert 'fault {at = 5, robots = 0.1, stop = "sensing", until = 9}\n' in table
    assert 'fault {at = 8, robots = {named = [2, 4]}, stop = "talking"}\n' in table
    assert "adversaries among the robots: shouter\n" in table


def test_the_page_of_the_command_line_shows_an_error_as_it_is(said):
    code, out, err = said("plot two.nc --kind lnes")
    assert (code, out) == (2, "")
    page = (DOCS / "reference" / "command-line.md").read_text(encoding="utf-8")
    assert f"$ swarmcensus plot my_study.nc --kind lnes\n{err}" in page


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a shell of POSIX closes them, and has /dev/full")
@pytest.mark.parametrize(("words", "code", "said"), [
    ("list studies >&-", 0, ""), ("show none.nc 2>&-", 2, ""), ("list studies >&- 2>&-", 0, ""),
    ("list studies > /dev/full", 2, "swarmcensus: No space left on device\n"),
])  # fmt: skip
def test_streams_that_are_closed_or_full_have_an_exit_code(words, code, said, results):
    line = f"{sys.executable} -m swarmcensus {words}"
    done = subprocess.run(line, shell=True, capture_output=True, text=True, cwd=results)
    assert (done.returncode, done.stdout + done.stderr) == (code, said)


def test_a_reader_that_goes_away_is_no_error(results):
    """As `| head -1` does."""
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "swarmcensus", "list", "studies"]
    done = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, cwd=results, text=True)
    os.close(write)
    assert (done.returncode, done.stderr) == (0, "")


EVIL = "\x1b[2J\x07\x7f\x9b1m\u202e\u2066\u061c\u200f"
SHOWN = r"\u001b[2J"


@pytest.fixture
def hostile(results, tmp_path):
    """Results of a stranger who has put escape sequences into names."""
    data = sc.load(results / "two.nc").assign_attrs({"title": f"two{EVIL}", f"note{EVIL}": "x"})
    data["brain"].values[0] = f"commons{EVIL}"
    sc.save(data, tmp_path / "hostile.nc")
    return tmp_path / "hostile.nc"


@pytest.mark.parametrize("columns", ["100", ""], ids=["terminal", "pipe"])
def test_names_cannot_control_a_terminal(columns, hostile, capsys, monkeypatch):
    monkeypatch.setenv(AS_TERMINAL, columns)
    monkeypatch.setenv("FORCE_COLOR", "1")
    for line in ("show", "show --json", "show --label x{0}", "compare", "merge --out {0}.png"):
        name, *options = line.split()
        with contextlib.suppress(SystemExit):
            main([name, str(hostile), *(option.format(EVIL) for option in options)])
        out, err = capsys.readouterr()
        said = re.sub(r"\x1b\[[\d;]*m", "", out) + err  # without colours
        assert SHOWN in said, line
        assert not CONTROL.search(said), line
        if line == "show --json":
            assert json.loads(out)["title"] == f"two{EVIL}"


def test_what_ends_colours_is_passed_on():
    """A library may write it when Python ends, to what was standard output when it was imported."""
    stream = io.StringIO()
    Escaping(stream).write("\x1b[0m")
    assert stream.getvalue() == "\x1b[0m"


def test_names_cannot_control_a_progress_bar():
    file = io.StringIO()
    with Live(console=console(file=file, force_terminal=True, force_jupyter=False), auto_refresh=False) as live:
        live.update(Text(EVIL), refresh=True)
    assert SHOWN in file.getvalue()
    assert "\x1b[2J" not in file.getvalue()


def test_an_error_on_a_terminal_that_was_closed_has_its_exit_code(monkeypatch):
    class Closed(io.StringIO):
        def write(self, _):
            raise OSError(5, "Input/output error")

    monkeypatch.setattr(sys, "stderr", Closed())
    assert main(["show", "nothing.nc"]) == 2


def test_ctrl_c_at_the_start_has_no_traceback():
    code = """if True:
        from swarmcensus.cli import app, program
        def stopped(*_):
            raise KeyboardInterrupt
        app.app = stopped
        program.program()
    """
    done = subprocess.run([sys.executable, "-c", code, "list"], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "swarmcensus: stopped\n")
