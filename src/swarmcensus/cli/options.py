"""The options of every command of the command line."""

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from swarmcensus.basics.version import __version__
from swarmcensus.cli.common_options import Parser, add_output_options
from swarmcensus.cli.comparison_options import add_compare_options
from swarmcensus.cli.mission_options import add_plan_options
from swarmcensus.cli.starting_options import (
    add_completion_options,
    add_new_options,
    add_studies_options,
)
from swarmcensus.cli.watching_options import add_watch_options

DOORS = {
    "brains": "brains.brain", "adversaries": "brains.adversary", "metrics": "metrics.metric",
    "topologies": "worlds.wiring", "floors": "worlds.patterns", "spreads": "worlds.spreading",
    "figures": "figures.kinds",
}  # fmt: skip  # what is added by files, and where its door is
DIGITS = 18  # of a number, so that it fits into 64 bits
MOST_ROWS = 40  # of a summary, unless one asks for more


def parser(runs: Mapping[str, Callable[[argparse.Namespace], int]]) -> argparse.ArgumentParser:
    """All commands and their options; `runs` is what a command of each name calls."""
    top = Parser(
        prog="swarmcensus",
        description="Robot swarms with lying sensors agree on how much of a floor is black.",
        epilog="'swarmcensus COMMAND --help' tells more. Begin with: swarmcensus reproduce",
    )
    top.add_argument("--version", action="version", version=f"swarmcensus {__version__}")
    commands = top.add_subparsers(title="commands", metavar="COMMAND", required=True)

    def command(name: str, text: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=text, description=text)
        sub.set_defaults(run=runs[name])
        return sub

    sub = command("reproduce", "Run the paper's evaluation; draw its figures; check its claims.")
    sub.add_argument(
        "of",
        nargs="?",
        default="paper",
        metavar="WHAT",
        help="paper (default), or rivals: what is known of them",
    )
    sub.add_argument("--out", type=Path, help="folder to write (default: reproduction, or reproduction-rivals)")
    sub.add_argument("--only", nargs="+", metavar="PART", help="such as fig2, fig3, fig4, fig5 or claims")
    _add_run_options(sub)

    sub = command("run", "Run a study file; write its results as netCDF.")
    sub.add_argument("study", type=Path, metavar="STUDY.toml")
    sub.add_argument("--out", type=Path, metavar="FILE.nc", help="default: the study file's name with .nc, here")
    _add_run_options(sub)
    sub.add_argument("--share", type=_share, metavar="K/N", help="run the K-th of N parts of the trials, to merge")
    sub.add_argument("--scheduler", metavar="ADDRESS", help="a running Dask scheduler, as tcp://host:8786")
    sub.add_argument("--cluster", metavar="WHERE", help="local:4 (processes here), or a TOML file (docs/clusters.md)")

    sub = command("show", "Print the summary of a results file: medians and right decisions, a row a setting.")
    sub.add_argument("results", type=Path, metavar="RESULTS.nc")
    sub.add_argument("--where", metavar="EXPR", help="settings to show, as 'topology == \"ring\" and robots == 100'")
    _add_measure_options(sub)
    sub.add_argument(
        "--checkpoint",
        type=_or_time,
        metavar="K",
        help="the round of 'right', or a time as '5 min' (default: the last)",
    )
    sub.add_argument("--sort", metavar="COLUMN", help="as error, right, K or fill_ratio (default: as stored)")
    sub.add_argument("--reverse", action="store_true", help="the other way round")
    sub.add_argument(
        "--limit", type=_from_zero, metavar="N", help=f"rows at the most, 0: all (default: {MOST_ROWS}; of --json all)"
    )

    sub = command("compare", "Rank brains within each world, paired trial by trial, and say what trials tell.")
    add_compare_options(sub, _from_zero, MOST_ROWS)

    sub = command(
        "explain", "Hold all settings against theory, or set what one measured beside it and say what limits it."
    )
    sub.add_argument("results", type=Path, metavar="RESULTS.nc")
    sub.add_argument("--setting", type=_from_zero, metavar="N", help="one, as 'show' numbers them (default: all)")
    sub.add_argument("--where", metavar="EXPR", help="settings to hold against theory, as 'topology == \"ring\"'")
    sub.add_argument("--limit", type=_from_zero, metavar="N", help=f"rows at the most, 0: all (default: {MOST_ROWS})")

    sub = command("leaderboard", "Run the shipped brains, and your own beside them, in one fixed set of worlds.")
    sub.add_argument("files", type=Path, nargs="*", metavar="FILE.py", help="a brain file of your own")
    sub.add_argument("--out", type=Path, default=Path("leaderboard"), help="folder to write (default: %(default)s)")
    _add_run_options(sub)

    sub = command("tune", "Search for good values of a brain's parameters, and evaluate them where the search was not.")
    sub.add_argument("study", type=Path, metavar="STUDY.toml")
    sub.add_argument("--brain", metavar="NAME", help="which of the study's brains, if several have parameters")
    sub.add_argument(
        "--parameters",
        nargs="+",
        required=True,
        metavar="NAME=LOW:HIGH",
        help="where to look, as prior=1:100, prior=1:100:log, k=1:9:whole, weights[0]=0:1",
    )
    sub.add_argument(
        "--metric",
        default="final_error",
        metavar="NAME",
        help="a measure as of compare, as correct, or my_metric:low (default: %(default)s)",
    )
    sub.add_argument(
        "--budget", default="200", metavar="N|TIME", help="evaluations, or a time as '10 min' (default: %(default)s)"
    )
    sub.add_argument(
        "--trials", type=_from_one, default=10, help="in each world of an evaluation (default: %(default)s)"
    )
    sub.add_argument("--seed", type=_from_zero, help="instead of the study's own")
    sub.add_argument("--jobs", type=_from_one, help="threads (default: one a core); the values do not depend on it")
    sub.add_argument("--out", type=Path, metavar="FILE.toml", help="default: the brain's name with -tuned.toml, here")
    sub.add_argument("--fresh", action="store_true", help="begin anew instead of going on with the log")

    sub = command("plan", "Say how many robots, or how many minutes, a mission needs.")
    add_plan_options(sub, _from_zero, _from_one)

    sub = command("status", "Say how far a study is that runs, or was cut off, and when it ends.")
    sub.add_argument("results", type=Path, metavar="RESULTS.nc")

    sub = command("merge", "Put results together whose settings or trials differ.")
    sub.add_argument("results", type=Path, nargs="+", metavar="RESULTS.nc")
    sub.add_argument("--out", type=Path, metavar="FILE.nc", required=True)
    sub.add_argument("--fresh", action="store_true", help="replace what --out holds, though it is not in the others")

    sub = command("verify", "Run trials of a results file again and compare them bit for bit.")
    sub.add_argument("results", type=Path, metavar="RESULTS.nc")
    which = sub.add_mutually_exclusive_group()
    which.add_argument(
        "--sample", type=float, default=0.01, metavar="SHARE", help="of the trials (default: %(default)s)"
    )
    which.add_argument("--all", action="store_true", help="every trial")
    sub.add_argument(
        "--brain", action="append", default=[], metavar="FILE", help="a brain or metric file, if any is used"
    )
    sub.add_argument("--seed", type=_from_zero, help="of the choice, to make the same one again")
    sub.add_argument("--jobs", type=_from_one, help="threads (default: one a core)")

    sub = command("plot", "Draw a results file.")
    sub.add_argument("results", type=Path, metavar="RESULTS.nc")
    sub.add_argument(
        "--kind",
        default="scatter",
        help="what to draw: lines, decisions, heatmap, curves, arena, ... (docs/plotting.md; default: %(default)s)",
    )
    sub.add_argument("--where", metavar="EXPR", help="settings to draw, as 'topology == \"ring\" and robots == 100'")
    sub.add_argument("--x", metavar="NAME", help="the coordinate along the x axis (lines, heatmap)")
    sub.add_argument("--y", metavar="NAME", help="the variable of lines, or the other coordinate of a heatmap")
    sub.add_argument("--color", metavar="NAME", help="the coordinate that colours tell apart (default: accuracy)")
    sub.add_argument(
        "--panels", type=_names, metavar="NAMES", help="coordinates with a panel for each value, as topology,robots"
    )
    sub.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="OPTION=VALUE",
        help="any other option of the kind, as scale=linear",
    )
    _add_measure_options(sub)
    sub.add_argument("--local", action="store_true", default=None, help="the local estimate instead (scatter)")
    sub.add_argument(
        "--theory", action="store_true", default=None, help="lay theory's curves over it (scatter, decisions, curves)"
    )
    sub.add_argument("--setting", type=int, help="the setting of curves, arena or film (default: the first)")
    sub.add_argument("--trial", type=int, help="the trial of curves, arena or film (default: 0)")
    sub.add_argument("--brain", metavar="FILE", help="the brain file, where the brain is one of your own")
    sub.add_argument(
        "--tick", type=_or_time, help="when the arena is drawn, a tick or a time as '1 min' (default: the last)"
    )
    sub.add_argument("--robot", type=_from_zero, help="whose radio range the arena shows (default: 0)")
    sub.add_argument("--first", type=_or_time, help="the tick, or time, that a film begins at (default: 1)")
    sub.add_argument("--last", type=_or_time, help="the tick, or time, that it ends at (default: 600 ticks)")
    sub.add_argument("--every", type=_from_one, help="ticks from frame to frame (default: 2)")
    sub.add_argument("--fps", type=_from_one, help="frames a second (default: 20)")
    sub.add_argument(
        "--out", type=Path, metavar="FILE", help="default: RESULTS-KIND.png and .svg (also .pdf), or .mp4 (also .gif)"
    )

    sub = command("export", "Write results as a table: one row a robot and trial.")
    sub.add_argument("results", type=Path, metavar="RESULTS.nc")
    sub.add_argument("--to", choices=("csv", "parquet"), help="default: as --out ends, else csv")
    sub.add_argument("--where", metavar="EXPR", help="settings to export, as 'accuracy == 0.675'")
    sub.add_argument("--delta", type=float, help="of convergence, asked anew of kept estimates")
    sub.add_argument("--out", type=Path, metavar="FILE", help="default: RESULTS.csv or .parquet, here")

    sub = command("replay", "Run one trial of a results file again and show every round of it.")
    sub.add_argument("results", type=Path, metavar="RESULTS.nc")
    sub.add_argument("--setting", type=int, required=True)
    sub.add_argument("--trial", type=int, required=True)
    sub.add_argument("--brain", metavar="FILE", help="the brain file, where the brain is one of your own")
    sub.add_argument("--out", type=Path, metavar="FILE.nc|csv", help="every robot's memory after every round")
    sub.add_argument("--plot", type=Path, metavar="FILE.png|svg|pdf", help="every robot's estimate against rounds")
    sub.add_argument("--recording", type=Path, metavar="FOLDER", help="the trial as observations.csv and links.csv")

    sub = command("infer", "Run a brain on recorded observations and links instead of a simulated world.")
    sub.add_argument("observations", type=Path, metavar="OBSERVATIONS.csv")
    sub.add_argument("--links", type=Path, metavar="LINKS.csv", help="edges, or messages: step, sender, receiver")
    sub.add_argument("--accuracy", required=True, help="0.8 (b = w), 0.9,0.6 (b, w), or a CSV with a row a robot")
    sub.add_argument("--every", type=int, metavar="STEPS", help="steps in a round (default: 10; 1 for messages)")
    sub.add_argument("--brain", default="minimalistic", help="a shipped brain or a brain file (default: %(default)s)")
    sub.add_argument("--out", type=Path, metavar="FILE.csv|nc", help="default: OBSERVATIONS-trace.csv, here")
    sub.add_argument("--plot", type=Path, metavar="FILE.png|svg|pdf", help="default: beside --out, as .png")

    sub = command("list", "List what there is to choose from, ours and what other installed packages add.")
    sub.add_argument("kind", nargs="?", metavar="KIND", choices=[*DOORS], help=f"one of {', '.join(DOORS)}")

    sub = command("brains", "List the shipped brains and adversaries, show one, or check a file.")
    one = sub.add_mutually_exclusive_group()
    one.add_argument("--check", metavar="FILE", help="run a brain or an adversary through the conformance suite")
    one.add_argument("--show", metavar="FILE", help="print the source of a brain, or of an adversary and its brain")
    sub.add_argument("--wearing", metavar="BRAIN", default="", help="what an adversary wears (default: minimalistic)")

    add_new_options(command("new", "Write a study or a brain to begin with, every line explained."))
    add_watch_options(command("watch", "Watch one trial live in a browser, or write it as a page for others."))
    add_studies_options(
        command("studies", "List the studies that come with swarmcensus, copy one, or print their schema.")
    )
    command("doctor", "Say what this installation is made of, and what is missing.")
    add_completion_options(command("completion", "Print what makes a shell complete commands, options and files."))
    add_output_options(commands.choices)
    return top


