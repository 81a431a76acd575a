"""The options of `compare`."""

import argparse
from collections.abc import Callable
from pathlib import Path


def add_compare_options(sub: argparse.ArgumentParser, from_zero: Callable[[str], int], rows: int) -> None:
    """Add them to the command's parser; `rows` is what `--limit` is by default."""
    sub.add_argument("results", type=Path, metavar="RESULTS.nc")
    sub.add_argument("--where", metavar="EXPR", help="settings to compare, as 'topology == \"ring\" and robots == 100'")
    sub.add_argument(
        "--metric",
        action="append",
        default=[],
        metavar="NAME",
        help="a measure to compare by, as correct, or my_metric:low (default: the usual ones); several: once for each",
    )
    sub.add_argument("--against", metavar="NAME", help="hold all others against this brain alone, in fewer tests")
    sub.add_argument(
        "--by",
        action="append",
        default=[],
        metavar="AXIS",
        help="count worlds by their topology, robots or what else they differ in; several: once for each",
    )
    sub.add_argument("--pairs", action="store_true", help="each pair of brains too: difference, effect, p-values")
    sub.add_argument("--limit", type=from_zero, metavar="N", help=f"rows at the most, 0: all (default: {rows})")
    sub.add_argument("--csv", type=Path, metavar="FILE.csv", help="write all pairs, a row each")
    sub.add_argument("--latex", type=Path, metavar="FILE.tex", help="write the table of worlds for a paper (booktabs)")
    sub.add_argument("--out", type=Path, metavar="FILE", help="draw FILE-ranks and FILE-pareto (.png, .svg, .pdf)")
