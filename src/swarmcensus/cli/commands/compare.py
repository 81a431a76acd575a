"""The command `compare`."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from swarmcensus.cli.parameters import NAMES, Labels, Results, Where, exclusive, number, takes
from swarmcensus.cli.source import read
from swarmcensus.support.answers import Answer
from swarmcensus.support.options import continuing, option_conflict

if TYPE_CHECKING:
    from swarmcensus.analysis import Comparison, Interaction

AXES = Parameter(metavar="AXIS", allow_repeating=True)
ROWS = exclusive()


def _margin(text: str) -> tuple[str, float]:
    """The name of a measure, or nothing, and its margin."""
    name, _, margin = text.rpartition("=")
    try:
        return name, number(margin)
    except ValueError:
        raise ValueError("should be a number, or NAME=number") from None


def compare(
    results: Results, /, *, where: Where = None,
    metric: Annotated[Sequence[str], NAMES] = (), factor: Annotated[Sequence[str], AXES] = (),
    against: Annotated[str | None, Parameter(metavar="NAME")] = None,
    margin: Annotated[Sequence[tuple[str, float]], takes(_margin, "[NAME=]X", several=True)] = (),
    by: Annotated[Sequence[str], AXES, ROWS] = (), pairs: Annotated[bool, ROWS] = False, sentences: bool = False,
    interaction: bool = False, label: Labels = (),
) -> Answer:  # fmt: skip
    """Rank brains in each world, and test their differences.

    Args:
        metric: a measure such as correct, or my_metric:low if low is good (default: the usual ones); may be repeated
        factor: compare values of topology, robots, ... where all else is equal (default: brains); may be repeated
        against: compare all others with this one only, which needs fewer tests
        margin: a difference that makes none in practice: pairs that differ by less are called equal; may be repeated
        by: count wins by topology, robots or another coordinate of the worlds; may be repeated
        pairs: show each pair: difference, effect, p-values
        sentences: also print a sentence on each pair, for a paper
        interaction: does the effect of --factor differ between levels of --by? Compare differences
    """
    if interaction and not by:
        raise option_conflict("interaction", True, "needs --by: the coordinate with the levels to compare between")
    names = [name for name, _ in margin]
    if len({*names}) < len(names) or ("" in names and len(names) > 1):
        raise option_conflict("margin", None, "is given twice for one measure: write --margin NAME=X for each")
    stored, _ = read(results, where, label)
    from swarmcensus.analysis import compare as compare_results
    from swarmcensus.summaries import Summary

    margins = margin[0][1] if names == [""] else dict(margin) or None
    title = Summary(stored, stored, path=results).title
    found: Comparison | Interaction
    if interaction:
        found = compare_results(stored, metric, where, against, factor, margins, interaction=by)
        found.title = title
    else:
        found = compare_results(stored, metric, where, against, factor, margins)
        found.title, found.with_pairs, found.axes = title, pairs, [*dict.fromkeys(by)]
        found.sentences += found.pair_sentences if sentences else []
        found.next = "" if pairs or by else f"{continuing('limit', 'columns', 'save')} --pairs"
    return found
