"""Writes the few lines of source that fit one brain, or one metric, to the compiled loops."""

import ast
import itertools
from collections.abc import Callable, Collection, Iterable
from typing import Any

from swarmcensus.brains import BELIEFS, FUNCTIONS, MOST, READ, ROUND, STEPS, Brain, Part, is_shipped, length, slots
from swarmcensus.brains.metrics import Metric
from swarmcensus.engine.constants import NOISE, POWER, RAISED, SAID, SILENT

SIGNS = str.maketrans({"-": "minus_", "+": "plus_", "~": "not_"})
CLIPPED, OWED = "_clipped", "_owed_{}"  # of a state, where its messages have a format
DECLARED = ("MEMORY", "MESSAGE", "SUMS", "PARAMETERS", "OPTIONS")

STRICT = "from swarmcensus.engine.python_errors import make_strict\nmake_strict(brain)"
ROBOT = '''"""Fits one brain to the engine. Made by swarmcensus; edits are lost."""

from numpy import float32, float64  # noqa: F401
from swarmcensus.engine.calling import blank_state, word_at
from swarmcensus.engine.compiling import compiled
from swarmcensus.engine.random import {chance}
from swarmcensus.engine.records import record_type
from swarmcensus.engine.return_values import spoken, whole_vector
from . import {files}

record = record_type({record})
{rounding}
{strict}
for file in ({files},):
    for name, value in list(vars(file).items()):
        if isinstance(value, type(lambda: None)):
            setattr(file, name, compiled(value, {checked}))
{given}
number, width, is_signalled, options = {number}, {width}, {signalled}, {options}
{own}
'''
OTHERWISE = {  # what stands for a function that a brain may leave out
    "steer": "lambda me: None",
    "decide": "lambda me: -1.0",
    "done": "lambda me: False",
    "interval": "lambda me: (0.0, 1.0)",
}

GAUGE = '''"""Fits one metric to the engine. Made by swarmcensus; edits are lost."""

from swarmcensus.engine.compiling import compiled, entry  # noqa: F401

from . import metric

for name, value in list(vars(metric).items()):
    if isinstance(value, type(lambda: None)):
        setattr(metric, name, compiled(value))
begin, watch, result, after = metric.begin, metric.watch, metric.result, {after}
'''


def essence(source: str, strict: bool = True) -> str:
    """The parts of a brain's file that machine code depends on: no comments, docstrings, or numbers of declarations.

    With `strict`, powers are checked.
    """
    tree = ast.parse(source)
    read = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
    tree.body = [node for node in tree.body if not _is_declaration(node, read)]
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.FunctionDef):
            body = [one for one in node.body if not (isinstance(one, ast.Expr) and isinstance(one.value, ast.Constant))]
            node.body = body or [ast.Pass()]
    try:
        powers = _Powers()
        tree.body = [powers.visit(node) if strict and isinstance(node, ast.FunctionDef) else node for node in tree.body]
        tree.body += powers.functions()
        return ast.unparse(ast.fix_missing_locations(tree))
    except RecursionError:  # an expression of hundreds of terms
        return source


class _Powers(ast.NodeTransformer):
    """Has the result of each `a ** b` looked at: machine code goes on with infinity or NaN where CPython raises.

    Numba multiplies where an exponent is a whole number that it knows: so each of these has a function of its own.
    """

    def __init__(self) -> None:
        self.whole: dict[str, ast.expr] = {}  # by the function's name

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        if not isinstance(node.op, ast.Pow):
            return node
        if not _is_whole(node.right):
            return ast.Call(ast.Name(RAISED, ast.Load()), [node.left, node.right], [])
        name = f"{RAISED}_to_{ast.unparse(node.right).translate(SIGNS)}"
        self.whole[name] = node.right
        return ast.Call(ast.Name(name, ast.Load()), [node.left], [])

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AugAssign | ast.Assign:
        """An index that calls a function is worked out once: such powers are left alone."""
        self.generic_visit(node)
        if not isinstance(node.op, ast.Pow) or any(isinstance(part, ast.Call) for part in ast.walk(node.target)):
            return node
        before = ast.parse(ast.unparse(node.target), mode="eval").body
        return ast.Assign([node.target], self.visit_BinOp(ast.BinOp(before, node.op, node.value)))

    def functions(self) -> list[ast.stmt]:
        """The functions for whole exponents."""
        powers = ((name, ast.unparse(exponent)) for name, exponent in self.whole.items())
        sources = (f"def {name}(base):\n    return {POWER}(base ** {n}, base, {n})" for name, n in powers)
        return [node for source in sources for node in ast.parse(source).body]


def _is_whole(node: ast.expr) -> bool:
    number = node.operand if isinstance(node, ast.UnaryOp) else node
    return isinstance(number, ast.Constant) and isinstance(number.value, int)


def _is_declaration(node: ast.stmt, read: set[str]) -> bool:
    """Whether this declares MEMORY or the like, and the file does not read it: then only the engine does."""
    if not isinstance(node, ast.Assign) or len(node.targets) != 1 or not isinstance(node.targets[0], ast.Name):
        return False
    return node.targets[0].id in DECLARED and node.targets[0].id not in read


