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
INSTEAD = {  # of functions that CPython has and a robot lacks
    "cbrt": "x ** (1.0 / 3.0)",
    "dist": "math.sqrt of a sum of squares",
    "exp2": "2.0 ** x",
    "factorial": "a loop that multiplies, or math.gamma(x + 1.0),",
    "fma": "x * y + z",
    "fsum": "a loop that adds",
    "hypot": "math.sqrt(x * x + y * y)",
    "isclose": "abs(x - y) <= 1e-9 * max(abs(x), abs(y))",
    "isqrt": "math.floor(math.sqrt(x))",
    "log1p": "math.log(1.0 + x), or for a small x math.log(y) * (x / (y - 1.0)) with y = 1.0 + x, and x where y is 1.0",
    "modf": "math.trunc(x) for the whole part, and x - math.trunc(x) for the rest,",
    "prod": "a loop that multiplies",
    "remainder": "x % y or math.fmod(x, y)",
    "sumprod": "a loop that adds",
}
NOT_IN_C = ("factorial", "isclose", "modf")  # which MicroPython has, and C lacks, or cannot return two numbers
NOT_ON_AVR = ("acosh", "asinh", "atanh", "erf", "erfc", "expm1", "gamma", "lgamma", "log2")  # which avr-libc lacks


def check(tree: ast.Module) -> None:
    """Raise BrokenContract if a source uses of `math` what MicroPython or C lacks."""
    for name, line in _uses(tree):
        if name in FUNCTIONS or name in CONSTANTS:
            continue
        if not hasattr(math, name) and name not in INSTEAD:
            raise BrokenContract(f"math has no {name}: {did_you_mean(name, FUNCTIONS)}".rstrip(": "), line)
        right = INSTEAD.get(name, f"your own arithmetic, or one of {', '.join(FUNCTIONS)},")
        who = "C" if name in NOT_IN_C else "MicroPython"
        raise BrokenContract(f"uses math.{name}, which {who} on a robot lacks: {right} is right", line)


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
