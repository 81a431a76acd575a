"""What a translation to C knows about a source: kinds, constants, names in C, and helper functions that it needs."""

import ast
import functools
import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from swarmcensus.brains import (
    NOTHING,
    REAL,
    RECORD,
    TRUTH,
    VECTOR,
    WHOLE,
    Kind,
    Kinds,
    arguments_of,
    functions_of,
    may_be_none,
    rounded_to_single,
)
from swarmcensus.translation.reserved import OF_FIELDS, OF_LOCALS, OURS

ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")
SPECIAL = {"interval": ("low", "high"), "steer": ("speed", "turn")}  # names for what these functions return
C_TYPES = {REAL: "number", WHOLE: "int32_t", TRUTH: "bool", NOTHING: "void"}


class Untranslatable(Exception):
    """A line of a source has no translation."""

    def __init__(self, what: str, node: ast.AST) -> None:
        """Keep the message and the line."""
        super().__init__(what)
        self.line = getattr(node, "lineno", 0)


class Record(NamedTuple):
    """A struct of C that holds the items of a tuple."""

    name: str
    items: tuple[str, ...]
    kinds: tuple[Kind, ...]
    lengths: tuple[int, ...]  # of items that are vectors; 0 for a number


@dataclass
class Unit:
    """One source to be translated."""

    tree: ast.Module
    kinds: Kinds
    constants: Mapping[str, Any]  # the values of its constants
    number: str  # the type of real numbers in C, "float" or "double"
    message: Record | None = None  # what `broadcast` returns and `receive` takes
    parameters: frozenset[str] = frozenset()  # fields of the record that are constants in C
    prefix: str = ""  # of functions and constants in C; without one, those of a brain's contract have their names
    checked: bool = False  # whether what raises an error in Python is noticed, by functions that a program has
    needs: set[str] = field(default_factory=set)  # names of helper functions in C
    used: set[str] = field(default_factory=set)  # constants that functions read
    used_parameters: set[str] = field(default_factory=set)
    functions_of_math: set[str] = field(default_factory=set)
    counters: set[tuple[str, str]] = field(default_factory=set)  # names, by function, that are never negative
    records: dict[str, Record] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Find what each function returns, and which functions change the record."""
        functions = functions_of(self.tree)
        # the functions that others call, and those that these call; all, if it is not known which others call
        reached = [name for name in functions if name in self.kinds.first] or [*functions]
        for name in reached:
            calls = {called(node) for node in ast.walk(functions[name])}
            reached += sorted((calls & functions.keys()) - {*reached})
        self.functions = {name: function for name, function in functions.items() if name in reached}
        for function in self.functions.values():
            for node in ast.walk(function):
                if called(node) in self.functions:
                    check_plain(node)  # type: ignore[arg-type]
        self.writers = self._writers()
        self.heard = self._find_messages()  # arguments, by function, that are the message of a neighbour
        self.speakers = self._speakers()
        self.results = {name: self._result(name) for name in self.functions}

    @functools.cached_property
    def vectors(self) -> dict[tuple[str, str], int]:
        """The lengths of vectors that have a name, by function and name. Raises Untranslatable if one has several."""
        found: dict[tuple[str, str], int] = {}
        before = -1
        while len(found) != before:
            before = len(found)
            for function, node in self.functions.items():
                for part in ast.walk(node):
                    for place, value in self._named_values(function, part):
                        items = self._items(function, value, found)
                        if items and found.setdefault(place, items) != items:
                            what = f"{place[1]} is a vector of {items} and of {found[place]} items"
                            raise Untranslatable(f"{what}: functions are given vectors of one length", value)
        return found

    def _named_values(self, function: str, node: ast.AST) -> Iterator[tuple[tuple[str, str], ast.expr]]:
        """The names that a node gives a value: its function and name, and the value."""
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            yield (function, node.targets[0].id), node.value
        if (other := called(node)) in self.functions:
            for name, value in zip(arguments_of(self.functions[other]), node.args, strict=False):  # type: ignore[attr-defined]
                yield (other, name), value

    def _items(self, function: str, value: ast.expr, found: Mapping[tuple[str, str], int]) -> int:
        """How many items a vector has; 0 if it is none, or if that is not known yet."""
        match value:
            case ast.Attribute(attr=field):
                return self.kinds.record.get(field, 0)
            case ast.Name(id=name):
                return found.get((function, name), 0)
            case ast.Subscript(value=ast.Name(id=name), slice=ast.Constant(value=int(place))) if (
                self.message and (function, name) in self.heard
            ):
                return self.message.lengths[place]
        return 0

    def local(self, name: str) -> str:
        """A local name in C."""
        return in_c(name, OF_LOCALS)

    def field(self, name: str) -> str:
        """A field of the record in C."""
        return in_c(name, OF_FIELDS)

    def function(self, name: str) -> str:
        """The name of a function in C; a prefix keeps it apart from all libraries."""
        return name if self.message and name in self.kinds.first else f"{self.prefix or 'helper_'}{in_ascii(name)}"

    def constant(self, name: str) -> str:
        """The name of a constant in C."""
        self.used.add(name)
        return f"{self.prefix or 'constant_'}{in_ascii(name)}"

    def math(self, name: str) -> str:
        """The name of a function of math.h for this type of numbers."""
        return f"{name}f" if self.number == "float" else name

    def need(self, name: str) -> str:
        """A helper function, which is then written into the file."""
        self.needs.add(name)
        return name

    def real(self, value: float) -> str:
        """A real number as a literal."""
        if self.number == "float":
            value = rounded_to_single(value)
        if math.isinf(value):
            return "-INFINITY" if value < 0 else "INFINITY"
        if self.number == "double":
            return repr(float(value))
        text = str(np.float32(value))  # the shortest decimal from which a compiler gets this float32
        return f"{text if set(text) & set('.en') else text + '.0'}f"

    def returns_record(self, name: str) -> bool:
        """Whether a function fills a record and returns whether it has anything to say."""
        return isinstance(self.results[name], Record) and (
            name in self.speakers or name == "steer" or may_be_none(self.functions[name])
        )

    def type_of(self, kind: Kind, node: ast.AST) -> str:
        """The type in C of a value of this kind. Raises Untranslatable."""
        if isinstance(kind, tuple):
            return f"struct {self.record_of(kind, node).name}"
        if kind == VECTOR:
            return "const number *"
        if kind == RECORD:
            return "const struct brain *"
        return C_TYPES[kind]

    def declaration(self, kind: Kind, name: str, node: ast.AST) -> str:
        """The declaration of a local name of this kind. Raises Untranslatable."""
        c_type = self.type_of(kind, node)
        return f"{c_type}{'' if c_type.endswith('*') else ' '}{self.local(name)}"

    def record_of(self, kind: tuple[Kind, ...], node: ast.AST) -> Record:
        """The struct for tuples of this kind. Raises Untranslatable for tuples that hold more than numbers."""
        if self.message and VECTOR in kind and kind == self.message.kinds:
            return self.message
        if any(item not in (REAL, WHOLE, TRUTH) for item in kind) or not 0 < len(kind) <= len(ORDINALS):
            raise Untranslatable(f"a tuple of other things than 1 to {len(ORDINALS)} numbers has no type in C", node)
        name = "_".join(str(item) for item in kind) if len(kind) > 1 else f"one_{kind[0]}"
        record = Record(name, ORDINALS[: len(kind)], kind, (0,) * len(kind))
        return self.records.setdefault(name, record)

    def is_pure(self, node: ast.AST) -> bool:
        """Whether an expression changes nothing, so that it may be left out or written twice."""
        return not any(called(part) in self.writers for part in ast.walk(node))

    def check_order(self, node: ast.AST) -> None:
        """Raise Untranslatable if the value depends on the order of evaluation, which C leaves open."""
        for part in ast.walk(node):
            if isinstance(part, ast.BoolOp | ast.IfExp):
                continue
            sides = [side for side in ast.iter_child_nodes(part) if isinstance(side, ast.expr)]
            for side in sides:
                others = [other for other in sides if other is not side]
                if not self.is_pure(side) and any(map(self.may_change, others)):
                    raise Untranslatable(
                        f"{ast.unparse(side)} changes what the rest of the line reads, and C may evaluate them in any "
                        "order: assign it to a name in a line before",
                        side if isinstance(side, ast.expr) else node,
                    )

    def may_change(self, node: ast.expr) -> bool:
        """Whether a value may change while others are evaluated."""
        return any(isinstance(part, ast.Attribute) or called(part) in self.functions for part in ast.walk(node))

    def _result(self, name: str) -> Record | Kind:
        kind = self.kinds.results.get(name, NOTHING)
        if name in self.speakers:
            assert self.message is not None
            return self.message
        if name in SPECIAL and not self.prefix:
            items = SPECIAL[name]
            record = Record({"steer": "command"}.get(name, name), items, (REAL,) * len(items), (0,) * len(items))
            return self.records.setdefault(record.name, record)
        if isinstance(kind, tuple):
            return self.record_of(kind, self.functions[name])
        if kind != NOTHING and may_be_none(self.functions[name]):
            what = f"{name} may return a value or nothing, which C cannot tell apart"
            raise Untranslatable(what, self.functions[name])
        return kind

    def _speakers(self) -> frozenset[str]:
        """`broadcast`, and functions whose results it returns as they are."""
        reached = ["broadcast"] if self.message and "broadcast" in self.functions else []
        for name in reached:
            reached += [other for other in dict.fromkeys(self._tail_calls(name)) if other not in reached]
        for name in reached[1:]:
            calls = sum(called(node) == name for f in self.functions.values() for node in ast.walk(f))
            returns = sum(self._tail_calls(speaker).count(name) for speaker in reached)
            if calls > returns:  # something else is done with what it returns
                reached = reached[: reached.index(name)]
                break
        return frozenset(reached)

    def _tail_calls(self, name: str) -> list[str]:
        """The functions whose results a function hands on as they are, once for each such `return`."""
        returned = [
            node.value for node in ast.walk(self.functions[name]) if isinstance(node, ast.Return) and node.value
        ]
        return [other for value in returned if (other := called(value)) in self.functions]

    def _find_messages(self) -> frozenset[tuple[str, str]]:
        heard = [("receive", arguments_of(self.functions["receive"])[1])] if self.message else []
        for function, name in heard:
            for node in ast.walk(self.functions[function]):
                other = called(node)
                for place, argument in enumerate(node.args if other in self.functions else ()):  # type: ignore[attr-defined]
                    if isinstance(argument, ast.Name) and argument.id == name:
                        message = other, arguments_of(self.functions[other])[place]
                        heard += [message] if message not in heard else []
        return frozenset(heard)

    def _writers(self) -> frozenset[str]:
        writers: set[str] = set()
        before = -1
        while len(writers) != before:  # who calls a writer is one: until a round finds no more
            before = len(writers)
            for name, function in self.functions.items():
                for node in ast.walk(function):
                    stores = isinstance(node, ast.Attribute | ast.Subscript) and isinstance(node.ctx, ast.Store)
                    if stores or called(node) in writers:
                        writers.add(name)
        return frozenset(writers)


def check_plain(node: ast.Call) -> None:
    """Raise Untranslatable if a call names its arguments, or spreads them."""
    if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
        raise Untranslatable(f"{ast.unparse(node)}: C has neither named nor spread arguments", node)


def called(node: ast.AST) -> str:
    """The name of the function that an expression calls by its name; empty if it is something else."""
    return node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""


def parameter_in_c(name: str) -> str:
    """The name of a parameter in C."""
    return f"parameter_{in_ascii(name)}"


def in_ascii(name: str) -> str:
    """A name without letters that C lacks."""
    return "".join(c if c.isascii() else f"u{ord(c):04x}" for c in name)


def in_c(name: str, taken: Collection[str]) -> str:
    """A name in C: without letters that C lacks, and with one more underscore if it is taken but for those it has."""
    made = in_ascii(name)
    plain = made.rstrip("_") or made
    return f"{made}_" if plain in taken or OURS.match(plain) else made
