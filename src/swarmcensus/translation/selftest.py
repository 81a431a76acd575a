"""A test of a translated brain: a small swarm lives the same history in C and in CPython, and both print their bits."""

import ast
import struct
from collections.abc import Sequence
from typing import Any, NamedTuple

from swarmcensus.brains import Brain, rounded_to_single
from swarmcensus.runtime.history import ACCURACIES, FAR, LOOKS, LOST, ROBOTS, ROUNDS, SEED, SHARE, STOPS, live
from swarmcensus.support.errors import BrainError
from swarmcensus.support.options import command
from swarmcensus.translation.messages import messages_of, owed_places
from swarmcensus.translation.pieces import filled
from swarmcensus.translation.unit import Unit

EXACT = {  # of math: all machines give the same bits
    "sqrt", "floor", "ceil", "trunc", "fabs", "fmod", "copysign", "frexp", "ldexp", "isnan", "isinf", "isfinite", "pi",
}  # fmt: skip


def expected(brain: Brain) -> str:
    """What the self-test of a brain prints, from CPython. Raises InputError if the brain fails in it."""
    single = brain.numbers.precision == "single"
    width = rounded_to_single if single else float
    states = [brain.robot(width(b), width(w), float(i)) for i, (b, w) in enumerate(ACCURACIES)]
    try:
        return lived(brain, brain.functions, states)
    except Exception as error:
        what = f"{type(error).__name__}: {str(error).partition(chr(10))[0]}"
        fails = f"brain {brain.name!r} fails in the self-test: {what}"
        check = command("swarmcensus", "brains", "--check", brain.name)
        raise BrainError(f"{fails}; {check} shows where", key="brain", value=brain.name) from error


def lived(brain: Brain, functions: Any, states: Sequence[Any], codec: Any = None) -> str:
    """What the self-test prints in this process, with a brain's `functions`, blank `states` and a codec."""
    radios = [messages_of(brain) for _ in states]
    for radio in radios:
        radio.codec = codec or radio.codec
    single = brain.numbers.precision == "single"
    lines = live(functions, states, radios, list(brain.memory), owed_places(brain), brain.uses.luck, single)
    return "".join(f"{line}\n" for line in lines)


class BitDifference(NamedTuple):
    """How the output of a self-test differs from what is expected."""

    line: int  # the first line that differs, counted from 1; 0 if none does
    largest: float  # the largest difference of numbers, relative to those above 1; infinite if other things differ


def is_exact(brain: Brain) -> bool:
    """Whether a brain uses only what IEEE 754 defines to the last bit: no functions such as exp, and no powers.

    Rounded to single precision, a square of CPython's has the bits of a product.
    """
    nodes = list(ast.walk(ast.parse(brain.source)))
    called = {
        node.attr for node in nodes if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "math"
    }
    called |= {"pow"} & {node.id for node in nodes if isinstance(node, ast.Name)}
    powers = [node for node in nodes if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.Pow)]
    return called <= EXACT and all(_is_square(node) and brain.numbers.precision == "single" for node in powers)


def _is_square(node: ast.BinOp | ast.AugAssign) -> bool:
    exponent = node.right if isinstance(node, ast.BinOp) else node.value
    return isinstance(exponent, ast.Constant) and exponent.value == 2


def compare(wanted: str, found: str) -> BitDifference:
    """Compare the output of a self-test with the expected one."""
    rows = list(zip(wanted.splitlines(), found.splitlines(), strict=False))
    first = next((k for k, (one, other) in enumerate(rows, 1) if one != other), 0)
    if len(wanted.splitlines()) != len(found.splitlines()):
        return BitDifference(first or len(rows) + 1, float("inf"))
    largest = max((_distance(one, other) for one, other in rows if one != other), default=0.0)
    return BitDifference(first, largest)


def _distance(one: str, other: str) -> float:
    mine, yours = one.split(), other.split()
    if len(mine) != len(yours) or mine[:2] != yours[:2]:
        return float("inf")
    last = len(mine) if mine[2] == "memory" else len(mine) - 1  # a message's bytes may change with a number's last bit
    if "silent" in (mine[-1], yours[-1]) and mine[-1] != yours[-1]:
        return float("inf")
    return max(map(_apart, mine[2:last], yours[2:last]), default=0.0)


def _apart(one: str, other: str) -> float:
    if one == other:
        return 0.0
    if "nan" in (one, other):
        return float("inf")
    x, y = (struct.unpack(">f" if len(text) == 8 else ">d", bytes.fromhex(text))[0] for text in (one, other))
    return float(abs(x - y) / max(1.0, abs(x)))


def in_c(brain: Brain, unit: Unit) -> str:
    """The self-test's C source, for a file next to brain.h."""
    put = "    test_put_number({});".format
    answers = [put("estimate(me)"), *([put("decide(me)")] * brain.decides)]
    answers += [put("done(me) ? 1 : 0")] * brain.ends + [put("jam(me) ? 1 : 0")] * brain.jams
    if brain.has_interval:
        answers += ["    const struct interval ends = interval(me);", put("ends.low"), put("ends.high")]
    if brain.steers:
        answers += ["    test_give_draw(me);", "    struct command command = {0, 0};"]
        answers += map(put, ("steer(me, &command) ? 1 : 0", "command.speed", "command.turn"))
    fields = [(unit.field(name), items) for name, items in brain.lengths.items()]
    owed = len(owed_places(brain))
    memory = [line for field in fields + [("owed", owed)] * bool(owed) for line in _put(*field)]
    return filled(
        "swarm_selftest.c",
        **{"robots": ROBOTS, "rounds": ROUNDS, "seed": SEED, "share": SHARE, "far": FAR, "lost": LOST},
        stops=", ".join(map(str, STOPS)),
        looks=", ".join(map(str, LOOKS)),
        accuracies=", ".join(f"{{{unit.real(b)}, {unit.real(w)}}}" for b, w in ACCURACIES),
        word="uint32_t" if unit.number == "float" else "uint64_t",
        top=28 if unit.number == "float" else 60,
        draws="    me->luck = luck;" if brain.uses.luck else "    (void)me;\n    (void)luck;",
        unit_of_draw=unit.real(2.0**-24),
        name=", (number)i" if brain.uses.name else "",
        done=" && !done(me)" if brain.ends else "",
        jam="jam(&test_swarm[i]) ? false : " if brain.jams else "",
        answers="\n".join(answers),
        memory="\n".join(memory),
    )


def _put(field: str, items: int) -> list[str]:
    if not items:
        return [f"    test_put_number(me->{field});"]
    return [f"    for (int32_t k = 0; k < {items}; k++) {{", f"        test_put_number(me->{field}[k]);", "    }"]
