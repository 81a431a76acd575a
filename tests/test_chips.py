"""Translated brains on simulated chips give the bits of CPython in single precision."""

import pytest

from swarmcensus.deployment import chips
from tests.translated import BRAINS, CLOSE, differs, is_exact, load_busy, named

AVR = pytest.mark.skipif(
    bool(chips.missing(chips.AVR)),
    reason=f"not installed: {', '.join(chips.missing(chips.AVR))} (tools/install-chips.sh)",
)
CORTEX = pytest.mark.skipif(
    bool(chips.missing(chips.CORTEX)),
    reason=f"not installed: {', '.join(chips.missing(chips.CORTEX))} (tools/install-chips.sh)",
)
SHORT = 17  # rounds in an AVR, which is slow to simulate
STACK = 400  # bytes of RAM that the self-test needs beside its robots


def on_atmega(source):
    """Run the first rounds of a self-test on the smallest chip that has room for its swarm."""
    rounds = f"-DROUNDS={SHORT}"
    return chips.on_avr(source, chips.avr_for(source, STACK, rounds), rounds)


@AVR
@pytest.mark.parametrize("name", ["commons", "minimalistic"])
def test_atmega(name, tmp_path):
    brain = load_busy(name, "single", "ratio16")
    assert differs(brain, tmp_path, on_atmega, SHORT).line == 0


@CORTEX
@pytest.mark.parametrize("name", ["commons", "minimalistic", "w-msr"])
def test_cortex(name, tmp_path):
    assert differs(load_busy(name, "single", "ratio16"), tmp_path, chips.on_cortex).line == 0


@AVR
@pytest.mark.long
@pytest.mark.parametrize("name", BRAINS, ids=named)
def test_all_on_atmega(name, tmp_path):
    brain = load_busy(name, "single", "ratio8" if is_exact(load_busy(name, "single")) else "float32")
    difference = differs(brain, tmp_path, on_atmega, SHORT)
    assert difference.line == 0 if is_exact(brain) else difference.largest < CLOSE


@CORTEX
@pytest.mark.long
@pytest.mark.parametrize("name", BRAINS, ids=named)
def test_all_on_cortex(name, tmp_path):
    brain = load_busy(name, "single", "ratio8" if is_exact(load_busy(name, "single")) else "float32")
    difference = differs(brain, tmp_path, chips.on_cortex)
    assert difference.line == 0 if is_exact(brain) else difference.largest < CLOSE
