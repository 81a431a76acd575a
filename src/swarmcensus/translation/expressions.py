"""Expressions of a brain in C, with the meaning that they have in Python."""

import ast
import math

from swarmcensus.brains import CONSTANTS, REAL, RECORD, TRUTH, VECTOR, WHOLE, Kind, arguments_of
from swarmcensus.translation.texts import (  # fmt: skip
    CHOICE,
    EQUAL,
    LESS,
    OR,
    PRODUCT,
    SUM,
    UNARY,
    Text,
    joined,
    literal,
    signed,
)
from swarmcensus.translation.unit import Record, Unit, Untranslatable, check_plain, parameter_in_c

COMPARES = {ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
PLAIN = {ast.Add: ("+", SUM), ast.Sub: ("-", SUM), ast.Mult: ("*", PRODUCT)}
WHOLES = {"floor": "floor", "ceil": "ceil", "trunc": "trunc", "int": "trunc", "round": "nearest_even"}
TESTS = ("isnan", "isinf", "isfinite")
SAME_NAME = """
acos acosh asin asinh atan atan2 atanh copysign cos cosh erf erfc exp expm1 fabs fmod lgamma log10 log2 pow sin sinh
sqrt tan tanh
""".split()  # noqa: SIM905 - read more easily than a list


class Expressions:
    """Translates the expressions of one function."""

    def __init__(self, unit: Unit, function: str) -> None:
        """Translate for this function of a source."""
        self.unit = unit
        self.function = function
        self.names = unit.kinds.names[function]

    def kind(self, node: ast.expr) -> Kind:
        """The kind of an expression."""
        return self.unit.kinds.of(node, self.function)

    def real(self, node: ast.expr) -> Text:
        """An expression as a real number."""
        if (value := literal(node)) is not None:
            return signed(self.unit.real(float(value)))
        if isinstance(node, ast.Call) and (rounding := self._rounding(node)):
            return Text(f"{rounding.text} + {self.unit.real(0.0)}", SUM)  # whole numbers of Python have no -0
        return self._value(node, REAL)

    def whole(self, node: ast.expr) -> Text:
        """An expression as a whole number."""
        value = literal(node)
        if isinstance(value, int):
            return self._whole_literal(value, node)
        if self.kind(node) == REAL:
            return self._to_whole(self.real(node))
        if isinstance(node, ast.Call) and (rounding := self._rounding(node)):
            cut = self.real(node.args[0]) if WHOLES[_called(node)] == "trunc" else rounding
            return self._to_whole(cut)
        return self._value(node, WHOLE)

    def truth(self, node: ast.expr) -> Text:
        """An expression as a truth."""
        match self.kind(node):
            case "whole" if not isinstance(node, ast.BoolOp):
                return Text(f"{self.whole(node).within(LESS)} != 0", EQUAL)
            case "real" if not isinstance(node, ast.BoolOp):
                return Text(f"{self.real(node).within(LESS)} != {self.unit.real(0.0)}", EQUAL)
        return self._value(node, TRUTH)

    def as_kind(self, node: ast.expr, kind: Kind) -> Text:
        """An expression as a value of this kind."""
        ways = {REAL: self.real, WHOLE: self.whole, TRUTH: self.truth, VECTOR: self.vector}
        return ways[kind](node) if kind in ways else self._value(node, kind)

    def vector(self, node: ast.expr) -> Text:
        """An expression as a pointer to the items of a vector."""
        match node:
            case ast.Name(id=name) if name in self.names:
                return Text(self.unit.local(name))
            case ast.Attribute(attr=field):
                return Text(self._field(node, field))
            case ast.Subscript(value=whole, slice=ast.Constant(value=int(place))) if self._is_message(whole):
                return Text(self._item(whole, place))
        raise Untranslatable(f"{ast.unparse(node)} is no vector that C can point to", node)

    def length(self, node: ast.expr) -> int:
        """The number of items of a vector, a table or a tuple. Raises Untranslatable if the source does not say it."""
        match node:
            case ast.Attribute(attr=field) if self.unit.kinds.record.get(field):
                return self.unit.kinds.record[field]
            case ast.Name(id=name) if name not in self.names and isinstance(self.unit.constants.get(name), tuple):
                return len(self.unit.constants[name])
            case ast.Subscript(value=whole, slice=ast.Constant(value=int(place))) if self._is_message(whole):
                assert self.unit.message is not None
                return self.unit.message.lengths[place]
        if isinstance(kind := self.kind(node), tuple):
            return len(kind)
        raise Untranslatable(f"the length of {ast.unparse(node)} is not known before the program runs", node)

    def record(self, node: ast.expr) -> Record | None:
        """The struct that an expression gives; None if it gives another value."""
        match node:
            case ast.Name(id=name) if name in self.names:
                kind = self.names[name]
                if self._is_message(node):
                    return self.unit.message
                return self.unit.record_of(kind, node) if isinstance(kind, tuple) else None
            case ast.Call(func=ast.Name(id=name)) if name in self.unit.functions:
                result = self.unit.results[name]
                return result if isinstance(result, Record) else None
        return None

    def is_never_negative(self, node: ast.expr) -> bool:
        """Whether a whole number is surely 0 or more."""
        match node:
            case ast.Constant(value=int(value)):
                return value >= 0
            case ast.Name(id=name) if name in self.names:
                return (self.function, name) in self.unit.counters
            case ast.BinOp(left=left, op=ast.Add() | ast.Mult() | ast.FloorDiv(), right=right):
                return self.is_never_negative(left) and self.is_never_negative(right)
            case ast.BinOp(op=ast.Mod(), right=right):
                return self.is_never_negative(right)
        return False

    def _value(self, node: ast.expr, want: Kind) -> Text:
        """An expression, with its parts as they are needed for a value of this kind."""
        match node:
            case ast.Constant(value=bool(value)):
                return Text("true" if value else "false") if want == TRUTH else Text(str(int(value)))
            case ast.Constant(value=int(value)):
                return self._whole_literal(value, node)
            case ast.Constant(value=float(value)):
                return signed(self.unit.real(value))
            case ast.Name(id=name):
                return self._name(node, name)
            case ast.Attribute(value=ast.Name(id="math"), attr=name) if name in (*CONSTANTS, "nan"):
                return Text("NAN") if name == "nan" else signed(self.unit.real(getattr(math, name)))
            case ast.Attribute(attr=field):
                return Text(self._field(node, field))
            case ast.Subscript():
                return self._subscript(node)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return Text(f"!{self.truth(operand).within(UNARY)}", UNARY)
            case ast.UnaryOp(op=ast.USub(), operand=ast.Call() as operand) if want == REAL and self._rounding(operand):
                inner = self.real(operand).within(PRODUCT)
                return Text(f"{self.unit.real(0.0)} - {inner}", SUM)  # so that 0 has no sign
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                inner = self.as_kind(operand, self._side(operand, want)).within(UNARY)
                return Text(f"-({inner})" if inner.startswith("-") else f"-{inner}", UNARY)
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.as_kind(operand, self._side(operand, want))
            case ast.BinOp():
                return self._operation(node)
            case ast.Compare():
                return self._comparison(node)
            case ast.BoolOp():
                if want != TRUTH and self.kind(node) != TRUTH:
                    right = "a choice such as `x if x else y` is right"
                    raise Untranslatable(f"{ast.unparse(node)} is used as a number: {right}", node)
                sign = "&&" if isinstance(node.op, ast.And) else "||"
                return joined([self.truth(value) for value in node.values], sign)
            case ast.IfExp(test=test, body=body, orelse=otherwise):
                first, second = self.as_kind(body, want), self.as_kind(otherwise, want)
                return Text(f"{self.truth(test).within(OR)} ? {first.within(OR)} : {second.within(CHOICE)}", CHOICE)
            case ast.Call():
                return self._call(node)
        raise Untranslatable(f"{ast.unparse(node)} has no translation to C", node)

    def _whole_literal(self, value: int, node: ast.AST) -> Text:
        if abs(value) >= 2**31:
            raise Untranslatable(f"{value:,} is no whole number of 32 bits: write {value:,}.0 for a real one", node)
        return signed(str(value))

    def _side(self, node: ast.expr, want: Kind) -> Kind:
        """The kind in which an operand of arithmetic is worked out: a truth counts as a whole number."""
        is_rounding = isinstance(node, ast.Call) and self._rounding(node) is not None
        if want == REAL and (literal(node) is not None or is_rounding):
            return REAL
        kind = self.kind(node)
        return WHOLE if kind == TRUTH else kind

    def _name(self, node: ast.expr, name: str) -> Text:
        if name in self.names:
            return Text(self.unit.local(name))
        value = self.unit.constants.get(name)
        if isinstance(value, int | float):
            if isinstance(value, int) and abs(value) >= 2**31:
                raise Untranslatable(f"{name} = {value:,} is no whole number of 32 bits", node)
            return Text(self.unit.constant(name))
        if name in CONSTANTS:
            return signed(self.unit.real(getattr(math, name)))
        raise Untranslatable(f"{name} is no number", node)

    def _field(self, node: ast.Attribute, field: str) -> str:
        if not isinstance(node.value, ast.Name) or self.names.get(node.value.id) != RECORD:
            raise Untranslatable(f"{ast.unparse(node)} has no translation to C", node)
        if field in self.unit.parameters:
            self.unit.used_parameters.add(field)
            return parameter_in_c(field)
        return f"{self.unit.local(node.value.id)}->{self.unit.field(field)}"

    def _is_message(self, node: ast.expr) -> bool:
        """Whether this is the message that `receive` was given."""
        return isinstance(node, ast.Name) and (self.function, node.id) in self.unit.heard

    def _item(self, whole: ast.expr, place: int) -> str:
        """An item of a struct."""
        record = self.record(whole)
        if record is None or not -len(record.items) <= place < len(record.items):
            raise Untranslatable(f"{ast.unparse(whole)} has no item {place}", whole)
        if isinstance(whole, ast.Call):
            return f"{self.as_kind(whole, record.kinds).text}.{record.items[place]}"
        assert isinstance(whole, ast.Name)
        arrow = "->" if self._is_message(whole) else "."
        return f"{self.unit.local(whole.id)}{arrow}{record.items[place]}"

    def _subscript(self, node: ast.Subscript) -> Text:
        whole, index = node.value, node.slice
        place = literal(index)
        if self.record(whole) is not None:
            if not isinstance(place, int):
                what = f"{ast.unparse(node)}: an item of a tuple, or of a table of whole numbers, is chosen as it runs"
                raise Untranslatable(what, node)
            return Text(self._item(whole, place))
        if isinstance(table := self._table(whole), tuple):
            inner = self.unit.constant(whole.id) if isinstance(whole, ast.Name) else self._subscript(whole).text  # type: ignore[arg-type]
            return Text(f"{inner}[{self._index(index, len(table))}]")
        items = self.length(whole) if not isinstance(whole, ast.Name) else 0
        if self.unit.checked and isinstance(whole, ast.Name):
            items = self.unit.vectors.get((self.function, whole.id), 0)
        return Text(f"{self.vector(whole).text}[{self._index(index, items)}]")

    def _table(self, node: ast.expr) -> object:
        """The value of a constant table, or of a row of one; all rows have one type."""
        if isinstance(node, ast.Name) and node.id not in self.names:
            return self.unit.constants.get(node.id)
        if isinstance(node, ast.Subscript) and isinstance(rows := self._table(node.value), tuple):
            return rows[0]
        return None

    def _index(self, index: ast.expr, items: int) -> str:
        """An index into `items` items, 0 if their number is not known; a negative one counts from the end."""
        place = literal(index)
        if isinstance(place, int):
            if items and not -items <= place < items:
                raise Untranslatable(f"the index {place} is beyond the {items} items", index)
            if place < 0 and not items:
                raise Untranslatable(f"the index {place} counts from an end that is not known", index)
            return str(place % items if items else place)
        text = self.whole(index).text
        if items and self.unit.checked:
            return f"brain_place({text}, {items})"
        if self.is_never_negative(index):
            return text
        if not items:
            what = f"the index {ast.unparse(index)} may be negative, and counts from an end that is not known here"
            raise Untranslatable(f"{what}: a whole number that counts up from 0 is right", index)
        return f"{self.unit.need('item_at')}({text}, {items})"

    def _operation(self, node: ast.BinOp) -> Text:
        left, right, kind = node.left, node.right, self.kind(node)
        if isinstance(kind, tuple) or kind == VECTOR:
            raise Untranslatable(f"{ast.unparse(node)}: arithmetic with tuples has no translation to C", node)
        sides = [self.as_kind(side, self._side(side, kind)) for side in (left, right)]
        if type(node.op) in PLAIN:
            operator, level = PLAIN[type(node.op)]
            if kind == WHOLE:
                sides[0] = self._wide(left, sides[0], right)
            return Text(f"{sides[0].within(level)} {operator} {sides[1].within(level + 1)}", level)
        if isinstance(node.op, ast.Div):
            dividend = sides[0].within(PRODUCT)
            if REAL not in (self._side(left, REAL), self._side(right, REAL)):
                dividend = f"(number){sides[0].within(UNARY)}"
            return Text(f"{dividend} / {self._divisor(right, sides[1]).within(UNARY)}", PRODUCT)
        return self._by_helper(node, kind, sides)

    def _divisor(self, node: ast.expr, text: Text) -> Text:
        """What is divided by, and looked at as it runs where the unit is checked."""
        return Text(f"brain_divisor({text.text})") if self.unit.checked and not literal(node) else text

    def _argument(self, node: ast.expr) -> str:
        """A real argument of a function of math.h, of which C++ has one for each type."""
        text = self.real(node)
        is_whole = self.unit.checked and self.kind(node) == WHOLE
        return f"(number){text.within(UNARY)}" if is_whole else text.text

    def _to_whole(self, text: Text) -> Text:
        """A real number without its fraction as a whole one, and looked at as it runs where the unit is checked."""
        return Text(f"{'brain_whole' if self.unit.checked else self.unit.need('to_whole')}({text.text})")

    def _result(self, text: str) -> Text:
        """What a function of math.h gives, and looked at as it runs where the unit is checked."""
        return Text(f"brain_result({text})" if self.unit.checked else text)

    def _wide(self, node: ast.expr, text: Text, other: ast.expr) -> Text:
        """A whole number in 32 bits: C works with 16 on small chips, if neither operand has a type of ours."""
        is_wide = not (self._is_narrow(node) and self._is_narrow(other))
        return text if is_wide else Text(f"(int32_t){text.within(UNARY)}", UNARY)

    def _is_narrow(self, node: ast.expr) -> bool:
        """Whether C gives a whole number the type int."""
        while isinstance(node, ast.UnaryOp):
            node = node.operand
        is_length = isinstance(node, ast.Call) and _called(node) == "len"
        return is_length or isinstance(node, ast.Constant | ast.IfExp) or self.kind(node) == TRUTH

    def _by_helper(self, node: ast.BinOp, kind: Kind, sides: list[Text]) -> Text:
        """Operations whose meaning differs from C's."""
        left, right = node.left, node.right
        if isinstance(node.op, ast.Mod | ast.FloorDiv):
            sides[1] = self._divisor(right, sides[1])
        both, which = f"({sides[0].text}, {sides[1].text})", "whole" if kind == WHOLE else "number"
        match node.op, left:
            case ast.Mod(), ast.BinOp(left=one, op=ast.Mult(), right=other) if kind == WHOLE:
                first, second = self.whole(one).text, self.whole(other).text
                return Text(f"{self.unit.need('whole_product_modulo')}({first}, {second}, {sides[1].text})")
            case ast.Mod(), _:
                return Text(self.unit.need(f"{which}_modulo") + both)
            case ast.FloorDiv(), _:
                return Text(self.unit.need(f"{which}_floor_divide") + both)
            case ast.Pow(), _ if kind == WHOLE:
                return Text(self.unit.need("whole_power") + both)
            case ast.Pow(), _ if literal(right) == 2.0:
                return Text(f"{self.unit.need('number_square')}({self.real(left).text})")
            case ast.Pow(), _:
                return self._result(f"{self.unit.math('pow')}({self._argument(left)}, {self._argument(right)})")
        raise Untranslatable(f"{ast.unparse(node)} has no translation to C", node)

    def _comparison(self, node: ast.Compare) -> Text:
        terms = [node.left, *node.comparators]
        if any(not self.unit.is_pure(term) for term in terms[1:-1]):
            raise Untranslatable(f"{ast.unparse(node)} evaluates its middle once, and C would do so twice", node)
        links = [self._link(*each) for each in zip(terms, node.ops, terms[1:], strict=False)]
        return joined(links, "&&")

    def _link(self, left: ast.expr, operator: ast.cmpop, right: ast.expr) -> Text:
        if isinstance(operator, ast.In | ast.NotIn):
            options = right.elts if isinstance(right, ast.Tuple | ast.List) else None
            if options is None or not self.unit.is_pure(left):
                raise Untranslatable(f"{ast.unparse(right)}: `in` is translated for a tuple in its place only", right)
            found = joined([self._link(left, ast.Eq(), option) for option in options], "||")
            return found if isinstance(operator, ast.In) else Text(f"!{found.within(UNARY)}", UNARY)
        if type(operator) not in COMPARES:
            raise Untranslatable(f"{ast.unparse(left)} may be None, which C does not have", left)
        if isinstance(left, ast.Tuple) and isinstance(operator, ast.Lt | ast.LtE | ast.Gt | ast.GtE):
            return self._tuples(left, operator, right)
        sign = COMPARES[type(operator)]
        level = EQUAL if sign in ("==", "!=") else LESS
        is_real = REAL in (self.kind(left), self.kind(right))
        sides = [self.real(side) if is_real else self.whole(side) for side in (left, right)]
        return Text(f"{sides[0].within(SUM)} {sign} {sides[1].within(SUM)}", level)

    def _tuples(self, left: ast.expr, operator: ast.cmpop, right: ast.expr) -> Text:
        """A comparison of tuples: by their first items that differ."""
        assert isinstance(left, ast.Tuple)
        if not (isinstance(right, ast.Tuple) and len(left.elts) == len(right.elts)):
            raise Untranslatable("tuples are compared item by item, if both are written in their place", left)
        if not (self.unit.is_pure(left) and self.unit.is_pure(right)):
            raise Untranslatable("items of compared tuples are evaluated more than once in C", left)
        pairs = list(zip(left.elts, right.elts, strict=True))
        equal = [self._link(one, ast.Eq(), other) for one, other in pairs]
        strict = ast.Lt() if isinstance(operator, ast.Lt | ast.LtE) else ast.Gt()
        last = len(pairs) - 1
        ways = [
            joined([*equal[:k], self._link(*pair[:1], operator if k == last else strict, pair[1])], "&&")
            for k, pair in enumerate(pairs)
        ]
        return joined(ways, "||")

    def _rounding(self, node: ast.Call) -> Text | None:
        """A call of floor, ceil, int or round as a real number; None for other calls."""
        name, arguments = _called(node), node.args
        if name not in WHOLES or name in self.unit.functions or len(arguments) != 1 or self.kind(arguments[0]) != REAL:
            return None
        made = WHOLES[name]
        function = self.unit.need(made) if made == "nearest_even" else self.unit.math(made)
        text = self.real(arguments[0]).text
        return Text(f"{function}({f'brain_countable({text})' if self.unit.checked else text})")

    def _call(self, node: ast.Call) -> Text:
        name, arguments = _called(node), node.args
        check_plain(node)
        if isinstance(node.func, ast.Name) and name in self.unit.functions:
            if self.unit.returns_record(name):
                raise Untranslatable(f"{name} may return None, so that its result can only be returned", node)
            return Text(f"{self.unit.function(name)}({', '.join(self.arguments(node, name))})")
        if name in WHOLES and len(arguments) == 1:
            return self.whole(arguments[0])
        if isinstance(node.func, ast.Name) and name in ("float", "bool", "abs", "min", "max", "len"):
            return self._builtin(node, name)
        if name in TESTS:
            return Text(f"{name}({self.real(arguments[0]).text})")
        if name == "ldexp":
            scale = self.whole(arguments[1]).within(UNARY)
            return self._result(f"{self.unit.math(name)}({self.real(arguments[0]).text}, (int){scale})")
        if name in SAME_NAME or (name in ("log", "gamma") and len(arguments) == 1):
            self.unit.functions_of_math.add(name)
            function = self.unit.math("tgamma" if name == "gamma" else name)
            return self._result(f"{function}({', '.join(map(self._argument, arguments))})")
        raise Untranslatable(f"{ast.unparse(node.func)} has no translation to C", node)

    def arguments(self, node: ast.Call, name: str) -> list[str]:
        """The arguments of a call of a function of the source."""
        kinds, texts = self.unit.kinds.names[name], []
        for argument, place in zip(node.args, arguments_of(self.unit.functions[name]), strict=True):
            if (name, place) in self.unit.heard:
                texts.append(self.unit.local(argument.id) if isinstance(argument, ast.Name) else "")
            else:
                texts.append(self.as_kind(argument, kinds.get(place, REAL)).text)
        return texts

    def _builtin(self, node: ast.Call, name: str) -> Text:
        arguments, kind = node.args, self.kind(node)
        if name == "len":
            return Text(str(self.length(arguments[0])))
        if name == "float":
            inner = self.real(arguments[0]) if arguments else Text(self.unit.real(0.0))
            is_real = not arguments or self.kind(arguments[0]) == REAL or literal(arguments[0]) is not None
            return inner if is_real else Text(f"(number){inner.within(UNARY)}", UNARY)
        if name == "bool":
            return self.truth(arguments[0])
        if name == "abs":
            if kind == REAL:
                return Text(f"{self.unit.math('fabs')}({self.real(arguments[0]).text})")
            return Text(f"{self.unit.need('whole_abs')}({self.whole(arguments[0]).text})")
        if len(arguments) < 2:
            raise Untranslatable(f"{ast.unparse(node)}: {name} needs two numbers or more here", node)
        helper = self.unit.need(f"{'number' if kind == REAL else 'whole'}_{name}")
        texts = [(self.real(each) if kind == REAL else self.whole(each)).text for each in arguments]
        made = texts[0]
        for text in texts[1:]:
            made = f"{helper}({made}, {text})"
        return Text(made)


def _called(node: ast.Call) -> str:
    if isinstance(node.func, ast.Attribute):
        return node.func.attr
    return node.func.id if isinstance(node.func, ast.Name) else ""
