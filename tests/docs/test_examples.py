"""The examples of README and docs/ run, and print, write and draw what their pages show.

A text below a block of Python is its output; in a console, so is what stands below a command, where a line of three
dots stands for any lines.
"""

import re
import shutil
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from swarmcensus.cli.app import app
from swarmcensus.cli.commands import main
from swarmcensus.cli.help import COMMANDS
from swarmcensus.search.planning.mission import missions_of
from swarmcensus.studies.study import Study
from swarmcensus.support.toml_text import to_toml
from tests.support.pages import PAGES, assert_shown, blocks, commands, page_named
from tests.support.places import DOCS, EXAMPLE, ROOT

OTHER_PROGRAMS = """
    cd cut git less npm export make sh tools/lowest.sh pip python pytest ruff lint-imports mypy pre-commit mkdocs
    mpremote source .ci/run cosmic-ray cr-report
"""
LONG_PYTHON = "brain-contract comparing data-format tuning"
CONSOLES = dict.fromkeys(("a-swarm-on-your-desk", "comparing", "data-format", "plotting", "theory", "tuning"))
CONSOLES["theory"] = 1  # console block is run of this page, and all of the others: the rest take minutes
NOT_ALWAYS_SO = ("a-swarm-on-your-desk",)  # its swarms run in real time, and print other numbers each time
IMAGES = {
    "ranking-ranks.png": "ranks.png", "lines.png": "lines.png", "small-world-profiles.png": "profiles.png",
    "differences.png": "differences.png",
}  # fmt: skip


def examples(*languages):
    texts = [pytest.param(t, id=f"{page.name}-{k}") for page in PAGES for k, t in enumerate(blocks(page, *languages))]
    return pytest.mark.parametrize("text", texts)


# ---- run
@pytest.fixture
def folder(here, monkeypatch):
    """A folder with the shipped studies, and the files of the example beside them."""
    shutil.copytree(ROOT / "studies", here / "studies")
    for file in filter(Path.is_file, EXAMPLE.iterdir()):
        shutil.copy(file, here)
    monkeypatch.syspath_prepend(here)
    return here


@pytest.mark.long(only=[f"{name}.md" for name in LONG_PYTHON.split()])
@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "python")], ids=lambda page: page.name)
def test_python_runs_and_prints_what_the_page_shows(page, folder, capsys):
    names = {"__name__": "example"}
    for text in blocks(page, "python"):
        capsys.readouterr()
        exec(compile(text, page.name, "exec"), names)
        below = page.read_text(encoding="utf-8").partition(text + "```\n\n```text\n")[2]
        if below:
            assert_shown(capsys.readouterr().out, below.partition("```")[0])


@pytest.mark.long(but=["data-format", "theory"])
@pytest.mark.skipif(sys.platform == "win32", reason="processes with signals")
@pytest.mark.parametrize("name", CONSOLES)
def test_consoles_print_write_and_draw_what_the_page_shows(name, folder, accepted):
    page = page_named(name)
    before = {path.name for path in folder.iterdir()}
    if name == "a-swarm-on-your-desk":
        Path("desk.toml").write_text(*blocks(page, "toml"), encoding="utf-8")
    for text in blocks(page, "console")[: CONSOLES[name]]:
        for command, shown in commands(text, shown=True):
            printed = accepted(*command[1:]).out
            parts = shown.split("...\n") if shown and name not in NOT_ALWAYS_SO else []
            for part in filter(None, map(untimed, parts)):
                assert_shown(untimed(printed), part, whole=False)
    written = {path.name for path in folder.iterdir()} - before
    for file in written & {"shy-tuned.toml", "slow-liar-worst.toml"}:
        text = Path(file).read_text(encoding="utf-8")
        assert sum(block in text for block in blocks(page, "toml")) == 1
    for file in written & set(IMAGES):
        with Image.open(file) as drawn, Image.open(DOCS / "images" / IMAGES[file]) as shown:
            assert drawn.size == shown.size
            differ = np.abs(np.asarray(drawn.convert("L"), int) - np.asarray(shown.convert("L"), int)) > 64
        assert differ.mean() < 0.01  # letters are drawn by a library of the machine


def untimed(text):
    """A text without durations, and without spaces at ends of lines."""
    return re.sub(r" +$", "", re.sub(r"\d+\.\d s of", "s of", text), flags=re.MULTILINE)


def test_the_recorded_example_is_what_its_study_makes(folder, capsys):
    """The commands of docs/data-format.md give the files of studies/example: write both again where numbers change."""
    example = folder / "studies" / "example"
    (example / "observations.csv").unlink()
    (example / "links.csv").unlink()
    assert main(["run", "studies/example/recorded.toml"]) == 0
    [shown] = (t for t in blocks(page_named("data-format"), "console") if "--recording" in t)
    record, *_ = commands(shown)
    assert main(record[1:]) == 0
    for name in ("observations.csv", "links.csv"):
        assert (example / name).read_bytes() == (EXAMPLE / name).read_bytes()


def test_the_study_page_shows_errors_as_they_are(here, capsys):
    plain = "trials = 1\n[swarm]\nrobots = 5\naccuracy = 0.7\n[world]\ntopology = 'ring'\nfill_ratio = 0.5"
    for right, wrong in (("[schedule]", "[schedule]\nround = 3"), ("fill_ratio = 0.5", "fill_ratio = 1.5")):
        Path("s.toml").write_text(f"{plain}\n[schedule]\n".replace(right, wrong), encoding="utf-8")
        assert main(["run", "s.toml"]) == 2
        assert capsys.readouterr().err in page_named("study-file").read_text(encoding="utf-8")


# ---- read
@examples("toml")
def test_toml_is_a_study_or_a_change_to_one(text):
    tables = {"trials": 1, "swarm": {"robots": 20, "accuracy": 0.7}, "world": {"topology": "ring", "fill_ratio": 0.55}}
    found = tomllib.loads(text)
    if "wanted" in found:
        assert missions_of(found, base=EXAMPLE)
        return
    if not {"trials", "swarm", "world"} <= set(found):
        for key, value in found.items():
            tables[key] = tables[key] | value if isinstance(tables.get(key), dict) else value
        found = tables
    assert Study.parse(to_toml(found), context={"base": EXAMPLE}).settings()


PROGRAM = app(*COMMANDS)


@examples("console", "sh")
def test_commands_parse(text):
    assert list(commands(text))
    for program, *arguments in commands(text):
        if program == "swarmcensus":
            PROGRAM.parse_args(arguments)
        else:
            assert program in OTHER_PROGRAMS.split()
