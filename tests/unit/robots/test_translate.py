"""Brains as C: the same bits as CPython, Python's meaning of every operation, and one sentence for what cannot be."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import swarmcensus as sc
from swarmcensus.brains import load
from swarmcensus.brains.brain import parse, shipped
from swarmcensus.brains.float32 import rounded_to_single
from swarmcensus.brains.kinds import RECORD, WHOLE
from swarmcensus.brains.packing import Numbers
from swarmcensus.robots.targets.c import translated
from swarmcensus.support.errors import InputError
from swarmcensus.translation.headers import header
from swarmcensus.translation.messages import messages_of
from swarmcensus.translation.selftest import is_exact
from tests.support.bit_differences import compare
from tests.support.hosts import on_host
from tests.support.places import DOCS, EXAMPLE
from tests.support.translated import BRAINS, CLOSE, compiled, differs, load_busy, named

GCC, GXX = (pytest.mark.skipif(not shutil.which(name), reason=f"{name} is not installed") for name in ("gcc", "g++"))
BRAIN = '''"""A brain that tries out Python."""
import math

TABLE = (1.5, -2.0, 0.25)
ORDER = (2, 0, 1)
ROWS = ((1.0, 2.0), (3.0, 4.0))
SMALL = 3

MEMORY = {"x": 0.0, "y": 0.0, "k": 0.0, "list": (0.0, 1.0, 2.0)}
MESSAGE = ("x", "list")
PARAMETERS = {"gain": 2.0, "weights": (0.5, 0.25)}

def observe(me, blacks, looks):
    me.x = blacks
    me.y = looks

def broadcast(me):
    return me.x, me.list

def receive(me, message):
    x, items = message
    me.x += x + items[2]

def fuse(me):
FUSE

def estimate(me):
    return 0.5
'''
NAMES_OF_C = """typeof linux unix AVR RAND_MAX BUFSIZ SEEK_CUR EXIT_FAILURE TMP_MAX P_tmpdir FOPEN_MAX WNOHANG
BYTE_ORDER LITTLE_ENDIAN MAXFLOAT FD_SETSIZE SNAN stdin FILENAME_MAX concept"""
NUMBERS = Numbers("double", "float32")


def trying(body, extra=""):
    """A brain whose `fuse` has these lines."""
    indented = "\n".join(f"    {line}" for line in body.strip().splitlines())
    return parse(BRAIN.replace("FUSE", indented) + extra, "trying", Path("trying.py")).with_numbers(NUMBERS)


SIGNED = "me.x, me.y = 2.5 * me.x - 7.0, 1.5 * min(me.y, 10.0) - 4.0\n"  # no y is 0
PROGRAMS = {
    "modulo and floor division": "me.k = me.x % me.y\nme.list[0] = me.x // me.y\nme.x %= 2.0\nme.y //= 0.5",
    "of whole numbers": "a = int(me.x)\nb = int(me.y * 2.0)\nme.k = a % b + 10 * (a // b)\nme.list[0] = a / b\n"
        "me.list[1] = 1.0 * (a * 60 % 7)",
    "round, floor, ceil and int": "me.k = round(me.x)\nme.list[0] = math.floor(me.x) + 10.0 * math.ceil(me.x)\n"
        "me.list[1] = int(me.x) + math.trunc(me.y)",
    "powers": "me.k = me.x ** 2 + (me.y + 1.0) ** 3\nme.list[0] = abs(me.x) ** 0.5\nn = 3\nme.list[1] = n ** 4\n"
        "me.list[2] = 2.0 ** me.y\nme.y **= 2",
    "min, max and abs": "me.k = min(me.x, me.y, 1.0) + 100.0 * max(me.x, me.y, -1.0)\n"
        "me.list[0] = max(0.0, -0.0) + min(int(me.x), 4)\nme.list[1] = abs(int(me.y)) + abs(me.x)",
    "chained comparisons": "me.k = float(0.0 < me.x <= me.y * 3.0 != 9.0)\nme.list[0] = float(-3.0 <= me.x < 3.0)",
    "truths": "a = me.x > 0.0\nb = not a\nme.k = a + 2 * b\n"
        "me.list[2] = 1.0 if me.x and not me.y < 0.0 or b else -1.0\nif me.x:\n    me.y = 5.0",
    "tables": "k = 3\nme.k = TABLE[ORDER[0]] + TABLE[-1] + ROWS[1][0]\nfor j in range(len(TABLE)):\n"
        "    me.list[j] = TABLE[j] * me.weights[j % 2] * me.gain + k\nme.y = me.list[-2]",
    "negative indexes": "k = int(me.x) % 3 - 1\nme.list[k] = 9.0\nme.k = me.list[k - 1]",
    "loops": "total = 0.0\nfor k in range(2, 10, 3):\n    if k == 5:\n        continue\n    total += k\n"
        "me.k = total + k\nfor j in range(5, 0, -2):\n    if j < 2:\n        break\n    me.list[0] += j\nn = 4\n"
        "for _ in range(n):\n    n -= 1\nme.list[1] = n\nwhile True:\n    me.y += 1.0\n    if me.y > 10.0:\n"
        "        break",
    "a name that lives from turn to turn": "for k in range(4):\n    if k == 1:\n        kept = me.x\n"
        "    elif k > 1:\n        kept = kept + 1.0\nme.k = kept",
    "tuples": "low, high = ends(me.x, me.y)\nme.k = low\nme.list[0] = high\nlow, high = high, low\n"
        "me.list[1] = low\npair = ends(1.0, me.y)\nme.list[2] = pair[1]",
    "tuples compared": "me.k = float((me.x, me.y) < (2.5, 2.0)) + 2.0 * float((me.x, 1.0) >= (me.x, me.y))\n"
        "me.list[0] = float(me.x in (7.0, 2.5))",
    "parts of a number": "part, power = math.frexp(me.x)\nme.k = part\nme.list[0] = power\n"
        "me.list[1] = math.fmod(me.x, 3.0)\nme.list[2] = math.ldexp(part, 3)",
    "words of C": "double = me.x\nint_ = 1.0\nregister = double + int_\nnumber = register\n"
        "floor = math.floor(number)\nme.k = floor",
}  # fmt: skip


@GCC
@pytest.mark.long(but=["commons-True", "swift-False", "belief-sharing-False", "whole-True"])
@pytest.mark.parametrize("busy", [False, True])
@pytest.mark.parametrize("name", BRAINS, ids=named)
def test_same_bits(name, busy, tmp_path):
    for message in ("float16", "ratio8") if busy else ("float32",):
        assert differs(load_busy(name, "double", message, busy), tmp_path, on_host).line == 0


@GCC
@pytest.mark.long(but=["commons-True", "minimalistic-False", "whole-True"])
@pytest.mark.parametrize("busy", [False, True])
@pytest.mark.parametrize("name", BRAINS, ids=named)
def test_same_bits_in_single(name, busy, tmp_path):
    exact = is_exact(load_busy(name, "single"))
    difference = differs(load_busy(name, "single", "ratio16" if exact else "float32", busy), tmp_path, on_host)
    assert difference.line == 0 if exact else difference.largest < CLOSE


@GCC
def test_the_test_can_fail(tmp_path):
    files = translated(load_busy("commons", "double"))
    for name, text in files.items():
        (tmp_path / name).write_text(text.replace("slope * slope * looks", "slope * (slope * looks)"))
    difference = compare(files["expected.txt"], on_host(tmp_path / "selftest.c"))
    assert difference.line > 0
    assert 0.0 < difference.largest < 1e-9


def test_comparing():
    assert compare("1 0 3f000000 silent\n", "1 0 3f800000 silent\n") == (1, 0.5)
    assert compare("1 0 3f000000 silent\n", "1 0 3f000000 00\n").largest == float("inf")
    assert compare("1 0 3f000000 00\n2 0 nan 00\n", "1 0 3f000000 00\n") == (2, float("inf"))


def test_kinds_do_not_depend_on_the_order_of_functions():
    """`helper` stands before what calls it, and calls others."""
    source = BRAIN.replace("def observe", f"{HELPER}def observe").replace("FUSE", "    me.x = helper(me, 3)")
    kinds = parse(source, "trying", Path("trying.py")).kinds
    assert kinds.names["helper"] == {"me": RECORD, "k": WHOLE}
    assert (kinds.names["estimate"], kinds.names["deeper"]) == ({"me": RECORD}, {"k": WHOLE})


HELPER = "def helper(me, k):\n    return estimate(me) * deeper(k + 1)\n\n\ndef deeper(k):\n    return k * 2\n\n\n"
ODD = {
    "a field that a helper reads": "me.x, me.y = me.x + 1.0, doubled(me)",
    "items of one vector": "i = int(me.x) % 2\nme.list[i], me.list[i + 1] = me.list[i] + me.y, me.list[int(me.x) % 2]",
    "two swaps": "a = me.x\nb = me.y\na, b = b, a\na, b = b + 1.0, a\nme.x = a - b",
    "two exponents": "m, e = math.frexp(me.x)\nme.x = m\nn, f = math.frexp(me.y + 3.0)\nme.x += n * f + e",
    "a tuple of itself": "t = (me.x, me.y)\nt = (t[1], t[0])\nme.x = t[0] - 3.0 * t[1]",
    "a chain": "unused = me.x = me.y + 1.0",
    "a loop without a name": "turn = 0.0\nfor _ in range(4):\n    turn += 1.0\nme.x = turn",
    "words of C": "double = me.x\ndouble_ = me.y + 1.0\nint32_t = 3\nk = int(me.x)\nme.x = double - double_ + int32_t",
    "macros": "me.x = me.x + INT32_MAX * BRAIN_MESSAGE_BYTES",
    "a result that nobody reads": "_, y = grown(me), 1.0\nme.x += y",
    "an exponent alone": "m, e = math.frexp(me.x + 1.0)\nme.x = e",
    "zeros without a sign": "me.x = math.ceil(me.x * 0.01 - 0.5)\nme.y = -math.floor(me.y * 0.001)",
    "a table of whole numbers": "for i in range(4):\n    me.x = -WHOLES[i]\n    me.y = WHOLES[i] % -3",
    "a helper that nobody calls": "me.x += 1.0  # no not_called here",
    "names of the self-test": "me.x = test_put(me)",
    "the largest real number": "me.x = min(me.x + 1.0, 3.4028235e38)\nme.y = 3.4028235e38",
    "whole beside real numbers": "k = 16777217\nif k > 16777216.0 + me.y * 0.0:\n    me.y += 1.0\nme.x += 16777217",
    "a helper that reads a parameter alone": "me.x *= tuned(me)",
    "large whole numbers": "k = int(me.x) + 16777217\nme.x = less(k) * 0.001\nme.y = k",
}
FAULTS = {
    "me.x = last(me.list, int(me.x))": "may be negative, and counts from an end that is not known here",
    "me.x = max(me.list)": "max(me.list): max needs two numbers or more here",
    "a, c = (me.x, 1) if me.x > 0.5 else (2, me.x)\nme.x = a + c": "a choice between tuples has no translation to C",
    "me.x = round(me.x, 2)": "round has no translation to C",
    "me.k = int(me.x) & 3": "int(me.x) & 3 has no translation to C",
    "for x in me.list:\n    me.x += x": "a loop over me.list: one over range(...) is right",
    "me.x = last(TABLE, 1)": "TABLE is no number",
    "for k in range(3):\n    me.x += k\nelse:\n    me.x = 0.0": "a loop with else has no translation to C",
    "me.x = me.y + grown(me)": "grown(me) changes what the rest of the line reads",
    "n = 3000000000\nme.x = n": "3,000,000,000 is no whole number of 32 bits",
    "me.x = me.y + (y := me.x * 2.0)": "(y := (me.x * 2.0)) has no translation to C",
    "me.x = me.x or me.y": "me.x or me.y is used as a number: a choice such as `x if x else y` is right",
    "me.x > 2 and grown(me)": "me.x > 2 and grown(me) has no translation to C",
    "me.x = doubled(me=me)": "doubled(me=me): C has neither named nor spread arguments",
    "a, *b = me.x, me.y, 1.0\nme.x = a": "a starred name takes a list, which C does not have",
    "me.x = either(me)": "either may return a value or nothing, which C cannot tell apart",
}
HELPERS = {
    "ends": "\n\ndef ends(low, high):\n    if low <= high:\n        return low, high\n    return high, low\n",
    "last": "\n\ndef last(items, k):\n    return items[k - 1]\n",
    "doubled": "\n\ndef doubled(me):\n    return me.x * 2.0 + 1.0\n",
    "less": "\n\ndef less(k):\n    return (k - 16777216.0) * 0.5\n",
    "INT32_MAX": "\n\nINT32_MAX = 5.0\nBRAIN_MESSAGE_BYTES = 3.0\n",
    "grown": "\n\ndef grown(me):\n    me.y += 1.0\n    return me.y\n",
    "tuned": "\n\ndef tuned(me):\n    return me.gain * 0.75\n",
    "WHOLES": "\n\nWHOLES = (0, 2, -1, 0)\n",
    "not_called": "\n\n# Left out.\ndef not_called(me):\n    me.x = me.y + 1.0\n    return me.x\n",
    "test_put": "\n\ndef test_put(me):\n    return me.x * 0.5\n",
    "either": "\n\ndef either(me):\n    if me.x > 0.0:\n        return 1.0\n",
}


def helpers_of(body):
    return "".join(text for name, text in HELPERS.items() if name in body)


@GCC
@pytest.mark.long(but_every=3)
@pytest.mark.parametrize("what", [*PROGRAMS, *(f"{what}, single" for what in ODD)])
def test_lines_have_the_bits_of_python(what, tmp_path):
    body = SIGNED + PROGRAMS[what] if what in PROGRAMS else ODD[what.removesuffix(", single")]
    numbers = NUMBERS if what in PROGRAMS else Numbers("single", "float32")
    assert differs(trying(body, helpers_of(body)).with_numbers(numbers), tmp_path, on_host).line == 0


@pytest.mark.parametrize("body", FAULTS)
def test_what_cannot_be(body):
    extra = helpers_of(body)
    with pytest.raises(InputError, match=r"brain file trying\.py, line \d+: ") as caught:
        translated(trying(body, extra))
    assert FAULTS[body] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_whole_numbers_have_32_bits_on_small_chips():
    text = translated(trying("me.x = len(me.list) * 10000\nme.y = (me.x > 0.0) * 300 * 300"))["brain.h"]
    assert "(int32_t)3 * 10000" in text
    assert "(int32_t)(me->x > 0.0) * 300" in text


def test_a_brain_that_fails():
    with pytest.raises(InputError, match="brain 'trying' fails in the self-test: ZeroDivisionError: float division"):
        translated(trying("me.x = 1.0 / me.k"))


@GXX
@pytest.mark.parametrize("name", ["bayes-bots", "swift", BRAINS[-1]], ids=named)
def test_headers_are_c_plus_plus_too(name, tmp_path):
    (tmp_path / "brain.h").write_text(header(load_busy(name, "single", "ratio16")))
    assert_compiles("g++ -std=c++11 -x c++", '#include "brain.h"\n', tmp_path)


def assert_compiles(command, program, folder):
    (folder / "program").write_text(program)
    words = f"{command} -Wall -Wextra -Werror -fsyntax-only program".split()
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@GXX
@pytest.mark.parametrize("command", ["gcc -std=gnu11 -x c", "g++ -std=gnu++17 -x c++"])
def test_fields_and_locals_may_have_names_of_c_libraries(command, tmp_path):
    fields = "".join(f'"{name}": 0.0, ' for name in NAMES_OF_C.split())
    source = BRAIN.replace("MEMORY = {", f"MEMORY = {{{fields}").replace("FUSE", "    main = me.x\n    me.y = main")
    (tmp_path / "brain.h").write_text(header(parse(source, "names", Path("names.py")).with_numbers(NUMBERS)))
    heads = "".join(f"#include <{name}.h>\n" for name in ("stdio", "stdlib", "limits", "sys/wait", "sys/select"))
    assert_compiles(f"{command} -D_GNU_SOURCE", f'{heads}#include "brain.h"\n', tmp_path)


@pytest.mark.parametrize(("arguments", "message"), [
    (["commons", "new", "--parameter", "k=1"], "the brain 'commons' has no parameter 'k': it has none"),
    (["tracking", "new", "--parameter", "z=1,2"], "z = [1.0, 2.0]"),
    (["commons", "other"], "the folder other is not empty, it holds 'mine.txt'"),
    (["commons", "file"], "file is a file: name a new folder"),
    (["commons", "new", "--precision", "float"], "--precision float"),
    (["commons", "new", "--hz", "4"], "--hz 4"),
])  # fmt: skip
def test_wrong_input(arguments, message, here, refused):
    (here / "other").mkdir()
    (here / "other" / "mine.txt").touch()
    (here / "file").touch()
    assert message in refused("deploy", *arguments, "--target", "c")


@GCC
def test_the_page_shows_a_robot_that_works(tmp_path):
    brain = load("commons").with_numbers(Numbers("single", "ratio16"))
    (tmp_path / "brain.h").write_text(header(brain))
    page = (DOCS / "onto-a-robot.md").read_text()
    top, start, rest = page.partition("```c\n")[2].partition("```")[0].partition("brain_start")
    body = f'{start}{rest}printf("%.9g", x);\nreturn 0;'
    printed = compiled(tmp_path, f"#include <stdio.h>\n{top}int main(void) {{\n{body}\n}}\n", "-I", str(tmp_path))
    me, radio, call = brain.robot(rounded_to_single(0.9), rounded_to_single(0.8)), messages_of(brain), brain.functions
    call.observe(me, 3.0, 10.0)
    call.receive(me, radio.read(radio.coded(call.broadcast(me))))
    call.fuse(me)
    assert float(printed) == pytest.approx(call.estimate(me), rel=1e-8)
    assert 0.1 < float(printed) < 0.2


@GCC
def test_check_bears_what_a_library_rounds_otherwise(tmp_path):
    """In a brain with exp and log; a wrong number, a missing line and another silence fail it."""
    sc.deploy(EXAMPLE / "sprt.py", tmp_path, "c", precision="double")
    wanted = tmp_path / "expected.txt"
    text = wanted.read_text()
    number = text.splitlines()[1].split()[2]
    cases = [
        (number, 0, "\nsame bits as in Python"),
        (f"{int(number, 16) + 1:016x}", 0, "numbers differ by 2.2e-16 at most"),
        (f"{int(number, 16) + 2**20:016x}", 2, "not what Python has"),
        ("7ff8000000000000", 2, "numbers differ by inf at most"),
    ]
    for other, code, said in cases:
        wanted.write_text(text.replace(number, other, 1))
        done = subprocess.run(["make", "-C", tmp_path, "check"], capture_output=True, text=True, check=False)
        assert (done.returncode, said in done.stdout) == (code, True)
    for other in (text.partition("\n")[2], f"{text}1 ", text.replace(text.splitlines()[0].split()[-1], "silent", 1)):
        wanted.write_text(other)
        assert subprocess.run(["make", "-C", tmp_path, "check"], capture_output=True, check=False).returncode == 2


def test_shipped_brains_multiply_instead_of_squaring():
    """CPython's power may differ from a product in the last bit, and C and machine code have products."""
    assert [name for name in shipped() if re.search(r"\*\* *2(\.0)?\b", load(name).source)] == []


