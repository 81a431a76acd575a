"""What all benchmarks share: questions from the shell, timing in turn, processes, tables, and figures.

A benchmark is a file of functions that are marked as a `question`. `python benchmarks/FILE.py QUESTION` answers one,
and without a name it answers all that do not say otherwise; a file's only question needs no name. Parameters of the
function are its options. `--quick` asks for an answer in seconds, whose last digits count for less: of few `trials`,
and of less where a function takes `quick`.
"""

import argparse
import csv
import inspect
import io
import os
import runpy
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from PIL import Image
from rich.console import Console
from rich.table import Column, Table

from swarmcensus.figures.axes import short
from swarmcensus.figures.styles import looks_of
from swarmcensus.support.intervals import estimate

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
GO = np.zeros(1, np.uint8)  # nobody stops the engine
IS_QUICK = False

# ---- questions


def question(function=None, *, unasked=True):
    """Mark a function as a question; one that is not answered `unasked` has to be named."""
    if function is None:
        return lambda it: question(it, unasked=unasked)
    function.unasked = unasked
    return function


def trials(number):
    """So many trials, or few with `--quick`."""
    return min(number, 6) if IS_QUICK else number


def few(values):
    """These values, or the first one with `--quick`: each of them may take seconds to compile."""
    return values[:1] if IS_QUICK else values


def answer(module):
    """Answer what the command line asks of a benchmark, given its names."""
    global IS_QUICK
    questions = {name: it for name, it in module.items() if hasattr(it, "unasked")}
    parser = argparse.ArgumentParser(description=module["__doc__"], formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer trials")
    below = parser.add_subparsers(dest="question", metavar="QUESTION")
    for name, it in questions.items():
        about = inspect.getdoc(it) or ""
        one = below.add_parser(name, help=about.partition("\n")[0].replace("%", "%%"), description=about)
        if "quick" not in inspect.signature(it).parameters:
            one.add_argument("--quick", action="store_true", default=argparse.SUPPRESS)
        for key, given in inspect.signature(it).parameters.items():
            if given.kind is given.VAR_POSITIONAL:
                one.add_argument(key, nargs="*", metavar=key.upper())
            elif given.default is given.empty:
                one.add_argument(key, metavar=key.upper())
            elif given.default is False:
                one.add_argument(f"--{key}", action="store_true", default=argparse.SUPPRESS)
            else:
                kind = str if given.default is None else type(given.default)
                one.add_argument(f"--{key}", type=kind, default=argparse.SUPPRESS, metavar=key.upper())
    words = sys.argv[1:]
    if len(questions) == 1 and words[:1] != [*questions]:  # the only question needs no name
        words = [*questions, *words]
    options = vars(parser.parse_args(words))
    name, IS_QUICK = options.pop("question"), options.pop("quick")
    for it in [questions[name]] if name else [it for it in questions.values() if it.unasked]:
        takes = inspect.signature(it).parameters
        given = {key: value for key, value in options.items() if takes[key].kind is not takes[key].VAR_POSITIONAL}
        more = [word for key, value in options.items() if key not in given for word in value]
        ahead = [given.pop(key) for key, one in takes.items() if key in given and one.default is one.empty]
        it(*ahead, *more, **given | ({"quick": True} if IS_QUICK and "quick" in takes else {}))


# ---- timing


def in_turn(functions, repeats, clock=time.perf_counter):
    """Seconds of each call (repeat, function): one after the other, as the speed of a machine varies with time."""
    spent = np.empty((repeats, len(functions)))
    for row in spent:
        for k, function in enumerate(functions):
            begun = clock()
            function()
            row[k] = clock() - begun
    return spent


def least(functions, repeats, clock=time.perf_counter):
    """The least seconds of each: on a shared machine the others measure the neighbours."""
    return in_turn(functions, repeats, clock).min(axis=0)


def ratio(one, other, repeats, clock=time.perf_counter):
    """The seconds of one as a multiple of another's: the median of the repeats' ratios, and its 95 % interval."""
    spent = in_turn([other, one], repeats + 1, clock)[1:]  # the first compiles
    return estimate((spent[:, 1] / spent[:, 0])[:, np.newaxis], "median")


class Spent(NamedTuple):
    """What a process took, and what it printed."""

    seconds: float
    processor: float  # seconds
    memory: float  # bytes at the peak
    out: str


def process(*words, code=0, cache=None):
    """Run Python with these words in a process; `cache` is where compiled code is kept."""
    environment = os.environ | ({"SWARMCENSUS_CACHE": str(cache)} if cache else {})
    begun = time.perf_counter()
    command = [sys.executable, *map(str, words)]
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment, text=True)
    with running.stdout:
        out = running.stdout.read()
    _, status, used = os.wait4(running.pid, 0)
    seconds = time.perf_counter() - begun
    running.returncode = os.waitstatus_to_exitcode(status)
    if running.returncode != code:
        sys.exit(f"{' '.join(command)} ended with {running.returncode}: {out}")
    unit = 1 if sys.platform == "darwin" else 1024
    return Spent(seconds, used.ru_utime + used.ru_stime, used.ru_maxrss * unit, out)


