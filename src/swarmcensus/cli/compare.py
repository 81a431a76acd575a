"""The command `compare`: brains within each world, as tables, files and figures. Imports wait until needed."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.formatting import counted
from swarmcensus.cli.output import answer, say, wrote
from swarmcensus.cli.source import MOST_ROWS, add_limit_option, add_source_options, again, read

if TYPE_CHECKING:
    from swarmcensus.comparing.comparison import Comparison


def add_compare_options(sub: argparse.ArgumentParser) -> None:
    """Of `compare`."""
    add_source_options(sub)
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
    add_limit_option(sub)
    sub.add_argument("--csv", type=Path, metavar="FILE.csv", help="write all pairs, a row each")
    sub.add_argument("--latex", type=Path, metavar="FILE.tex", help="write the table of worlds for a paper (booktabs)")
    sub.add_argument("--out", type=Path, metavar="FILE", help="draw FILE-ranks and FILE-pareto (.png, .svg, .pdf)")


def compare(options: argparse.Namespace) -> int:
    """Compare brains within each world."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.cli import compare_tables
    from swarmcensus.cli.plot import figure_files
    from swarmcensus.cli.tables import head
    from swarmcensus.comparing.comparison import compare as compare_results
    from swarmcensus.comparing.latex import write_latex
    from swarmcensus.comparing.tables import write_csv

    if options.by and options.pairs:
        raise InputError("--by counts worlds, --pairs shows pairs in each of them: leave one out")
    for path, suffix in ((options.csv, ".csv"), (options.latex, ".tex")):
        if path and path.suffix.lower() != suffix:
            flag = "--csv" if path is options.csv else "--latex"
            raise InputError(f"{flag} {path}: this table is written as {suffix}")
        if path:
            check_writable(path, options.results)
    figures = {kind: _beside(options.out, kind) for kind in ("ranks", "pareto")} if options.out else {}
    for path in figures.values():
        figure_files(path, ("png", "svg"), options.results)
    stored = read(options).stored
    found = compare_results(stored, options.metric, options.where, options.against)
    limit = MOST_ROWS if options.limit is None else options.limit
    title, line = head(stored, options.results), again(options, "compare", ("against", "metric", "by"))
    if options.json:
        answer("comparison", _told(found, list(dict.fromkeys(options.by))))
    elif options.by:
        compare_tables.show_groups(found, title, line, list(dict.fromkeys(options.by)), limit)
    else:
        compare_tables.show(found, title, line, limit, options.pairs)
    if options.csv:
        wrote(f"{options.csv}: {counted(write_csv(found, options.csv), 'row')}")
    if options.latex:
        write_latex(found, options.latex)
        wrote(options.latex)
    if figures:
        _draw(found, figures)
    return 0


def _told(found: "Comparison", axes: list[str]) -> dict[str, Any]:
    """All its tables as data, a row an object; with `axes` also the one of `--by`."""
    tables = {"worlds": found.table, "pairs": found.pairs, "ranks": found.ranks, "duels": found.duels}
    tables |= {"groups": found.by(*axes)} if axes else {}
    about = {"title": found.title, "measures": found.measures, "verdict": found.verdict, "cautions": found.cautions}
    return about | {name: table.to_dict("records") for name, table in tables.items()}


def _beside(out: Path, kind: str) -> Path:
    """The file of a figure: comparison.png becomes comparison-ranks.png."""
    return out.with_name(f"{out.stem}-{kind}{out.suffix}")


def _draw(found: "Comparison", figures: dict[str, Path]) -> None:
    """Draw its figures; ranks are left out, and this is said, where all contenders are held against one."""
    from swarmcensus.cli.plot import save_figure
    from swarmcensus.figures.kinds.pareto import draw_pareto
    from swarmcensus.figures.kinds.ranks import draw_ranks

    if found.against is None:
        save_figure(draw_ranks(found), figures["ranks"])
    else:
        say(f"{figures['ranks']} is not drawn: ranks are of each against each")
    save_figure(draw_pareto(found), figures["pareto"])
