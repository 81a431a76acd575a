"""The conformance suite passes the shipped brains and names each fault of a broken one."""

import ast
import re
import runpy
from pathlib import Path
from types import SimpleNamespace

import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.checks import checking, machine_code, quick, suite as conformance
from swarmcensus.checks.checking import run_checks
from swarmcensus.checks.contract_checks import PROMISES
from swarmcensus.checks.suite import AGREES, COMPILES, KEEPS, checks
from tests.support.places import DOCS, EXAMPLE
from tests.support.second import changed
from tests.support.small import study_of

PAGE = DOCS / "brain-contract.md"
TINY = changed(
    ("MEMORY =", "import math\n\nMEMORY ="),
    ('("x",)', '("n",)'),
    ("(estimate(me),)", "(me.n,)"),
    ("return me.n / me.t if me.t > 0.0 else 0.5", "if me.t == 0.0:\n        return 0.5\n    return me.n / me.t"),
)
OWN = "    me.n += blacks\n"  # the line of TINY's observe that follows `me.t += looks`
HEAR = "def receive(me, message):\n    pass\n"
FUSE = "def fuse(me):\n    pass\n"


def made(path, *changes):
    """A brain file: TINY with these changes."""
    path.write_text(changed(*changes, source=TINY))
    return path


def fault_in(path, name):
    return conformance.fault_of(PROMISES[name], brains.load(path))


def faults_of(path, tests=PROMISES):
    return {one.name: one.fault for one in conformance.examine(conformance.brain_to_check(path), tests) if one.fault}


def found_by(path, **more):
    """What the checks of a process of its own find."""
    return run_checks(path, brains.load(path), **more)


def test_unused_optional_parts_are_reported(monkeypatch):
    """A leaver steers and sums up what it hears; a brain alone says nothing, and hears nothing."""

    def unused(name):
        return [one.name for one in conformance.examine(brains.load(name), PROMISES) if not one.used]

    optional = ["steers by a speed and a turn, or not at all", "decides for an option, or not yet",
                "tells an interval within [0, 1], the low end first"]  # fmt: skip
    assert unused("alone") == [*optional, "messages mean the same in any order", "SUMS only add up"]
    assert unused("leaver") == optional[1:]
    checked = list(conformance.examine(brains.load("alone"), PROMISES))
    assert all(one.fault is None for one in checked)
    monkeypatch.setattr(checking, "run_checks", lambda *_: checked)
    assert f"-     {optional[0]}: not used\n" in repr(sc.check("alone"))


@pytest.mark.long
def test_all_checks_of_a_shipped_brain(untraced_processes):
    """In a process of their own; all brains are checked in this one elsewhere."""
    found = found_by("minimalistic")
    assert len(found) == len(checks()) + 1
    assert [c.fault for c in found] == [None] * len(found)


ORDER = "messages mean the same in any order"
AT_ONCE = "readings at once mean the same as one by one"
ADD = "SUMS only add up"
NUMBERS = "remembers numbers in MEMORY's fields, nothing else"
FINITE = "gives finite messages and estimates in [0, 1]"
READ = "functions that tell something only read"
MORE = ('"n": 0.0}', '"n": 0.0, "sum": 0.0, "heard": 0.0, "mean": 0.0, "rounds": 0.0, "x": 0.5, "seen": (0.0,) * 3}')
SUMS = ('MESSAGE = ("n",)', 'MESSAGE = ("n",)\nSUMS = ("sum", "heard")')


def own(text):
    """A line more in `observe`."""
    return [MORE, (OWN, f"{OWN}    {text}\n")]


def adds(text):
    """What messages add to sums."""
    fuses = (FUSE, "def fuse(me):\n    me.sum = 0.0\n    me.heard = 0.0\n")
    return [MORE, SUMS, (HEAR, f"def receive(me, message):\n    me.heard += 1.0\n    {text}\n"), fuses]


def hears(text):
    """What is made of messages one by one, and of their mean."""
    fuse = "me.rounds += 1.0\n    me.mean = me.sum / max(me.heard, 1.0)\n    me.heard = me.sum = 0.0"
    heard = (HEAR, f"def receive(me, message):\n    me.heard += 1.0\n    {text}\n")
    return [MORE, heard, (FUSE, f"def fuse(me):\n    {fuse}\n"), CLIP]


CLIP = ("return me.n / me.t", "return min(me.n / me.t, 1.0)")


