"""The command `compare`: brains within each world, as tables, files and figures. Imports wait until needed."""

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.basics.counting import counted
from swarmcensus.basics.errors import InputError
from swarmcensus.cli.options import MOST_ROWS
from swarmcensus.cli.output import answer, say, wrote

if TYPE_CHECKING:
    from swarmcensus.comparing.comparison import Comparison


def compare(options: argparse.Namespace) -> int:
    """Compare brains within each world."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.cli import compare_tables, comparison_groups_page
    from swarmcensus.cli.plot import figure_files
    from swarmcensus.cli.tables import head
    from swarmcensus.comparing.comparison import compare as compare_results
    from swarmcensus.comparing.latex import write_latex
    from swarmcensus.comparing.tables import write_csv
    from swarmcensus.results.early import opened

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
    stored = opened(options.results)
    found = compare_results(stored, options.metric, options.where, options.against)
    limit = MOST_ROWS if options.limit is None else options.limit
    title, again = head(stored, options.results), _again(options)
    if options.json:
        answer("comparison", _told(found, list(dict.fromkeys(options.by))))
    elif options.by:
        comparison_groups_page.show(found, title, again, list(dict.fromkeys(options.by)), limit)
    else:
        compare_tables.show(found, title, again, limit, options.pairs)
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


def _again(options: argparse.Namespace) -> str:
    """The command with what it was given."""
    words = ["swarmcensus", "compare", str(options.results)]
    words += ["--where", options.where] if options.where is not None else []
    words += ["--against", options.against] if options.against is not None else []
    words += [word for name in options.metric for word in ("--metric", name)]
    return shlex.join([*words, *(word for name in options.by for word in ("--by", name))])


def _draw(found: "Comparison", figures: dict[str, Path]) -> None:
    """Draw what can be drawn of it, and say what cannot."""
    from swarmcensus.cli.plot import save_figure
    from swarmcensus.figures.pareto_fronts import draw_pareto
    from swarmcensus.figures.rank_lines import draw_ranks

    if found.against is None:
        save_figure(draw_ranks(found), figures["ranks"])
    else:
        say(f"{figures['ranks']} is not drawn: ranks are of each against each")
    if "bytes_sent" in found.costs:
        save_figure(draw_pareto(found), figures["pareto"])
    else:
        say(f"{figures['pareto']} is not drawn: these results do not say how many bytes were sent")
