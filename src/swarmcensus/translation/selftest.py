"""A test of a translated brain: a small swarm lives the same history in C and in CPython, and both print their bits."""

import ast
from collections.abc import Sequence
from typing import Any

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
    exponents = [node.right if isinstance(node, ast.BinOp) else node.value for node in powers]
    are_squares = all(isinstance(one, ast.Constant) and one.value == 2 for one in exponents)
    return called <= EXACT and (not powers or (are_squares and brain.numbers.precision == "single"))


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
