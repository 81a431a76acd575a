"""Theory's curves in figures: what a lone robot is expected to do, and what all readings at once would give.

Both depend on sensors and fill ratio, not on the brain. What communication achieves lies between
them, but for few readings: theory is of unbiased estimates, and a brain may begin near the truth.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.lines import Line2D

from swarmcensus.analysis import ALONE, SWARM, Line, expect
from swarmcensus.figures.captions import without_theory
from swarmcensus.figures.coordinates import Panel, texts_of
from swarmcensus.figures.styles import Look
from swarmcensus.results import finished_trials

STYLES = {ALONE: (0, (1, 1.5)), SWARM: (0, (4, 2))}  # dots, and dashes
NAMES = {ALONE: "theory: a robot alone", SWARM: "theory: all readings at once"}
THIN = 0.9
GREY = "0.3"
DIFFERENT = "settings drawn as one differ in it"

Curves = dict[str, dict[str, Line]]  # value of the colour -> name of the line -> line


def curves_of(panel: Panel, color: str, times: Sequence[int] = ()) -> tuple[Curves, str]:
    """Theory's lines by values of `color`, at these rounds or ticks (default: the last); if there are none, a remark.

    Settings that are pooled share a line if theory is the same for all of them. Raises InputError as `expect` does.
    """
    results, names = panel.results, (ALONE,) if panel.local else (ALONE, SWARM)
    texts, ran = texts_of(results, color), finished_trials(results).any(axis=1)
    curves: Curves = {}
    reasons: list[str] = []
    for text in dict.fromkeys(texts[ran].tolist()):
        expected = []
        for k in np.flatnonzero((texts == text) & ran):
            number, rounds = int(results["setting"].values[k]), int(results["rounds"].values[k])
            expected.append(expect(results, number, times or [rounds], names))
        first = expected[0].lines
        reasons += [each.absent[name] for each in expected for name in names if name in each.absent]
        agreed = {name: all(_agree(first[name], each.lines.get(name)) for each in expected) for name in first}
        reasons += [DIFFERENT] * (not all(agreed.values()))
        if any(agreed.values()):
            curves[text] = {name: line for name, line in first.items() if agreed[name]}
    return curves, without_theory(panel.caption, "" if curves or not reasons else reasons[0])


def lines_to_draw(curves: Curves, looks: Mapping[str, Look]) -> Iterator[tuple[str, Line, dict[str, Any]]]:
    """Each line of a panel: the value of its colour, the line and its style.

    Lines that are equal for all values, such as brains, are drawn once, in grey, for the value "".
    """
    first = next(iter(curves.values()), {}) if len(curves) > 1 else {}
    same = {name: line for name, line in first.items() if all(_agree(line, each.get(name)) for each in curves.values())}
    for text in ("", *looks):
        lines = curves.get(text, {}) if text else same
        for name, line in lines.items():
            if not text or name not in same:
                style = {"color": looks[text].colour if text else GREY, "linewidth": THIN, "linestyle": STYLES[name]}
                yield text, line, style | {"label": f"theory {name} {text}".rstrip()}


def entries(drawn: Sequence[Curves]) -> dict[str, Artist]:
    """The key's entries for the lines that are drawn."""
    known = {name for curves in drawn for lines in curves.values() for name in lines}
    return {NAMES[name]: sample(name) for name in STYLES if name in known}


def sample(name: str) -> Line2D:
    """A line in the style of a theory line, for the key."""
    return Line2D([], [], color=GREY, linewidth=THIN, linestyle=STYLES[name])


def _agree(first: Line, second: Line | None) -> bool:
    return second is not None and all(map(partial(np.allclose, rtol=0.02, atol=1e-6), first, second))
