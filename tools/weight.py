"""Counts lines of code, without docstrings, comments, blank lines and imports; fails if a package has more than MOST.

Lowering a number is free. Whoever raises one writes the reason next to it, in a sentence.
"""

import ast
import io
import sys
import tokenize
from collections import Counter
from pathlib import Path

# Raised: brains has the counter of lines that checks and simulation had each; engine and simulation make the trace of
# trials in place of live, robots and summaries; engine uses machine code that ships; content: census, sure and
# steadfast keep their promises in worlds where they did not, and measured sensors are a spread; robots and runtime
# calibrate sensors, and start fleets over UDP, serial ports and gateways; gpu compares each program with the CPU once
MOST = {
    "__init__": 8, "__main__": 1, "analysis": 1727, "brains": 1322, "checks": 751, "cli": 1403, "content": 3827,
    "engine": 3154, "evaluation": 854, "figures": 3073, "gpu": 837, "live": 1137, "results": 1233, "robots": 3570,
    "runs": 1470, "runtime": 805, "search": 1764, "simulation": 1740, "studies": 1610, "summaries": 955,
    "support": 2521, "theory": 399, "translation": 1615, "worlds": 1582,
}  # fmt: skip
CONTENT = {
    "brains/library", "brains/adversaries", "brains/metrics", "worlds/topologies", "worlds/floors", "worlds/spreads",
}  # fmt: skip  # one file each, which names its source: they count apart
MOST_OF_CONTENT = 250  # in a file
SPACE = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}


def lines_of_code(text: str) -> int:
    """The lines of a program that are neither docstrings nor comments, blank or imports."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    lines = {n for one in tokens if one.type not in SPACE for n in range(one.start[0], one.end[0] + 1)}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            lines.difference_update(range(node.lineno, node.end_lineno + 1))
        elif isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node) is not None:
            lines.difference_update(range(node.body[0].lineno, node.body[0].end_lineno + 1))
    return len(lines)


def main() -> int:
    """Print a table of all packages; the exit code is 1 if one is too heavy."""
    source, weight, faults = Path(__file__).parents[1] / "src/swarmcensus", Counter(dict.fromkeys(MOST, 0)), []
    for path in source.rglob("*.py"):
        place, lines = path.relative_to(source), lines_of_code(path.read_text(encoding="utf-8"))
        is_content = place.parent.as_posix() in CONTENT
        weight["content" if is_content else place.parts[0].removesuffix(".py")] += lines
        if is_content and lines > MOST_OF_CONTENT:
            faults.append(f"{place}: {lines} lines of code, at most {MOST_OF_CONTENT} in a file of content")
    for package, lines in sorted(weight.items()):
        print(f"{package:<12}{lines:>7,}{MOST.get(package, 0):>7,}")
        if lines > MOST.get(package, 0):
            faults.append(f"{package}: {lines:,} lines of code, at most {MOST.get(package, 0):,}")
    print(f"{'all':<12}{weight.total():>7,}{sum(MOST.values()):>7,}", *faults, sep="\n")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
