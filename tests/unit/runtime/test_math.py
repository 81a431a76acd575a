"""What brains may use of `math`: what MicroPython has; and what AVR boards lack."""

import ast
import math
import re
import shutil
import subprocess
import tempfile
import types
from pathlib import Path

import numba
import pytest

from swarmcensus import brains
from swarmcensus.brains import robot_math
from swarmcensus.checks import checking
from swarmcensus.engine import codegen, python_errors
from swarmcensus.engine.constants import RAISED
from swarmcensus.support.errors import InputError
from tests.support.boards import MICROPYTHON, on_board
from tests.support.on_node import NEEDED
from tests.support.places import DOCS
from tests.support.second import changed

TINY = changed(
    ('"""The mean of its own readings, and it tells it."""', "import math"),
    ('{"t": 0.0', '{"x": 0.5, "t": 0.0'),
    ("    me.t += looks\n    me.n += blacks\n", "    me.x = 0.5\n"),
)


def micropython(source):
    """What MicroPython prints."""
    if not MICROPYTHON:
        pytest.skip(f"needs {NEEDED}")
    with tempfile.TemporaryDirectory() as folder:
        return on_board(Path(folder), {"main.py": source})


def lacks(source):
    """Whether MicroPython refuses what CPython runs."""
    exec(source, {})
    program = f"try:\n    exec({source!r}, {{}})\nexcept (SyntaxError, NotImplementedError):\n    print('lacks it')"
    return micropython(program) == "lacks it\n"


def refused(source, read=brains.parse):
    with pytest.raises(InputError) as caught:
        read(source, "x", Path("x.py"))
    return str(caught.value)


def test_the_list_is_what_micropython_has():
    known = micropython("import math\nprint(*dir(math))").split()
    listed = {*robot_math.FUNCTIONS, *robot_math.CONSTANTS, *robot_math.NOT_IN_C}
    assert {name for name in known if name[0] != "_"} == listed
    calls = micropython("import builtins\nprint(*dir(builtins))").split()
    assert {"abs", "min", "max", "int", "float", "bool", "round", "range", "pow", "divmod", "len"} <= {*calls}


@pytest.mark.parametrize("name", [n for n in dir(math) if n[0] != "_" and n not in robot_math.CONSTANTS])
def test_a_function_is_allowed_or_refused_with_its_line(name):
    source = TINY.replace("    me.x = 0.5\n", f"    me.x = math.{name}(0.5)\n")
    if name in robot_math.FUNCTIONS:
        assert brains.parse(source, "x", Path("x.py"))
    else:
        who = "C" if name in robot_math.NOT_IN_C else "MicroPython"
        assert f"x.py, line 8: uses math.{name}, which {who} on a robot lacks: " in refused(source)


@pytest.mark.parametrize(("line", "said"), [
    ("match me.t:\n        case 0.0:\n            me.x = 0.5", "match statement: if and elif are right"),
    ("pair = (me.x, 1.0)\n    me.x = max((*pair, 2.0))", "* in a tuple, as in (*pair, 2.0): write its items one"),
    ("me.x = (1.0, 0.5, 0.0)[::2][1]", "step in a slice, as in (1.0, 0.5, 0.0)[::2]: a loop over range is right"),
])  # fmt: skip
def test_syntax_that_micropython_lacks(line, said):
    error = refused(TINY.replace("    me.x = 0.5\n", f"    {line}\n"))
    assert f"line {8 + line.startswith('pair')}: MicroPython on a robot has no {said}" in error
    assert lacks(f"def f(me):\n    {line}\nclass M:\n    t = x = 0.0\nf(M())")


@pytest.mark.parametrize("power", ["2 ** k", "pow(2, k)", "2 ** -1", "2 ** (k - 1)", "(me.x > 1.0) ** -k"])
def test_a_whole_number_is_raised_to_none_that_may_be_below_0(power):
    """Numba gives 0, as numbers and types are whole."""
    source = TINY.replace("    me.x = 0.5\n", f"    k = int(me.x) - 3\n    me.x = 0.25 * {power}\n")
    assert "line 9: " in (said := refused(source))
    assert "are whole numbers, and machine code gives 0 if the second is below 0: float(" in said
    assert brains.parse(source.replace(power, "2.0 ** k"), "x", Path("x.py"))


@pytest.mark.parametrize("power", ["2 ** 3", "me.x ** k", "3 ** -0.5"])
def test_a_whole_number_is_raised_to_one_from_0(power):
    body = f"    for k in range(3):\n        me.x = 0.01 * {power}\n"
    assert brains.parse(f"ROWS = (0.1, 0.2)\n{TINY}".replace("    me.x = 0.5\n", body), "x", Path("x.py"))


