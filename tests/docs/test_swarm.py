"""The page of swarms of processes: its commands run, and it names all that the command takes."""

import re
import sys
from pathlib import Path

import pytest

from swarmcensus.cli.commands import main, parser
from swarmcensus.reliving.logs import read_log
from swarmcensus.swarm.faults import ACTIONS
from tests.support.pages import blocks, commands
from tests.support.places import ROOT

PAGE = ROOT / "docs" / "a-swarm-on-your-desk.md"
COMMANDS = [words[1:] for text in blocks(PAGE, "console") for words in commands(text)]


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="processes with signals")
def test_its_commands_run_one_after_the_other(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("desk.toml").write_text(*blocks(PAGE, "toml"), encoding="utf-8")
    for arguments in COMMANDS:
        assert main(arguments) == 0
        *told, wrote = capsys.readouterr().out.splitlines()
        folder = Path(wrote.partition(":")[0])
        assert all(read_log(path).ticks for path in folder.glob("robot-*.log"))
        assert not any("died" in line for line in told)
        assert wrote.endswith(f"next: swarmcensus relive {folder}")
    assert {path.name for path in tmp_path.iterdir()} == {"desk.toml", "swarm", "swarm-2", "storm"}


def test_it_shows_the_lines_that_are_printed():
    shown = blocks(PAGE, "console")[0]
    heads = re.findall(r"^(\w+) ", shown, re.MULTILINE)
    assert heads == ["robots", "error", "right", "message", "heard", "missed", "processor", "memory"]


def test_it_names_every_option_and_every_fault():
    text = PAGE.read_text(encoding="utf-8")
    given = parser()._subparsers._group_actions[0].choices["swarm"]._option_string_actions
    output = {"--help", "--quiet", "--verbose"}
    assert {option for option in given if option.startswith("--") and f"`{option}" not in text} == output
    assert all(re.search(rf"`[^`]*s {action}\b", text) for action in ACTIONS)


@pytest.mark.parametrize("name", ["costs", "simulator"])
def test_its_tables_are_those_of_the_benchmark(name):
    text = PAGE.read_text(encoding="utf-8")
    table = text.partition(f"<!-- {name}: python benchmarks/swarm.py --write -->")[2].partition("<!-- end of")[0]
    assert len(re.findall(r"^\|", table, re.MULTILINE)) > 6
