"""The pages of docs/: their blocks, their commands, and whether what is printed is what they show."""

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


def assert_shown(printed, shown):
    """What is printed is what a page shows."""
    if OUR_C_LIBRARY:
        assert printed == shown
    number = r"-?\d+\.\d+"
    assert re.sub(number, "", printed) == re.sub(number, "", shown)
    found, told = ([float(n) for n in re.findall(number, t)] for t in (printed, shown))
    assert found == pytest.approx(told, abs=0.01)


def commands(text):
    """The commands of a block, each a list of words; in a console they follow a $."""
    lines = text.replace("\\\n", " ").splitlines()
    if any(line.startswith("$ ") for line in lines):
        lines = [line[2:] for line in lines if line.startswith("$ ")]
    for line in lines:
        words = shlex.split(line, comments=True)
        while words:
            end = next((k for k, word in enumerate(words) if word in ("&&", "|")), len(words))
            command = words[:end]
            yield command[: command.index(">")] if ">" in command else command
            words = words[end + 1 :]


POINTS = [0.001 * k for k in range(1, 20_000)]


# walks are chaotic: whether they are those of the docs depends on the last bits of what the C library computes
OUR_C_LIBRARY = (
    hashlib.sha256(np.array([[f(x) for f in (math.sin, math.cos, math.log)] for x in POINTS]).tobytes()).hexdigest()[
        :16
    ]
    == "e7a65513f63370a7"
)