def program(*words, **more):
    """The same with `swarmcensus`."""
    return process("-m", "swarmcensus", *words, **more)


# ---- tables


def table(title, *heads):
    """A table whose columns after the first hold numbers."""
    return Table(*heads[:1], *(Column(head, justify="right") for head in heads[1:]), title=title, title_justify="left")


def show(what, width=110):
    """Print a table or a line."""
    Console(width=width, highlight=False).print(what)


def markdown(heads, rows):
    """Lines of a table in Markdown."""
    rule = "|".join(["---", *["--:"] * (len(heads) - 1)])
    return "\n".join([f"| {' | '.join(heads)} |", f"|{rule}|", *(f"| {' | '.join(row)} |" for row in rows)])


def write_csv(name, heads, rows):
    """Write benchmarks/tables/NAME.csv, and renew what pages show of it; `--quick` measures too little for that."""
    if IS_QUICK:
        return show(f"with --quick, {name}.csv stays as it is")
    with (ROOT / "benchmarks" / "tables" / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([heads, *rows])
    runpy.run_path(str(ROOT / "docs_hooks" / "tables.py"), run_name="__main__")


# ---- figures


def panels(rows, columns, width, height):
    """A figure without frames, and its axes one after the other."""
    matplotlib.use("agg")
    plt.rcParams |= {"font.size": 9, "axes.titlesize": 9, "axes.titlelocation": "left"}
    figure, axes = plt.subplots(
        rows, columns, figsize=(width, height), layout="constrained", sharex=True, sharey=True, squeeze=False
    )
    for one in axes.flat:
        one.spines[["top", "right"]].set_visible(False)
    return figure, axes.flat


def looks(brains):
    """The name, colour and marker of each brain, as in all figures."""
    return [*looks_of(brains, "o", "brain").values()]


def line_of(look):
    """How a line with the marks of a brain is drawn, as in all figures."""
    return {"color": look.colour, "marker": look.marker, "ms": 5, "mec": "black", "mew": 0.5, "lw": 1.6}


def decimals(axis, steps=(1.0,)):
    """Label a logarithmic axis with decimal numbers at these multiples of powers of ten."""
    axis.set_major_locator(LogLocator(subs=steps))
    axis.set_major_formatter(FuncFormatter(lambda value, _: short(value)))
    axis.set_minor_formatter(NullFormatter())


def save(figure, path, names, handles):
    """With one key below all panels."""
    figure.legend(handles, names, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    write_small(figure, path)


def write_small(figure, path):
    """Write a picture for a page: few pixels and few colours."""
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=120, format="png")
    Image.open(drawn).convert("RGB").quantize(64, dither=Image.Dither.NONE).save(path, "png", optimize=True)
