"""The page of the leaderboard, in Markdown, so that a repository can show it."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from swarmcensus.analysis import p_value
from swarmcensus.evaluation.ranking.losses import FEW, Behind, Losses
from swarmcensus.evaluation.ranking.scores import Score, Scores
from swarmcensus.support.formatting import counted
from swarmcensus.support.printed_tables import Column, Table, markdown
from swarmcensus.support.templates import render
from swarmcensus.support.version import __version__

TITLE = "# Leaderboard"
TAIL = "90 % within"
VALUES = dict.fromkeys(("place", "its own", "best other's", "best other"), True)  # columns of losses


def page(
    boards: Sequence[Scores],
    losses: Sequence[Sequence[Losses]],
    cautions: Sequence[str],
    command: str,
    seed: int,
    trials: int,
    figure: str,
) -> str:
    """The whole page, from the scores and losses of each board; `figure` is the picture's file name."""
    own = [loss.name for loss in losses[0]]
    text = render(
        Path(__file__).with_name("page.md.jinja"),
        title=TITLE,
        contenders=f"{len(boards[0].contenders):,}",
        trials=trials,
        command=command,
        seed=seed,
        version=__version__,
        boards=boards,
        own=[(name, [loss for board in losses for loss in board if loss.name == name]) for name in own],
        figure=figure,
        cautions=cautions,
        tail=TAIL,
        table=lambda scores, score: _table(scores, score, {*own}),
        costs=_costs(boards[0]),
        losses_by_kind=_by_kind,
        losses_by_world=_by_world,
        rivals=_rivals,
        counted=counted,
    )
    return text + "\n"


def _table(scores: Scores, score: Score, marked: set[str]) -> str:
    low, columns = score is scores.error, scores.division.columns
    order = score.order
    best = [np.nan] * len(columns)
    for k in range(len(columns)):
        rivals = [score.values[c, k] for c in order if scores.contenders[c] not in scores.bounds]
        known = np.array(rivals)[~np.isnan(rivals)]
        if known.size:
            best[k] = known.min() if low else known.max()
    places = np.cumsum([scores.contenders[k] not in scores.bounds for k in order]).tolist()
    names = [scores.contenders[k] for k in order]
    return markdown(Table([
        Column("", ["" if n in scores.bounds else str(p) for n, p in zip(names, places, strict=True)], number=False),
        Column("brain", names, number=False, strong=[name in marked for name in names]),
        Column("rank", [f"{score.ranks[k]:.1f}" for k in order]),
        *[Column(TAIL, [cell(scores.tail[k], True) for k in order])] * low,
        *(
            Column(column.name, [cell(score.values[k, c], low) for k in order],
                   strong=[score.values[k, c] == best[c] for k in order])
            for c, column in enumerate(columns)
        ),
    ]))  # fmt: skip


def cell(value: float, low: bool) -> str:
    """A value as text: an error in three digits, a share in percent."""
    return "–" if np.isnan(value) else f"{value:.4f}" if low else f"{100 * value:.1f}"


def _costs(scores: Scores) -> str:
    rounds = float(np.mean([world["rounds"] for world in scores.worlds]))
    rows = []
    for k in np.argsort(scores.costs["memory_bytes"], kind="stable"):
        memory, message, sent = (scores.costs[n][k] for n in ("memory_bytes", "message_bytes", "messages_sent"))
        rows.append([scores.contenders[k], f"{memory:.0f}", f"{message:.0f}", f"{sent / rounds:.3g}"])
    heads = {"brain": False} | dict.fromkeys(("memory", "message", "messages a round"), True)
    return markdown(Table.of_rows(heads, rows))


def _by_kind(losses: Sequence[Losses]) -> str:
    """Where a brain loses, in all kinds of worlds of all boards."""
    rows = [[loss.board, b.column, *_behind(b, loss.low)] for loss in losses for b in loss.columns]
    return markdown(Table.of_rows({"board": False, "kind of world": False} | VALUES, rows))


def _by_world(loss: Losses) -> str:
    """The single worlds of a board in which a brain loses most."""
    return markdown(Table.of_rows({"world": False} | VALUES, [[w, *_behind(b, loss.low)] for w, b in loss.worlds]))


def _rivals(loss: Losses) -> str:
    """The brains that are better over the worlds of a board."""
    ahead = [
        f"{rival.name} (better in {rival.better:.0%}, worse in {rival.worse:.0%} of trials, p {p_value(rival.p)})"
        for rival in loss.rivals[:FEW]
    ]
    more = [f"and {len(loss.rivals) - FEW} more"] * (len(loss.rivals) > FEW)
    return "; ".join([*ahead, *more]) or "none"


def _behind(behind: Behind, low: bool) -> list[str]:
    """Place, own value, and value and name of the best other brain, as cells."""
    place = f"{behind.place} of {behind.of}"
    return [place, cell(behind.value, low), cell(behind.best_value, low), behind.best]