@pytest.mark.parametrize(("promise", "changes", "said"), [
    (NUMBERS, own("me.n += blacks * math.inf * 0.0"), r"observe \(line 9\) makes me.n NaN \(b = 0.0"),
    (NUMBERS, own("me.n = 1 << 1023"), r"observe \(line 9\) makes me.n a whole number too large for 8"),
    (NUMBERS, own("me.b = 0.9"), r"observe \(line 9\) sets me.b and me.w from \(0.0, 0.0\) to \(0.9"),
    (NUMBERS, own("me.w = 0.9 if me.t > 5000.0 else me.w"), r"observe \(line 9\) sets me.b and me.w from"),
    (NUMBERS, own("me.seen[1] = math.inf - math.inf"), r"observe \(line 9\) makes me.seen\[1\] NaN"),
    (NUMBERS, own("me.seen[1] = 1 << 1023"), r"observe \(line 9\) makes me.seen\[1\] a whole number too large"),
    (NUMBERS, own("me.seen[1] = None"), r"observe \(line 9\) makes me.seen\[1\] None, not a number"),
    (NUMBERS, own("me.seen[3] = looks"), r"observe fails at line .*IndexError"),
    (NUMBERS, [(HEAR, "def receive(me, message):\n    me.n += 0.0 / me.t\n")], "receive fails at line 19 .*Zero"),
    (FINITE, [("return me.n / me.t", "return 2.0 * me.n / me.t")], r"not a number in \[0, 1\]"),
    (FINITE, [("return me.n / me.t", "return me.n / me.t + (me.t > 5000.0)")], "estimate .* gives 1"),
    (FINITE, [("if me.t == 0.0:", "if me.t < 0.0:")], r"estimate fails at line 29 \(return me.n / me.t\): Zero"),
    (FINITE, [("return (me.n,)", "return (me.n, me.t)")], "not a tuple of 1"),
    (FINITE, [("return (me.n,)", "return (math.inf,)")], "not a finite number"),
    (READ, [("return (me.n,)", "me.n += 1.0\n    return (me.n,)")], r"broadcast \(line 14\) changes me.n"),
    (READ, [("return (me.n,)", "me.n += me.t > 5000.0\n    return (me.n,)")], "broadcast .* changes me.n"),
    # what sums add depends on the message alone: not on beliefs, sums so far, or how old a state is
    (ADD, adds("me.sum += message[0] * me.b"), r"line \d+.*with SUMS.*depends on the message alone"),
    (ADD, adds("me.sum += message[0] / (1.0 + abs(me.sum))"), "depends on the message alone"),
    (ADD, adds("me.sum = max(me.sum, message[0])"), "depends on the message alone"),
    (ADD, adds("me.sum += message[0]\n    me.t += 1.0"), "adds 1.0 to me.t"),
    (ADD, adds("me.sum += message[0] * (me.heard != 9.0)"), r"adds \S+ to me.sum "),
    (ADD, adds("me.sum += message[0] * (me.heard != 300.0)"), r"adds \S+ to me.sum "),
    (ADD, adds("me.sum += message[0] * (message[0] < 5000.0 or me.t < 10.0)"), r"adds \S+ to me.sum "),
    (ADD, adds("me.sum += message[0] * (me.t < 500000.0)"), r"adds \S+ to me.sum "),
    # many readings at once, also in a long life
    (AT_ONCE, own("me.n = 0.9 * me.n"), r"makes me.n \S+ of \d+ readings at once, \d+ of them black, and \S+ of "),
    (AT_ONCE, [("    me.t += looks\n" + OWN, "    me.t += 1.0\n    me.n += blacks / looks\n")], "makes me.[tn]"),
    (AT_ONCE, [(OWN, "    me.n += min(blacks, 50.0)\n")], "makes me.n"),
    (AT_ONCE, own("me.n -= me.t > 9000.0"), "makes me.n"),
    (AT_ONCE, own("me.n -= looks > 2500.0"), "makes me.n"),
    (AT_ONCE, [*hears("pass"), (OWN, OWN + "    me.n += me.rounds > 120.0\n")], "makes me.n"),
    # messages in any order, also of many and in a long life
    (ORDER, hears("me.n = 0.5 * me.n + 0.5 * message[0]"), r"receive \(line 18\), with fuse after it, makes me.n"),
    (ORDER, hears("me.n += message[0] * (message[0] > me.n)"), "the order of messages should"),
    (ORDER, hears("me.sum += message[0] * (me.heard <= 8.0)"), r"makes me.mean \S+ of the messages \["),
    (ORDER, hears("me.sum += message[0] * (me.heard <= 150.0)"), r"makes me.mean .* in all\)? and "),
    (ORDER, hears("me.sum += message[0] * (me.rounds < 120.0 or me.heard <= 1.0)"), "makes me.mean"),
    (ORDER, hears("me.sum += message[0] * (message[0] < 5000.0 or me.heard <= 2.0)"), "makes me.mean"),
    # random draws do not hide it
    (ORDER, hears("me.x = me.luck\n    me.n = message[0]"), "the order of messages should not matter"),
    (ORDER, hears("me.n = message[0] if me.luck < 0.5 else me.n"), "me.n.* the order of messages should not matter"),
    (AT_ONCE, own("me.heard += me.luck < 0.9 ** looks"),
     "me.heard a number of mean .* of 10 readings at once, .* of the same in two"),
    (AT_ONCE, own("me.x += me.luck"), "me.x a number of mean"),
])  # fmt: skip
def test_faults_are_found(promise, changes, said, tmp_path):
    fault = fault_in(made(tmp_path / "bad.py", *changes), promise)
    assert fault
    assert re.search(said, fault)