def fields_of(brain: Brain) -> dict[str, int]:
    """The fields of a state in the engine, in order, with lengths, 0 for a number; the sensor's beliefs come last."""
    parameters = {name: length(value) for name, value in brain.parameters.items()}
    kept = [CLIPPED] * bool(brain.parts) + [OWED.format(place) for place in brain.owed]
    extras = [name for name, asked in (("luck", brain.uses.luck), ("name", brain.uses.name)) if asked]
    return brain.lengths | parameters | dict.fromkeys((*kept, *extras, *BELIEFS), 0)


def record_fields(brain: Brain) -> list[tuple[Any, ...]]:
    """The fields of a state, as NumPy takes them: numbers in the brain's precision, and a name in double precision."""
    kinds = {"name": "f8", CLIPPED: "i8"}
    usual = "f4" if brain.numbers.precision == "single" else "f8"
    return [(name, kinds.get(name, usual), *([(long,)] if long else [])) for name, long in fields_of(brain).items()]


def is_signalled(brain: Brain, mixed: bool) -> bool:
    """Whether robots may be silent or jam, so that each says in every round what it does."""
    return mixed or brain.uses.silence or brain.jams


def message_numbers(brain: Brain, mixed: bool) -> list[str]:
    """The numbers that the engine keeps of a message. Where `receive` only adds, they are what it adds."""
    if brain.sums and not mixed:
        return slots({name: brain.lengths[name] for name in brain.sums})
    return slots(brain.message)


def of_brain(brain: Brain, mixed: bool = False) -> str:
    """The module `robot.py` of a brain.

    Where `receive` only adds, what a message adds is computed once by its sender, and not by each receiver; but not in
    a `mixed` swarm, where other brains hear it, too.
    """
    kept = message_numbers(brain, mixed)
    single = brain.numbers.precision == "single"
    columns = [f"outbox[i, {k}]" for k, _ in enumerate(kept)]
    sums = kept if brain.sums and not mixed else []
    rounds = single or any(part.coding == "float32" for part in brain.parts)
    files, chance = ["brain", "codec"] if brain.parts else ["brain"], "single_chance" if single else "chance"

    def rounded(term: str) -> str:
        return f"{ROUND}({term})" if single else term

    read = [rounded(column) for column in columns]
    spans = [] if sums else _starts(brain.message)
    heard = ", ".join(f"outbox[i, {start}:{start + long}]" if long else read[start] for start, long in spans)
    own = {
        "give(me, i, b, w)": ["me.name = i" if brain.uses.name else "pass", "me.b = b", "me.w = w"],
        "say(outbox, i, me)": _saying(brain, columns, sums),
        "take(me, outbox, i)": [_addition(name, column, rounded) for column, name in zip(read, sums, strict=False)],
        "give_draw(me, words, k)": [f"me.luck = {chance}(word_at(words, k))" if brain.uses.luck else "pass"],
        "sums_of(me)": [f"return {_tuple(f'me.{name}' for name in sums)}"],
        "sums_with(sums, outbox, i)": [
            f"return {_tuple(rounded(f'sums[{k}] + {column}') for k, column in enumerate(read[: len(sums)]))}"
        ],
        "sums_at(rows, i)": [f"return {_tuple(rounded(f'rows[i, {k}]') for k, _ in enumerate(sums))}"],
        "keep_sums(rows, i, sums)": [f"rows[i, {k}] = sums[{k}]" for k, _ in enumerate(sums)],
        "put_sums(me, sums)": [f"me.{name} = sums[{k}]" for k, name in enumerate(sums)],
        "add_sums(me, sums)": [_addition(name, f"sums[{k}]", rounded) for k, name in enumerate(sums)],
    }
    own |= {} if sums else {"take(me, outbox, i)": [f"receive(me, ({heard},))"]}
    own |= {"observe(me, blacks, looks)": [f"brain.observe(me, {ROUND}(blacks), {ROUND}(looks))"]} if single else {}
    targets = "".join(f"{file}.{ROUND} = " for file in files)
    given = [f"{name} = brain.{name}" for name in (*FUNCTIONS, *["jam"] * brain.jams)]
    for name, otherwise in OTHERWISE.items():
        given.append(f"{name} = " + (f"brain.{name}" if name in brain.contents.functions else f"compiled({otherwise})"))
    return ROBOT.format(
        files=", ".join(files),
        chance=chance,
        strict="" if is_shipped(brain) else STRICT,
        rounding=f"from swarmcensus.engine.random import to_single as {ROUND}\n{targets}{ROUND}" if rounds else "",
        record=record_fields(brain),
        checked=any(fields_of(brain).values()) or any(brain.message.values()),
        given="\n".join(given),
        number="float32" if single else "float64",
        width=len(columns),
        signalled=is_signalled(brain, mixed),
        options=brain.options,
        own="\n\n".join("\n    ".join([f"@compiled\ndef {head}:", *(body or ["pass"])]) for head, body in own.items()),
    )


