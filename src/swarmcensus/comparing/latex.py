r"""A comparison as a LaTeX table (package booktabs), to be included in a paper by \input."""

from pathlib import Path

from swarmcensus.basics.files import atomic_write
from swarmcensus.comparing.cells import MARKS, Cell, columns, legend, rows_of
from swarmcensus.comparing.standings import Standings
from swarmcensus.results.summaries import is_idle

ESCAPED = {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}",
    ">": r"\textgreater{}", "|": r"\textbar{}", **{mark: f"\\{mark}" for mark in "&%$#_{}"},
}  # fmt: skip


def escaped(text: str) -> str:
    """Text with LaTeX's special characters escaped."""
    return "".join(ESCAPED.get(letter, letter) for letter in " ".join(text.split()))


def latex(standings: Standings, worlds: int | None = None) -> str:
    """The table of the first `worlds` worlds, by default of all: a row for each world and contender.

    Marks are those of the terminal; the best, or better, values are bold. A comment explains them, for the caption.
    """
    worlds = len(standings.field.worlds) if worlds is None else worlds
    world, contender = rows_of(standings, worlds)
    names = list(standings.field.worlds[0])
    cells = columns(standings, worlds)
    heads = [*map(escaped, (*names, "contender")), *(escaped(head).replace(r"\%", r"(\%)") for head in cells)]
    lines = [
        f"% {len(standings.field.worlds):,} worlds, {len(standings.contenders):,} contenders: "
        f"{' '.join(standings.title.split())}",
        f"% {' '.join(legend(standings).split())}",
        rf"\begin{{tabular}}{{{'l' * (len(names) + 1)}{'r' * len(cells)}}}", r"\toprule",
        " & ".join(heads) + r" \\", r"\midrule",
    ]  # fmt: skip
    before = None
    for row, (w, c) in enumerate(zip(world.tolist(), contender.tolist(), strict=True)):
        if before not in (None, w):
            lines.append(r"\addlinespace")
        texts = ("--" if is_idle(value) else escaped(str(value)) for value in map(standings.field.worlds[w].get, names))
        shown = [text if w != before else "" for text in texts]
        lines.append(
            " & ".join([*shown, escaped(standings.contenders[c]), *(_cell(column[row]) for column in cells.values())])
            + r" \\"
        )
        before = w
    lines += [r"\bottomrule", r"\end{tabular}"]
    return "\n".join(lines) + "\n"


def write_latex(standings: Standings, path: str | Path) -> None:
    """Write the table of all worlds, whole or not at all. Raises InputError."""
    with atomic_write(path) as temporary:
        temporary.write_text(latex(standings), encoding="utf-8")


def _cell(cell: Cell) -> str:
    value = escaped(cell.value).replace("-", "$-$") if cell.value != "-" else "--"
    strong = rf"\textbf{{{value}}}" if cell.standing in ("best", "better") else value
    value = rf"{strong}$^{{{MARKS[cell.standing]}}}$" if cell.standing in MARKS else value
    lacks = cell.interval in ("", "-")
    return value if lacks else f"{value} {{\\footnotesize {escaped(cell.interval).replace('-', '$-$')}}}"
