"""What `math` has on robots: what MicroPython and C both have, and what C on AVR boards lacks of that."""

import ast
import math
from collections.abc import Iterator

from swarmcensus.brains.syntax import BrokenContract
from swarmcensus.support.hints import did_you_mean

CONSTANTS = ("e", "inf", "nan", "pi", "tau")
FUNCTIONS = (  # of MicroPython 1.27, without those of NOT_IN_C
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "ceil", "copysign", "cos", "cosh", "degrees", "erf",
    "erfc", "exp", "expm1", "fabs", "floor", "fmod", "frexp", "gamma", "isfinite", "isinf",
    "isnan", "ldexp", "lgamma", "log", "log10", "log2", "pow", "radians", "sin", "sinh", "sqrt", "tan", "tanh",
    "trunc",
)  # fmt: skip
NOT_IN_C = ("factorial", "isclose", "modf")  # which MicroPython has, and C lacks, or cannot return two numbers
NOT_ON_AVR = ("acosh", "asinh", "atanh", "erf", "erfc", "expm1", "gamma", "lgamma", "log2")  # which avr-libc lacks


def check(tree: ast.Module) -> None:
    """Raise BrokenContract if a source uses of `math` what MicroPython or C lacks."""
    for name, line in _uses(tree):
        if name in FUNCTIONS or name in CONSTANTS:
            continue
        if not hasattr(math, name):
            raise BrokenContract(f"math has no {name}: {did_you_mean(name, FUNCTIONS)}".rstrip(": "), line)
        who = "C" if name in NOT_IN_C else "MicroPython"
        right = f"your own arithmetic is right, or one of {', '.join(FUNCTIONS)}"
        raise BrokenContract(f"uses math.{name}, which {who} on a robot lacks: {right}", line)


def missing_on_avr(tree: ast.Module) -> list[str]:
    """The functions of `math` that a source uses and avr-libc lacks, each once."""
    return sorted({name for name, _ in _uses(tree)} & {*NOT_ON_AVR})


def _uses(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Every name of `math` that is imported or an attribute, and its line."""
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
    modules = {a.asname or a.name for node in imports if isinstance(node, ast.Import) for a in node.names}
    for node in imports:
        if isinstance(node, ast.ImportFrom):
            yield from ((alias.name, node.lineno) for alias in node.names)
    for part in ast.walk(tree):
        if isinstance(part, ast.Attribute) and isinstance(part.value, ast.Name) and part.value.id in modules:
            yield part.attr, part.lineno
