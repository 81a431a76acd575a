"""The page that `reproduce` writes: one HTML file that needs no other, with links to the files next to it."""

import base64
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from swarmcensus.evaluation.paper.evaluations import PaperFigure
from swarmcensus.evaluation.paper.evidence import HOLDS, MARGIN, MUCH, VERDICTS
from swarmcensus.evaluation.paper.report import SIGNS, Reproduction, tally, value_and_interval
from swarmcensus.figures import crosses_of, shares_of
from swarmcensus.support import intervals
from swarmcensus.support.formatting import CLOCK, fixed
from swarmcensus.support.templates import render
from swarmcensus.support.version import __version__

AS_PAPER = "-as-paper"  # the end of the names of figures on the paper's axes


def html(done: Reproduction) -> str:
    """The text of index.html: findings, figures, claims, how they were made, and files. Empty parts are left out."""
    findings = [outcome for outcome in done.claims if outcome.verdict != HOLDS]
    return render(
        Path(__file__).with_name("page.html.jinja"), done=done, of=done.of, version=__version__, claims=done.claims,
        style=Path(__file__).with_name("page.css").read_text(encoding="utf-8"), intervals=intervals, margin=MARGIN,
        counts=Counter(outcome.verdict for outcome in done.claims), datasets=done.datasets, clock=CLOCK, much=MUCH,
        findings=sorted(findings, key=lambda outcome: VERDICTS.index(outcome.verdict)), verdicts=VERDICTS[::-1],
        figures=[_figure(done, *each) for each in done.figures], signs=SIGNS, tally=tally,
        value_and_interval=value_and_interval,
    )  # fmt: skip


def _figure(done: Reproduction, figure: PaperFigure, paths: Sequence[Path]) -> dict[str, Any]:
    panels = [f"({chr(97 + i)}) {view.caption}" for i, view in enumerate(figure.views)]
    return {
        "name": figure.name, "title": figure.title, "quote": figure.quote, "panels": panels,
        "pictures": [_picture(done, figure, paths, as_paper) for as_paper in (False, True)],
        "claims": [outcome for outcome in done.claims if outcome.claim.id in figure.claims],
        "shown": ("median K", "error") if figure.kind == "scatter" else ("right robots at the end",),
        "rows": _medians(done, figure),
    }  # fmt: skip


def _picture(done: Reproduction, figure: PaperFigure, paths: Sequence[Path], as_paper: bool) -> dict[str, Any]:
    """One of the two pictures of a figure: its image, its text and its files."""
    files = [path for path in paths if path.stem.endswith(AS_PAPER) == as_paper]
    png, text = next(path for path in files if path.suffix == ".png"), figure.caption(done.datasets, as_paper=as_paper)
    image = base64.b64encode(png.read_bytes()).decode()
    return {"kind": "theirs" if as_paper else "ours", "text": text, "png": png, "image": image, "files": files}


def _medians(done: Reproduction, figure: PaperFigure) -> dict[str, list[str]]:
    """What is drawn as numbers, by accuracy: of each panel median K and error, or the last share of right robots."""
    columns: list[dict[str, str]] = []
    for view in figure.views:
        part = view.panel(done.datasets)[1]
        if figure.kind == "scatter":
            medians = {name: dot for name, (dot, _) in crosses_of(part, view.local).items()}
            columns.append({name: fixed(k) for name, (k, _) in medians.items()})
            columns.append({name: f"{error:.4f}" for name, (_, error) in medians.items()})
        else:
            shares = {name: share.right[np.isfinite(share.right)][-1] for name, share in shares_of(part).items()}
            columns.append({name: f"{100 * share:.1f} %" for name, share in shares.items()})
    return {name: [column.get(name, "–") for column in columns] for name in columns[0]}
