"""A claim's settings side by side as a small drawing: inline SVG in the colours of the page."""

import math
from html import escape

from swarmcensus.paper.evidence import NO, OPEN, YES, Detail, Outcome

WIDTH, HEIGHT, LEFT, MARGIN, LETTERS = 960.0, 180.0, 60.0, 12.0, 11.0
COLOURS = {YES: "var(--yes)", NO: "var(--no)", OPEN: "var(--open)"}
FEWEST = 4  # settings: fewer are told as well by their list


def strip(outcome: Outcome) -> str:
    """Value and interval of each setting, and the range that bears the claim out as a shaded band, as SVG.

    The scale is logarithmic where all is positive. Empty for few settings, and where values have no interval.
    """
    shown = [(d, *d.interval) for d in outcome.details if d.interval and _finite(d.value, *d.interval)]
    thresholds = [end for end in outcome.claim.right if _finite(end)]
    ends = [end for _, low, high in shown for end in (low, high)] + thresholds
    if len(shown) < FEWEST or min(ends) == max(ends):
        return ""
    scale = math.log if min(ends) > 0 else float
    bottom, top = scale(min(ends)), scale(max(ends))

    def y(value: float) -> float:
        inside = min(max(value, min(ends)), max(ends))  # an open end of the band is the edge of the drawing
        return MARGIN + (top - scale(inside)) / (top - bottom) * (HEIGHT - 2 * MARGIN)

    low, high = map(y, outcome.claim.right)
    band = f'<rect x="{LEFT}" y="{high:.1f}" width="{WIDTH - LEFT}" height="{low - high:.1f}" class="band"/>'
    lines = "".join(f'<path d="M{LEFT} {y(end):.1f}H{WIDTH}" class="threshold"/>' for end in thresholds)
    labels: dict[float, float] = {}
    for end in (*thresholds, min(ends), max(ends)):  # thresholds first: the others yield
        if all(abs(y(end) - place) > LETTERS for place in labels):
            labels[y(end)] = end
    texts = "".join(
        f'<text x="{LEFT - 5}" y="{place + 4:.1f}" text-anchor="end">{value:.3g}</text>'
        for place, value in labels.items()
    )
    step = (WIDTH - LEFT) / len(shown)
    marks = "".join(
        _mark(detail, LEFT + (i + 0.5) * step, y(detail.value), y(least), y(most))
        for i, (detail, least, most) in enumerate(shown)
    )
    label = escape(f"All settings of: {outcome.claim.title}")
    box = f"0 0 {WIDTH:.0f} {HEIGHT:.0f}"
    return f'<svg viewBox="{box}" role="img" aria-label="{label}">{band}{lines}{texts}{marks}</svg>'


def _finite(*values: float) -> bool:
    return all(map(math.isfinite, values))


def _mark(detail: Detail, x: float, value: float, low: float, high: float) -> str:
    """A vertical interval with a dot, a ring (undecided) or a cross (on the wrong side) at its value."""
    colour = COLOURS[detail.verdict]
    fill = "var(--paper)" if detail.verdict == OPEN else colour
    sign = f'<circle cx="{x:.1f}" cy="{value:.1f}" r="2.5" fill="{fill}"/>'
    if detail.verdict == NO:
        sign = f'<path d="M{x - 3:.1f} {value - 3:.1f}l6 6m0 -6l-6 6"/>'
    bar = f'<path d="M{x:.1f} {low:.1f}V{high:.1f}"/>'
    return f'<g stroke="{colour}" stroke-width="1.5"><title>{escape(detail.setting)}</title>{bar}{sign}</g>'
