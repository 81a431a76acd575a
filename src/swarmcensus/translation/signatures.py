"""The heads of functions in C."""

import ast

from swarmcensus.brains import REAL, RECORD, arguments_of
from swarmcensus.translation.unit import Record, Unit


def signature(unit: Unit, name: str) -> str:
    """A function's head in C."""
    result = unit.results[name]
    kinds = unit.kinds.names[name]
    arguments = []
    for argument in arguments_of(unit.functions[name]):
        kind = kinds.get(argument, REAL)
        c_name = unit.local(argument)
        if (name, argument) in unit.heard:
            arguments.append(f"const struct message *{c_name}")
        elif kind == RECORD:
            arguments.append(f"{'' if name in unit.writers else 'const '}struct brain *{c_name}")
        else:
            arguments.append(unit.declaration(kind, argument, unit.functions[name]))
    if not isinstance(result, Record):
        c_type = unit.type_of(result, unit.functions[name])
    elif unit.returns_record(name):
        c_type = "bool"
        arguments.append(f"struct {result.name} *{out_name(unit, name)}")
    else:
        c_type = f"struct {result.name}"
    return f"static inline {c_type} {unit.function(name)}({', '.join(arguments) or 'void'})"


def out_name(unit: Unit, name: str) -> str:
    """What a function calls the record that it fills."""
    result = unit.results[name]
    assert isinstance(result, Record)
    names = {node.id for node in ast.walk(unit.functions[name]) if isinstance(node, ast.Name)}
    return f"{result.name}_out" if result.name in names else result.name
