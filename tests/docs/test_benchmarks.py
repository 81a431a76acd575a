"""The commands of benchmarks/, which pages name, and the tables of machines."""

import functools
import re

import pytest

from swarmcensus.brains import load
from swarmcensus.brains.brain import shipped
from swarmcensus.translation import selftest
from tests.support.pages import PAGES, cells_of
from tests.support.places import ROOT

NAMES = sorted(path.stem for path in (ROOT / "benchmarks").glob("*.py"))
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.md"))
TEXT = "\n".join(page.read_text(encoding="utf-8") for page in (*PAGES, *TUTORIALS))
NAMED = {command.strip() for command in re.findall(r"python\s+benchmarks/([^`#\n]+)", TEXT)}
QUICK = {
    "engine": ["local_estimates"], "first_page": ["five"], "liars": ["kinds", "cost", "insiders", "worse"],
    "methods": ["factors", "planning", "worth"], "moving": ["bodies", "steering", "walks"],
    "shell": ["scaling"], "sure": ["coverage"], "swarm": ["logs"],
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_benchmarks_find_what_they_measure(name, benchmark):
    benchmark(name)


@pytest.mark.parametrize("command", sorted(NAMED))
def test_benchmarks_know_the_commands_of_pages(command, benchmark, monkeypatch):
    file, *words = command.split()
    module, asked = vars(benchmark(file.removesuffix(".py"))), []
    for name, it in module.items():
        if hasattr(it, "unasked"):
            monkeypatch.setitem(module, name, functools.wraps(it)(lambda *_, name=name, **__: asked.append(name)))
    monkeypatch.setattr("sys.argv", [file, *words])
    monkeypatch.setattr(benchmark("harness"), "IS_QUICK", False)
    benchmark("harness").answer(module)
    assert words[:1] in ([], asked) or words[0].startswith("-")


@pytest.mark.long
@pytest.mark.parametrize(("name", "question"), [(name, one) for name, every in QUICK.items() for one in every])
def test_a_quick_benchmark_ends(name, question, benchmark, monkeypatch):
    """Its table has the columns and the cells of the published one."""
    module, harness, written = vars(benchmark(name)), benchmark("harness"), {}
    monkeypatch.setattr(harness, "write_csv", lambda table, heads, rows: written.update({table: (heads, rows)}))
    monkeypatch.setattr(harness, "IS_QUICK", False)
    writes = "write" in module[question].__code__.co_varnames
    monkeypatch.setattr("sys.argv", [name, question, "--quick", *["--write"] * writes])
    harness.answer(module)
    assert bool(written) == writes
    for table, (heads, rows) in written.items():
        assert list(map(str, heads)) == list(cells_of(table)[0])
        assert {len(row) for row in rows} == {len(heads)}


# ---- the tables of machines have all brains, and their command compares what they say
@pytest.fixture
def machines(benchmark):
    return benchmark("machines")


def test_the_tables_have_all_brains_and_machines(machines):
    for name, columns in (("machines-bits", machines.BITS), ("machines-costs", machines.COSTS)):
        rows = cells_of(name)
        assert list(rows[0]) == ["brain", *columns]
        assert [row["brain"] for row in rows] == shipped()


def test_brains_without_exp_have_the_same_bits(machines):
    rows = cells_of("machines-bits")
    for name, *cells in map(dict.values, rows):
        for cell in cells:
            assert cell in ("same bits", machines.NOT_TRIED) or not selftest.is_exact(load(name))
            assert cell in ("same bits", machines.NOT_TRIED) or float(cell) < 1e-4
    same = sum({*row.values()} == {row["brain"], "same bits"} for row in rows)
    page = (ROOT / "docs" / "machines.md").read_text(encoding="utf-8")
    assert f"**{same} of {len(rows)} brains have the same bits everywhere.**" in page


def test_what_is_absent_is_not_tried(machines, monkeypatch):
    there = dict.fromkeys(("MicroPython", "C", "ATmega328P", "Cortex-M4F"), "x")
    monkeypatch.setattr(machines, "needed", lambda: there)
    monkeypatch.setattr(machines, "in_machine_code", selftest.expected)
    assert machines.bits("commons") == ["same bits", *["not tried"] * 5]
