"""docs/rivals.md shows every shipped brain as it is, and leads to every deviation that its file tells."""

import re
import runpy

import pytest

from swarmcensus import brains
from swarmcensus.brains import adversary
from tests.support.places import DOCS

PAGE = DOCS / "rivals.md"
TEXT = PAGE.read_text(encoding="utf-8")
HOOK = runpy.run_path(str(PAGE.parents[1] / "docs_hooks" / "brain_files.py"))


def built(page):
    """A page of docs/ as the site has it, with what its brain files say."""
    text = (PAGE.parent / page).read_text(encoding="utf-8")
    return HOOK["on_page_markdown"](text, page=None, config=None, files=None)


def deviations(name):
    """What the file of a brain says of its deviations; nothing where it says nothing."""
    return brains.load(name).functions.__doc__.partition("Deviations")[2]


def rows():
    """The cells of the table's rows, by brain."""
    for line in TEXT.splitlines():
        if line.startswith("| `"):
            name, *cells = (cell.strip() for cell in line.split("|")[1:-1])
            yield name.strip("`"), cells


def told(brain):
    """What a brain estimates, what it decides for, and what it costs, as the table's row says it."""
    estimates = "an opinion" if brain.is_opinion else "a number"
    bins = "–" if not brain.decides else "black or white" if brain.options == 2 else f"one of {brain.options}"
    return [estimates, bins, f"{brain.memory_bytes:,}", f"{brain.message_bytes:,}"]


def test_the_table_has_every_shipped_brain_as_it_is():
    found = {}
    for name, (estimates, decides, _source, memory, message, page) in rows():
        found[name] = [estimates, decides, memory, message]
        assert re.fullmatch(r"\[[^]]+\]\([\w-]+\.md(#[\w-]+)?\)", page), name
        beside = (PAGE.parent / re.findall(r"\((.*?)[)#]", page)[0]).read_text(encoding="utf-8")
        assert f"`{name}`" in beside, f"{page} says nothing of {name}"
    assert found == {name: told(brains.load(name)) for name in brains.shipped()}


@pytest.mark.parametrize("name", brains.shipped())
def test_pages_of_brains_list_deviations_and_parameters(name):
    text = deviations(name)
    none = re.search(r"^None are listed by ([^:]*):", TEXT, re.MULTILINE)[1]
    assert (f"`{name}`" in none) == (not text)
    *_, page = dict(rows())[name]
    shown = built(re.findall(r"\((.*?)[)#]", page)[0])
    assert all(line in shown for line in text.strip().splitlines())
    assert all(f'"{parameter}"' in shown for parameter in brains.load(name).parameters)


def test_a_page_shows_a_file_below_the_paragraph_that_links_it():
    shown = built("rivals-others.md").partition("library/alone.py)\n\n")[2]
    assert shown.startswith('??? quote "alone.py"\n\n    A robot alone')


def test_the_first_page_counts_them_rightly():
    first = (PAGE.parents[1] / "README.md").read_text(encoding="utf-8").lower()
    words = {9: "nine", 10: "ten", 33: "thirty-three"}
    assert f"{words[len(brains.shipped())]} brains ship" in first
    assert f"{words[len(adversary.PLUGINS.shipped)]} adversaries" in first
