"""A brain as one C header: its memory, its parameters and tables, its functions and its messages."""

import ast
import contextlib
import re
import textwrap
from collections.abc import Iterator
from typing import Any

from swarmcensus.brains import REAL, VECTOR, Brain, Value, bytes_of, functions_of, length
from swarmcensus.support.errors import BrainError
from swarmcensus.support.safe_source import parse_checked
from swarmcensus.support.version import __version__
from swarmcensus.translation import helpers, messages
from swarmcensus.translation.reserved import OF_FIELDS
from swarmcensus.translation.signatures import signature
from swarmcensus.translation.statements import Function
from swarmcensus.translation.texts import quoted
from swarmcensus.translation.unit import C_TYPES, Record, Unit, Untranslatable, called, in_c, parameter_in_c

ABOUT = """\
// Written by swarmcensus {version}: the brain {label}, for numbers of type {number}, messages as {message}.
// Comments are in the brain's own file.
//
// Compile with -ffp-contract=off: a * b + c is then rounded twice, as in the simulator. Where Python raises an error,
// C goes on: a division by zero gives an infinity or NaN, the square root or logarithm of a negative number NaN, and a
// whole number beyond 32 bits is wrong. Indexes are not checked. The brain's checks in Python cover these cases.
//
// A robot calls brain_start once. Then it calls observe after each reading, brain_send to talk, brain_hear for each
// message, fuse at the end of a round, and estimate when it likes.
"""
FEATURES = """\
#ifndef BRAIN_H
#define BRAIN_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#if defined(__clang__) || !defined(__GNUC__)
#pragma STDC FP_CONTRACT OFF
#endif
"""
IS_DOUBLE = "\ntypedef char number_has_8_bytes[sizeof(number) == 8 ? 1 : -1];  // an AVR has no such numbers"
IN_FLASH = """\
#if defined(__FLASH) && !defined(__STRICT_ANSI__)  // an AVR with -std=gnu99: its tables stay in its flash
#define BRAIN_TABLE __flash
#else
#define BRAIN_TABLE
#endif
"""


def header(brain: Brain) -> str:
    """The C header of a brain in its number formats; a message needs a format. Raises InputError."""
    with _naming_line(brain):
        return _header(brain)


@contextlib.contextmanager
def _naming_line(brain: Brain) -> Iterator[None]:
    """Raise InputError with the line of a brain's file that has no translation."""
    try:
        yield
    except Untranslatable as error:
        raise BrainError.of(brain.path, error, where=f"brain file {brain.path}, line {error.line}") from None


def unit_of(brain: Brain) -> Unit:
    """A brain's source as one to be translated."""
    tree, constants = parse_checked(brain.source, "brain", brain.path)
    lengths = tuple(brain.message.values())
    names = tuple(in_c(name, OF_FIELDS) for name in brain.message)
    record = Record("message", names, tuple(VECTOR if n else REAL for n in lengths), lengths)
    return Unit(tree, brain.kinds, constants, number_type(brain), record, frozenset(brain.parameters))


def number_type(brain: Brain) -> str:
    """The type of C for the brain's numbers."""
    return "float" if brain.numbers.precision == "single" else "double"


