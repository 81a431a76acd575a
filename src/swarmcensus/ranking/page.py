"""The page of the leaderboard, in Markdown, so that a repository can show it."""

from collections.abc import Sequence

import numpy as np

from swarmcensus.basics.formatting import counted
from swarmcensus.basics.printed_tables import Column, Table, markdown
from swarmcensus.basics.version import __version__
from swarmcensus.comparing.cells import p_value
from swarmcensus.ranking.losses import FEW, Behind, Losses
from swarmcensus.ranking.scores import Score, Scores

TITLE = "# Leaderboard"


def page(
    boards: Sequence[Scores], losses: Sequence[Sequence[Losses]], command: str, seed: int, trials: int, figure: str
) -> str:
    """The whole page, from the scores and losses of each board; `figure` is the picture's file name."""
    own = [loss.name for loss in losses[0]]
    marked = set(own)
    contenders = len(boards[0].contenders)
    parts = [
        TITLE,
        f"{contenders:,} contenders in the same worlds, {counted(trials, 'trial')} each, by `{command}` "
        f"(seed {seed}, swarmcensus {__version__}). All have the same tiles, readings, neighbours, losses and liars, "
        "trial by trial. Each board has worlds of its own: a brain for honest robots need not bear liars, and few "
        "brains follow a floor that changes. *Rank* is the average over all worlds and trials of a board, 1 is best; "
        "the column of a kind of world has the mean over its worlds. The best of a column is **bold**. `oracle` is a "
        "bound and has no place: it hears all honest robots and knows all sensors and when the floor changes, which no "
        "robot can. `alone` communicates with nobody and is ranked, because a robot can run it.",
        "\n".join(_meaning(scores) for scores in boards),
        *(_losses(name, [loss for board in losses for loss in board if loss.name == name], boards) for name in own),
        "## Errors of estimates",
        "The distance of a robot's last estimate from *f*, median over robots and trials. Brains whose estimate is "
        "an opinion, black or white, are left out.",
        *_tables(boards, "error", marked),
        f"![Errors of all contenders by kind of world: dark means a large error]({figure})",
        "## Right decisions on black or white",
        "The percentage of robots whose last estimate is on the right side of one half. An estimate of exactly one "
        "half is wrong.",
        *_tables(boards, "side", marked),
        "## Costs",
        "Bytes of memory and of a message, with four bytes per number, and messages per robot and round.",
        _costs(boards[0]),
    ]
    return "\n\n".join(parts) + "\n"


def _meaning(scores: Scores) -> str:
    """A board in the list of boards, with its kinds of worlds."""
    division = scores.division
    kinds = "; ".join(f"*{column.name}*: {column.meaning}" for column in division.columns)
    return f"- **{division.title}** ({counted(len(scores.worlds), 'world')}): {division.meaning}. {kinds}"


def _tables(boards: Sequence[Scores], measure: str, marked: set[str]) -> list[str]:
    """A heading and a table for each board."""
    parts = []
    for scores in boards:
        parts += [f"### {scores.division.title}", _table(scores, getattr(scores, measure), marked)]
    return parts


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


def _losses(name: str, losses: Sequence[Losses], boards: Sequence[Scores]) -> str:
    """Where a brain loses: all kinds of worlds, then single worlds and rivals by board."""
    lines = [f"## Where {name} loses", "Kinds of worlds, the largest loss of each board first:"]
    values = dict.fromkeys(("place", "its own", "best other's", "best other"), True)
    rows = [[loss.board, b.column, *_behind(b, loss.low)] for loss in losses for b in loss.columns]
    lines.append(markdown(Table.of_rows({"board": False, "kind of world": False} | values, rows)))
    for brain, scores in zip(losses, boards, strict=True):
        lines.append(f"### {scores.division.title}: {name}")
        lines.append(f"{name} is number {brain.place} of {brain.of}. Single worlds with the largest losses:")
        rows = [[text, *_behind(b, brain.low)] for text, b in brain.worlds]
        lines.append(markdown(Table.of_rows({"world": False} | values, rows)))
        ahead = "; ".join(
            f"{rival.name} (better in {rival.better:.0%}, worse in {rival.worse:.0%} of trials, p {p_value(rival.p)})"
            for rival in brain.rivals[:FEW]
        )
        more = f"; and {len(brain.rivals) - FEW} more" if len(brain.rivals) > FEW else ""
        lines.append(
            "Significantly better over these worlds, compared trial by trial (Wilcoxon signed-rank test, corrected by "
            f"Holm's method): {ahead or 'none'}{more}."
        )
    return "\n\n".join(lines)


def _behind(behind: Behind, low: bool) -> list[str]:
    """Place, own value, and value and name of the best other brain, as cells."""
    place = f"{behind.place} of {behind.of}"
    return [place, cell(behind.value, low), cell(behind.best_value, low), behind.best]
