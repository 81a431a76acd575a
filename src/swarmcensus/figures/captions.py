"""The caption of a figure: what is drawn, of how many trials, what its intervals are, and remarks.

Remarks are what a figure lacks, pools and leaves out, and what its trials are too few for. They are not drawn: `save`
writes them to a file next to the figure, and to the log.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from swarmcensus.figures.coordinates import pooled
from swarmcensus.figures.groups import lacking
from swarmcensus.figures.sheets import NOTHING, figure_of
from swarmcensus.results import finished_trials
from swarmcensus.summaries import (
    SETTLING_TIMES,
    TAIL_QUANTITY,
    caution_of_learning,
    cautions_of_edges,
    measures,
    settled_far_off,
    shows_tail,
)
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import option, wrong_option

HIDING = {"convergence_error", "final_error"}  # errors of which medians are drawn
MOST_NAMED = 8  # settings
NEVER = "it counts as never"  # a time in which robots settle that never learnt
FIRST = "its error at K is that of its first belief"
WIDE = 100  # letters of a line in a file
DRAWN_BY = "; drawn by "  # in a remark: what follows is for the log only
THEORY = "Thin dotted or dashed lines are theory, as the key says."
SYMBOLS = (r"\,", ""), (r"\hat{x}", "x̂"), (r"\Delta", "Δ"), (r"\delta", "δ"), ("$", ""), ("\n", " ")  # of formulas


class Caption(NamedTuple):
    """Sentences about a figure, and remarks."""

    about: list[str]
    remarks: list[str]


_CAPTIONS: WeakKeyDictionary[Figure, Caption] = WeakKeyDictionary()


def captioned(
    axes: Sequence[Axes],
    kind: Callable[..., Any],
    parts: Sequence[xr.Dataset] = (),
    remarks: Iterable[str] = (),
    more: Iterable[str] = (),
) -> Figure:
    """The figure of these axes, with a caption: what `kind` draws, of which trials, and all remarks but empty ones.

    `more` are sentences on what is drawn.
    """
    sentences = re.split(r"(?<=\.) (?=[A-Zxy])", " ".join((kind.__doc__ or "").split("\n    - `")[0].split()))
    first = sentences[0].removeprefix("Draw ").replace("`", "")
    names = [str(ax.get_label()) for ax in axes]
    about = [f"{first[:1].upper()}{first[1:]}"]
    about += [f"{'; '.join(names)}."] if any(names) else []
    for which in "xy":
        labels = [getattr(ax, f"get_{which}label")() for ax in axes if ax.axison]
        about += [f"{which}: {' or '.join(map(_plain, dict.fromkeys(filter(None, labels))))}."] if any(labels) else []
    about += [f"{trials}."] if (trials := trials_of(parts)) else []
    lines = [str(line.get_label()) for ax in axes for line in ax.lines]
    about += [THEORY] * any(name.startswith(("theory ", "predicted ")) for name in lines)
    figure = figure_of(axes)
    keys = " ".join(text.get_text() for ax in figure.axes if (key := ax.get_legend()) for text in key.get_texts())
    about += [*filter(None, more), *(sentence for sentence in sentences[1:] if "95 %" in sentence and "95 %" in keys)]
    drawn = lacking(parts) if parts else ""
    _CAPTIONS[figure] = Caption(about, [*filter(None, [f"drawn: {drawn}" * bool(drawn), *remarks])])
    return figure


def remarks_on(figure: Figure) -> list[str]:
    """The remarks of a figure's caption."""
    return _CAPTIONS[figure].remarks if figure in _CAPTIONS else []


def caption(figure: Figure) -> str:
    """A draft of the caption of a figure that `sc.plot` drew; empty for other figures.

    It says what is drawn, of how many trials and robots, and what intervals are. Remarks follow, a line each, such as
    what is pooled or left out, or for what the trials are too few.
    """
    about = [" ".join(_CAPTIONS[figure].about)] if figure in _CAPTIONS else []
    lines = about + [f"- {remark.partition(DRAWN_BY)[0]}" for remark in dict.fromkeys(remarks_on(figure))]
    return "".join(textwrap.fill(line, WIDE, break_long_words=False) + "\n" for line in lines)


