"""What docs/comparing.md shows is what its commands print and draw."""

import re
import shutil

import numpy as np
import pytest
from PIL import Image

from swarmcensus import metrics
from swarmcensus.cli.commands import main
from swarmcensus.results.measures import OURS
from swarmcensus.statistics.significance import fewest_trials
from tests.support.pages import blocks, commands
from tests.support.places import ROOT

PAGE = ROOT / "docs" / "comparing.md"


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A folder in which the study of the page has been run."""
    folder = tmp_path_factory.mktemp("page")
    shutil.copytree(ROOT / "studies", folder / "studies")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        (run, _), *_ = (list(commands(text)) for text in blocks(PAGE, "console"))
        assert main(run[1:]) == 0
    return folder


@pytest.mark.long
def test_the_comparison_is_what_the_command_prints(ran, monkeypatch, capsys):
    monkeypatch.chdir(ran)
    first, *others, _ = blocks(PAGE, "console")
    _, compare = commands(first)
    capsys.readouterr()
    assert main(compare[1:]) == 0
    assert first.endswith("ranking.nc\n" + capsys.readouterr().out)
    for against in others:
        [held] = commands(against)
        assert main(held[1:]) == 0
        assert against.partition("...\n")[2] in capsys.readouterr().out


@pytest.mark.long
def test_the_other_commands_run_and_the_figure_is_theirs(ran, monkeypatch, capsys):
    monkeypatch.chdir(ran)
    printed = []
    for command in commands(blocks(PAGE, "console")[-1]):
        assert main(command[1:]) == 0
        printed.append(capsys.readouterr().out)
    with Image.open("ranking-ranks.png") as drawn, Image.open(ROOT / "docs" / "images" / "ranks.png") as shown:
        assert drawn.size == shown.size
        differ = np.abs(np.asarray(drawn.convert("L"), int) - np.asarray(shown.convert("L"), int)) > 64
    assert differ.mean() < 0.01
    assert "pairs.csv: 36 rows" in printed[2]
    [line] = (one for one in printed[1].splitlines() if re.match(r"    1  U\(0.525,0.975\)  minimalistic +\*", one))
    assert line  # alone, final errors tell apart what all measures do not
    assert "=" in next(one for one in blocks(PAGE, "console")[0].splitlines() if one.startswith("    1  ring"))


def test_the_page_lists_every_measure_and_which_way_is_better():
    text = PAGE.read_text(encoding="utf-8")
    listed = {}
    for names, better in re.findall(r"^\| (`\w+`(?:, `\w+`)*) \| [^|]* \| (\w+) \|", text, re.MULTILINE):
        listed |= dict.fromkeys(re.findall(r"\w+", names), better)
    assert listed == {name: "low" if one.low else "high" for name, one in OURS.items()}
    assert all(metrics.load(name).low is not None for name in metrics.PLUGINS.shipped)
    assert f"among 36 tests it takes {fewest_trials(36, 0.05)} trials" in " ".join(text.split())
