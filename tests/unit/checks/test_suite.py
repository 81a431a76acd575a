"""The conformance suite passes the shipped brains and names each fault of a broken one."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.checks import machine_code, quick, suite as conformance
from swarmcensus.checks.contract_checks import PROMISES
from swarmcensus.checks.suite import check, checks
from swarmcensus.cli.commands import list_brains
from tests.support.places import DOCS, EXAMPLE

GOOD = brains.load("minimalistic").source
PAGE = DOCS / "brain-contract.md"
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


OWN = "    me.n += blacks\n"  # the line of TINY's observe that follows `me.t += looks`
HEAR = "def receive(me, message):\n    pass\n"
FUSE = "def fuse(me):\n    pass\n"


def changed(path, *changes):
    """A brain file: TINY with these changes."""
    source = TINY.replace("return math.sqrt(me.n / me.t) ** 2", "return me.n / me.t")
    for old, new in changes:
        assert old in source
        source = source.replace(old, new)
    path.write_text(source)
    return path


def test_unused_optional_parts_are_reported(tmp_path, capsys):
    """A leaver steers and sums up what it hears; a brain alone says nothing, and hears nothing."""

    def unused(name):
        return [one.name for one in conformance.examine(name, PROMISES) if not one.used]

    optional = ["steers by a speed and a turn, or not at all", "decides for an option, or not yet",
                "tells an interval within [0, 1], the low end first"]  # fmt: skip
    assert unused("alone") == [*optional, "messages mean the same in any order", "SUMS only add up"]
    assert unused("leaver") == optional[1:]
    checked = list(conformance.examine("alone", PROMISES))
    assert all(one.fault is None for one in checked)
    list_brains.show_checks("alone", checked, conforms=True)
    assert f"-     {optional[0]}: not used\n" in capsys.readouterr().out


def fault_in(path, name):
    """What one check finds."""
    return conformance.fault_of(PROMISES[name], brains.load(path))


def faults_of(path):
    """What the checks that do not compile find."""
    return {one.name: one.fault for one in conformance.examine(path, PROMISES) if one.fault}


@pytest.mark.parametrize("name", ["minimalistic"])
def test_shipped_brains_conform(name, untraced_processes):
    """All checks, in a process of their own; below they are made of each brain here."""
    found = check(name)
    assert len(found) == len(checks()) + 1
    assert [c.fault for c in found] == [None] * len(found)


def test_a_brain_of_ones_own(tmp_path):
    (tmp_path / "tiny.py").write_text(TINY)
    found = list(conformance.examine(tmp_path / "tiny.py", PROMISES))
    assert [c.fault for c in found] == [None] * (len(PROMISES) + 1)


@pytest.mark.long(
    only=[
        "change10-gives finite-not a tuple of 1",
        "change11-gives finite-not a finite number",
        "change12-only read-broadcast (line 14) changes me.n",
        "change8-gives finite-not a number in [0, 1]",
        "change9-gives finite-estimate fails at line 29 (return me.n / me.t): Zero",
    ]
)
@pytest.mark.parametrize(
    ("change", "name", "said"),
    [
        ((OWN, OWN + "    me.diary = 1.0\n"), "keeps the", "line 12: observe uses me.diary: a robot has only b, w"),
        (("return me.n / me.t", "return me.N / me.t"), "keeps the", "estimate uses me.N: did you mean 'n'?"),
        ((OWN, "    me.n += blacks * math.inf * 0.0\n"), "remembers", "observe (line 9) makes me.n NaN (b = 0.0"),
        ((OWN, "    me.n = 1 << 1023\n"), "remembers", "observe (line 9) makes me.n a whole number too large for 8"),
        ((OWN, OWN + "    if me.t > 5.0:\n        raise SystemExit\n"), "keeps the", "line 13: observe uses Syst"),
        ((OWN, OWN + "    observe(me, blacks, looks)\n"), "keeps the", "line 12: observe calls itself"),
        ((OWN, OWN + "    me.b = 0.9\n"), "remembers", "observe (line 9) sets me.b and me.w from (0.0, 0.0) to (0.9"),
        ((FUSE, "def fuse(me):\n    me.w = 0.9\n"), "remembers", "fuse (line 22) sets me.b and me.w from"),
        (("return me.n / me.t", "return 2.0 * me.n / me.t"), "gives finite", "not a number in [0, 1]"),
        (("if me.t == 0.0:", "if me.t < 0.0:"), "gives finite", "estimate fails at line 29 (return me.n / me.t): Zero"),
        (("return (me.n,)", "return (me.n, me.t)"), "gives finite", "not a tuple of 1"),
        (("return (me.n,)", "return (math.inf,)"), "gives finite", "not a finite number"),
        (("return (me.n,)", "me.n += 1.0\n    return (me.n,)"), "only read", "broadcast (line 14) changes me.n"),
    ],
)  # fmt: skip
def test_faults_are_found(change, name, said, tmp_path):
    fault = next(fault for found, fault in faults_of(changed(tmp_path / "bad.py", change)).items() if name in found)
    assert said in fault


QUICK = {
    "out of range": (
        ("return me.n / me.t", "return 2.0 * me.n / me.t"),
        "estimate (line 26) gives 2.0, not a number in",
    ),
    "endless": ((FUSE, "def fuse(me):\n    while True:\n        pass\n"), "it did not return within"),
    "power": ((OWN, OWN + "    k = int(min(me.t, 9.0))\n    me.n += 0.0 * (k**k**k > 1)\n"), "line 13"),
    "changes": (("return (me.n,)", "me.n += 1.0\n    return (me.n,)"), "broadcast (line 14) changes me.n"),
    "none": ((OWN, OWN), ""),
}


@pytest.mark.parametrize("fault", QUICK)
def test_a_quick_check_finds_plain_faults_and_ends(fault, tmp_path):
    change, said = QUICK[fault]
    found = quick.quick_fault(brains.load(changed(tmp_path / "bad.py", change)))
    assert said in found if said else not found


def test_a_quick_check_finds_nothing_wrong_in_shipped_brains():
    for name in ("minimalistic", "commons", "sure", "steadfast", "self-taught", "leaver"):
        assert not quick.quick_fault(brains.load(name))


@pytest.mark.interpreted
def test_brain_file_is_checked_once_before_a_run(tmp_path, monkeypatch):
    monkeypatch.setenv("SWARMCENSUS_CACHE", str(tmp_path / "cache"))
    bad = changed(tmp_path / "bad.py", QUICK["changes"][0], ('"""The mean', '"""Another mean'))
    study = {"world": {"topology": "ring", "fill_ratio": 0.3}, "schedule": {"rounds": 2}}
    checked = []
    monkeypatch.setattr(quick, "quick_fault", lambda brain: checked.append(brain.name) or "it is odd")
    for _ in range(2):
        quick._caution.cache_clear()
        with pytest.warns(
            UserWarning, match=rf"bad.py' breaks the contract: it is odd: swarmcensus brains --check {bad}"
        ):
            sc.run(
                sc.Study(trials=1, swarm={"brain": [str(bad), "alone"], "robots": 3, "accuracy": 0.8}, **study), jobs=1
            )
    assert checked == [str(bad)]


def test_a_robot_may_hear_others_before_it_has_observed(tmp_path):
    """As one that avoids an obstacle in the first tick does, or one whose sensor has failed."""
    path = changed(tmp_path / "bad.py", (HEAR, "def receive(me, message):\n    me.n += 0.0 / me.t\n"))
    assert "receive fails at line 19 (me.n += 0.0 / me.t): ZeroDivisionError" in str(faults_of(path))


@pytest.mark.long
@pytest.mark.parametrize(
    "adds",
    [
        "me.sum += message[0] * me.b",
        "me.sum += message[0] * (me.b + me.w > 1.0)",
        "me.sum += message[0] / (1.0 + abs(me.sum))",
        "me.sum = max(me.sum, message[0])",
        "me.sum += message[0] * (me.t < 3000.0)",
        "me.sum += message[0]\n    me.sum += 0.0 * math.log(me.t + 1.0)",
    ],
)
def test_what_sums_add_depends_on_the_message_alone(adds, tmp_path):
    """Not on beliefs, not on sums so far, not on states older than those that the suite makes."""
    path = changed(
        tmp_path / "bad.py",
        ('"n": 0.0}', '"n": 0.0, "sum": 0.0}'),
        ('MESSAGE = ("n",)', 'MESSAGE = ("n",)\nSUMS = ("sum",)'),
        (HEAR, f"def receive(me, message):\n    {adds}\n"),
        (FUSE, "def fuse(me):\n    me.sum = 0.0\n"),
    )
    faults = faults_of(path)
    assert set(faults) == {"SUMS only add up"}
    assert re.search(r"^receive .*line \d+.*with SUMS.*depends on the message alone", faults["SUMS only add up"])


@pytest.mark.long
def test_sums_change_no_other_field(tmp_path):
    path = changed(
        tmp_path / "bad.py",
        ('MESSAGE = ("n",)', 'MESSAGE = ("n",)\nSUMS = ("n",)'),
        (HEAR, "def receive(me, message):\n    me.t += 1.0\n"),
    )
    assert "receive (line 19) adds 1.0 to me.t" in faults_of(path)["SUMS only add up"]


@pytest.mark.long
@pytest.mark.parametrize(
    "own",
    [
        "    me.t = 0.9 * me.t + looks\n    me.n = 0.9 * me.n + blacks\n",  # forgets once a call
        "    me.t = 0.9**looks * me.t + looks\n    me.n = 0.9**looks * me.n + blacks\n",  # but not within one
        "    me.t += 1.0\n    me.n += blacks / looks\n",
        "    me.t += looks\n    me.n += min(blacks, 50.0)\n",
    ],
)
def test_readings_at_once_mean_the_same_as_one_by_one(own, tmp_path):
    faults = faults_of(changed(tmp_path / "bad.py", ("    me.t += looks\n" + OWN, own)))
    assert set(faults) == {"readings at once mean the same as one by one"}
    [fault] = faults.values()
    assert re.match(
        r"observe \(line 9\) makes me.[tn] \S+ of \d+ readings at once, \d+ of them black, and \S+ of ", fault
    )


@pytest.mark.parametrize(
    ("own", "hears"),
    [
        (OWN + "    if me.t > 500.0:\n        me.t /= 2.0\n        me.n /= 2.0\n", "pass"),  # a window
        (OWN + "    if me.t > 9000.0:\n        me.n -= 1.0\n", "pass"),
        (OWN + "    if looks > 2500.0:\n        me.n -= 1.0\n", "pass"),
        (OWN + "    if me.ever > 0.0:\n        me.age += 1.0\n", "me.ever = 1.0"),
        (OWN + "    if me.rounds > 120.0:\n        me.n += 1.0\n", "pass"),
        (OWN + "    if me.heard > 0.0:\n        me.n += 1.0\n", "me.heard += 1.0"),
    ],
)
def test_many_readings_and_such_in_a_long_life_add_up_too(own, hears, tmp_path):
    path = changed(
        tmp_path / "bad.py",
        ('"n": 0.0}', '"n": 0.0, "ever": 0.0, "age": 0.0, "rounds": 0.0, "heard": 0.0}'),
        (OWN, own),
        (HEAR, f"def receive(me, message):\n    {hears}\n"),
        (FUSE, "def fuse(me):\n    me.rounds += 1.0\n    me.heard = 0.0\n"),
    )
    assert re.match(r"observe \(line 9\) makes me.", fault_in(path, "readings at once mean the same as one by one"))


@pytest.mark.long
def test_the_page_shows_how_to_forget(tmp_path):
    """So that ten readings at once are ten times one: its example passes."""
    text = PAGE.read_text(encoding="utf-8")
    [shown] = (block for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "KEEP =" in block)
    constant, function = shown.split("\n\n\n")
    old = TINY[TINY.index("def observe") : TINY.index("def broadcast")]
    path = changed(tmp_path / "forgets.py", ("MESSAGE =", f"{constant}\nMESSAGE ="), (old, function + "\n\n"))
    assert faults_of(path) == {}


@pytest.mark.long
@pytest.mark.parametrize(
    "hears", ["me.n = 0.5 * me.n + 0.5 * message[0]", "me.n += message[0] * (message[0] > me.n)", "me.n = message[0]"]
)
def test_messages_mean_the_same_in_any_order(hears, tmp_path):
    faults = faults_of(
        changed(
            tmp_path / "bad.py",
            (HEAR, f"def receive(me, message):\n    {hears}\n"),
            ("return me.n / me.t", "return min(me.n / me.t, 1.0)"),
        )
    )
    assert set(faults) == {"messages mean the same in any order"}
    [fault] = faults.values()
    assert re.match(
        r"receive \(line 18\), with fuse after it, makes me.n \S+ of the messages \[.*the order of messages should",
        fault,
    )


@pytest.mark.parametrize(
    "hears",
    [
        "me.sum += message[0] * (me.heard <= 8.0)",
        "me.sum += message[0] * (me.heard <= 150.0)",
        "me.sum += message[0] * (me.rounds < 120.0 or me.heard <= 1.0)",
        "me.sum += message[0] * (message[0] < 5000.0 or me.heard <= 2.0)",  # where robots have seen so many
    ],
)
def test_order_of_many_messages(hears, tmp_path):
    path = changed(
        tmp_path / "bad.py",
        ('"n": 0.0}', '"n": 0.0, "heard": 0.0, "sum": 0.0, "mean": 0.0, "rounds": 0.0}'),
        (HEAR, f"def receive(me, message):\n    me.heard += 1.0\n    {hears}\n"),
        (
            FUSE,
            "def fuse(me):\n    me.rounds += 1.0\n    me.mean = me.sum / max(me.heard, 1.0)\n"
            "    me.heard = 0.0\n    me.sum = 0.0\n",
        ),
    )
    said = r"receive \(line 18\), with fuse after it, makes me.mean \S+ of the messages \[.*\]( \(\d+ in all\))? and "
    assert re.match(said, fault_in(path, "messages mean the same in any order"))


@pytest.mark.parametrize(
    "adds",
    [
        "me.sum += message[0] * (me.heard != 9.0)",  # a number that only counting meets
        "me.sum += message[0] * (me.heard != 300.0)",
        "me.sum += message[0] * (message[0] < 5000.0 or me.t < 10.0)",
        "me.sum += message[0] * (me.t < 500000.0)",
    ],
)
def test_many_messages_add_to_sums_and_those_of_old_robots(adds, tmp_path):
    path = changed(
        tmp_path / "bad.py",
        ('"n": 0.0}', '"n": 0.0, "sum": 0.0, "heard": 0.0}'),
        ('MESSAGE = ("n",)', 'MESSAGE = ("n",)\nSUMS = ("sum", "heard")'),
        (HEAR, f"def receive(me, message):\n    me.heard += 1.0\n    {adds}\n"),
        (FUSE, "def fuse(me):\n    me.sum = 0.0\n    me.heard = 0.0\n"),
    )
    assert re.match(r"receive \(line 19\) adds \S+ to me.sum ", fault_in(path, "SUMS only add up"))


@pytest.mark.parametrize(
    ("change", "name", "said"),
    [
        ((OWN, OWN + "    if me.t > 5000.0:\n        me.w = 0.9\n"), "remembers numbers", "observe .* sets me.b and"),
        (("return me.n / me.t", "return me.n / me.t + (me.t > 5000.0)"), "gives finite", "estimate .* gives 1"),
        (
            ("return (me.n,)", "me.n += me.t > 5000.0\n    return (me.n,)"),
            "functions that tell",
            "broadcast .* changes me.n",
        ),
    ],
)
def test_promises_hold_in_a_long_life(change, name, said, tmp_path):
    [promise] = [one for one in PROMISES if one.startswith(name)]
    assert re.search(said, fault_in(changed(tmp_path / "bad.py", change), promise))


def forgetful(keep):
    return (
        ("    me.t += looks\n" + OWN, f"    keep = {keep}**looks\n    fresh = (1.0 - keep) / (1.0 - {keep})\n"
         "    me.t = keep * me.t + fresh\n    me.n = keep * me.n + fresh * blacks / looks\n"),
    )  # fmt: skip


SIGNED = (  # sums of large numbers that cancel
    ('"n": 0.0}', '"n": 0.0, "sum": 0.0, "x": 0.5}'),
    ('MESSAGE = ("n",)', 'MESSAGE = ("n",)\nSUMS = ("sum",)'),
    ("return (me.n,)", "return (1.1 * (2.0 * me.n - me.t),)"),
    (HEAR, "def receive(me, message):\n    me.sum += message[0]\n"),
    (FUSE, "def fuse(me):\n    me.x = 1.0 / (1.0 + math.exp(-min(max(me.sum, -99.0), 99.0)))\n    me.sum = 0.0\n"),
)
WELFORD = (  # mean and variance, message by message
    ('"n": 0.0}', '"n": 0.0, "heard": 0.0, "mean": 0.0, "odd": 0.0}'),
    (
        HEAR,
        "def receive(me, message):\n    me.heard += 1.0\n    d = message[0] - me.mean\n"
        "    me.mean += d / me.heard\n    me.odd += d * (message[0] - me.mean)\n",
    ),
    (FUSE, "def fuse(me):\n    me.heard = 0.0\n    me.mean = 0.0\n"),
)
KALMAN = (
    ('"n": 0.0}', '"n": 0.0, "p": 1.0, "x": 0.5}'),
    (OWN, OWN + "    me.p = 1.0 / (1.0 / me.p + 4.0 * looks)\n    me.x += 4.0 * me.p * (blacks - looks * me.x)\n"),
)


@pytest.mark.long
@pytest.mark.parametrize("changes", [forgetful(0.5), forgetful(0.9999), SIGNED, WELFORD, KALMAN])
def test_rounding_is_no_fault(changes, tmp_path):
    clip = ("return me.n / me.t", "return min(me.n / me.t, 1.0)")
    assert faults_of(changed(tmp_path / "good.py", clip, *changes)) == {}


@pytest.mark.long
def test_means_and_extremes_may_be_found_message_by_message(tmp_path):
    """They depend on the order in the last bits alone."""
    hears = "me.t += 1.0\n    me.x += (message[0] - me.x) / me.t\n    me.n = max(me.n, message[0])"
    path = changed(
        tmp_path / "good.py",
        ('"n": 0.0}', '"n": 0.0, "x": 0.5}'),
        (HEAR, f"def receive(me, message):\n    {hears}\n"),
        ("return me.n / me.t", "return min(me.n / me.t, 1.0)"),
    )
    assert faults_of(path) == {}


@pytest.mark.long(but=["change0-gives me.n = "])
@pytest.mark.parametrize(
    ("change", "said"),
    [
        ((OWN, OWN + "    calls = CALLS\n    calls += (1.0,)\n    me.n += 1e-6 * len(CALLS)\n"), "gives me.n = "),
        (
            ("return (me.n,)", "calls = CALLS\n    calls += (1.0,)\n    return (me.n + len(CALLS) % 5.0,)"),
            "broadcast (line 15) gives (0.0,) and then (1.0,)",
        ),
        (
            ("    if me.t ==", "    calls = CALLS\n    calls += (1.0,)\n    if len(CALLS) % 7.0 == 0.0 or me.t =="),
            "estimate (line 27) gives ",
        ),
    ],
)
def test_nothing_is_kept_outside_of_a_mind(change, said, tmp_path):
    calls = ('MESSAGE = ("n",)', 'MESSAGE = ("n",)\nCALLS = [0.0]')
    clip = ("return me.n / me.t", "return min(me.n / me.t, 1.0)")
    fault = faults_of(changed(tmp_path / "bad.py", change, calls, clip))["the same history gives the same state"]
    assert said in fault
    assert "something is kept outside of me" in fault


@pytest.mark.long(only=["in a function"])
@pytest.mark.long(but=["in a function"])
@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("    while me.t > 5.0:\n        pass\n", "observe did not return within 0.5 s: it was at line 1[23]$"),
        ("    k = int(min(me.t, 9.0))\n    me.n += 0.0 * (k**k**k > 1)\n", "observe did not return .* at line 13$"),
        (
            "    rest(me)\n\n\ndef rest(me):\n    while me.t > 5.0:\n        pass\n",
            r"observe did .* 1[67] \(in rest\)$",
        ),
        ("    me.n += 0.0 * (1 << 10**11)\n", "observe fails at line 12 .*(MemoryError|OverflowError)"),
    ],
    ids=["loop", "power", "in a function", "too large"],
)
def test_a_function_that_does_not_return_is_named(lines, said, tmp_path, monkeypatch):
    """Endless loops, numbers of a hundred million digits, and what brings the process down; in a folder of any name."""
    monkeypatch.chdir(tmp_path)
    Path("bräin").mkdir()
    path = changed(Path("bräin/bad.py"), (OWN, OWN + lines))
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")  # nothing is compiled
    found = {one.name: one.fault for one in check(path, patience=0.5)}
    assert found["keeps the contract"] is None
    assert re.search(said, found["remembers numbers in MEMORY's fields, nothing else"])


@pytest.mark.long
@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled")
def test_a_loop_that_ends_in_cpython_alone(tmp_path, untraced):
    """Shifted into the sign, a number is negative in machine code and not in CPython."""
    lines = "    while (1 << (62 + int(me.t))) < 0:\n        me.n += 1e-9\n"
    found = check(changed(tmp_path / "bad.py", (OWN, OWN + lines)), patience=1.0)
    assert [one.fault for one in found[:-1]] == [None] * len(checks())
    said = (
        r"compiled, observe\(me, \S+, 1.0\) \(b = \S+, w = \S+\) did not return within 1 s, though in CPython it does"
    )
    assert re.fullmatch(said, found[-1].fault)


@pytest.mark.long
@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled")
def test_fields_named_like_numpy_attributes(tmp_path, capsys, untraced):
    odd = {"t": "data", "n": "dtype"}
    source = re.sub(r'(?<=me\.)[tn]\b|(?<=")[tn](?=")', lambda field: odd[field[0]], TINY)
    assert '{"data": 0.0, "dtype": 0.0}' in source
    (tmp_path / "odd.py").write_text(source)
    machine_code.step_by_step(brains.load(tmp_path / "odd.py"))()
    seen = np.isfinite(machine_code.history()[2]).sum()
    assert capsys.readouterr().out.count("observe(me, ") == seen


def test_what_does_not_compile_is_found(tmp_path):
    path = changed(tmp_path / "bad.py", (OWN, "    me.n += blacks * (('a' if looks > 0.0 else 1.0) == 'a')\n"))
    found = {
        one.name: one.fault
        for one in conformance.examine(path, {k: v for k, v in checks().items() if k not in PROMISES})
        if one.fault
    }
    assert list(found) == ["compiles"]
    assert re.match(r"Numba cannot compile it \(line \d+\)", found["compiles"])


@pytest.mark.long
def test_disagreement_is_found(tmp_path):
    """Integers wrap in machine code and grow in CPython: the suite sees it."""
    wrap = "    me.t += looks\n    if (1 << (62 + int(me.t))) > 0:\n        me.n += 0.25 * looks\n"
    source = TINY.replace("    me.t += looks\n", wrap).replace("me.n / me.t", "min(me.n / me.t, 1.0)")
    (tmp_path / "wraps.py").write_text(source)
    tests = {conformance.AGREES: checks()[conformance.AGREES]}
    assert any(c.fault and "compiled" in c.fault for c in conformance.examine(tmp_path / "wraps.py", tests))


@pytest.mark.long
def test_compiling_has_room_but_not_all(tmp_path, monkeypatch):
    """In a process of its own, where a compiler that is never done asks for more than it may have."""
    path = changed(tmp_path / "good.py")
    ask = (
        "import sys; from swarmcensus.checks import machine_code as m, suite as c\n"
        "m.compiles = lambda brain: bytearray(c.COMPILE_MEMORY_BYTES)\n"
        "c.checks = lambda every=c.checks(): {c.COMPILES: every[c.COMPILES]}\n"
        "c.report(sys.argv[1], 30.0)"
    )
    done = subprocess.run([sys.executable, "-c", ask, str(path)], capture_output=True, text=True, check=True)
    said = "Numba did not compile it within 4 GiB of memory"
    assert json.loads(done.stdout.splitlines()[-1]) == ["compiles", said, True]


@pytest.mark.parametrize(
    ("error", "said"), [(MemoryError(), "within 4 GiB of memory"), (ValueError("no"), "cannot compile it: no")]
)
def test_why_numba_does_not_compile_it(error, said, tmp_path, monkeypatch):
    def fails(*_):
        raise error

    monkeypatch.setattr(machine_code.compiler, "compile_brain", fails)
    brain = brains.load(changed(tmp_path / "good.py"))
    assert said in conformance.fault_of(checks()[conformance.COMPILES], brain)


def test_a_file_that_breaks_the_contract(tmp_path):
    (tmp_path / "bad.py").write_text("def observe(:")
    found = check(tmp_path / "bad.py")
    assert len(found) == 1
    assert "not Python" in found[0].fault


def test_from_python_a_check_is_an_answer(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("bad.py").write_text("def observe(:")
    bad = sc.check("bad.py", single=True)
    assert not bad.conforms
    assert bad.single is None
    assert str(bad).startswith(
        "bad.py does not keep the contract\nFAIL  keeps the contract: brain file bad.py, line 1: "
    )
    with pytest.raises(sc.InputError, match=r"brain 'minimalistc': did you mean 'minimalistic'\?"):
        sc.check("minimalistc")
    with pytest.raises(sc.InputError, match="did you mean 'legacy'"):
        sc.check("bad.py", wrapping="legcy")
    monkeypatch.setattr(conformance, "check", lambda *_, wrapping: [conformance.Check("keeps the contract", None)])
    monkeypatch.setattr(conformance, "single_life", lambda *_: {"alone": None, "hearing": 7})
    good = sc.check("three-state", single=True)
    assert good.conforms
    assert good.single == {"alone": None, "hearing": 7}
    assert repr(good).splitlines()[0] == "three-state keeps the contract"


LOT = "    me.heard += 1.0\n    if me.luck * me.heard < 1.0:\n        me.kept = message[0]\n"
RANDOM = (
    ("MEMORY = {", 'MEMORY = {"heard": 0.0, "kept": 0.5, "lot": 0.5, "x": 0.5, '),
    (HEAR, f"def receive(me, message):\n{LOT}"),
    (FUSE, "def fuse(me):\n    me.x = 0.5 * me.x + 0.5 * me.kept\n    me.heard = 0.0\n"),
    ("MESSAGE = ", "MESSAGE = "),
)
ORDER = "messages mean the same in any order"
AT_ONCE = "readings at once mean the same as one by one"


@pytest.mark.long
def test_fair_sampling_of_messages_is_allowed(tmp_path):
    """Each of the messages is as likely to be kept, in whatever order they come: the same law, and other states."""
    path = changed(tmp_path / "mine.py", *RANDOM)
    assert not fault_in(path, ORDER)
    assert not faults_of(path)


@pytest.mark.parametrize(
    ("lot", "field"),
    [
        ("    me.lot = me.luck\n    me.kept = message[0]\n", "kept"),
        ("    me.heard += 1.0\n    if me.luck < 0.5:\n        me.kept = message[0]\n", "kept"),
        ("    me.heard += me.luck\n    if me.heard < 0.9:\n        me.kept = message[0]\n", "kept"),
        ("    me.lot = 0.5 * me.lot + 0.5 * me.luck\n    me.kept = 0.5 * me.kept + 0.5 * message[0]\n", "kept"),
    ],
    ids=["the last", "the last by a coin", "the first by lot", "fading"],
)
def test_order_dependence_is_found_despite_random_draws(tmp_path, lot, field):
    changes = [(old, new.replace(LOT, lot)) for old, new in RANDOM]
    fault = fault_in(changed(tmp_path / "mine.py", *changes), ORDER)
    assert fault
    assert f"gives me.{field} another distribution" in fault or f"makes me.{field}" in fault
    assert "the order of messages should not matter" in fault


def test_order_dependence_is_found_despite_random_draws_elsewhere(tmp_path):
    last = [(old, new.replace(LOT, "    me.kept = message[0]\n")) for old, new in RANDOM]
    own = (OWN, f"{OWN}    me.lot = me.luck\n")
    fault = fault_in(changed(tmp_path / "mine.py", *last, own), ORDER)
    assert fault
    assert "the order of messages should not matter" in fault


@pytest.mark.long(
    but=["    if me.luck < 0.9 ** looks:\\n        me.heard += 1.0\\n-False", "    me.lot += me.luck\\n-False"]
)
@pytest.mark.parametrize(
    ("line", "lawful"),
    [
        ("    me.lot = me.luck\n", True),
        ("    if me.luck < 0.9 ** looks:\n        me.heard += 1.0\n", False),
        ("    me.lot += me.luck\n", False),
        ("    if me.luck < 1.0 - 0.9 ** looks:\n        me.heard = 1.0\n", True),
    ],
)
def test_readings_at_once_mean_the_same_by_law(tmp_path, line, lawful):
    """Ten readings are ten times one: a coin that is thrown once a call and not once a reading is caught."""
    fault = fault_in(
        changed(tmp_path / "mine.py", ("MEMORY = {", 'MEMORY = {"lot": 0.5, "heard": 0.0, '), (OWN, OWN + line)),
        AT_ONCE,
    )
    assert bool(fault) != lawful
    if fault:
        assert "another distribution" in fault
        assert "from 10 readings at once than from the same one by one" in fault


def test_a_vector_indexed_beyond_its_end_is_told(tmp_path):
    """In words, by each check that meets it, and by none with a crash."""
    path = changed(
        tmp_path / "mine.py", ("MEMORY = {", 'MEMORY = {"seen": (0.0,) * 3, '), (OWN, f"{OWN}    me.seen[3] = looks\n")
    )
    found = faults_of(path)
    assert len(found) > 3
    first, *others = found.values()
    assert "observe fails at line" in first
    assert "IndexError" in first
    assert set(others) == {"the same as above"}


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("me.seen[1] = math.inf - math.inf", "observe (line 9) makes me.seen[1] NaN"),
        ("me.seen[1] = 1 << 1023", "observe (line 9) makes me.seen[1] a whole number too large"),
        ("me.seen[1] = None", "observe (line 9) makes me.seen[1] None, not a number"),
        ("me.seen[0] = math.inf\n    me.seen[1] = -math.inf\n    me.seen[2] = 3", None),
    ],
    ids=["NaN", "large", "None", "infinite and whole"],
)
def test_a_vector_s_numbers_are_looked_at_one_by_one(line, said, tmp_path):
    path = changed(tmp_path / "mine.py", ("MEMORY = {", 'MEMORY = {"seen": (0.0,) * 3, '), (OWN, f"{OWN}    {line}\n"))
    fault = fault_in(path, "remembers numbers in MEMORY's fields, nothing else")
    assert fault is None if said is None else said in fault


EXAMPLES = EXAMPLE


def test_a_name_that_decides_who_is_heard_is_lawful():
    """The example: of the lowest name the latest news, in whatever order they come."""
    assert not fault_in(EXAMPLES / "leader.py", ORDER)
