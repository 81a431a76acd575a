"""A robot's messages as bytes: in C, and in CPython as what the C is tested against."""

import ast
import functools
from importlib.resources import files
from typing import Any

from swarmcensus.brains import (
    BYTES,
    MOST,
    READ,
    REAL,
    STEPS,
    Brain,
    Kinds,
    Part,
    arguments_of,
    functions_of,
    in_single,
)
from swarmcensus.runtime.codec import LARGEST_REAL
from swarmcensus.runtime.runtime import Messages
from swarmcensus.support import safe_source
from swarmcensus.translation.pieces import functions
from swarmcensus.translation.unit import Record, Unit


@functools.cache
def codec(single: bool) -> tuple[ast.Module, Kinds, dict[str, Any], Any]:
    """The codec's syntax tree, kinds, constants, and functions in CPython."""
    path = files("swarmcensus.runtime") / "codec.py"
    tree, constants = safe_source.parse_checked(path.read_text(encoding="utf-8"), "codec", path)  # type: ignore[arg-type]
    kinds = Kinds(tree, {}, {name: (REAL,) * len(arguments_of(f)) for name, f in functions_of(tree).items()})
    run = safe_source.run(in_single(tree, kinds) if single else tree, "codec", path)  # type: ignore[arg-type]
    return tree, kinds, constants, run


def codec_unit(number: str) -> Unit:
    """The codec as a source to be translated."""
    tree, kinds, constants, _ = codec(number == "float")
    return Unit(tree, kinds, constants, number, prefix="codec_")


def messages_of(brain: Brain) -> Messages:
    """Packs what one robot says, and reads what it hears, in CPython."""
    single = brain.numbers.precision == "single"
    return Messages([*brain.message.values()], brain.parts, 0, False, brain.numbers.feedback, codec(single)[3])


def in_c(brain: Brain, message: Record, unit: Unit) -> str:
    """`brain_send` and `brain_hear` in C; `unit` is that of the codec, whose functions they call."""
    fields = zip(message.items, message.lengths, strict=True)
    places = [f"{name}[{k}]" if items else name for name, items in fields for k in range(max(items, 1))]
    owed, send, hear = owed_places(brain), [], []
    at = slot = 0
    for part in brain.parts:
        one, other = [*(f"message.{places[p]}" for p in part.places), ""][:2]
        owes = part.places[0] in owed
        # what is owed is added before a number is coded, and what rounding takes is known once it is read back
        for k, name in enumerate((one, other)[: len(part.places)] if owes else (), slot):
            send += [f"const number said{k} = {name};", f"{name} = codec_added({name}, me->owed[{k}]);"]
        send += _send(unit, part, one, other, at)
        hear += (received := _hear(unit, part, one, other, at))
        if owes:
            send += _owed_after(unit, part, (one, other), received, slot)
            slot += len(part.places)
        at += BYTES[part.coding]
    declare = "    struct message message;\n"
    return (
        "// Writes what the robot says, BRAIN_MESSAGE_BYTES bytes, and returns whether it says anything.\n"
        "static inline bool brain_send(struct brain *me, uint8_t *out) {\n"
        f"{declare}    if (!broadcast(me, &message)) {{\n        return false;\n    }}\n"
        + "\n".join(f"    {line}" for line in send)
        + "\n    return true;\n}\n\n"
        "// Takes in what another robot said.\n"
        "static inline void brain_hear(struct brain *me, const uint8_t *bytes) {\n"
        + declare
        + "\n".join(f"    {line.replace('out[', 'bytes[')}" for line in hear)
        + "\n    receive(me, &message);\n}"
    )


def owed_places(brain: Brain) -> list[int]:
    """Which numbers of a message owe something to the next, in the order of its bytes."""
    return [place for part in brain.parts if part.owed and brain.numbers.feedback for place in part.places]


def owed_numbers(brain: Brain) -> int:
    """How many numbers of memory that takes."""
    return len(owed_places(brain))


def _owed_after(unit: Unit, part: Part, names: tuple[str, str], received: list[str], slot: int) -> list[str]:
    """What rounding took is kept; a number that the format cannot hold owes nothing."""
    names_here = names[: len(part.places)]
    given = STEPS.get(part.coding) or MOST.get(part.coding)
    arguments = ", ".join([*names_here, *([] if given is None else [unit.real(given)])])
    lines = [f"const bool holds = codec_holds_{READ[part.coding]}({arguments});"]
    lines += [f"const number sent{k} = {name};" for k, name in enumerate(names_here)]
    lines += received
    for k, name in enumerate(names_here):
        owed = f"me->owed[{slot + k}]"
        rest = f"codec_rest(said{slot + k}, {owed}, sent{k}, {name})"
        lines.append(f"{owed} = holds ? {rest} : {unit.real(0.0)};")
    return ["{", *(f"    {line}" for line in lines), "}"]


def _send(unit: Unit, part: Part, one: str, other: str, at: int) -> list[str]:
    coding, size = part.coding, BYTES[part.coding] - bool(other)  # the confidence of a pair has a byte of its own
    if coding == "float32":
        return [f"codec_put_float(out + {at}, {one});"]
    if coding in STEPS:
        code = f"ratio_code({f'codec_ratio_of({one}, {other})' if other else one}, {unit.real(STEPS[coding])})"
    elif coding in MOST:
        code = f"whole_code({one}, {unit.real(MOST[coding])})"
    else:
        code = f"{'half' if coding == 'float16' else 'log'}_code({one})"
    put = f"out[{at}] = (uint8_t)codec_{code};" if size == 1 else f"codec_put_16(out + {at}, (uint16_t)codec_{code});"
    return [put, *([f"out[{at + size}] = (uint8_t)codec_log_code({other});"] if other else [])]


def _hear(unit: Unit, part: Part, one: str, other: str, at: int) -> list[str]:
    coding, size = part.coding, BYTES[part.coding] - bool(other)
    if coding == "float32":
        return [f"{one} = codec_get_float(&out[{at}]);"]
    value = f"out[{at}]" if size == 1 else f"codec_get_16(&out[{at}])"
    if coding in STEPS:
        value = f"codec_ratio_value({value}, {unit.real(STEPS[coding])})"
    elif coding not in MOST:
        value = f"codec_{'half' if coding == 'float16' else 'log'}_value({value})"
    if other:
        return [f"{other} = codec_log_value(out[{at + size}]);", f"{one} = {value} * {other};"]
    return [f"{one} = {value};"]


def bytes_in_c(text: str, number: str) -> str:
    """The functions that put numbers into bytes, as far as `text` calls them."""
    largest = f"{LARGEST_REAL!r}{'f' if number == 'float' else ''}"
    clamped = f"x > {largest} ? {largest} : x < -{largest} ? -{largest} : x"
    clamped = clamped if number == "float" else f"(float)({clamped})"
    needed = (code for name, code in functions("bytes.h").items() if f"{name}(" in text)
    return "".join(needed).replace("CLAMPED", clamped).strip()
