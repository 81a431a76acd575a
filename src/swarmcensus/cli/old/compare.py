"""The command `compare`, which prints, writes and draws comparisons. Imports wait until the command needs them."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.cli.options import Command, Group, add_shared

from swarmcensus.cli.output import present, say, wrote
from swarmcensus.cli.source import MOST_ROWS, add_limit_option, add_source_options, again, read
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import misplaced

if TYPE_CHECKING:
    import xarray as xr

    from swarmcensus.analysis import Comparison


def add_compare_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `compare`."""
    add_source_options(sub)
    sub.add_argument(
        "--metric",
        action="append",
        default=[],
        metavar="NAME",
        help="a measure to compare by, such as correct, or my_metric:low if low is good (default: the usual measures); "
        "may be repeated",
    )
    sub.add_argument(
        "--factor",
        action="append",
        default=[],
        metavar="AXIS",
        help="compare the values of topology, robots or another coordinate, where all else is equal (default: brains); "
        "may be repeated for combinations",
    )
    sub.add_argument("--against", metavar="NAME", help="compare all others with this one only, which needs fewer tests")
    sub.add_argument(
        "--margin",
        action="append",
        default=[],
        type=_margin,
        metavar="[NAME=]X",
        help="a difference of a measure that makes no difference in practice: pairs with an interval within it are "
        "called equal; may be repeated",
    )
    sub.add_argument(
        "--by",
        action="append",
        default=[],
        metavar="AXIS",
        help="count wins by topology, robots or another coordinate of the worlds; may be repeated",
    )
    sub.add_argument("--pairs", action="store_true", help="also show each pair: difference, effect, p-values")
    sub.add_argument("--sentences", action="store_true", help="also show a sentence on each pair, for a paper")
    add_shared(sub, "label")
    add_limit_option(sub, "; in a pipe: all")
    sub.add_argument("--csv", type=Path, metavar="FILE.csv", help="write all pairs, one row each")
    sub.add_argument("--latex", type=Path, metavar="FILE.tex", help="write the table of worlds for a paper (booktabs)")
    add_shared(sub, plot="FILE-ranks, FILE-pareto, and FILE-profiles of times that may never come")


def _margin(text: str) -> tuple[str, float]:
    """The name of a measure, or nothing, and its margin."""
    name, _, number = text.rpartition("=")
    try:
        return name, float(number)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} should be a number, or NAME=number") from None


def _margins(given: list[tuple[str, float]]) -> float | dict[str, float] | None:
    """The margins as `sc.compare` takes them. Raises InputError for a measure given twice."""
    names = [name for name, _ in given]
    if len(set(names)) < len(names) or ("" in names and len(names) > 1):
        raise misplaced("margin", None, "is given twice for one measure: write --margin NAME=X for each")
    return None if not given else given[0][1] if names == [""] else dict(given)


def compare(options: argparse.Namespace) -> int:
    """Compare brains, or levels of another factor, within each world."""
    from swarmcensus.cli.commands.plot import figure_files
    from swarmcensus.cli.tables import head

    from swarmcensus.analysis import compare as compare_results, write_csv, write_latex
    from swarmcensus.cli import compare_tables
    from swarmcensus.support.files import check_output

    if options.by and options.pairs:
        raise misplaced("by", None, "counts worlds, --pairs shows single worlds: give one of them")
    check_output("csv", options.csv, (".csv",), options.results)
    check_output("latex", options.latex, (".tex",), options.results)
    figures: dict[str, Path] = {}  # comparison.png becomes comparison-ranks.png and comparison-pareto.png
    if out := options.plot:
        kinds = ("ranks", "pareto", "profiles")
        figures = {kind: out.with_name(f"{out.stem}-{kind}{out.suffix}") for kind in kinds}
    for path in figures.values():
        figure_files(path, ("png", "svg"), options.results)
    stored = read(options).stored
    margins = _margins(options.margin)
    comparison = compare_results(stored, options.metric, options.where, options.against, options.factor, margins)
    limit = MOST_ROWS if options.limit is None else options.limit
    title, line = (
        head(stored, options.results),
        again(options, "compare", ("factor", "against", "metric", "by", "label")),
    )
    axes = list(dict.fromkeys(options.by))
    frame = comparison.by(*axes) if axes else comparison.pairs if options.pairs else comparison.table
    present(
        options,
        "comparison",
        lambda: _as_dict(comparison, axes),
        lambda: frame.head(options.limit or len(frame)).to_dict("records"),
        lambda: (
            compare_tables.show_groups(comparison, title, line, axes, limit)
            if axes
            else compare_tables.show(comparison, title, line, limit, options.pairs, options.sentences)
        ),
        lambda: [*str(comparison).splitlines(), *(comparison.sentences if options.sentences else ())],
    )
    if options.csv:
        wrote(f"{options.csv}: {counted(write_csv(comparison, options.csv), 'row')}")
    if options.latex:
        write_latex(comparison, options.latex)
        wrote(options.latex)
    if figures:
        _draw(comparison, stored, figures)
    return 0


def _as_dict(comparison: "Comparison", axes: list[str]) -> dict[str, Any]:
    """All tables of a comparison for JSON, an object per row; with `axes` also the table of `--by`."""
    tables = {
        "worlds": comparison.table,
        "pairs": comparison.pairs,
        "ranks": comparison.ranks,
        "duels": comparison.duels,
    }
    tables |= {"groups": comparison.by(*axes)} if axes else {}
    tables |= {"profiles": profiles} if len(profiles := comparison.profiles) else {}
    about = {
        "title": comparison.title,
        "measures": comparison.measures,
        "verdict": comparison.verdict,
        "pairing": comparison.pairing,
        "sentences": comparison.sentences,
        "cautions": comparison.cautions,
    }
    return about | {name: table.to_dict("records") for name, table in tables.items()}


def _draw(comparison: "Comparison", stored: "xr.Dataset", figures: dict[str, Path]) -> None:
    """Draw ranks, the Pareto front and profiles of times; with --against, say why there are no ranks."""
    from swarmcensus.cli.commands.plot import save_figure

    from swarmcensus.analysis import is_time
    from swarmcensus.figures.kinds.pareto import draw_pareto
    from swarmcensus.figures.kinds.profiles import draw_profiles
    from swarmcensus.figures.kinds.ranks import draw_ranks

    if comparison.against is None:
        save_figure(draw_ranks(comparison, results=[stored]), figures["ranks"])
    else:
        say(f"{figures['ranks']} is not drawn: --against does not rank all brains")
    try:
        save_figure(draw_pareto(comparison, results=[stored]), figures["pareto"])
    except InputError as error:  # no finite number, no cost, or too many worlds
        say(f"{figures['pareto']} is not drawn: {error}")
    if any(is_time(measure.name) for measure in comparison.measures):
        save_figure(draw_profiles(comparison, results=[stored]), figures["profiles"])


COMMANDS = (
    Command(
        "compare", "Rank brains in each world, and test their differences.",
        Group.STUDIES, 5, compare, add_compare_options, table=True,
    ),
)  # fmt: skip
