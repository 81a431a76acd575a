"""The conformance suite passes the shipped brains and names each fault of a broken one."""

import pytest

from swarmcensus import brains
from swarmcensus.conformance import CHECKS, check

GOOD = brains.load("minimalistic").source
TINY = '''"""The mean of one's own readings."""

import math

MEMORY = {"t": 0.0, "n": 0.0}
MESSAGE = ("n",)


def observe(me, blacks, looks):
    me.t += looks
    me.n += blacks


def broadcast(me):
    return (me.n,)


def receive(me, message):
    pass


def fuse(me):
    pass


def estimate(me):
    if me.t == 0.0:
        return 0.5
    return math.sqrt(me.n / me.t) ** 2
'''


@pytest.mark.parametrize("name", brains.shipped())
def test_shipped_brains_conform(name):
    found = check(name)
    assert len(found) == len(CHECKS) + 1
    assert [c.fault for c in found] == [None] * len(found)


def test_a_brain_of_ones_own(tmp_path):
    (tmp_path / "tiny.py").write_text(TINY)
    assert [c.fault for c in check(tmp_path / "tiny.py")] == [None] * 8


@pytest.mark.parametrize(
    ("change", "name", "said"),
    [
        (("    me.n += blacks\n", "    me.n += blacks\n    me.diary = 1.0\n"), "remembers", "diary"),
        (("return me.n / me.t", "return 2.0 * me.n / me.t"), "gives finite", "not a number in [0, 1]"),
        (("if me.t == 0.0:", "if me.t < 0.0:"), "gives finite", "ZeroDivisionError"),
        (("return (me.n,)", "return (me.n, me.t)"), "gives finite", "not a tuple of 1"),
        (("return (me.n,)", "return (math.inf,)"), "gives finite", "not a finite number"),
        (("return (me.n,)", "me.n += 1.0\n    return (me.n,)"), "only read", "broadcast changes me.n"),
        (('MESSAGE = ("n",)', 'MESSAGE = ("n",)\nSUMS = ("n",)'), "SUMS", "by SUMS it adds to n alone"),
        (
            ("    me.n += blacks\n", "    me.n += ('a' if looks > 0.0 else 1.0) == 'a'\n"),
            "compiles",
            "Numba cannot compile it",
        ),
    ],
)
def test_faults_are_found(change, name, said, tmp_path):
    source = TINY.replace("return math.sqrt(me.n / me.t) ** 2", "return me.n / me.t")
    assert change[0] in source
    source = source.replace(*change)
    if "SUMS" in change[1]:
        source = source.replace(
            "def receive(me, message):\n    pass", "def receive(me, message):\n    me.n += message[0] * me.t"
        )
    (tmp_path / "bad.py").write_text(source)
    faults = {c.name: c.fault for c in check(tmp_path / "bad.py") if c.fault}
    fault = next((f for n, f in faults.items() if name in n), None)
    assert fault is not None, faults
    assert said in fault


def test_disagreement_is_found(tmp_path):
    """Integers wrap in machine code and grow in CPython: the suite sees it."""
    wrap = "    me.t += looks\n    if (1 << (62 + int(me.t))) > 0:\n        me.n += 0.25 * looks\n"
    source = TINY.replace("    me.t += looks\n", wrap).replace("me.n / me.t", "min(me.n / me.t, 1.0)")
    (tmp_path / "wraps.py").write_text(source)
    assert any(c.fault and "compiled" in c.fault for c in check(tmp_path / "wraps.py"))


def test_a_file_that_breaks_the_contract(tmp_path):
    (tmp_path / "bad.py").write_text("def observe(:")
    found = check(tmp_path / "bad.py")
    assert len(found) == 1
    assert "not Python" in found[0].fault