def _header(brain: Brain) -> str:
    unit = unit_of(brain)
    assert unit.message is not None
    body = _functions(unit)
    codec = messages.codec_unit(unit.number)
    talk = messages.in_c(brain, unit.message, codec)
    codec_text = _needed_codec(codec, talk)
    tables = [*_parameters(brain, unit), *_constants_of(unit), *_constants_of(codec)]
    label, number = quoted(brain.label), unit.number
    about = ABOUT.format(version=__version__, label=label, number=number, message=brain.numbers.message)
    has_tables = any("BRAIN_TABLE" in table for table in tables)
    parts = [
        about.rstrip(),
        FEATURES.rstrip(),
        f"typedef {number} number;" + IS_DOUBLE * (number == "double"),
        IN_FLASH.rstrip() if has_tables else "",
        _memory(brain, unit),
        _message_of(unit),
        f"#define BRAIN_MESSAGE_BYTES {bytes_of(brain.parts)}",
        *map(_struct_of, unit.records.values()),
        "\n".join(tables),
        helpers.of_python(unit.needs | codec.needs, number),
        helpers.of_avr(unit.functions_of_math | codec.functions_of_math),
        body,
        _start(brain, unit),
        codec_text,
        messages.bytes_in_c(talk, number),
        talk,
        "#endif",
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def bare(brain: Brain, talk: str, codec: Unit) -> str:
    """A brain's C for a program that runs many: without includes, bytes and parameters.

    Whole numbers have 64 bits, as in the engine, and functions named `brain_...` notice what raises an error in Python.
    `talk` is text that calls functions of the `codec`. Raises InputError.
    """
    with _naming_line(brain):
        unit = unit_of(brain)
        unit.checked = codec.checked = True
        body = _functions(unit)
        codec_text = _needed_codec(codec, talk)
        parts = [
            _memory(brain, unit),
            _message_of(unit),
            *map(_struct_of, (unit.records | codec.records).values()),
            "\n".join([*_constants_of(unit), *_constants_of(codec)]),
            helpers.of_python(unit.needs | codec.needs, unit.number),
            body,
            codec_text,
        ]
    return re.sub(r"\bint32_t\b", "int64_t", "\n\n".join(part for part in parts if part))


def _memory(brain: Brain, unit: Unit) -> str:
    lines = ["// All that a robot remembers.", "struct brain {"]
    for name, items in brain.lengths.items():
        size = f"[{items}]" if items else ""
        lines.append(f"    number {unit.field(name)}{size};")
    lines.append("    number b;  // how often its sensor reads black right, as it believes")
    lines.append("    number w;  // and white")
    if brain.uses.luck:
        lines.append("    number luck;  // a new random number in (0, 1) before each observe, receive, fuse and steer")
    if brain.uses.name:
        lines.append("    number name;  // which no other robot has")
    if owed := messages.owed_numbers(brain):
        lines.append(f"    number owed[{owed}];  // what rounding took of its messages, which is added to the next one")
    return "\n".join([*lines, "};"])


def _message_of(unit: Unit) -> str:
    """The struct of a message."""
    record = unit.message
    assert record is not None
    lines = ["// What a robot says.", "struct message {"]
    for name, items in zip(record.items, record.lengths, strict=True):
        lines.append(f"    number {name}{f'[{items}]' if items else ''};")
    return "\n".join([*lines, "};"])


def _struct_of(record: Record) -> str:
    """The struct of a tuple."""
    fields = "\n".join(f"    {C_TYPES[kind]} {name};" for name, kind in zip(record.items, record.kinds, strict=True))  # type: ignore[index]
    return f"struct {record.name} {{\n{fields}\n}};"


def _parameters(brain: Brain, unit: Unit) -> list[str]:
    lines = []
    for name, value in brain.parameters.items():
        if name in unit.used_parameters:
            items, text = _value(unit, value)
            lines.append(f"static const number {parameter_in_c(name)}{items} = {text};")
    return lines


def _constants_of(unit: Unit) -> list[str]:
    """The constants that a source's functions read."""
    lines = []
    for name, value in unit.constants.items():
        if name not in unit.used:
            continue
        items, text = _value(unit, value)
        where = "BRAIN_TABLE " if isinstance(value, tuple) else ""
        c_type = "int32_t" if _is_whole(value) else "number"
        lines.append(f"static const {where}{c_type} {unit.constant(name)}{items} = {text};")
    return lines


def _value(unit: Unit, value: Any) -> tuple[str, str]:
    """The dimensions of a constant in C, and its value."""
    if isinstance(value, tuple):
        inner = [_value(unit, item) for item in value]
        if len({items for items, _ in inner}) != 1:
            raise Untranslatable("a table whose rows differ in length has no translation to C", unit.tree)
        whole = _is_whole(value)
        texts = [
            text if whole or isinstance(item, tuple) else unit.real(float(item))
            for item, (_, text) in zip(value, inner, strict=True)
        ]
        line = ", ".join(texts)
        if len(texts) > 5:  # several a line
            line = "\n" + "".join(f"    {part}\n" for part in textwrap.wrap(f"{line},", 112))
        return f"[{len(value)}]{inner[0][0]}", f"{{{line}}}"
    if isinstance(value, int):
        return "", str(int(value))
    return "", unit.real(value)


def _is_whole(value: Any) -> bool:
    """Whether a constant is a whole number, or a table of such."""
    return all(map(_is_whole, value)) if isinstance(value, tuple) else isinstance(value, int)


def _needed_codec(unit: Unit, talk: str) -> str:
    """The functions of the codec that the messages of this brain need, in C."""
    needed = [name for name in unit.functions if f"codec_{name}(" in talk]
    for name in needed:
        for node in ast.walk(unit.functions[name]):
            if (other := called(node)) in unit.functions and other not in needed:
                needed.append(other)
    unit.functions = {name: function for name, function in unit.functions.items() if name in needed}
    return _functions(unit)


def _start(brain: Brain, unit: Unit) -> str:
    arguments = ["struct brain *me", "number b", "number w", *(["number name"] if brain.uses.name else [])]
    lines = [
        "// A robot that knows nothing yet, with the accuracies of its sensor.",
        f"static inline void brain_start({', '.join(arguments)}) {{",
    ]
    for name, value in brain.memory.items():
        lines += _begin(unit, name, value)
    if owed := messages.owed_numbers(brain):
        lines += _loop("owed", owed, unit.real(0.0))
    lines += [f"    me->{name} = {name};" for name in ("b", "w", *(["name"] if brain.uses.name else []))]
    if brain.uses.luck:
        lines.append(f"    me->luck = {unit.real(0.5)};")
    return "\n".join([*lines, "}"])


def _begin(unit: Unit, name: str, value: Value) -> list[str]:
    field = unit.field(name)
    if not length(value):
        assert isinstance(value, float)
        return [f"    me->{field} = {unit.real(value)};"]
    assert isinstance(value, tuple)
    if len(set(value)) == 1:
        return _loop(field, len(value), unit.real(value[0]))
    return [f"    me->{field}[{k}] = {unit.real(item)};" for k, item in enumerate(value)]


def _loop(field: str, items: int, value: str) -> list[str]:
    return [f"    for (int32_t k = 0; k < {items}; k++) {{", f"        me->{field}[k] = {value};", "    }"]


def _functions(unit: Unit) -> str:
    """All functions of a source in C, in its order; those that are called before are declared first."""
    made = {name: Function(unit, name).lines() for name in functions_of(unit.tree) if name in unit.functions}
    declared, calls = [], set[str]()
    for name in made:
        calls |= {called(node) for node in ast.walk(unit.functions[name])}
        declared += [f"{signature(unit, name)};"] if name in calls else []
    parts = ["\n".join(declared)] if declared else []
    return "\n\n".join([*parts, *("\n".join(lines) for lines in made.values())])
