"""How the page of `reproduce` looks: its style sheet, the signs of verdicts, and a strip of all settings' intervals."""

from __future__ import annotations

import math
from html import escape

from swarmcensus.evidence import FAILS, HOLDS, NO, OPEN, UNMEASURED, YES, Outcome

SCORES = {HOLDS: "holds", FAILS: "does not hold", OPEN: "not decided", UNMEASURED: "not measured"}
ICONS = {HOLDS: "✓", FAILS: "✗", OPEN: "?", UNMEASURED: "–"}

# Blue and vermilion are told apart by all kinds of colour vision (Okabe and Ito); an icon and a word repeat them.
STYLE = """
:root { color-scheme: light dark; --paper: #fff; --ink: #1c2127; --quiet: #5d6773; --line: #d9dee3; --shade: #f4f6f8;
  --yes: #00609c; --no: #b34700; --open: #5d6773; --link: #00609c }
@media (prefers-color-scheme: dark) { :root { --paper: #14181c; --ink: #e4e8ec; --quiet: #9aa5b0; --line: #333b43;
  --shade: #1d2329; --yes: #6cb8ee; --no: #ff9a5c; --open: #a5b0ba; --link: #6cb8ee } }
* { box-sizing: border-box }
html { scroll-padding-top: 3.5rem }
body { margin: 0; background: var(--paper); color: var(--ink); font: 1rem/1.55 system-ui, sans-serif }
header, main { max-width: 72rem; margin: auto; padding: 0 1.25rem }
header { padding-top: 2.5rem } h1 { font-size: 2.2rem; line-height: 1.15; margin: 0 0 .5rem }
h2 { font-size: 1.5rem; margin: 3rem 0 .75rem } h3 { font-size: 1.05rem; margin: 0 0 .5rem }
p, dl, figcaption, .findings { max-width: 46rem } .lead { font-size: 1.2rem; margin: 0 0 .75rem }
a { color: var(--link) } .quiet { color: var(--quiet); font-size: .875rem }
nav { position: sticky; top: 0; z-index: 1; background: var(--paper); border-bottom: 1px solid var(--line);
  padding: .6rem max(1.25rem, calc((100% - 69.5rem) / 2)); display: flex; flex-wrap: wrap; gap: .2rem 1.25rem; margin-top: 1.5rem }
nav a { text-decoration: none }
.scores { display: flex; flex-wrap: wrap; gap: .75rem } .score { border: 1px solid var(--line); border-left: 4px solid;
  border-radius: 4px; padding: .4rem 1rem .5rem .8rem; min-width: 8rem }
.score b { display: block; font-size: 1.9rem; line-height: 1.2 }
.holds { color: var(--yes) } .does-not-hold { color: var(--no) } .undecided, .not-measured { color: var(--open) }
.badge { font-weight: 600 }
.findings { padding: 0; list-style: none } .findings li { margin: 1.5rem 0 } .findings p { margin: .4rem 0 }
figure { margin: 0 0 2.75rem } figure img { width: 100%; height: auto; background: #fff; border: 1px solid var(--line);
  border-radius: 4px; padding: .5rem; margin-bottom: .6rem }
.chips { margin: .6rem 0 0; display: flex; flex-wrap: wrap; gap: .4rem }
.chip { border: 1px solid var(--line); border-radius: 1rem; padding: .05rem .7rem; font-size: .875rem;
  text-decoration: none } .chip .badge { font-weight: 400 } .chip:hover { background: var(--shade) }
table { border-collapse: collapse } th { text-align: left; font-weight: 600 }
.claims { width: 100%; table-layout: fixed } .claims > thead th, .claims > tbody > tr > td { padding: .75rem 1.25rem .75rem 0;
  vertical-align: top; border-top: 1px solid var(--line); overflow-wrap: break-word }
.claims > thead th { border: 0; padding-bottom: .3rem } .claims > thead th:first-child { width: 8.5rem }
.claims > thead th:last-child { width: 14.5rem } .claims tr:target { background: var(--shade) }
blockquote { margin: .35rem 0; font-style: italic } .claims p { margin: .4rem 0; font-size: .9rem }
summary { cursor: pointer; color: var(--link) }
.claims > tbody > tr.more > td { border: 0; padding-top: 0 } .interval { white-space: nowrap }
.settings { font-size: .875rem; font-variant-numeric: tabular-nums; margin: .75rem 0; padding: 0; list-style: none;
  columns: 21rem; column-gap: 1.25rem } .settings li { break-inside: avoid }
.studies td, .studies th { padding: .15rem 1.5rem .15rem 0 } .studies { font-variant-numeric: tabular-nums }
svg { width: 100%; height: auto; margin-top: .6rem } svg text { fill: var(--quiet); font-size: 11px }
dt { font-weight: 600 } dd { margin: 0 0 .6rem; overflow-wrap: anywhere } code { font-size: .9rem }
@media (max-width: 46rem) { .claims > thead { display: none } .claims, .claims > tbody, .claims > tbody > tr, .claims > tbody > tr > td {
  display: block; width: 100% } .claims > tbody > tr { border-top: 1px solid var(--line); padding: .75rem 0 }
  .claims > tbody > tr > td { border: 0; padding: .2rem 0 } h1 { font-size: 1.8rem }
  .claims > tbody > tr.more { border: 0; padding-top: 0 } }
@media print { nav { display: none } }
"""

