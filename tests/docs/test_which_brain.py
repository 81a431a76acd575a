"""docs/which-brain.md says what the leaderboard says: every number of it, and what it puts into words."""

import csv
import re
import tomllib

import pytest

import swarmcensus as sc
from swarmcensus.studies.study import Study
from swarmcensus.support.toml_text import to_toml
from tests.support.places import DOCS

PAGE = (DOCS / "which-brain.md").read_text(encoding="utf-8")
OWN = (DOCS / "leaderboard.md").read_text(encoding="utf-8")
BOARD = DOCS.parent / "benchmarks" / "tables" / "leaderboard.csv"
BOUNDS = {"oracle"}


def rows(text):
    """Each table of a text: its head, and its rows, cells without marks."""
    for block in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        head, _, *body = ([cell.strip(" *`") for cell in line.split("|")[1:-1]] for line in block.splitlines())
        yield head, body


@pytest.fixture(scope="module")
def board():
    """The value of each brain in each column of the leaderboard, as it is printed."""
    with BOARD.open(encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    return {(line["brain"], column): value for line in lines for column, value in line.items() if value}


def test_advice_follows_the_leaderboard(board):
    def order(column, best=min):
        values = {b: float(v) for (b, c), v in board.items() if c == column and b not in BOUNDS}
        return sorted(values, key=values.get, reverse=best is max)

    for column in ("networks", "moving", "poor sensors", "mixed sensors"):
        assert {"commons", "swift"} <= set(order(f"error: {column}")[:5])
    assert order("error: 90 % (liars)")[0] == "steadfast"
    assert order("error: 10 % liars")[:3] == ["steadfast", "minimalistic", "leaver"]
    assert {"commons", "swift"} <= set(order("error: 30 % liars")[-5:])
    assert order("error: 30 % liars")[:2] == order("right %: 30 % liars", max)[:2] == ["steadfast", "alone"]
    assert order("error: change")[:2] == ["tracking", "census"]
    opinions = {b for b, c in board if c.startswith("right") and (b, "error: networks") not in board}
    assert next(b for b in order("right %: f near 1/2", max) if b in opinions).startswith("direct-comparison")
    assert {"tracking", "bayes-cpf"} <= {b.partition(" ")[0] for b in order("right %: change", max)[:6]}
    assert order("memory", max)[0].startswith("changing-floor")


def test_numbers_in_the_text_are_in_the_tables():
    words = re.sub(r"^```text\n(?s:.*?)^```|(?:^\|.*\n)+|\]\([^)]*\)", "", PAGE, flags=re.MULTILINE)
    study = tomllib.loads((DOCS.parent / "studies" / "leaderboard.toml").read_text(encoding="utf-8"))
    changes = [case["fill_ratio"] for case in study["case"] if isinstance(case.get("fill_ratio"), dict)]
    ratios = {*study["world"]["fill_ratio"], *(change[end] for change in changes for end in ("from", "to"))}
    worlds = {"0.1", "0.05", "0.7", *map(str, ratios)}  # seconds a round, half a tenth, an accuracy
    assert set(re.findall(r"\d+\.\d+", words)) <= worlds


def test_worlds_in_which_our_brains_are_worse(benchmark):
    """The table itself is measured by the command; here, that its worlds are those, and that each row shows a loss."""
    [block] = re.findall(r"```text\n(.*?)```", PAGE, re.DOTALL)
    _, *lines = block.splitlines()
    for line, (world, (ours, *_)) in zip(lines, benchmark("liars").WORLDS.items(), strict=False):
        found = re.fullmatch(rf"{re.escape(world)} +{ours} +([\d.]+) +([\d.]+) +([\d.]+)  ([\d.]+) .*", line)
        assert found, line
        mine, *others = map(float, found.groups())
        assert mine > 1.5 * min(others)


def test_ones_own_brain_is_shown_on_the_same_board(board):
    shown = re.findall(r"^ *\d* +([\w-]+) +[\d.]+ +[\d.]+ +[\d.]+ +([\d.]+) +([\d.]+)$", OWN, re.MULTILINE)
    assert len(shown) == 3
    columns = ("error: networks", "error: moving")
    assert shown == [(name, *(board[name, column] for column in columns)) for name, *_ in shown]
    kind = re.search(r"loses most in '(.+)'", OWN)[1]
    assert f"error: {kind}" in {column for _, column in board}


@pytest.mark.long
def test_own_brain_on_networks():
    tables = tomllib.loads((DOCS.parent / "studies" / "leaderboard.toml").read_text(encoding="utf-8"))
    tables["swarm"]["brain"] = str(DOCS.parent / "studies" / "example" / "my_brain.py")
    tables["world"] = {"topology": "scale-free", "fill_ratio": tables["world"]["fill_ratio"]}
    del tables["members"], tables["case"], tables["schedule"]["ticks"]
    data = sc.run(Study.parse(to_toml(tables)))
    errors = abs(data["final_estimate"] - data["fill_ratio"]).median("robot").median("trial")
    assert re.search(rf"my_brain.py +\S+ +\S+ +\S+ +{errors.mean().item():.4f} ", OWN)
