"""Counts lines of code, without docstrings, comments, blank lines and imports; fails if a package has more than MOST.

Lowering a number is free. Whoever raises one writes the reason next to it, in a sentence.
"""

import ast
import io
import sys
import tokenize
from collections import Counter
from pathlib import Path

# Raised: support renders all answers and says what a table may be given in Python, and robots makes the answers of
# relive and swarm, in place of cli; worlds and robots have the faults of processes, and worlds reads accuracies as
# they are printed; simulation and worlds refuse files that were read in part; runs says what keeps a cluster from
# starting; summaries are of results; studies say what is wanted, and make a study of one of their settings, with other
# values, in place of search and live; worlds, studies and support read labels, and lists in tables that span the grid;
# simulation, results, summaries and analysis have fill ratios that trials draw and networks that are not connected,
# which gpu names too; analysis and figures say whether an effect differs between levels of another factor, and draw
# logs of searches; summaries make the cautions of cli and analysis
MOST = {
    "__init__": 8, "__main__": 1, "analysis": 1867, "brains": 1447, "checks": 1082, "cli": 1574, "content": 3818,
    "engine": 3329, "evaluation": 989, "figures": 3323, "gpu": 796, "live": 1578, "results": 1474, "robots": 3631,
    "runs": 1915, "runtime": 681, "search": 2150, "simulation": 1827, "studies": 1782, "summaries": 1178,
    "support": 2700, "theory": 669, "translation": 1927, "worlds": 1786,
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
