"""The commands of benchmarks/: those that pages name are understood, and with --quick they come to an end."""

import functools
import re

import pytest

from tests.support.pages import PAGES, cells_of
from tests.support.places import ROOT

NAMES = sorted(path.stem for path in (ROOT / "benchmarks").glob("*.py"))
TUTORIALS = sorted((ROOT / "docs" / "tutorials").glob("*.md"))
NAMED = {
    command.strip()
    for page in (*PAGES, *TUTORIALS)
    for command in re.findall(r"python\s+benchmarks/([^`#\n]+)", page.read_text(encoding="utf-8"))
}
QUICK = {
    "engine": ["local_estimates"],
    "first_page": ["five"],
    "liars": ["kinds", "cost", "insiders", "worse"],
    "methods": ["factors", "planning", "worth"],
    "moving": ["bodies", "steering", "walks"],
    "shell": ["scaling"],
    "sure": ["coverage"],
    "swarm": ["logs"],
}


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
