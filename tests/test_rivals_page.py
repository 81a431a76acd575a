"""docs/rivals.md shows every shipped brain as it is, and every deviation that its file tells."""

import re
import textwrap
from pathlib import Path

import pytest

from swarmcensus import brains
from swarmcensus.brains import adversary

PAGE = Path(__file__).parents[1] / "docs" / "rivals.md"
TEXT = PAGE.read_text(encoding="utf-8")
PARAGRAPHS = re.compile(r"\b(Deviations[^:]*:)\s*(.*?)(?=\n\n|\Z)", re.DOTALL)


def deviations(name):
    """What the file of a brain says of its deviations, in lines; nothing where it says nothing."""
    found = PARAGRAPHS.search(brains.load(name).functions.__doc__)
    if found is None:
        return ""
    items = re.split(r"^- ", found[2], flags=re.MULTILINE)
    if len(items) == 1:
        return textwrap.fill(" ".join(found[0].split()), 120)
    assert items[0] == "", f"{name}: words before the first deviation"
    listed = (textwrap.fill(" ".join(item.split()), 118, subsequent_indent="  ") for item in items[1:])
    return "\n".join(f"- {item}" for item in listed)


def told(brain):
    """What a brain estimates, what it decides for, and what it costs, as the table's row says it."""
    estimates = "an opinion" if brain.is_opinion else "a number"
    bins = "–" if not brain.decides else "black or white" if brain.options == 2 else f"one of {brain.options}"
    return [estimates, bins, f"{brain.memory_bytes:,}", f"{brain.message_bytes:,}"]


def test_the_table_has_every_shipped_brain_as_it_is():
    rows = {}
    for line in TEXT.splitlines():
        if line.startswith("| `"):
            name, estimates, decides, _source, memory, message, page = (cell.strip() for cell in line.split("|")[1:-1])
            rows[name.strip("`")] = [estimates, decides, memory, message]
            assert re.fullmatch(r"\[[^]]+\]\([\w-]+\.md(#[\w-]+)?\)", page), name
            beside = (PAGE.parent / re.findall(r"\((.*?)[)#]", page)[0]).read_text(encoding="utf-8")
            assert f"`{name.strip('`')}`" in beside, f"{page} says nothing of {name}"
    assert rows == {name: told(brains.load(name)) for name in brains.shipped()}


@pytest.mark.parametrize("name", brains.shipped())
def test_every_deviation_that_a_file_tells_stands_on_the_page(name):
    """Where this fails, the text that is missing is what the page should have below its heading."""
    text = deviations(name)
    if text:
        assert f"\n### {name}\n\n{text}\n" in TEXT
    else:
        none = re.search(r"^None are told by ([^:]*):", TEXT, re.MULTILINE)[1]
        assert f"`{name}`" in none


def test_the_page_tells_deviations_of_shipped_brains_alone():
    assert set(re.findall(r"^### (.*)$", TEXT, re.MULTILINE)) == {n for n in brains.shipped() if deviations(n)}


def test_the_first_page_counts_them_rightly():
    first = (PAGE.parents[1] / "README.md").read_text(encoding="utf-8")
    words = {9: "Nine", 29: "Twenty-nine", 32: "Thirty-two"}
    assert f"{words[len(brains.shipped())]} brains ship" in first
    assert f"{words[len(adversary.PLUGINS.shipped)]} adversaries" in first
