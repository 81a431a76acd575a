"""The page of six machines has all brains and machines, and its command compares what it says."""

import re

import numba
import pytest

from swarmcensus.brains import load
from swarmcensus.brains.brain import shipped
from swarmcensus.brains.packing import Numbers
from swarmcensus.translation import selftest
from tests.support.boards import needs_micropython
from tests.support.places import ROOT

PAGE = (ROOT / "docs" / "six-machines.md").read_text(encoding="utf-8")


@pytest.fixture
def machines(benchmark):
    return benchmark("machines")


def rows(what):
    """The columns of a table of the page, and its rows by brain."""
    [part] = re.findall(rf"<!-- {what}: .*?-->(.*?)<!-- end of {what} -->", PAGE, re.DOTALL)
    head, _, *lines = [re.split(r" *\| *", line)[1:-1] for line in part.splitlines() if line.startswith("|")]
    return head[1:], {name.strip("`"): cells for name, *cells in lines}


def test_the_page_has_all_brains_and_machines(machines):
    for what, columns in (("bits", machines.BITS), ("costs", machines.COSTS)):
        assert f"<!-- {what}: python benchmarks/machines.py machines --write -->" in PAGE
        head, cells = rows(what)
        assert head == list(columns)
        assert list(cells) == shipped()
        assert {len(row) for row in cells.values()} == {len(columns)}


def test_brains_without_exp_have_the_same_bits_on_the_page(machines):
    for name, cells in rows("bits")[1].items():
        for cell in cells:
            assert cell in ("same bits", machines.NOT_TRIED) or not selftest.is_exact(load(name))
            assert cell in ("same bits", machines.NOT_TRIED) or float(cell) < 1e-4


def test_what_is_absent_is_not_tried(machines, monkeypatch):
    monkeypatch.setattr(
        machines, "needed", lambda: dict.fromkeys(("MicroPython", "C", "ATmega328P", "Cortex-M4F"), "x")
    )
    monkeypatch.setattr(machines, "in_machine_code", selftest.expected)
    assert machines.bits("commons") == ["same bits", *["not tried"] * 5]


@needs_micropython
def test_micropython(machines):
    brain = load("commons").with_numbers(Numbers("double", "ratio16"))
    assert machines.on_micropython(brain) == selftest.expected(brain)


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="NUMBA_DISABLE_JIT is 1: nothing becomes machine code")
@pytest.mark.long(but=["asdf"])
@pytest.mark.parametrize("name", ["asdf", "commons", "sure", "bayes-cpf"])
def test_machine_code(machines, name):
    brain = machines.in_numbers(load(name), "double")
    assert machines.in_machine_code(brain) == selftest.expected(brain)
