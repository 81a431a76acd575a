"""Statements and functions of a brain in C."""

import ast
import itertools
from collections import Counter

from swarmcensus.brains import NOTHING, REAL, TRUTH, WHOLE, Kind, arguments_of
from swarmcensus.support.safe_source import names_set_by
from swarmcensus.translation.expressions import PLAIN, Expressions
from swarmcensus.translation.scopes import Scopes, mentions
from swarmcensus.translation.signatures import out_name, signature
from swarmcensus.translation.texts import literal
from swarmcensus.translation.unit import Record, Unit, Untranslatable, called

STEP = "    "
SET = {**{kind: f"{sign}=" for kind, (sign, _) in PLAIN.items()}, ast.Div: "/="}


class Function:
    """Translates one function."""

    def __init__(self, unit: Unit, name: str) -> None:
        """Begin with nothing written."""
        self.unit = unit
        self.name = name
        self.node = unit.functions[name]
        self.scopes = Scopes(self.node, unit.parameters)
        self.say = Expressions(unit, name)
        self.names = unit.kinds.names[name]
        self.result = unit.results[name]
        self.fills = unit.returns_record(name)
        self.made: list[str] = []
        self.fresh: set[str] = set()  # names made up here that stay in force to the end of a block
        self._note_counters()

    def lines(self) -> list[str]:
        """The function in C."""
        body = self.node.body
        for name in self.scopes.local:
            kind = self.names.get(name, REAL)
            blank = {REAL: self.unit.real(0.0), TRUTH: "false"}
            zero = "{0}" if isinstance(kind, tuple) else blank.get(kind, "0")
            self._write(f"{self.unit.declaration(kind, name, self.node)} = {zero};", 1)
        for name in (*arguments_of(self.node), *self.scopes.local):
            if name not in self.scopes.read:
                self._write(f"(void){self.unit.local(name)};", 1)
        returned = [node.value for node in ast.walk(self.node) if isinstance(node, ast.Return)]
        if self.fills and all(map(_is_nothing, returned)):
            self._write(f"(void){out_name(self.unit, self.name)};", 1)
        self._block(body, 1)
        if self.fills and not isinstance(body[-1] if body else None, ast.Return):
            self._write("return false;", 1)
        return [f"{signature(self.unit, self.name)} {{", *self.made, "}"]

    def _note_counters(self) -> None:
        """Find the names that only count up from 0 or more, in loops, so that they can be indexes as they are."""
        loops = [node for node in ast.walk(self.node) if isinstance(node, ast.For) and _is_range(node.iter)]
        begun = [(loop.target, *self._range(loop)) for loop in loops if isinstance(loop.target, ast.Name)]
        stores = Counter(name for node in ast.walk(self.node) for name in names_set_by(node))
        rising = Counter(
            target.id for target, start, _, step in begun
            if (start is None or self.say.is_never_negative(start)) and (step is None or (literal(step) or -1) > 0)
        )  # fmt: skip
        self.unit.counters |= {(self.name, name) for name, times in rising.items() if times == stores[name]}

    def _write(self, line: str, depth: int) -> None:
        self.made.append(f"{STEP * depth}{line}")

    def _block(self, body: list[ast.stmt], depth: int) -> None:
        written: ast.stmt | None = None
        for statement, following in itertools.zip_longest(body, body[1:]):
            if statement is written:
                continue
            match statement, following:
                case (
                    ast.Assign(targets=[ast.Name(id=name)], value=ast.Call() as call),
                    ast.If(test=ast.Compare(ast.Name(id=same), [ast.Is()], [ast.Constant(None)]), body=then, orelse=[]),
                ) if name == same and self.unit.returns_record(called(call)):
                    self._ask(name, call, then, depth)
                    written = following
                case _:
                    self._statement(statement, depth)

    def _ask(self, name: str, call: ast.Call, then: list[ast.stmt], depth: int) -> None:
        """Name what a function returns if it says anything, and else do something."""
        asked = self._passed_on(call, called(call), f"&{self.unit.local(name)}")
        self._write_block(f"if (!{asked})", then, depth)

    def _write_block(self, head: str, body: list[ast.stmt], depth: int, *first: str) -> None:
        """A block of statements after its head, and after lines that are written `first` in it."""
        self._write(f"{head} {{", depth)
        for line in first:
            self._write(line, depth + 1)
        self._block(body, depth + 1)
        self._write("}", depth)

    def _statement(self, node: ast.stmt, depth: int) -> None:
        for part in ast.iter_child_nodes(node):
            if isinstance(part, ast.expr):
                self.unit.check_order(part)
        match node:
            case ast.Expr(value=ast.Constant()) | ast.Pass():
                return
            case ast.Expr(value=ast.Call() as value):
                text = self.say.as_kind(value, self.say.kind(value)).text
                is_void = self.unit.results.get(called(value), REAL) == NOTHING
                self._write(f"{text};" if is_void else f"(void){text};", depth)
            case ast.Break() | ast.Continue():
                self._write(f"{ast.unparse(node)};", depth)
            case ast.Return(value=value):
                self._return(node, value, depth)
            case ast.Assign(targets=targets, value=value):
                for k, target in enumerate(targets):
                    self._assign(node, target, value if k == 0 else _to_read(targets[0]), depth)
            case ast.AugAssign():
                self._augment(node, depth)
            case ast.If():
                self._if(node, depth)
            case ast.While(test=test, body=body, orelse=otherwise):
                self._no_else(otherwise)
                self._write_block(f"while ({self.say.truth(test).text})", body, depth)
            case ast.For():
                self._for(node, depth)
            case _:
                raise Untranslatable(f"{ast.unparse(node).splitlines()[0]} has no translation to C", node)

    def _no_else(self, otherwise: list[ast.stmt]) -> None:
        if otherwise:
            raise Untranslatable("a loop with else has no translation to C", otherwise[0])

    def _if(self, node: ast.If, depth: int, word: str = "if") -> None:
        self._write(f"{word} ({self.say.truth(node.test).text}) {{", depth)
        self._block(node.body, depth + 1)
        if not node.orelse:
            self._write("}", depth)
            return
        first = node.orelse[0]
        if len(node.orelse) == 1 and isinstance(first, ast.If) and first.col_offset == node.col_offset:
            self.unit.check_order(first.test)
            self._if(first, depth, "} else if")
            return
        self._write_block("} else", node.orelse, depth)

    def _range(self, node: ast.For) -> tuple[ast.expr | None, ast.expr, ast.expr | None]:
        """The start, the end and the step of a loop over a range."""
        assert isinstance(node.iter, ast.Call)
        given = node.iter.args
        if not 1 <= len(given) <= 3 or node.iter.keywords:
            raise Untranslatable(f"{ast.unparse(node.iter)} has no translation to C", node)
        if len(given) == 1:
            return None, given[0], None
        return given[0], given[1], given[2] if len(given) == 3 else None

    def _for(self, node: ast.For, depth: int) -> None:
        self._no_else(node.orelse)
        if not isinstance(node.target, ast.Name):
            raise Untranslatable(f"a loop over {ast.unparse(node.target)} has no translation to C", node)
        if not _is_range(node.iter):
            raise Untranslatable(f"a loop over {ast.unparse(node.iter)}: one over range(...) is right", node)
        start, end, step = self._range(node)
        is_own = id(node) in self.scopes.private
        name = self.unit.local(node.target.id)
        counter = name if is_own else self._new(f"{name}_next")
        by = 1 if step is None else literal(step)
        if not isinstance(by, int) or by == 0:
            what = f"the step of {ast.unparse(node.iter)} should be a whole number, written in its place"
            raise Untranslatable(what, node)
        begin = "0" if start is None else self.say.whole(start).text
        last, limit = self.say.whole(end).text, ""
        if not _is_fixed(end, node):
            limit = self._new(f"{name}_end")
            last, limit = limit, f", {limit} = {last}"
        change = {1: f"{counter}++", -1: f"{counter}--"}.get(by, f"{counter} += {by}")
        sign = "<" if by > 0 else ">"
        head = f"for (int32_t {counter} = {begin}{limit}; {counter} {sign} {last}; {change})"
        self._write_block(head, node.body, depth, *([] if is_own else [f"{name} = {counter};"]))

    def _new(self, like: str, stays: bool = False) -> str:
        """A name that the function does not use; one that `stays` is not made again."""
        taken = {self.unit.local(node.id) for node in ast.walk(self.node) if isinstance(node, ast.Name)} | self.fresh
        name, count = like, 1
        while name in taken:
            count += 1
            name = f"{like}{count}"
        if stays:
            self.fresh.add(name)
        return name

    def _assign(self, node: ast.stmt, target: ast.expr, value: ast.expr, depth: int) -> None:
        if isinstance(target, ast.Tuple | ast.List):
            self._unpack(node, target, value, depth)
            return
        if isinstance(target, ast.Name):
            self._set_name(node, target.id, value, depth)
            return
        if not self.unit.is_pure(value) and isinstance(target, ast.Subscript) and self.unit.may_change(target.slice):
            what = "the index may change while the value is worked out: assign the value to a name first"
            raise Untranslatable(what, node)
        place = self.say.as_kind(target, REAL).text
        self._write(f"{place} = {self.say.real(value).text};", depth)

    def _set_name(self, node: ast.stmt, name: str, value: ast.expr, depth: int) -> None:
        kind = self.names.get(name, REAL)
        if isinstance(value, ast.Name) and (self.name, value.id) in self.unit.heard:
            raise Untranslatable(f"{name} would be a second name of the message", node)
        if isinstance(kind, tuple):
            self._set_record(node, name, kind, value, depth)
            return
        self._write(f"{self.unit.local(name)} = {self.say.as_kind(value, kind).text};", depth)

    def _set_record(self, node: ast.stmt, name: str, kind: tuple[Kind, ...], value: ast.expr, depth: int) -> None:
        """Give a local tuple its items."""
        record = self.unit.record_of(kind, node)
        if any(record.lengths) and self.unit.results.get(called(value)) == record:
            self._write(f"{self.unit.local(name)} = {self.say.as_kind(value, kind).text};", depth)
            return
        texts = self._items(node, value, len(kind), depth, kind)
        if mentions(value, name):
            texts = [self._name_value(text, one, node, depth) for text, one in zip(texts, kind, strict=True)]
        for text, item in zip(texts, record.items, strict=True):
            self._write(f"{self.unit.local(name)}.{item} = {text};", depth)

    def _items(
        self, node: ast.stmt, value: ast.expr, count: int, depth: int, kinds: tuple[Kind, ...] | None = None
    ) -> list[str]:
        """The items of a tuple in C; a call is made once, before."""
        match value:
            case ast.Tuple(elts=items) | ast.List(elts=items):
                if len(items) != count or any(isinstance(item, ast.Starred) for item in items):
                    raise Untranslatable(f"{ast.unparse(value)} should have {count} items", node)
                return [
                    self.say.as_kind(item, kinds[k] if kinds else self.say.kind(item)).text
                    for k, item in enumerate(items)
                ]
            case ast.Call(func=ast.Attribute(attr="frexp"), args=[number]):
                power = self._new("exponent", stays=True)
                self._write(f"int {power};", depth)
                return [f"{self.unit.math('frexp')}({self.say.real(number).text}, &{power})", power]
            case ast.IfExp(test=test):
                what = f"a choice between tuples has no translation to C: if {ast.unparse(test)}: and else: are right"
                raise Untranslatable(what, node)
        record = self.say.record(value)
        if record is None or len(record.items) != count:
            raise Untranslatable(f"{ast.unparse(value)} gives no tuple of {count}", node)
        if isinstance(value, ast.Call):
            name = self._new("result", stays=True)
            text = self.say.as_kind(value, record.kinds).text
            self._write(f"const struct {record.name} {name} = {text};", depth)
            return [f"{name}.{item}" for item in record.items]
        return [self.say._item(value, k) for k in range(count)]

    def _unpack(self, node: ast.stmt, target: ast.Tuple | ast.List, value: ast.expr, depth: int) -> None:
        places = target.elts
        if any(isinstance(place, ast.Starred) for place in places):
            raise Untranslatable("a starred name takes a list, which C does not have", node)
        own = [self.names.get(place.id, REAL) if isinstance(place, ast.Name) else REAL for place in places]
        texts = self._items(node, value, len(places), depth, tuple(own))
        in_parts = isinstance(value, ast.Call) and called(value) not in self.unit.functions  # frexp
        later = value.elts if isinstance(value, ast.Tuple) else [value] * len(places) if in_parts else []
        if any(self._may_set(place, item) for k, item in enumerate(later) for place in places[:k]):
            texts = [self._name_value(text, kind, node, depth) for text, kind in zip(texts, own, strict=True)]
        for place, text in zip(places, texts, strict=True):
            if isinstance(place, ast.Name):
                start = self.unit.local(place.id)
            elif isinstance(place, ast.Attribute | ast.Subscript):
                start = self.say.as_kind(place, REAL).text
            else:
                raise Untranslatable("a tuple within a tuple has no translation to C", node)
            self._write(f"{start} = {text};", depth)

    def _name_value(self, text: str, kind: Kind, node: ast.stmt, depth: int) -> str:
        """A name for a value that is worked out before anything is set."""
        name = self._new("new", stays=True)
        self._write(f"const {self.unit.type_of(kind, node)} {name} = {text};", depth)
        return name

    def _may_set(self, place: ast.expr, item: ast.expr) -> bool:
        """Whether setting a place may change what an expression gives."""
        if isinstance(place, ast.Name):
            return mentions(item, place.id)
        return self.unit.may_change(item) or any(isinstance(part, ast.Subscript) for part in ast.walk(item))

    def _augment(self, node: ast.AugAssign, depth: int) -> None:
        target = node.target
        kind = self.names.get(target.id, REAL) if isinstance(target, ast.Name) else REAL
        read = _to_read(target)
        whole = ast.copy_location(ast.BinOp(read, node.op, node.value), node)
        self.unit.check_order(whole)
        place = self.say.as_kind(read, kind).text
        is_short = type(node.op) in SET and not (kind == WHOLE and self.say.kind(node.value) == REAL)
        sign, value = (SET[type(node.op)], node.value) if is_short else ("=", whole)
        self._write(f"{place} {sign} {self.say.as_kind(value, kind).text};", depth)

    def _return(self, node: ast.Return, value: ast.expr | None, depth: int) -> None:
        is_nothing = _is_nothing(value)
        if isinstance(self.result, Record):
            if is_nothing:
                self._write("return false;", depth)
            else:
                assert value is not None
                self._return_record(node, self.result, value, depth)
        elif is_nothing or value is None:
            self._write("return;", depth)
        else:
            self._write(f"return {self.say.as_kind(value, self.result).text};", depth)

    def _return_record(self, node: ast.Return, record: Record, value: ast.expr, depth: int) -> None:
        name = out_name(self.unit, self.name)
        other = called(value)
        if other in self.unit.functions and self.unit.results[other] == record:
            text = self._passed_on(value, other, name)  # type: ignore[arg-type]
            if self.fills and not self.unit.returns_record(other):
                self._write(f"*{name} = {text};", depth)
                text = "true"
            self._write(f"return {text};", depth)
            return
        arrow = "->" if self.fills else "."
        if not self.fills:
            self._write(f"struct {record.name} {name};", depth)
        if isinstance(value, ast.Tuple) and len(value.elts) == len(record.items):
            for item, place, kind, items in zip(value.elts, record.items, record.kinds, record.lengths, strict=True):
                self._fill(f"{name}{arrow}{place}", item, kind, items, depth)
        else:
            texts = self._items(node, value, len(record.items), depth, (REAL,) * len(record.items))
            for text, place in zip(texts, record.items, strict=True):
                self._write(f"{name}{arrow}{place} = {text};", depth)
        self._write("return true;" if self.fills else f"return {name};", depth)

    def _passed_on(self, value: ast.Call, other: str, name: str) -> str:
        """A call whose result is returned as it is."""
        record = [name] if self.unit.returns_record(other) else []
        return f"{self.unit.function(other)}({', '.join([*self.say.arguments(value, other), *record])})"

    def _fill(self, place: str, item: ast.expr, kind: Kind, items: int, depth: int) -> None:
        """Set an item of a record, which may be a vector."""
        if not items:
            self._write(f"{place} = {self.say.as_kind(item, kind).text};", depth)
        elif isinstance(item, ast.Tuple):
            for k, part in enumerate(item.elts):
                self._write(f"{place}[{k}] = {self.say.real(part).text};", depth)
        else:
            at = self._new("k")
            self._write(f"for (int32_t {at} = 0; {at} < {items}; {at}++) {{", depth)
            self._write(f"{place}[{at}] = {self.say.vector(item).text}[{at}];", depth + 1)
            self._write("}", depth)


def _is_nothing(value: ast.expr | None) -> bool:
    """Whether `return` with this value returns None."""
    return value is None or (isinstance(value, ast.Constant) and value.value is None)


def _is_range(node: ast.expr) -> bool:
    return called(node) == "range"


def _is_fixed(end: ast.expr, node: ast.For) -> bool:
    """Whether the end of a range is a number, a length, or a name that the loop leaves alone."""
    if not isinstance(end, ast.Name):
        return literal(end) is not None or called(end) == "len"
    names = (part for part in ast.walk(node) if isinstance(part, ast.Name) and part.id == end.id)
    return all(isinstance(name.ctx, ast.Load) for name in names)


def _to_read(node: ast.expr) -> ast.expr:
    """An expression that was assigned to, to be read."""
    return ast.parse(ast.unparse(node), mode="eval").body
