"""Take the leaderboard's numbers over to the pages that quote them: `python benchmarks/boards.py FOLDER`.

FOLDER is where `swarmcensus leaderboard --out FOLDER` writes, if it has not. Its page becomes docs/leaderboard.md,
cells of tables in docs/which-brain.md are replaced by those of the same brain and column, and the example's brain is
put beside in FOLDER for docs/your-brain-on-the-leaderboard.md. The words around them stay:
tests/docs/test_which_brain.py says which of them are right no more.
"""

import contextlib
import io
import os
import re
import shutil
import sys
from pathlib import Path

from swarmcensus.cli.commands import main

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PARTS = {"Errors of estimates": "error: ", "Right decisions on black or white": "right %: ", "Costs": ""}
TABLE = re.compile(r"(?:^\|.*\n)+", re.MULTILINE)


def cells(line):
    """The cells of a row of a table, without marks."""
    return [cell.strip(" *`") for cell in line.split("|")[1:-1]]


def values_of(page):
    """The value of each brain in each column of the page's boards, as it is printed; ranks are left out."""
    found = {}
    for title, prefix in PARTS.items():
        part = page.partition(f"## {title}\n")[2].partition("\n## ")[0]
        for table in TABLE.findall(part + "\n"):
            head, _, *body = table.splitlines()
            at = cells(head).index("brain")
            for row in map(cells, body):
                named = zip(cells(head)[at + 1 :], row[at + 1 :], strict=True)
                found |= {(row[at], prefix + name): value for name, value in named if name != "rank"}
    return found


def renewed(table, board):
    """A table of which each cell is the leaderboard's."""
    head, rule, *body = table.splitlines()
    columns = cells(head)[1:]
    for brain, *_ in map(cells, body):
        if (brain, columns[0]) not in board:
            sys.exit(f"docs/which-brain.md: {brain!r} has no {columns[0]!r} on the leaderboard")
    rows = [(brain, *(board[brain, column] for column in columns)) for brain, *_ in map(cells, body)]
    return "\n".join([head, rule, *(f"| {' | '.join(row)} |" for row in rows)]) + "\n"


def shown(printed):
    """The lines of the shell's board that the page shows."""
    lines = [line.rstrip() for line in printed.splitlines()]
    mine = next(k for k, line in enumerate(lines) if " my_brain.py " in line)
    gap = ["..."] if mine > 6 else []
    return "\n".join([*lines[:6], *gap, lines[mine], "...", lines[-2], "leaderboard/leaderboard.md"]) + "\n"


def renew(folder):
    """All three pages."""
    folder = Path(folder).resolve()
    with contextlib.redirect_stdout(io.StringIO()):  # its page may have a brain of somebody beside the shipped ones
        assert main(["leaderboard", "--out", str(folder)]) == 0
    for name in ("leaderboard.md", "leaderboard.png"):
        shutil.copy(folder / name, DOCS / name)
    board = values_of((DOCS / "leaderboard.md").read_text(encoding="utf-8"))
    advice = DOCS / "which-brain.md"
    text = advice.read_text(encoding="utf-8")
    advice.write_text(TABLE.sub(lambda found: renewed(found[0], board), text), encoding="utf-8")

    os.chdir(ROOT / "studies" / "example")
    os.environ["SWARMCENSUS_TERMINAL"] = "100"  # a table for people
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert main(["leaderboard", "my_brain.py", "--out", str(folder)]) == 0
    own = DOCS / "your-brain-on-the-leaderboard.md"
    text = own.read_text(encoding="utf-8")
    command = "$ swarmcensus leaderboard my_brain.py\n"
    before, _, after = text.partition(command)
    text = before + command + shown(printed.getvalue()) + "```" + after.partition("```")[2]
    losses = TABLE.search((folder / "leaderboard.md").read_text(encoding="utf-8"))
    own.write_text(TABLE.sub(lambda _: losses[0], text), encoding="utf-8")


if __name__ == "__main__":
    renew(sys.argv[1])
