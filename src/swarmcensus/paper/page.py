"""The page that `reproduce` leaves: one HTML file without a single outside resource, links to the files beside it."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from urllib.parse import quote

import xarray as xr

from swarmcensus.basics.files import data_path
from swarmcensus.basics.version import __version__
from swarmcensus.paper.evaluations import PAPER, Evaluation
from swarmcensus.paper.evidence import FAILS, HOLDS, NO, OPEN, YES, Detail, Outcome
from swarmcensus.paper.figures import PaperFigure
from swarmcensus.paper.report import SIGNS, WORDS, kind, measured, tally
from swarmcensus.statistics import intervals

CLOCK = "wall-clock time"  # of all times that are told, on the page and while it is made


@dataclass(frozen=True)
class Reproduction:
    """What `reproduce` made: datasets by study, figures with their files, claims as measured, seconds by stage.

    Seconds are wall-clock time. Those of "simulate" are of all runs on these datasets together; the other stages are
    done anew each time, "compile" where there is something to run.
    """

    out: Path
    command: str
    datasets: Mapping[str, xr.Dataset]
    figures: Sequence[tuple[PaperFigure, Sequence[Path]]]
    claims: Sequence[Outcome]
    seconds: Mapping[str, float]
    of: Evaluation = PAPER

    @property
    def page(self) -> Path:
        """The page to open in a browser."""
        return self.out / "index.html"

    @property
    def files(self) -> list[Path]:
        """All other files that were written."""
        data = [data_path(self.out, name) for name in self.datasets]
        drawn = [path for _, paths in self.figures for path in paths]
        return [*data, *drawn, *([self.out / "claims.json"] if self.claims else [])]


def html(done: Reproduction) -> str:
    """The whole of index.html: findings, figures, claims, how they were made, and files; what there is of them."""
    sections = {
        "Findings": _findings(done),
        "Figures": "".join(_figure(done, figure, paths) for figure, paths in done.figures),
        "Claims": _claims(done),
        "How it was made": _provenance(done),
        "Files": _files(done),
    }
    filled = {name.lower().replace(" ", "-"): (name, body) for name, body in sections.items() if body}
    links = "".join(f'<a href="#{key}">{name}</a>' for key, (name, _) in filled.items())
    bodies = "".join(f'<section id="{key}"><h2>{name}</h2>{body}</section>' for key, (name, body) in filled.items())
    style = Path(__file__).with_name("page.css").read_text(encoding="utf-8")
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{done.of.title}</title><style>{style}</style></head><body>"
        f"<header><h1>{done.of.title}</h1><p class=lead>{escape(done.of.lead)}</p>"
        f"<p>{escape(done.of.source)}: {escape(done.of.about)}, by swarmcensus "
        f"{escape(__version__)}.</p><p class=quiet>{escape(done.of.symbols)}</p>{_scores(done)}</header>"
        f"<nav>{links}</nav><main>{bodies}</main></body></html>\n"
    )


def _badge(verdict: str, text: str = "") -> str:
    name = verdict.replace(" ", "-")
    return f'<span class="badge {name}">{SIGNS[verdict]} {escape(text or WORDS[verdict])}</span>'


def _scores(done: Reproduction) -> str:
    kinds = [kind(outcome) for outcome in done.claims]
    tiles = "".join(
        f'<div class="score {name.replace(" ", "-")}"><b>{kinds.count(name)}</b>{SIGNS[name]} {word}</div>'
        for name, word in WORDS.items()
        if name in kinds
    )
    label = f"Verdicts on {len(kinds)} claims"
    return f'<div class=scores role=group aria-label="{label}">{tiles}</div>' if kinds else ""


def _findings(done: Reproduction) -> str:
    if not done.claims:
        return ""
    others = [outcome for outcome in done.claims if outcome.holds is not True]
    if not others:
        return f"<p>All {len(done.claims)} claims hold.</p>"
    refuted_first = sorted(others, key=lambda outcome: outcome.holds is None)
    return (
        f"<p>{len(done.claims) - len(others)} of {len(done.claims)} claims hold. These do not, or cannot be told "
        f"from these trials:</p><ul class=findings>{''.join(map(_finding, refuted_first))}</ul>"
    )


def _finding(outcome: Outcome) -> str:
    claim, worst, text = outcome.claim, outcome.worst, ""
    if worst:
        which = "clearest" if outcome.holds is False else "least clear"
        text = (
            f"<p>Measured: {escape(claim.statistic)}. Needed: {escape(claim.threshold)}. Of "
            f"{len(outcome.details)} settings, {outcome.count(YES)} are on the right side with their whole interval, "
            f"{outcome.count(NO)} on the wrong side, and {outcome.count(OPEN)} cannot be told. The {which}: "
            f"{escape(worst.setting)}, <b class=interval>{' '.join(measured(worst)).strip()}</b>.</p>"
        )
    if outcome.explanation:
        text += f"<p><b>What lies behind it.</b> {escape(outcome.explanation)}</p>"
    title = f'<a href="#{claim.id}">{escape(claim.title)}</a>'
    return f"<li><h3>{title}: {_badge(kind(outcome), outcome.verdict)}</h3>{text}</li>"


def _figure(done: Reproduction, figure: PaperFigure, paths: Sequence[Path]) -> str:
    image = base64.b64encode(paths[0].read_bytes()).decode()
    chips = "".join(
        f'<a class=chip href="#{outcome.claim.id}">{_badge(kind(outcome), outcome.claim.title)}</a>'
        for outcome in done.claims
        if outcome.claim.id in figure.claims
    )
    if chips:
        chips = f"<p class=chips>What the paper says of it, as measured:</p><p class=chips>{chips}</p>"
    panels = "; ".join(f"({chr(97 + i)}) {view.caption}" for i, view in enumerate(figure.views))
    text = figure.said(done.datasets)
    alt = escape(f"{figure.title}. Panels: {panels}. {text}")
    links = ", ".join(f'<a href="{_link(done, path)}">{path.suffix[1:].upper()}</a>' for path in paths)
    return (
        f'<figure id="{figure.name}"><h3>{escape(figure.title)}</h3>'
        f'<img alt="{alt}" src="data:image/png;base64,{image}">'
        f"<figcaption>{escape(text)} <span class=quiet>{links}</span>{chips}</figcaption></figure>"
    )


def _claims(done: Reproduction) -> str:
    if not done.claims:
        return ""
    return (
        f"<p>A claim is checked in every setting that it speaks of: {escape(done.of.spoken_of)}. "
        "The value is that of the setting that bears it out least, with a "
        f"{intervals.LEVEL:.0%} interval: percentiles of {intervals.RESAMPLES:,} bootstrap resamples of whole "
        "trials, for the robots of a trial are not independent. A claim <b>holds</b> where the intervals of all "
        "settings lie on the right side, <b>does not hold</b> where at least one lies wholly on the wrong side, and "
        "is <b>not decided</b> otherwise. So a claim "
        "over many settings is harder to uphold and easier to refute: if all of m settings sat right on the "
        f"threshold, about m / {2 / (1 - intervals.LEVEL):.0f} would be called wrong by chance. That is why the "
        "settings are counted. Under a claim, a drawing holds all of its settings in the order of the list below it: "
        "value and interval, and shaded where they would bear the claim out. Quoted formulas are set as plain "
        "text.</p>"
        "<table class=claims><thead><tr><th>Verdict<th>The paper says<th>Measured<th>Value</tr></thead>"
        f"<tbody>{''.join(_row(done.of, outcome) for outcome in done.claims)}</tbody></table>"
    )


def _row(of: Evaluation, outcome: Outcome) -> str:
    claim, value, more = outcome.claim, "", ""
    if outcome.worst:
        number, interval = measured(outcome.worst)
        value = (
            f"<b>{number}</b> <span class=interval>{interval}</span>"
            f"<br><span class=quiet>{escape(outcome.worst.setting)}</span>"
        )
        items = "".join(
            f"<li>{_badge({YES: HOLDS, NO: FAILS}.get(detail.verdict, OPEN), detail.verdict)} "
            f"{escape(detail.setting)}: <span class=interval>{' '.join(measured(detail))}</span>"
            for detail in outcome.details
        )
        more = (
            f"<tr class=more><td><td colspan=3><details><summary>All {len(outcome.details)} settings: "
            f"{tally(outcome)}</summary>{strip(outcome)}<ul class=settings>{items}</ul></details></tr>"
        )
    note = f"<p>{escape(outcome.note)}</p>" if outcome.note else ""
    sentence = f"“{escape(claim.sentence)}”" if of.quoted else escape(claim.sentence)
    return (
        f'<tr id="{claim.id}"><td>{_badge(kind(outcome), outcome.verdict)}'
        f"<td><b>{escape(claim.title)}</b><blockquote>{sentence}</blockquote>"
        f"<span class=quiet>{of.section}{escape(claim.section)}</span>"
        f"<td>{escape(claim.statistic)}.<br>Needed: <b>{escape(claim.threshold)}</b>{note}<td>{value}</tr>{more}"
    )


def _provenance(done: Reproduction) -> str:
    facts = {"Command": f"<code>{escape(done.command)}</code>"}
    for data in list(done.datasets.values())[:1]:
        facts["Versions"] = escape(
            f"swarmcensus {data.attrs['swarmcensus_version']}, Python {data.attrs['python_version']}, "
            f"{data.attrs['library_versions']}; {data.attrs['machine']}"
        )
    facts[CLOCK.capitalize()] = ", ".join(f"{escape(stage)} {seconds:.1f} s" for stage, seconds in done.seconds.items())
    if done.datasets:
        facts[CLOCK.capitalize()] += "; that of simulations and studies is of all runs on their datasets together"
    studies = "".join(
        f"<tr><td>{escape(name)}<td>{data.sizes['setting']}<td>{data.sizes['trial']}<td>{data.attrs['seed']}"
        f"<td>{data.attrs['wall_seconds']:.1f} s"
        for name, data in done.datasets.items()
    )
    if studies:
        head = f"<tr><th>Study<th>Settings<th>Trials<th>Seed<th>{CLOCK.capitalize()}"
        facts["Studies"] = f"<table class=studies>{head}{studies}</table>"
    return (
        f"<dl>{''.join(f'<dt>{key}<dd>{value}' for key, value in facts.items())}</dl>"
        "<p>Every random number is addressed by seed, setting, trial, robot and round or tick: the same command gives "
        "the same numbers again, with any number of threads. Settings of robots that move share their walks where the "
        "density is the same: they are compared walk by walk.</p>"
    )


def _files(done: Reproduction) -> str:
    items = "".join(
        f'<li><a href="{_link(done, path)}">{escape(path.relative_to(done.out).as_posix())}</a> '
        f"<span class=quiet>{path.stat().st_size / 1e6:.1f} MB</span>"
        for path in done.files
    )
    return f"<ul>{items}</ul><p>Datasets are netCDF-4: xarray, R and MATLAB read them.</p>" if items else ""


def _link(done: Reproduction, path: Path) -> str:
    return escape(quote(path.relative_to(done.out).as_posix()))


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
