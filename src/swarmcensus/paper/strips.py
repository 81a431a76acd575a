"""The drawing of a claim: value and interval of each of its settings, as SVG inside the page."""

from __future__ import annotations

import math
from pathlib import Path

from swarmcensus.basics.templates import render
from swarmcensus.paper.evidence import NO, OPEN, YES, Outcome

WIDTH, HEIGHT, LEFT, MARGIN, LETTERS = 960.0, 180.0, 60.0, 12.0, 11.0
COLOURS = {YES: "var(--yes)", NO: "var(--no)", OPEN: "var(--open)"}
SHAPES = {YES: "dot", NO: "cross", OPEN: "ring"}
FEWEST = 4  # settings: fewer are read as easily in their list


def strip(outcome: Outcome) -> str:
    """Value and interval of each setting, with the range in which the claim holds as a shaded band, as SVG.

    Each setting is a vertical interval with a dot, a ring (undecided) or a cross (on the wrong side) at its value.
    The scale is logarithmic where all values are positive. Empty for few settings, and where values have no interval.
    """
    drawn = [(d, *d.interval) for d in outcome.details if d.interval and _finite(d.value, *d.interval)]
    thresholds = [end for end in outcome.claim.right if _finite(end)]
    ends = [end for _, low, high in drawn for end in (low, high)] + thresholds
    if len(drawn) < FEWEST or min(ends) == max(ends):
        return ""
    scale = math.log if min(ends) > 0 else float
    bottom, top = scale(min(ends)), scale(max(ends))

    def y(value: float) -> float:
        inside = min(max(value, min(ends)), max(ends))  # an open end of the band is the edge of the drawing
        return MARGIN + (top - scale(inside)) / (top - bottom) * (HEIGHT - 2 * MARGIN)

    labels: dict[float, float] = {}
    for end in (*thresholds, min(ends), max(ends)):  # thresholds first: the others yield
        if all(abs(y(end) - place) > LETTERS for place in labels):
            labels[y(end)] = end
    step = (WIDTH - LEFT) / len(drawn)
    marks = [
        {
            "setting": detail.setting,
            "shape": SHAPES[detail.verdict],
            "colour": COLOURS[detail.verdict],
            "x": LEFT + (i + 0.5) * step,
            "y": y(detail.value),
            "low": y(low),
            "high": y(high),
        }
        for i, (detail, low, high) in enumerate(drawn)
    ]
    return render(
        Path(__file__).with_name("strip.svg.jinja"),
        title=outcome.claim.title,
        width=WIDTH,
        height=HEIGHT,
        left=LEFT,
        band=sorted(map(y, outcome.claim.right)),
        thresholds=list(map(y, thresholds)),
        labels=labels,
        marks=marks,
    )


def _finite(*values: float) -> bool:
    return all(map(math.isfinite, values))
