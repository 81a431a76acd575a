"""What is read of a brain file; what is wrong with it is named, with its line."""

import pytest

from swarmcensus import brains
from swarmcensus.brains import brain as brain_module
from swarmcensus.support.errors import InputError
from tests.support.lying import RICH
from tests.support.second import MEANS, brain, changed

BASE = changed(("MEMORY = {", 'PARAMETERS = {"prior": 10.0, "among": (0.25, 0.75)}\nMEMORY = {"pair": (0.0, 0.5), '))
HEAD, FUSE, END = "PARAMETERS =", "def fuse(me):\n    pass", "the end"
CYCLE = "def far(me):\n    near(me)\n\n\ndef near(me):\n    far(me)"


def source_of(place, text):
    """A brain with this text above its tables, in `fuse`, at its end, or in place of other text."""
    if place == END:
        return f"{BASE}\n\n{text}\n"
    written = {HEAD: f"{text}\n{HEAD}", FUSE: f"def fuse(me):\n    {text}"}.get(place, text)
    return changed((place, written), source=BASE)


@pytest.mark.parametrize(("place", "text", "said"), [
    ("looks):", "looks:", "line 8: not Python"),
    ("def fuse(", "def fuze(", "the function fuse is missing"),
    ("broadcast(me)", "broadcast(me, you)", "broadcast: the number of its arguments should be 1, not 2"),
    ("MEMORY = {", "MEMORIES = {", "MEMORY is missing"),
    ('MESSAGE = ("x",)', 'MESSAGE = "x"', "MESSAGE is 'x', a text: a tuple of one name is"),
    ('("x",)', '("pair", "pair")', "MESSAGE names 'pair' twice"),
    (HEAD, 'SUMS = ("overheard",)', "SUMS names 'overheard'"),
    ('"t": 0.0', '"b": 0.0', "MEMORY key 'b' is reserved: choose another name than"),
    (FUSE, "me.t = math.sqrt(2.0)", "write import math at the top of the file"),
    ('"t": 0.0', '"t": "zero"', "not a number"),
    ('"t": 0.0', '"t t": 0.0', "not a name"),
    (HEAD, "import os", "line 3: imports os"),
    (HEAD, "class Diary: pass", "constants and small functions"),
    (HEAD, "X = 1 / 0", "a constant has no value: division by zero"),
    (HEAD, "X = {({},): 1.0}", "keys of a dict should be numbers or texts"),
    (END, "def fuse(me):\n    pass", "line 29: fuse is defined twice, and only the last would count"),
    (HEAD, 'MESSAGE = ("n",)', "MESSAGE is defined twice"),
    (HEAD, "from math import pi\npi = 3.0", "pi is defined twice"),
    (HEAD, "from math import *", "imports all of math: name what is used"),
    (HEAD, "import math, math", "math is defined twice"),
    (END, "import math as gain\n\n\ndef gain(me):\n    return me.x", "gain is defined twice"),
    (END, "def __getattr__(me):\n    return me.x", "defines __getattr__: names that begin with __"),
    (HEAD, "__builtins__ = {}", "defines __builtins__: names that begin with __"),
    ('"t": 0.0', '"t": 1.0, "t": 0.0', "the key 't' is there twice"),
    ("def estimate(", "@staticmethod\ndef estimate(", "decorator"),
    (FUSE, "me.n = [me.n][0]", "line 22: List in fuse"),
    (FUSE, "me.n = (lambda: me.n)()", "Lambda in fuse"),
    (FUSE, "fuse(me)", "line 22: fuse calls itself"),
    (END, CYCLE, "which calls far: functions of a brain"),
    # vectors
    ("(0.0, 0.5)", "(0.0,) * 4097", "a vector of 4,097: it should have 1 to 4,096 numbers"),
    ("(0.0, 0.5)", "()", "a vector of 0"),
    ("(0.0, 0.5)", "(0.0, True)", "not a number, as item 1"),
    ("(0.0, 0.5)", "(1e300, 0.0)", "too large, as item 0: numbers are below"),
    (FUSE, "me.pair = (1.0, 2.0)", "line 22: fuse sets me.pair, a vector: its items are set one by one"),
    (FUSE, "me.pair += 1.0", "sets me.pair, a vector: its items are set one by one"),
    (FUSE, "me.pair[0:1] = (1.0,)", "only items of MEMORY's vectors can be set"),
    (FUSE, "me.n = me.pair[0:1][0]", "takes a slice of a vector: its items are read one by one"),
    (FUSE, "del me.pair[0]", "only items of MEMORY's vectors can be set"),
    (FUSE, "me.n[0] = 1.0", "sets me.n[0]: only items of MEMORY's vectors can be set"),
    (FUSE, "pair = me.pair\n    pair[0] = 1.0", "sets pair[0]: only items of MEMORY's vectors can be set"),
    # parameters
    ('"prior"', '"n"', "PARAMETERS['n'] is in MEMORY too"),
    ('"prior"', '"luck"', "PARAMETERS key 'luck' is reserved"),
    ('"prior"', '"file"', "PARAMETERS key 'file' is reserved"),
    ("10.0", '"x"', "PARAMETERS['prior'] = 'x': not a number"),
    ('{"prior": 10.0, "among": (0.25, 0.75)}', '("prior",)', "PARAMETERS should be a dict such as"),
    (FUSE, "me.prior += 1.0", "line 22: fuse sets me.prior: parameters are read-only"),
    (FUSE, "me.n, me.prior = 1.0, 2.0", "fuse sets me.prior"),
    (FUSE, "for me.prior in range(3):\n        pass", "read-only"),
    (FUSE, "me.among[0] = 1.0", "read-only"),
    (FUSE, "del me.prior", "read-only"),
    (END, "def helper(me):\n    me.prior = 1.0", "helper sets me.prior"),
    # random draws and names
    (FUSE, "me.luck *= 2.0", "fuse sets me.luck, which is read-only"),
    (FUSE, "me.n, me.name = 1.0, 2.0", "fuse sets me.name, which is read-only"),
    (FUSE, "del me.name", "fuse sets me.name, which is read-only"),
    ("estimate(me):\n", "estimate(me):\n    x = me.luck\n", "line 25: broadcast reads me.luck in estimate, which"),
    (END, "def done(me):\n    return me.luck < 0.5", "done reads me.luck, which is new only in observe"),
    # optional functions
    (HEAD, "OPTIONS = 1", "OPTIONS = 1: should be a whole number, 2 (white and black) to 10,000"),
    (HEAD, "OPTIONS = True", "OPTIONS = True: should be a whole number"),
    (HEAD, "OPTIONS = 4", "OPTIONS needs the function decide, which is missing"),
    (END, "def decide(me, x):\n    return 1", "decide: the number of its arguments should be 1, not 2"),
    (END, "done = True", "done is True, not a function"),
    (END, "def decides(me):\n    return 1", "the function decides is never called: did you mean 'decide'?"),
    (END, "def decide(me):\n    if me.t > 2.0:\n        return\n    return 1", "decide may end without returning"),
    (END, "def interval(me, level):\n    return 0.0, 1.0", "the number of its arguments should be 1, not 2"),
    # what messages mean
    (HEAD, 'ROLES = ("x",)', 'ROLES should be a dict such as {"x_hat": "estimate"}'),
    (HEAD, 'ROLES = {"y": "estimate"}', "ROLES names 'y', which is not in MESSAGE"),
    (HEAD, 'ROLES = {"x": "truth"}', "ROLES['x'] = 'truth': should be one of estimate, opinion, option"),
    (HEAD, 'ROLES = {"x": "belief"}', "ROLES['x'] = 'belief': a belief is a vector, and other roles are"),
    (HEAD, 'ROLES = {"x": "information"}', "ROLES names an information but no confid"),
    (HEAD, "OPINION = 1", "OPINION = 1"),
    (HEAD, "ORACLE = True", "an ORACLE hears all robots at once, so it needs SUMS"),
    (HEAD, 'NEEDS = ("rounds",)', 'NEEDS should be a dict such as {"silent": "3 * phase"}'),
    (HEAD, 'NEEDS = {"round": 3}', "NEEDS names 'round': did you mean 'rounds'? known are silent, robots"),
    (HEAD, 'NEEDS = {"rounds": "2 * phas"}', "NEEDS['rounds'] = '2 * phas': should be a number, or plain arithm"),
    (HEAD, 'NEEDS = {"rounds": "1 +"}', "NEEDS['rounds'] = '1 +': should be a number"),
    (HEAD, 'NEEDS = {"rounds": "1 / 0"}', "NEEDS['rounds'] = '1 / 0': should be a number"),
    (HEAD, 'NEEDS = {"rounds": "print(1)"}', "NEEDS['rounds'] = 'print(1)': should be a number"),
    (END, "def jam(me):\n    if me.t > 1.0:\n        return True", "jam may end without returning"),
])  # fmt: skip
def test_faults_are_named(place, text, said):
    with pytest.raises(InputError, match=r"^brain file brain\.py") as caught:
        brain(source_of(place, text))
    assert said in str(caught.value)