def _addition(name: str, term: str, rounded: Callable[[str], str]) -> str:
    """A line that adds a term to a field."""
    whole = rounded(f"me.{name} + {term}")
    return f"me.{name} = {whole}" if whole.startswith(ROUND) else f"me.{name} += {term}"


def _saying(brain: Brain, columns: list[str], sums: list[str]) -> list[str]:
    """The lines of `say`."""
    names = [f"said_{k}" for k, _ in enumerate(brain.message)]
    unpacked = f"{', '.join(names)}, = broadcast(me)"
    lines = [unpacked]
    unsaid = [f"    {column} = 0.0" for column in columns]
    noise = ["if jam(me):", *unsaid, f"    return {NOISE}"] if brain.jams else []
    if brain.uses.silence:
        blank = "".join(f"{(0.0,) * long if long else 0.0}, " for long in brain.message.values())
        lines = [f"there, message = spoken(broadcast(me), ({blank}))", "if not there:", *unsaid, f"    return {SILENT}"]
        lines += [f"{', '.join(names)}, = message"]
    parts = list(zip(names, brain.message.values(), strict=True))
    lines += [f"whole_vector({name}, {long})" for name, long in parts if long]
    if brain.parts:
        lines += _coding_lines(brain, names)
    if sums:
        given = "".join(f"{name}, " if long else f"1.0 * {name}, " for name, long in parts)
        lines += ["hearer = blank_state(record)", *_parameter_copies(brain), f"receive(hearer, ({given}))"]
        lines += [f"{column} = hearer.{name}" for column, name in zip(columns, sums, strict=True)]
    else:
        for name, (start, long) in zip(names, _starts(brain.message), strict=True):
            if long:
                lines += [f"for k in range({long}):", f"    outbox[i, {start} + k] = 1.0 * {name}[k]"]
            else:
                lines += [f"{columns[start]} = 1.0 * {name}"]
    return [*noise, *lines, f"return {SAID}"]


def _coding_lines(brain: Brain, names: list[str]) -> list[str]:
    """Lines that replace the parts of a message by what a receiver reads, and keep what rounding took of them."""
    single = brain.numbers.precision == "single"
    owed = brain.owed
    lines, places = [], itertools.count()
    for name, long in zip(names, brain.message.values(), strict=True):
        for item in range(long) if long else (None,):
            place = next(places)
            number = f"1.0 * {name}" if item is None else f"1.0 * {name}[{item}]"
            lines.append(f"plain_{place} = {ROUND}({number})" if single else f"plain_{place} = {number}")
            sent = f"codec.added(plain_{place}, me.{OWED.format(place)})" if place in owed else f"plain_{place}"
            lines.append(f"number_{place} = {sent}")
    lines += ["clipped = 0"]
    for part in brain.parts:
        lines += _code(part, owed, single)
    lines += [f"me.{CLIPPED} += clipped"]
    places = itertools.count()
    for name, long in zip(names, brain.message.values(), strict=True):
        numbers = [f"read_{next(places)}" for _ in range(max(long, 1))]
        lines.append(f"{name} = {_tuple(numbers) if long else numbers[0]}")
    return lines


def _code(part: Part, owed: Collection[int], single: bool) -> list[str]:
    """Lines that give read_k for the numbers number_k of a part."""
    places, coding = part.places, part.coding
    numbers = ", ".join(f"number_{place}" for place in places)
    reads = ", ".join(f"read_{place}" for place in places)
    given = f", {STEPS[coding]}" if coding in STEPS else f", {MOST[coding]}" if coding in MOST else ""
    name = READ[coding]
    numbers = f"float({ROUND}({numbers}))" if coding == "float32" and not single else numbers
    lines = [f"{reads} = codec.read_{name}({numbers}{given})", f"holds = codec.holds_{name}({numbers}{given})"]
    lines += ["if not holds:", "    clipped = 1"]
    for place in places:
        if place in owed:
            kept = f"me.{OWED.format(place)}"
            rest = f"codec.rest(plain_{place}, {kept}, number_{place}, read_{place})"
            lines.append(f"{kept} = {rest} if holds else 0.0")
    return lines


def _parameter_copies(brain: Brain) -> list[str]:
    """Lines that copy the parameters of `me` to another state; the compiler drops what `receive` does not read."""
    lines = []
    for name, value in brain.parameters.items():
        if length(value):
            lines += [f"for k in range({length(value)}):", f"    hearer.{name}[k] = me.{name}[k]"]
        else:
            lines += [f"hearer.{name} = me.{name}"]
    return lines


def _starts(message: dict[str, int]) -> list[tuple[int, int]]:
    """Where each part of a message begins, and how long it is; 0 for a number."""
    ends = itertools.accumulate((max(long, 1) for long in message.values()), initial=0)
    return list(zip(ends, message.values(), strict=False))


def _tuple(items: Iterable[str]) -> str:
    return f"({''.join(f'{item}, ' for item in items) or '0.0,'})"


def of_metric(metric: Metric) -> str:
    """The module `gauge.py` of a metric."""
    return GAUGE.format(after="metric.after" if metric.of_swarm else "compiled(lambda our, k: None)")