CHANGES = ("return (me.n,)", "me.n += 1.0\n    return (me.n,)")


@pytest.mark.parametrize(("change", "said"), [
    (("return me.n / me.t", "return 2.0 * me.n / me.t"), "estimate (line 26) gives 2.0, not a number in"),
    ((FUSE, "def fuse(me):\n    while True:\n        pass\n"),
     "keep the contract: fuse has run 300,000 lines in one call and has not returned"),
    (CHANGES, "breaks the contract: broadcast (line 14) changes me.n"), ((OWN, OWN), ""),
], ids=["out of range", "endless", "changes", "none"])  # fmt: skip
def test_a_quick_check_finds_plain_faults_and_ends(change, said, tmp_path):
    found = quick.quick_fault(brains.load(made(tmp_path / "bad.py", change)))
    assert said in found if said else not found


def test_a_quick_check_finds_nothing_wrong_in_shipped_brains():
    for name in ("minimalistic", "steadfast", "leaver"):
        assert not quick.quick_fault(brains.load(name))


@pytest.mark.interpreted
def test_brain_file_is_checked_once_before_a_run(tmp_path, monkeypatch):
    monkeypatch.setenv("SWARMCENSUS_CACHE", str(tmp_path / "cache"))
    bad = made(tmp_path / "bad.py", CHANGES, ('"""The mean', '"""Another mean'))
    checked = []
    odd = "breaks the contract: it is odd"
    monkeypatch.setattr(quick, "quick_fault", lambda brain: checked.append(brain.name) or odd)
    monkeypatch.setattr(quick, "in_background", lambda work, **_: work)
    for _ in range(2):
        quick._caution.cache_clear()
        with pytest.warns(UserWarning, match=rf"breaks the contract: it is odd: swarmcensus brains --check {bad}"):
            sc.run(study_of([str(bad), "alone"], rounds=2, trials=1), jobs=1)
    assert checked == [str(bad)]


RECIPE = PAGE.read_text(encoding="utf-8").partition("## A recipe")[2].split("```")[1].removeprefix("python\n")


def with_recipe(path, recipe):
    """TINY with the functions, fields and constants of a recipe."""
    source = TINY
    for part in ast.parse(recipe).body:
        text = ast.get_source_segment(recipe, part)
        if isinstance(part, ast.FunctionDef):
            old = re.search(rf"def {part.name}\(.*?(?=\n\n\n|\Z)", source, re.DOTALL)
            source = source.replace(old[0], text) if old else f"{source}\n\n{text}\n"
        elif text.startswith("MEMORY = {"):
            source = source.replace("MEMORY = {", f"{text.removesuffix('}')}, ", 1)
        else:
            source = source.replace("MESSAGE =", f"{text}\nMESSAGE =", 1)
    path.write_text(source, encoding="utf-8")
    return path


@pytest.mark.long
def test_the_recipe_of_the_page_keeps_the_contract(tmp_path):
    path = with_recipe(tmp_path / "recipe.py", RECIPE)
    assert all(name in path.read_text() for name in re.findall(r"^def (\w+)", RECIPE, re.MULTILINE))
    assert faults_of(path) == {}


def test_the_recipe_of_the_page_computes_a_median(tmp_path):
    median = runpy.run_path(str(with_recipe(tmp_path / "recipe.py", RECIPE)))
    fields = {name: list(value) if isinstance(value, tuple) else value for name, value in median["MEMORY"].items()}
    me = SimpleNamespace(**fields)
    for heard in (0.1, 0.22, 0.9):
        median["receive"](me, (heard,))
    for _ in range(2):  # a round in which nobody is heard changes nothing
        median["fuse"](me)
        assert me.middle == 0.225


