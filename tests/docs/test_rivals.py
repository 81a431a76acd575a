"""docs/rivals.md shows every shipped brain as it is, and every deviation that its file lists.

A new brain needs a row in benchmarks/tables/brains.csv, and a link to its file from the page.
"""

import runpy

import pytest

from swarmcensus import brains
from swarmcensus.brains import adversary
from swarmcensus.studies.study import Study
from tests.support.pages import OUR_C_LIBRARY, cells_of
from tests.support.places import DOCS, ROOT

PAGE = DOCS / "rivals.md"
HOOK = runpy.run_path(str(PAGE.parents[1] / "docs_hooks" / "brain_files.py"))


def built(page):
    """A page of docs/ as the site has it, with what its brain files say."""
    text = (PAGE.parent / page).read_text(encoding="utf-8")
    return HOOK["on_page_markdown"](text, page=None, config=None, files=None)


def told(brain):
    """What a brain estimates, what it decides for, and what it costs, as the table's row says it."""
    options = "black or white" if brain.options == 2 else f"one of {brain.options}"
    return {
        "estimates": "an opinion" if brain.is_opinion else "a number",
        "decides for": options if brain.decides else "",
        "memory": str(brain.memory_bytes),
        "message": str(brain.message_bytes),
    }


def test_the_table_has_every_shipped_brain_as_it_is():
    found = {row["brain"]: row for row in cells_of("brains")}
    assert set(found) == set(brains.shipped())
    for name, row in found.items():
        assert told(brains.load(name)).items() <= row.items(), name


@pytest.mark.parametrize("name", brains.shipped())
def test_the_page_has_deviations_and_parameters_of_every_brain(name):
    brain, shown = brains.load(name), built("rivals.md")
    deviations = brain.functions.__doc__.partition("Deviations")[2]
    assert all(line in shown for line in deviations.strip().splitlines())
    assert all(f'"{parameter}"' in shown for parameter in brain.parameters)
    assert f"library/{name.replace('-', '_')}.py)" in shown


def test_a_page_shows_a_file_below_the_paragraph_that_links_it():
    shown = built("rivals.md").partition("library/oracle.py)\n\n")[2]
    assert shown.startswith('??? quote "alone.py"\n\n    A robot alone')


@pytest.mark.long
@pytest.mark.parametrize("question", ["consensus", "opinions", "unknown", "strobel", "beliefs"])
def test_tables_are_what_the_benchmark_measures(question, benchmark, monkeypatch):
    rivals, written = benchmark("rivals"), {}
    monkeypatch.setattr(
        rivals.harness, "write_csv", lambda name, heads, rows: written.update({name: [list(heads), *map(list, rows)]})
    )
    getattr(rivals, question)(write=True)
    [(name, (heads, *rows))] = written.items()
    for row, stored in zip(rows, cells_of(name), strict=True):
        row = dict(zip(heads, map(str, row), strict=True))
        if OUR_C_LIBRARY:
            assert row == stored
        else:
            assert list(row) == list(stored)


def test_the_first_page_counts_them_rightly():
    first = (PAGE.parents[1] / "README.md").read_text(encoding="utf-8").lower()
    words = {9: "nine", 10: "ten", 33: "thirty-three"}
    assert f"{words[len(brains.shipped())]} brains ship" in first
    assert f"{words[len(adversary.PLUGINS.shipped)]} adversaries" in first


def test_the_arena_of_liars_is_the_published_experiment():
    """Liars say 0 of a colour that covers 0.75; 10,000 ticks of 1 s and 10 cm are 217 phases, three of them silent."""
    study = Study.load(ROOT / "studies" / "rivals" / "strobel-2020.toml")
    for setting in study.settings():
        assert (setting.fill_ratio, setting.rounds) == (0.75, 10_000)
        body = setting.body
        assert (body.tick, body.speed, body.tile, body.radio_range) == (1, 0.1, 0.1, 0.5)
        assert (body.straight_mean, body.turn_most) == (40, 4)
        given = setting.brain.parameters
        assert (setting.rounds // given["phase"], given["silent"], given["debiased"]) == (217, 3, 0)
    assert [adversary.name for adversary in study.adversaries] == ["always-white"]