def _add_measure_options(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--bins", type=int, help="of decisions, asked anew of estimates that the study kept")
    sub.add_argument("--delta", type=float, help="of convergence, likewise")


def _add_run_options(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("--jobs", type=_from_one, help="threads (default: one a core); the numbers do not depend on it")
    sub.add_argument("--trials", type=_from_one, help="instead of the study's own number")
    sub.add_argument("--seed", type=_from_zero, help="instead of the study's own")
    sub.add_argument("--fresh", action="store_true", help="begin anew instead of going on with what --out holds")


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",") if name.strip()]


def _share(text: str) -> tuple[int, int]:
    k, slash, n = text.partition("/")
    if not (slash and k.isdecimal() and n.isdecimal() and len(text) <= DIGITS):
        raise argparse.ArgumentTypeError(f"{text!r}: should be such as 1/4")
    return int(k), int(n)


def _from_one(text: str) -> int:
    return _whole(text, 1)


def _from_zero(text: str) -> int:
    return _whole(text, 0)


def _or_time(text: str) -> Any:
    from swarmcensus.basics.times import parse_time

    if text.strip()[-1:].isalpha():  # a unit
        try:
            return parse_time(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"{text[:40]!r}: {error}") from None
    return _whole(text, 0)


def _whole(text: str, least: int) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= DIGITS and int(text) >= least):
        raise argparse.ArgumentTypeError(f"{text[:40]!r}: should be a whole number from {least}")
    return int(text)