def forgetful(keep):
    fresh = f"    keep = {keep}**looks\n    fresh = (1.0 - keep) / (1.0 - {keep})\n    me.t = keep * me.t + fresh\n"
    return [("    me.t += looks\n" + OWN, f"{fresh}    me.n = keep * me.n + fresh * blacks / looks\n")]


SIGNED = (  # sums of large numbers that cancel
    ('"n": 0.0}', '"n": 0.0, "sum": 0.0, "x": 0.5}'),
    ('MESSAGE = ("n",)', 'MESSAGE = ("n",)\nSUMS = ("sum",)'),
    ("return (me.n,)", "return (1.1 * (2.0 * me.n - me.t),)"),
    (HEAR, "def receive(me, message):\n    me.sum += message[0]\n"),
    (FUSE, "def fuse(me):\n    me.x = 1.0 / (1.0 + math.exp(-min(max(me.sum, -99.0), 99.0)))\n    me.sum = 0.0\n"),
)
WELFORD = (  # mean and variance, message by message
    ('"n": 0.0}', '"n": 0.0, "heard": 0.0, "mean": 0.0, "odd": 0.0}'),
    (HEAR, "def receive(me, message):\n    me.heard += 1.0\n    d = message[0] - me.mean\n"
           "    me.mean += d / me.heard\n    me.odd += d * (message[0] - me.mean)\n"),
    (FUSE, "def fuse(me):\n    me.heard = 0.0\n    me.mean = 0.0\n"),
)  # fmt: skip
KALMAN = (
    ('"n": 0.0}', '"n": 0.0, "p": 1.0, "x": 0.5}'),
    (OWN, OWN + "    me.p = 1.0 / (1.0 / me.p + 4.0 * looks)\n    me.x += 4.0 * me.p * (blacks - looks * me.x)\n"),
)


@pytest.mark.long(but_every=5)
@pytest.mark.parametrize("changes", [
    forgetful(0.5), forgetful(0.9999), SIGNED, WELFORD, KALMAN,
    hears("me.sum += (message[0] - me.sum) / me.heard\n    me.n = max(me.n, message[0])"),
    hears("me.x = message[0] if me.luck * me.heard < 1.0 else me.x"),
    own("me.seen[0] = math.inf\n    me.seen[1] = -math.inf\n    me.seen[2] = 3"), own("me.x = me.luck"),
    own("me.heard = 1.0 if me.luck < 1.0 - 0.9 ** looks else me.heard"),
])  # fmt: skip
def test_rounding_and_fair_draws_are_no_faults(changes, tmp_path):
    clip = [] if CLIP in changes else [CLIP]
    assert faults_of(made(tmp_path / "good.py", *clip, *changes)) == {}


@pytest.mark.long(but=["change0-gives me.n = "])
@pytest.mark.parametrize(("change", "said"), [
    ((OWN, OWN + "    calls = CALLS\n    calls += (1.0,)\n    me.n += 1e-6 * len(CALLS)\n"), "gives me.n = "),
    (("return (me.n,)", "calls = CALLS\n    calls += (1.0,)\n    return (me.n + len(CALLS) % 5.0,)"),
     "broadcast (line 15) gives (0.0,) and then (1.0,)"),
    (("    if me.t ==", "    calls = CALLS\n    calls += (1.0,)\n    if len(CALLS) % 7.0 == 0.0 or me.t =="),
     "estimate (line 27) gives "),
])  # fmt: skip
def test_nothing_is_kept_outside_of_a_state(change, said, tmp_path):
    calls = ('MESSAGE = ("n",)', 'MESSAGE = ("n",)\nCALLS = [0.0]')
    fault = faults_of(made(tmp_path / "bad.py", change, calls, CLIP))["the same history gives the same state"]
    assert said in fault
    assert "something is kept outside of me" in fault


