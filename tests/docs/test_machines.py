"""The tables of machines have all brains, and their command compares what they say."""

import numba
import pytest

from swarmcensus.brains import load
from swarmcensus.brains.brain import shipped
from swarmcensus.brains.packing import Numbers
from swarmcensus.translation import selftest
from tests.support.boards import needs_micropython
from tests.support.pages import cells_of
from tests.support.places import ROOT


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
