"""The pages of docs/: their blocks, their commands, and whether what is printed is what they show."""

import csv
import hashlib
import math
import re
import shlex

import numpy as np
import pytest

from tests.support.places import ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]


BLOCK = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(page, *languages):
    return [text for language, text in BLOCK.findall(page.read_text(encoding="utf-8")) if language in languages]


def cells_of(table):
    """The rows of a file of benchmarks/tables, each by the titles of its columns."""
    with (ROOT / "benchmarks" / "tables" / f"{table}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def page_named(name):
    """The file of a page of docs/."""
    return ROOT / "docs" / f"{name}.md"


def assert_shown(printed, shown, whole=True):
    """What is printed is what a page shows, or has it if not `whole`; elsewhere walks differ: there to 0.01."""
    number = r"-?\d+\.\d+"
    if OUR_C_LIBRARY:
        assert printed == shown if whole else shown in printed
    elif whole:
        assert re.sub(number, "", printed) == re.sub(number, "", shown)
        found, told = ([float(n) for n in re.findall(number, t)] for t in (printed, shown))
        assert found == pytest.approx(told, abs=0.01)
    else:
        words = (re.sub(r"[\d.,]+", "", text) for text in (shown, printed))
        assert next(words) in next(words)


def commands(text, shown=False):
    """The commands of a block, each a list of words; in a console they follow a $. Also what is `shown` below each."""
    text = text.replace("\\\n", " ")
    entries = [(line, "") for line in text.splitlines()]
    if text.startswith("$ "):
        entries = [entry.partition("\n")[::2] for entry in text.removeprefix("$ ").split("\n$ ")]
    for line, below in entries:
        words = shlex.split(line, comments=True)
        while words:
            end = next((k for k, word in enumerate(words) if word in ("&&", "|")), len(words))
            command = words[:end]
            command = command[: command.index(">")] if ">" in command else command
            words = words[end + 1 :]
            yield (command, "" if words else below) if shown else command


POINTS = [0.001 * k for k in range(1, 20_000)]


# walks are chaotic: whether they are those of the docs depends on the last bits of what the C library computes
VALUES = np.array([[f(x) for f in (math.sin, math.cos, math.log)] for x in POINTS])
OUR_C_LIBRARY = hashlib.sha256(VALUES.tobytes()).hexdigest().startswith("e7a65513f63370a7")
