"""Take numbers over to the pages that quote them: python benchmarks/pages.py QUESTION."""

import contextlib
import csv
import io
import os
import re
from pathlib import Path

import harness
import numpy as np
from matplotlib.figure import Figure

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.figures.looks import NAMED
from swarmcensus.studies.study import Study
from swarmcensus.support.intervals import estimate

ROOT, DOCS = harness.ROOT, harness.DOCS
ROWS = ROOT / "src" / "swarmcensus" / "robots" / "formats.csv"
READINGS = (1_000, 10_000, 864_000)
TRUTH = 0.55
LEAST = 5e-5  # smaller errors are drawn there
FORMATS = {  # precision and message format, as columns call them
    "double": ("double", "double"), "single": ("single", "float32"), "float16": ("single", "float16"),
    "ratio16": ("single", "ratio16"), "ratio8": ("single", "ratio8"),
}  # fmt: skip
COLOURS = dict(zip(FORMATS, ("black", *NAMED), strict=False))
MARKS = {"double": "|", "single": "o", "float16": "X", "ratio16": "s", "ratio8": "D"}
PARTS = {"Errors of estimates": "error: ", "Right decisions on black or white": "right %: ", "Costs": ""}
LOSSES = re.compile(r"^\| board \| kind of world .*\n(?:\|.*\n)+", re.MULTILINE)


# ---- number formats


def errors_of(data, name, format_):
    """Errors of a brain's robots (checkpoint, trial, robot); for an opinion, whether it is wrong."""
    precision, message = FORMATS[format_]
    chosen = (data["brain"] == name) & (data["precision"] == precision) & (data["message"] == message)
    estimates = data["estimates"].isel(setting=int(np.flatnonzero(chosen.values)[0]))
    values = estimates.transpose("checkpoint", "trial", "robot").values
    return (values < 0.5) + 0.5 * (values == 0.5) if brains.load(name).is_opinion else np.abs(values - TRUTH)


def found(data, name, format_, checkpoint):
    """The median error, or an opinion's mean share of wrong robots, and its interval over trials."""
    values = errors_of(data, name, format_)[checkpoint]
    return estimate(values, "mean", share=True) if brains.load(name).is_opinion else estimate(values, "median")


def table(data, names, checkpoint):
    """One row a brain: a cell is marked where its interval lies wholly above twice the value in double precision."""
    out = [f"| brain | {' | '.join(FORMATS)} |", f"|---|{'--:|' * len(FORMATS)}"]
    for name in names:
        plain = found(data, name, "double", checkpoint)
        cells = []
        for format_ in FORMATS:
            one = found(data, name, format_, checkpoint)
            text = "fails" if np.isnan(one.value) else f"{one.value:.4f}"
            worse = text == "fails" or one.low > 2.0 * plain.value
            cells.append(f"**{text}**" if worse else text)
        out.append(f"| `{name}` | {' | '.join(cells)} |")
    return "\n".join(out)


def draw(data, names):
    """Errors after a day: a row for each brain, a mark with its interval for each format."""
    figure = Figure(figsize=(7.0, 0.24 * len(names) + 1.3), layout="constrained")
    axes = figure.add_subplot()
    for row, name in enumerate(names):
        for k, format_ in enumerate(FORMATS):
            one = found(data, name, format_, 2)
            y = row + 0.16 * (k - 2)
            axes.plot([max(one.low, LEAST), max(one.high, LEAST)], [y, y], color=COLOURS[format_], linewidth=0.8)
            label = {"double": "double precision", "single": "single, float32"}.get(format_, f"single, {format_}")
            axes.plot(max(one.value, LEAST), y, MARKS[format_], color=COLOURS[format_], markersize=4.5,
                      label=label if row == 0 else None)  # fmt: skip
        if row % 2:
            axes.axhspan(row - 0.5, row + 0.5, color="0.95", zorder=0)
    axes.set_xscale("log")
    axes.set_xlim(0.8 * LEAST, 0.8)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_yticks(range(len(names)), names, size=8)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("error after 864,000 readings, with its 95 % interval")
    figure.legend(loc="outside upper center", ncols=5, frameon=False, fontsize=8, handletextpad=0.2)
    return figure


def tables_of(data):
    """The text between the comments of the page."""
    names = [str(name) for name in dict.fromkeys(data["brain"].values)]
    opinions = [name for name in names if brains.load(name).is_opinion]
    names = sorted((n for n in names if n not in opinions), key=lambda n: found(data, n, "double", 2).value)
    parts = []
    for checkpoint, readings in enumerate(READINGS):
        parts.append(f"### Errors after {readings:,} readings\n\n{table(data, names, checkpoint)}")
    parts.append(f"### Share of wrong opinions after 864,000 readings\n\n{table(data, opinions, 2)}")
    return "\n\n".join(parts[2:3] + parts[:2] + parts[3:]), names