@pytest.mark.parametrize(("added", "said"), [("me.luck", "me.luck"), ("message[0] * of(me)", "me.name")])
def test_sums_depend_on_the_message_alone(added, said):
    receive = f"me.n += {added}"
    helped = changed(("message):\n    pass", f"message):\n    {receive}")) + "\n\ndef of(me):\n    return me.name\n"
    brain(helped)
    with pytest.raises(InputError, match=rf"receive reads {said}.*with SUMS, what it adds may depend only on the mes"):
        brain(changed(("MEMORY =", 'SUMS = ("n",)\nMEMORY ='), source=helped))
    with pytest.raises(InputError, match="SUMS cannot be combined with jam"):
        brain(brains.load("minimalistic").source + "\n\ndef jam(me):\n    return me.t > 5.0\n")


@pytest.mark.parametrize("line", [
    "pow = eval", "pow = me.x; pow(me.x, 2)", "for pow in range(2): pow(2, 2)", "min((pow := me.x), 1.0); pow(2, 2)",
    "(abs, *pow) = (1, 2); pow(2, 2)", "del pow; pow(2, 2)", "math = me; math.sqrt(2.0)", "me.x = getattr",
    "me.x = __loader__", "__loader__('os')", "me.x = min(1, 2, key=exec)",
    "text = '{0.__class__}'; max(me, me, key=text.format)", "x = me.__class__", "me.__class__ = 1",
    "math.__loader__.load_module('os')", "math.__getattribute__('pi')", "x = math.sin.__self__", "math.pi = 3.0",
    "fuse.heard = 1.0", "me.x.real.imag", "raise SystemExit", "raise ValueError('no')", "assert print(1)",
    "x = f'{print(1)}'", "x: eval('1') = 1; x(2)", "try: me.x\n    except* ValueError as pow: pow(2, 2)",
    "with me as pow: pow(2, 2)", "import os as pow", "global pow; pow = 1", "async def pow(): pass",
    "x = [pow for pow in (1, 2)]", "x = (lambda pow: pow)(1)", "yield",
])  # fmt: skip
def test_no_line_reaches_code_that_the_contract_does_not_name(line):
    good = brains.load("minimalistic").source
    with pytest.raises(InputError, match=r"brain\.py, line \d+: "):
        brain(good.replace("    return me.x\n", f"    {line}\n    return me.x\n"))


