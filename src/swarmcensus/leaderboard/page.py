"""The page of the leaderboard, in Markdown, so that a repository can show it."""

from collections.abc import Sequence

import numpy as np

from swarmcensus.basics.formatting import counted
from swarmcensus.basics.version import __version__
from swarmcensus.comparing.cells import p_value
from swarmcensus.leaderboard.losses import FEW, Losses
from swarmcensus.leaderboard.scores import COLUMNS, Score, Scores

TITLE = "# Leaderboard"


def page(scores: Scores, losses: Sequence[Losses], command: str, seed: int, trials: int, figure: str) -> str:
    """The whole page; `figure` is the name of the picture's file, which lies beside it."""
    marked = {loss.name for loss in losses}
    worlds, many = len(scores.worlds), counted(trials, "trial")
    parts = [
        TITLE,
        f"{len(scores.contenders):,} contenders in the same {worlds:,} worlds, {many} each, by `{command}` "
        f"(seed {seed}, swarmcensus {__version__}). All have the same tiles, readings, neighbours, losses and liars, "
        "trial by trial. *Rank* is the average over all worlds and trials, 1 is best; the column of a kind of world "
        "has the mean over its worlds. The best of a column is **bold**. `oracle` is a bound and has no place: it "
        "hears all honest robots and knows all sensors, which no robot can. `alone` communicates with nobody and is "
        "ranked, because a robot can run it.",
        _kinds(),
        *(_losses(loss) for loss in losses),
        "## Errors of estimates",
        "The distance of a robot's last estimate from *f*, median over robots and trials. Brains whose estimate is "
        "an opinion, black or white, are left out.",
        _table(scores, scores.error, marked),
        f"![Errors of all contenders by kind of world: dark means a large error]({figure})",
        "## Right decisions on black or white",
        "The percentage of robots whose last estimate is on the right side of one half. An estimate of exactly one "
        "half is wrong.",
        _table(scores, scores.side, marked),
        "## Costs",
        "Bytes of memory and of a message, with four bytes per number, and messages per robot and round.",
        _costs(scores),
    ]
    return "\n\n".join(parts) + "\n"


def _kinds() -> str:
    return "\n".join(f"- *{column.name}*: {column.meaning}" for column in COLUMNS)


def _table(scores: Scores, score: Score, marked: set[str]) -> str:
    low = score is scores.error
    order = score.order
    best = [np.nan] * len(COLUMNS)
    for k in range(len(COLUMNS)):
        rivals = [score.values[c, k] for c in order if scores.contenders[c] not in scores.bounds]
        known = np.array(rivals)[~np.isnan(rivals)]
        if known.size:
            best[k] = known.min() if low else known.max()
    rows = [["", "brain", "rank", *(column.name for column in COLUMNS)]]
    place = 0
    for k in order:
        cells = [cell(v, low, v == best[c]) for c, v in enumerate(score.values[k])]
        name = scores.contenders[k]
        place += name not in scores.bounds
        rows.append(
            [
                str(place) if name not in scores.bounds else "",
                f"**{name}**" if name in marked else name,
                f"{score.ranks[k]:.1f}",
                *cells,
            ]
        )
    return _markdown(rows, left=2)


def cell(value: float, low: bool, best: bool = False) -> str:
    """A value as text: an error in three digits, a share in percent."""
    if np.isnan(value):
        return "–"
    text = f"{value:.4f}" if low else f"{100 * value:.1f}"
    return f"**{text}**" if best else text


def _costs(scores: Scores) -> str:
    rounds = float(np.mean([world["rounds"] for world in scores.worlds]))
    rows = [["brain", "memory", "message", "messages a round"]]
    for k in np.argsort(scores.costs["memory_bytes"], kind="stable"):
        memory, message, sent = (scores.costs[n][k] for n in ("memory_bytes", "message_bytes", "messages_sent"))
        rows.append([scores.contenders[k], f"{memory:.0f}", f"{message:.0f}", f"{sent / rounds:.3g}"])
    return _markdown(rows, left=1)


def _losses(brain: Losses) -> str:
    low = brain.low
    lines = [
        f"## Where {brain.name} loses",
        f"{brain.name} is number {brain.place} of {brain.of}. It is first in "
        f"{sum(b.place == 1 for b in brain.columns)} of {len(brain.columns)} kinds of worlds. "
        "Kinds of worlds, the largest loss first:",
    ]
    rows = [["kind of world", "place", "its own", "best other's", "best other"]]
    rows += [
        [b.column, f"{b.place} of {b.of}", cell(b.value, low), cell(b.best_value, low), b.best] for b in brain.columns
    ]
    lines.append(_markdown(rows, left=1))
    lines.append("Single worlds with the largest losses:")
    rows = [["world", "place", "its own", "best other's", "best other"]]
    rows += [[t, f"{b.place} of {b.of}", cell(b.value, low), cell(b.best_value, low), b.best] for t, b in brain.worlds]
    lines.append(_markdown(rows, left=1))
    ahead = "; ".join(
        f"{rival.name} (better in {rival.better:.0%}, worse in {rival.worse:.0%} of trials, p {p_value(rival.p)})"
        for rival in brain.rivals[:FEW]
    )
    more = f"; and {len(brain.rivals) - FEW} more" if len(brain.rivals) > FEW else ""
    lines.append(
        "Significantly better over all worlds, compared trial by trial (Wilcoxon signed-rank test, corrected by Holm's "
        f"method): {ahead or 'none'}{more}."
    )
    return "\n\n".join(lines)


def _markdown(rows: Sequence[Sequence[str]], left: int) -> str:
    head, *body = rows
    rule = [":--" if k < left else "--:" for k in range(len(head))]
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, rule, *body))