@pytest.mark.long(but=["in a function"])
@pytest.mark.parametrize(("lines", "said"), [
    ("    k = int(min(me.t, 9.0))\n    me.n += 0.0 * (k**387420489 > 1)\n",
     "it did not end within 0.5 s: observe has not returned, at line 13$"),
    ("    rest(me)\n\n\ndef rest(me):\n    while me.t > 5.0:\n        pass\n",
     r"it did not end within 0.5 s: observe has not returned, at line 1[67] in rest$"),
    ("    me.n += 0.0 * (1 << 10**11)\n", "observe fails at line 12 .*(MemoryError|OverflowError)"),
], ids=["power", "in a function", "too large"])  # fmt: skip
def test_a_function_that_does_not_return_is_named(lines, said, here, monkeypatch):
    """Endless loops, numbers of a hundred million digits, and what brings the process down; in a folder of any name."""
    Path("bräin").mkdir()
    path = made(Path("bräin/bad.py"), (OWN, OWN + lines))
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")  # nothing is compiled
    found = {one.name: one.fault for one in found_by(path, patience=0.5)}
    assert found["keeps the contract"] is None
    assert re.search(said, found["remembers numbers in MEMORY's fields, nothing else"])


@pytest.mark.parametrize(("returncode", "stderr", "begun", "said"), [
    (-9, "", KEEPS, "it ends its process by SIGKILL: most likely it is out of memory"),
    (3, "Fatal: no\n", KEEPS, "it ends its process: Fatal: no"),
    (1, "Timeout (0:00:09)!", COMPILES, "it did not end within 9 s: Numba is compiling it"),
    (1, "Timeout (0:00:09)!", AGREES, "it did not end within 9 s: its machine code has not returned, and in CPy"),
    (1, "Timeout (0:00:09)!", NUMBERS, "it did not end within 9 s: it is slow"),
])  # fmt: skip
def test_why_the_process_of_a_check_ended(returncode, stderr, begun, said):
    done = SimpleNamespace(returncode=returncode, stderr=stderr)
    assert checking._why_it_ended(done, brains.load("alone"), begun, 9.0).startswith(said)


def test_what_does_not_compile_is_found(tmp_path):
    path = made(tmp_path / "bad.py", (OWN, "    me.n += blacks * (('a' if looks > 0.0 else 1.0) == 'a')\n"))
    found = faults_of(path, {k: v for k, v in checks().items() if k not in PROMISES})
    assert list(found) == ["compiles"]
    assert re.match(r"Numba cannot compile it \(line \d+\)", found["compiles"])


@pytest.mark.long
@pytest.mark.parametrize("in_", ["observe", "steer"])
def test_disagreement_is_found(in_, tmp_path):
    """Integers wrap in machine code and grow in CPython: the suite sees it."""
    wrap = "    me.t += looks\n    if (1 << (62 + int(me.t))) > 0:\n        me.n += 0.25 * looks\n"
    source = TINY.replace("    me.t += looks\n", wrap).replace("me.n / me.t", "min(me.n / me.t, 1.0)")
    if in_ == "steer":
        source = f"{TINY}\n\ndef steer(me):\n    return 0.1 * ((1 << (58 + int(me.t))) > 0), 0.0\n"
    (tmp_path / "wraps.py").write_text(source)
    fault = conformance.fault_of(machine_code.agrees, brains.load(tmp_path / "wraps.py"))
    assert ("compiled, steer gives" if in_ == "steer" else "compiled") in fault


def test_why_numba_does_not_compile_it(tmp_path, monkeypatch):
    def fails(*_):
        raise MemoryError

    monkeypatch.setattr(machine_code.compiler, "compile_brain", fails)
    assert conformance.fault_of(machine_code.compiles, brains.load("alone")) == "Numba cannot compile it: MemoryError"


def test_from_python_a_check_is_an_answer(here, monkeypatch):
    Path("bad.py").write_text("def observe(:")
    bad = sc.check("bad.py")
    assert not bad.conforms
    said = "bad.py does not keep the contract\nFAIL  keeps the contract: brain file bad.py, line 1: "
    assert str(bad).startswith(said)
    with pytest.raises(sc.InputError, match=r"brain 'minimalistc': did you mean 'minimalistic'\?"):
        sc.check("minimalistc")
    with pytest.raises(sc.InputError, match="did you mean 'legacy'"):
        sc.check("bad.py", wrapping="legcy")
    monkeypatch.setattr(checking, "run_checks", lambda *_: [conformance.Check("keeps the contract", None)])
    good = sc.check("three-state")
    assert good.conforms
    assert repr(good).splitlines()[0] == "three-state keeps the contract"


def test_a_fault_of_several_checks_is_reported_once(tmp_path):
    first, *others = faults_of(made(tmp_path / "mine.py", *own("me.seen[3] = looks"))).values()
    assert "IndexError" in first
    assert len(others) > 2
    assert set(others) == {"the same as above"}


def test_a_name_that_decides_who_is_heard_is_lawful():
    """The example: of the lowest name the latest news, in whatever order they come."""
    assert not fault_in(EXAMPLE / "leader.py", ORDER)