def _plain(text: str) -> str:
    """A text without the signs of formulas."""
    for sign, letters in SYMBOLS:
        text = text.replace(sign, letters)
    return text


def trials_of(parts: Sequence[xr.Dataset]) -> str:
    """How many trials and robots are drawn, such as "30 trials of 100 robots in each of 8 settings"."""
    if not parts or any({"robots", "convergence_round"} - {*part.variables} for part in parts):
        return ""
    done = np.concatenate([finished_trials(part).sum(axis=1) for part in parts])
    robots = np.concatenate([part["robots"].values for part in parts])
    settings = f" in each of {done.size:,} settings" if done.size > 1 else ""
    return f"{_range(done, 'trial')} of {_range(robots, 'robot')}{settings}"


def _range(numbers: NDArray[Any], name: str) -> str:
    least, most = int(np.min(numbers)), int(np.max(numbers))
    return counted(most, name) if least == most else f"{least:,} to {counted(most, name)}"


def pooled_over(parts: Sequence[xr.Dataset], by: Sequence[str]) -> str:
    """Which coordinates are pooled in panels that distinguish `by`."""
    return f"pooled over {what}" if (what := pooled(parts, by)) else ""


def misleading(parts: Sequence[xr.Dataset]) -> str:
    """In which settings K misleads."""
    found = [number for part in parts for number in part["setting"].values[settled_far_off(part)].tolist()]
    if not found:
        return ""
    named = ", ".join(map(str, found[:MOST_NAMED])) + ", ..." * (len(found) > MOST_NAMED)
    what = "settled early, but far from each other or from f"
    return f"K misleads in setting{'s' * (len(found) > 1)} {named}: {what}"


def unlearnt(parts: Sequence[xr.Dataset], drawn: Collection[str], what: str) -> str:
    """Which robots never learnt, and `what` a figure of times in which they settle makes of their K = 0."""
    says = [what] * bool({*SETTLING_TIMES} & {*drawn}) + [FIRST] * ("convergence_error" in drawn)
    return caution_of_learning(parts, "; ".join(says)) if says else ""


def on_edges(parts: Sequence[xr.Dataset], drawn: Sequence[str]) -> str:
    """Which fill ratios lie on the edge between two bins, if shares of right robots are drawn."""
    return "".join(cautions_of_edges(*parts)) if "correct" in drawn else ""


def hidden_tail(results: xr.Dataset, drawn: Sequence[str], name: str) -> str:
    """That median errors hide a tail, and which option draws it."""
    hides = HIDING.intersection(drawn) and TAIL_QUANTITY not in drawn and shows_tail(results)
    return f"the worst tenth of the robots may err much more{DRAWN_BY}{option(name, TAIL_QUANTITY)}" if hides else ""


def with_numbers(
    captions: Sequence[str], has: Sequence[bool], why: str, *lists: Sequence[Any]
) -> tuple[str, *tuple[Any, ...]]:
    """A remark on panels left out, `why` they have no numbers, and these lists with an item for each other panel."""
    kept = [k for k, there in enumerate(has) if there]
    return left_out(captions, kept, why), *([each[k] for k in kept] for each in lists)


def nothing_of(results: xr.Dataset, option: str, name: str) -> InputError:
    """The error of a figure without any number of a quantity."""
    if not finished_trials(results).any():
        return InputError(NOTHING)
    endless = np.isinf(measures.numbers(results, name)).any()
    why = "it happened in no trial, or in too few" if endless else "no trial of these settings has numbers of it"
    return wrong_option(option, name, f"nothing to draw: {why}")


def left_out(captions: Sequence[str], kept: Sequence[int], why: str) -> str:
    """Which panels are left out, and why."""
    missing = [caption for k, caption in enumerate(captions) if k not in kept]
    return f"left out, {why}: {'; '.join(missing)}" if missing else ""


def without_theory(caption: str, why: str) -> str:
    """Why a panel has no theory; empty if there is no reason."""
    return f"no theory{f' for {caption}' if caption else ''}: {why}" if why else ""