WIDTH, HEIGHT, LEFT, MARGIN = 960.0, 180.0, 60.0, 12.0
SIGNS = {YES: "--yes", NO: "--no", OPEN: "--open"}


def strip(outcome: Outcome) -> str:
    """All settings side by side as SVG: value, interval, and the range that bears the claim out as a shaded band.

    Empty where no value has an interval or all are alike. Ratios, and all that is positive, are on a logarithmic scale.
    """
    shown = [(d, *d.interval) for d in outcome.details if d.interval and all(map(math.isfinite, (d.value, *d.interval)))]
    ends = [end for _, *interval in shown for end in interval] + [e for e in outcome.claim.right if math.isfinite(e)]
    if len(shown) < 4 or min(ends) == max(ends):
        return ""
    scale = math.log if min(ends) > 0 else float
    low, high = scale(min(ends)), scale(max(ends))

    def y(value: float) -> float:
        inside = min(max(value, min(ends)), max(ends))  # an open end of the band is the edge of the drawing
        share = (scale(inside) - low) / (high - low)
        return MARGIN + (1 - share) * (HEIGHT - 2 * MARGIN)

    bottom, top = (y(end) for end in outcome.claim.right)
    step = (WIDTH - LEFT) / len(shown)
    labels: dict[float, float] = {}
    for end in (*outcome.claim.right, min(ends), max(ends)):  # thresholds first: the others yield
        if math.isfinite(end) and all(abs(y(end) - place) > 11 for place in labels):
            labels[y(end)] = end
    parts = [f'<rect x="{LEFT}" y="{top:.1f}" width="{WIDTH - LEFT}" height="{bottom - top:.1f}" fill="var(--shade)"/>']
    parts += [f'<text x="{LEFT - 5}" y="{place + 4:.1f}" text-anchor="end">{v:.3g}</text>' for place, v in labels.items()]
    parts += [
        f'<path d="M{LEFT} {y(end):.1f}H{WIDTH}" stroke="var(--quiet)" stroke-dasharray="4 3"/>'
        for end in outcome.claim.right if math.isfinite(end)
    ]  # fmt: skip
    for i, (detail, least, most) in enumerate(shown):
        x, colour = LEFT + (i + 0.5) * step, SIGNS[detail.verdict]
        fill = "var(--paper)" if detail.verdict == OPEN else f"var({colour})"
        parts.append(
            f'<g stroke="var({colour})" stroke-width="1.5"><title>{escape(detail.setting)}</title>'
            f'<path d="M{x:.1f} {y(least):.1f}V{y(most):.1f}"/>'
            + (
                f'<path d="M{x - 3:.1f} {y(detail.value) - 3:.1f}l6 6m0 -6l-6 6"/>'
                if detail.verdict == NO
                else f'<circle cx="{x:.1f}" cy="{y(detail.value):.1f}" r="2.5" fill="{fill}"/>'
            )
            + "</g>"
        )
    label = f"All settings of: {outcome.claim.title}"
    return f'<svg viewBox="0 0 {WIDTH:.0f} {HEIGHT:.0f}" role="img" aria-label="{escape(label)}">{"".join(parts)}</svg>'
