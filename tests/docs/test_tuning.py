"""What docs/tuning.md shows is what its command prints and writes."""

import re
import shutil

import pytest

from swarmcensus.cli.commands import main
from tests.support.pages import blocks, commands
from tests.support.places import ROOT

PAGE = ROOT / "docs" / "tuning.md"


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A folder in which the command of the page has been run."""
    folder = tmp_path_factory.mktemp("page")
    shutil.copytree(ROOT / "studies", folder / "studies")
    return folder


@pytest.mark.long
@pytest.mark.parametrize(("k", "written"), enumerate(["shy-tuned.toml", "slow-liar-worst.toml"]))
def test_the_search_prints_and_writes_what_the_page_shows(k, written, ran, monkeypatch, capsys):
    """But for how long it took."""
    monkeypatch.chdir(ran)
    shown = blocks(PAGE, "console")[k]
    [command] = commands(shown)
    assert main(command[1:]) == 0
    printed, told = (re.sub(r"\d+\.\d s of", "s of", text) for text in (capsys.readouterr().out, shown))
    assert told.partition("\n")[2] == printed
    assert (ran / written).read_text(encoding="utf-8") == blocks(PAGE, "toml")[k]


def test_the_page_lists_every_option():
    from swarmcensus.cli.commands import parser

    words = set(re.findall(r"`(--\w+)", PAGE.read_text(encoding="utf-8")))
    common = ("--verbose", "--quiet", "--json")  # of every command
    known = parser()._subparsers._group_actions[0].choices["tune"]._option_string_actions
    assert {one for one in known if one.startswith("--")} - {"--help", *common} <= words