@pytest.mark.parametrize("is_new", [True, False])
def test_files_in_c_appear_together_or_not_at_all(tmp_path, monkeypatch, is_new):
    folder, write_text = tmp_path / "c", Path.write_text
    if not is_new:
        folder.mkdir()

    def full(path, text, **given):
        if path.suffix == ".txt":
            raise OSError(28, "No space left on device")
        return write_text(path, text, **given)

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(InputError, match=r"cannot write .*: No space left on device"):
        sc.deploy("alone", folder, "c")
    assert folder.exists() is not is_new
    assert list(tmp_path.rglob("*.*")) == []


def test_parameters_are_constants_and_files_are_written_again(tmp_path):
    text = header(load("tracking").with_parameters({"z": 3.0}).with_numbers(Numbers("single", "ratio16")))
    assert "static const number parameter_z = 3.0f;" in text
    sc.deploy("commons", tmp_path / "c", "c")
    (tmp_path / "c" / "selftest").touch()
    made = sc.deploy("commons", tmp_path / "c", "c", precision="double")
    assert made.fields["names"] == ("brain.h", "selftest.c", "expected.txt", "Makefile")
    assert "typedef double number;" in (tmp_path / "c" / "brain.h").read_text()


def test_a_brain_that_does_not_return_is_refused(here, refused, untraced):
    """Its self-test would run for ever; the runtime of robots goes on after what a brain raises, and not after this."""
    (here / "loop.py").write_text(BRAIN.replace("FUSE", "    while me.y >= 0.0:\n        me.x += 1.0"))
    for end in (["c"], ["udp", "--accuracy", "0.9"]):
        assert "'loop.py': seems not to keep the contract: fuse" in refused("deploy", "loop.py", "o", "--target", *end)


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="a process is not forked there")
def test_a_single_line_that_takes_for_ever_is_refused(here, untraced_processes):
    """In C no signal is handled: the check has a process of its own, which the system ends."""
    lines = "z = 1.5 in range(10**13)", "z = 3\n    for _ in range(60):\n        z = z * z", "z = 3 << 10**11"
    for k, line in enumerate(lines):
        (here / f"b{k}.py").write_text(BRAIN.replace("FUSE", f"    {line}"))
    code = (
        "from swarmcensus.checks import quick; from swarmcensus.cli.commands import main; quick.MOST_SECONDS = 0.2\n"
        "assert {main(['deploy', f'b{k}.py', 'o', '--target', 'c']) for k in range(3)} == {2}"
    )  # in a process with one thread, which can be forked
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert re.findall(r"'(b\d.py)': seems not to keep the contract", done.stderr) == ["b0.py", "b1.py", "b2.py"]