@pytest.mark.parametrize("head", [
    "# coding: utf-7", "from math import __loader__ as math", "from .math import sqrt",
    "from math import sqrt, __loader__ as root", "fuse = 1.0", "print('hello')",
    "def first(me, pow=print(1)):\n    pass", "def first(me: print(1)):\n    pass",
    "def first(me, *, pow: print(1)):\n    pass", "def first(me, *pow):\n    pass",
    "def first(me) -> print(1):\n    pass", "@print\ndef first(me):\n    pass", "X: print(1) = 1",
    "if print(1): X = 1", "X = (Y := 1)", "X[0] = 1", "X = f'{1}'",
    "X = 9**9**9", "X = 'a' * 10**10", "X = '%1000000000000d' % 1", "X = 1 << 10**10", "X = [0] * 10**10",
    "X = 0x" + "f" * 5000, "X = (*(1,), 2)", "X = 2.0**2000", "import math\nmath.pi = 3",
])  # fmt: skip
def test_no_first_line_runs_code(head, capsys):
    with pytest.raises(InputError, match=r"brain\.py"):
        brain(f"{head}\n{brains.load('minimalistic').source}")
    assert not capsys.readouterr().out


ALLOWED = [
    "round, pow, fuse = 1.0, 2.0, 3.0\n    if round > pow + fuse:\n        raise ValueError\n    return 0",
    "for k in range(2):\n        if k == 1:\n            return k",
    "if me.t > 2.0:\n        while True:\n            break\n        return 1\n    else:\n        return 0",
    "while me.t < 0.0:\n        return 1\n    return 0",
]


def test_what_is_allowed_is_not_refused():
    """Names that hide functions which are not called, and loops that are trusted to return."""
    for body in ALLOWED:
        brain(f"# coding: utf8\n{MEANS}\n\ndef decide(me):\n    {body}\n")
    for body in ("return 0, 1", "x = (0.2, me.t)\n    return x", "return wide(me)"):
        brain(f"{MEANS}\n\ndef wide(me):\n    return 0.0, 1.0\n\n\ndef interval(me):\n    {body}\n")


def test_usual_names_have_roles():
    assert brain(BASE).roles == {"x": "estimate"}
    assert brains.load("minimalistic").roles == {"x_hat": "estimate", "alpha": "confidence"}
    assert brain(source_of(HEAD, 'ROLES = {"x": "confidence"}')).roles == {"x": "confidence"}
    assert brain(RICH).roles["belief"] == "belief"
    assert not brain(BASE).is_opinion
    assert brain(source_of(HEAD, "OPINION = True")).is_opinion


def test_no_such_brain(tmp_path):
    with pytest.raises(InputError, match="neither a shipped brain"):
        brains.load("nobody")
    (tmp_path / "mine.py").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="cannot be read as text"):
        brains.load(tmp_path / "mine.py")


def test_shipped_brains_are_checked_once():
    """Whoever reads them all again, as many commands do, waits for no check."""
    for _ in range(2):
        before = brain_module._read.cache_info().misses
        for name in brains.shipped():
            brains.load(name)
    assert brain_module._read.cache_info().misses == before
