"""The page that the leaderboard leaves: Markdown, so that it can stand in a repository."""

from collections.abc import Sequence

import numpy as np

from swarmcensus.basics.formatting import counted
from swarmcensus.basics.version import __version__
from swarmcensus.comparing.cells import p_value
from swarmcensus.leaderboard.losses import FEW, Losses
from swarmcensus.leaderboard.scores import COLUMNS, Score, Scores

TITLE = "# Leaderboard"


def page(scores: Scores, losses: Sequence[Losses], command: str, seed: int, trials: int, figure: str) -> str:
    """The whole page; `figure` is the picture's file, beside it."""
    marked = {one.name for one in losses}
    worlds, many = len(scores.worlds), counted(trials, "trial")
    parts = [
        TITLE,
        f"{len(scores.contenders):,} contenders in the same {worlds:,} worlds, {many} each, by `{command}` "
        f"(seed {seed}, swarmcensus {__version__}). All meet the same tiles, readings, neighbours, losses and liars, "
        "trial by trial. "
        "*Rank* is the average over all worlds and trials, 1 the best; below a kind of world stands the mean over its "
        "worlds. The best of a column is **bold**, the bound `oracle` aside: it hears all honest robots and knows all "
        "sensors, as no robot could, and has no place. `alone` talks to nobody and is ranked: one could use it.",
        _kinds(),
        *(_losses(one) for one in losses),
        "## How near estimates are",
        "The distance of a robot's last estimate from *f*, the median over robots and trials. Brains whose estimate is "
        "an opinion, black or white, are not in this table.",
        _table(scores, scores.error, marked),
        f"![Errors of all contenders by kind of world: dark is far from the truth]({figure})",
        "## Who is right about black or white",
        "The share of robots, in percent, whose last estimate is on the right side of one half. One that sits on it is "
        "wrong.",
        _table(scores, scores.side, marked),
        "## What they cost",
        "Bytes that a robot remembers and says, numbers having four, and messages a robot and round.",
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
        rivals = [score.values[one, k] for one in order if scores.contenders[one] not in scores.bounds]
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


def _losses(one: Losses) -> str:
    low = one.low
    lines = [
        f"## Where {one.name} loses",
        f"{one.name} is number {one.place} of {one.of}. It is first in {sum(b.place == 1 for b in one.columns)} of "
        f"{len(one.columns)} kinds of worlds. By kinds of worlds, the largest loss first:",
    ]
    rows = [["kind of world", "place", "its own", "best other's", "best other"]]
    rows += [
        [b.column, f"{b.place} of {b.of}", cell(b.value, low), cell(b.best_value, low), b.best] for b in one.columns
    ]
    lines.append(_markdown(rows, left=1))
    lines.append("Single worlds in which it is furthest behind:")
    rows = [["world", "place", "its own", "best other's", "best other"]]
    rows += [[t, f"{b.place} of {b.of}", cell(b.value, low), cell(b.best_value, low), b.best] for t, b in one.worlds]
    lines.append(_markdown(rows, left=1))
    ahead = "; ".join(
        f"{rival.name} (better in {rival.better:.0%}, worse in {rival.worse:.0%} of trials, p {p_value(rival.p)})"
        for rival in one.rivals[:FEW]
    )
    more = f"; and {len(one.rivals) - FEW} more" if len(one.rivals) > FEW else ""
    lines.append(
        "Ahead of it over all worlds, held against it trial by trial (Wilcoxon's signed ranks, corrected by Holm's "
        f"method): {ahead or 'nobody that could be told apart'}{more}."
    )
    return "\n\n".join(lines)


def _markdown(rows: Sequence[Sequence[str]], left: int) -> str:
    head, *body = rows
    rule = [":--" if k < left else "--:" for k in range(len(head))]
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, rule, *body))