def write_rows(data):
    """All values with the ends of their 95 % intervals."""
    with ROWS.open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("brain", "format", "readings", "error", "low", "high"))
        for name in dict.fromkeys(map(str, data["brain"].values)):
            for format_ in FORMATS:
                for checkpoint, readings in enumerate(READINGS):
                    ends = (f"{x:.6f}" for x in found(data, name, format_, checkpoint)[:3])
                    rows.writerow((name, format_, readings, *ends))


@harness.question(unasked=False)
def formats(results=None, write=False):
    """What number formats cost every shipped brain: the tables of docs/formats.md.

    RESULTS is what `swarmcensus run studies/formats.toml --out formats.nc` writes. Without it the study is run. With
    `write`, tables go into the page, all rows into src/swarmcensus/robots/formats.csv, which `swarmcensus deploy`
    reads, and the figure into docs/images/formats.png.
    """
    data = (
        sc.load(results)
        if results
        else sc.run(Study.load(ROOT / "studies" / "formats.toml").with_(trials=harness.trials(30)))
    )
    text, names = tables_of(data)
    print(text)
    if write:
        harness.write(DOCS / "formats.md", formats=text)
        write_rows(data)
        draw(data, names).savefig(DOCS / "images" / "formats.png", dpi=130)


# ---- the leaderboard


def cells(line):
    """The cells of a row of a table, without marks."""
    return [cell.strip(" *`") for cell in line.split("|")[1:-1]]


def values_of(page):
    """The value of each brain in each column of all boards of a page that `swarmcensus leaderboard` wrote."""
    found, prefix, board, head = {}, None, "", []
    for line in page.splitlines():
        if line.startswith("## "):
            prefix = PARTS.get(line.removeprefix("## "))
        elif line.startswith("### "):
            board = line.split()[-1].lower().replace("robots", "honest").replace("changes", "change")
        elif prefix is not None and line.startswith("|"):
            row = cells(line)
            head = row if "brain" in row else head
            for name, value in zip(head, row, strict=True):
                if row is not head and name not in ("", "brain") and not row[-1].endswith("--:"):
                    column = f"{name} ({board})" if name == "rank" else name
                    found[row[head.index("brain")], prefix + column] = value
    return found


def shown(printed):
    """The lines of the shell's board that the page shows."""
    lines = [line.rstrip() for line in printed.splitlines()]
    mine = next(k for k, line in enumerate(lines) if " my_brain.py " in line)
    gap = ["..."] if mine > 6 else []
    return "\n".join([*lines[:6], *gap, lines[mine], "...", lines[-2], "leaderboard/leaderboard.md"]) + "\n"


@harness.question(unasked=False)
def boards(folder):
    """The leaderboard's numbers, in all pages that quote them.

    FOLDER is where `swarmcensus leaderboard --out FOLDER` writes, if it has not. The tables of its page become
    benchmarks/tables/leaderboard.csv, from which pages take theirs, and the example's brain joins in FOLDER for the
    last part of docs/leaderboard.md. The words of the pages stay: tests/docs/test_which_brain.py says which of them
    are no longer right.
    """
    folder = Path(folder).resolve()
    with contextlib.redirect_stdout(io.StringIO()):  # its page may have a brain of somebody beside the shipped ones
        assert main(["leaderboard", "--out", str(folder)]) == 0
    board = values_of((folder / "leaderboard.md").read_text(encoding="utf-8"))
    names, columns = (list(dict.fromkeys(part)) for part in zip(*board, strict=True))
    harness.write_csv(
        "leaderboard",
        ["brain", *columns],
        [[name, *(board.get((name, column), "") for column in columns)] for name in names],
    )

    os.chdir(ROOT / "studies" / "example")
    os.environ["SWARMCENSUS_TERMINAL"] = "100"  # a table for people
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert main(["leaderboard", "my_brain.py", "--out", str(folder)]) == 0
    own = DOCS / "leaderboard.md"
    text = own.read_text(encoding="utf-8")
    command = "$ swarmcensus leaderboard my_brain.py\n"
    before, _, after = text.partition(command)
    text = before + command + shown(printed.getvalue()) + "```" + after.partition("```")[2]
    [losses] = re.findall(LOSSES, (folder / "leaderboard.md").read_text(encoding="utf-8"))
    own.write_text(re.sub(LOSSES, lambda _: losses, text), encoding="utf-8")


if __name__ == "__main__":
    harness.answer(globals())