def test_arguments_by_place_only():
    said = refused(f"{TINY}\n\ndef half(x, /):\n    return 0.5 * x\n")
    assert "MicroPython on a robot has no / among arguments, as half has: leave it out" in said
    assert lacks("def half(x, /):\n    return 0.5 * x")


def test_own_names_are_no_functions_of_math():
    assert brains.parse(TINY + "\n\ndef comb(x):\n    return x\n", "x", Path("x.py"))


def test_what_avr_boards_lack():
    assert robot_math.missing_on_avr(ast.parse(brains.load("bayes-bots").source)) == ["lgamma"]
    lacks = "AVR boards (Kilobot, Arduino) cannot run it, as avr-libc lacks lgamma"
    assert checking.notes_on("bayes-bots", brains.load("bayes-bots"), "") == [lacks]
    assert checking.notes_on("commons", brains.load("commons"), "") == []


def test_the_page_lists_all():
    page = (DOCS / "brain-contract.md").read_text(encoding="utf-8")
    section = page.partition("### math\n")[2].partition("## Optional parts")[0]
    allowed, _, others = section.partition("Others, such as")
    assert {*re.findall(r"`(\w+)`", allowed)} - {"math"} == {*robot_math.FUNCTIONS, *robot_math.CONSTANTS}
    assert {*re.findall(r"`(\w+)`", others.partition("also lack")[2])} == {*robot_math.NOT_ON_AVR}


@pytest.mark.skipif(not shutil.which("avr-gcc"), reason="needs avr-gcc and avr-libc")
def test_what_avr_libc_declares():
    words = {"input": "#include <math.h>\n", "capture_output": True, "text": True, "check": True}
    header = subprocess.run(["avr-gcc", "-E", "-"], **words).stdout
    declared = {*re.findall(r"\b(\w+)\s*\(", header)}
    names_in_c = {name: name for name in robot_math.FUNCTIONS if name not in ("degrees", "radians")}
    lacking = {name for name, in_c in (names_in_c | {"gamma": "tgamma"}).items() if in_c not in declared}
    assert lacking == {*robot_math.NOT_ON_AVR}


NUMBERS = (0.0, 1.0, -1.0, 0.5, -0.5, -2.5, 3.0, 171.7, -1000.0, 1000.0, 1e308, math.inf, -math.inf, math.nan)
TO_WHOLE = ("int(x)", "round(x)", "math.ceil(x)", "math.floor(x)", "math.trunc(x)")
OF_TWO = ("fmod", "ldexp", "pow", "**", "powi")
CALLS = [
    *(f"math.{name}(x)" for name in python_errors.OF_MATH if name not in OF_TWO),
    "int(x)", "round(x)", "math.fmod(x, y)", "math.ldexp(x, int(min(max(y, -2000.0), 2000.0)))",
    "math.pow(x, y)", "pow(x, y)", "x ** y", "x ** 2", "x // y", "x % y",
]  # fmt: skip


def outcome(call, *given):
    """What a call returns, or the type of its error; a complex number, which no state can hold, is an error too."""
    try:
        result = call(*given)
    except (ValueError, OverflowError, ZeroDivisionError) as error:
        return type(error)
    return ValueError if isinstance(result, complex) else float(result)


@pytest.mark.long
def test_machine_code_raises_where_cpython_does():
    """Every function on edges of its domain; all in one function, which is compiled once."""
    body = "".join(f"    if k == {k}:\n        return 1.0 * ({call})\n" for k, call in enumerate(CALLS))
    source = f"import math\ndef call(k, x, y):\n{body}    return 0.0\n"
    usual, made = {}, types.ModuleType("mine")
    exec(source, usual)
    exec(codegen.essence(source), vars(made))
    python_errors.make_strict(made)
    for name in [name for name in vars(made) if name.startswith(f"{RAISED}_to_")]:
        setattr(made, name, numba.njit(error_model="python")(getattr(made, name)))
    machine = numba.njit(error_model="python")(made.call)
    for k, name in enumerate(CALLS):
        for x in NUMBERS:
            for y in NUMBERS if "y" in name else (0.0,):
                expected, found = outcome(usual["call"], k, x, y), outcome(machine, k, x, y)
                if isinstance(expected, float) and abs(expected) >= 2**63 and name in TO_WHOLE:
                    expected = OverflowError  # whole numbers have 64 bits
                if {expected, found} == {OverflowError, ValueError} and name in ("x ** y", "pow(x, y)") and x < 0:
                    continue  # a complex number that is too large
                due = expected if isinstance(expected, type) else pytest.approx(expected, 1e-13, nan_ok=True)
                assert found == due, (name, x, y, expected, found)


def test_it_is_refused_where_its_name_is_imported():
    said = refused(TINY.replace("import math", "from math import log1p").replace("me.x = 0.5", "me.x = log1p(0.5)"))
    assert "line 1: uses math.log1p" in said
