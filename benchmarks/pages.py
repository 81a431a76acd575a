"""Take numbers over to the pages that quote them: python benchmarks/pages.py QUESTION."""

import contextlib
import csv
import io
import os
from pathlib import Path

import harness
import numpy as np

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.cli.commands import main
from swarmcensus.studies.study import Study
from swarmcensus.support.intervals import estimate

ROOT, DOCS = harness.ROOT, harness.DOCS
ROWS = ROOT / "src" / "swarmcensus" / "robots" / "formats.csv"
READINGS = (1_000, 10_000, 864_000)
TRUTH = 0.55
FORMATS = {  # precision and message format, as columns call them
    "double": ("double", "double"), "single": ("single", "float32"), "float16": ("single", "float16"),
    "ratio16": ("single", "ratio16"), "ratio8": ("single", "ratio8"),
}  # fmt: skip
COSTS = ("memory", "message", "messages a round")


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


def rows_of(data, names, checkpoint):
    """One row a brain; the last cell has the formats whose intervals lie wholly above twice double precision."""
    for name in names:
        every = [found(data, name, format_, checkpoint) for format_ in FORMATS]
        worse = [f for f, one in zip(FORMATS, every, strict=True) if not one.low <= 2.0 * every[0].value]
        cells = ["fails" if np.isnan(one.value) else f"{one.value:.4f}" for one in every]
        measure = "share of wrong opinions" if brains.load(name).is_opinion else "error"
        yield [name, str(READINGS[checkpoint]), measure, *cells, ", ".join(worse)]


def table_of(data):
    """Rows after a day, the least error first, then after shorter times, then of opinions after a day."""
    names = [str(name) for name in dict.fromkeys(data["brain"].values)]
    opinions = [name for name in names if brains.load(name).is_opinion]
    names = sorted((n for n in names if n not in opinions), key=lambda n: found(data, n, "double", 2).value)
    parts = ((names, 2), (names, 0), (names, 1), (opinions, 2))
    return [row for part, checkpoint in parts for row in rows_of(data, part, checkpoint)]


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
    """What number formats cost every shipped brain.

    RESULTS is what `swarmcensus run studies/formats.toml --out formats.nc` writes. Without it the study is run. With
    `write`, the table goes into benchmarks/tables/number-formats.csv, and all rows with intervals into
    src/swarmcensus/robots/formats.csv, which `swarmcensus deploy` reads.
    """
    data = (
        sc.load(results)
        if results
        else sc.run(Study.load(ROOT / "studies" / "formats.toml").with_(trials=harness.trials(30)))
    )
    heads, rows = ["brain", "readings", "measure", *FORMATS, "more than doubled"], table_of(data)
    print(harness.markdown(heads, rows))
    if write:
        harness.write_csv("number-formats", heads, rows)
    if write and not harness.IS_QUICK:
        write_rows(data)


# ---- the leaderboard


def answers_of(folder, files=(), groups=("honest", "liars", "change"), **more):
    """The leaderboard of each group, of the results in `folder`."""
    quiet = {"say": lambda _: None, "progress": False}
    return [sc.leaderboard(files, folder, group=group, **quiet, **more) for group in groups]


def values_of(answers):
    """The value of each brain in each column of these leaderboards."""
    found = {}
    for answer in answers:
        for column in answer.tables(0)[0].columns[2:]:
            name = "" if column.head in COSTS or column.head.startswith("right %") else "error: "
            name += column.head + f" ({answer.group})" * (column.head in ("rank", "90 %"))
            if column.head not in ("error", "right %"):
                cells = [cell.strip("–") for cell in column.cells]  # nothing where there is no error
                found |= {(row["brain"], name): cell for row, cell in zip(answer.rows, cells, strict=True)}
    return found


def shown(printed, folder):
    """The lines of the shell's board that the page shows."""
    lines = [line.rstrip() for line in printed.splitlines()]
    lines[-2:] = ["leaderboard" + line.partition(folder)[2] for line in lines[-2:]]
    first = lines.index("") + 1  # of the table, below what was found
    table = lines[first:]
    mine = next(k for k, line in enumerate(table) if " my_brain.py " in line)
    gap = ["..."] if mine > 5 else []
    return "\n".join([*lines[:2], "...", *table[:5], *gap, table[mine], "...", *lines[-2:]]) + "\n"


@harness.question(unasked=False)
def boards(folder):
    """The leaderboard's numbers, in all pages that quote them.

    FOLDER is where `swarmcensus leaderboard --out FOLDER` writes, if it has not. The tables of all groups become
    benchmarks/tables/leaderboard.csv, from which pages take theirs, and the example's brain joins in FOLDER for the
    last part of docs/leaderboard.md. The words of the pages stay: tests/docs/test_which_brain.py says which of them
    are no longer right.
    """
    folder = Path(folder).resolve()
    asked = ["leaderboard", "--out", str(folder), *(["--trials", "1"] if harness.IS_QUICK else [])]
    with contextlib.redirect_stdout(io.StringIO()):  # its page may have a brain of somebody beside the shipped ones
        assert main(asked) == 0
    more = {"set": {"trials": 1}} if harness.IS_QUICK else {}
    board = values_of(answers_of(folder, **more))
    names, columns = (list(dict.fromkeys(part)) for part in zip(*board, strict=True))
    harness.write_csv(
        "leaderboard",
        ["brain", *columns],
        [[name, *(board.get((name, column), "") for column in columns)] for name in names],
    )

    os.chdir(ROOT / "studies" / "example")
    os.environ["SWARMCENSUS_TERMINAL"] = "100"  # a table for people
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert main([*asked, "my_brain.py"]) == 0
    own = DOCS / "leaderboard.md"
    text = own.read_text(encoding="utf-8")
    command = "$ swarmcensus leaderboard my_brain.py\n"
    before, _, after = text.partition(command)
    text = before + command + shown(printed.getvalue(), str(folder)) + "```" + after.partition("```")[2]
    if not harness.IS_QUICK:
        own.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    harness.answer(globals())
