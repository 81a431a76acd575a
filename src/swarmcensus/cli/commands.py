"""The command line: parses the options, calls a command, and reports an error in one line."""

import argparse
import contextlib
import functools
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from swarmcensus.basics.errors import STOPPED, InputError, Interrupted
from swarmcensus.basics.options import shell_options
from swarmcensus.basics.printable import escaping
from swarmcensus.basics.version import __version__
from swarmcensus.cli import (
    compare,
    deploy,
    explain,
    export,
    leaderboard,
    list_brains,
    plan,
    plot,
    read_results,
    relive,
    replay,
    run,
    start,
    swarm,
    translate,
    tune,
    watch,
)
from swarmcensus.cli.options import Parser, UsageError, add_output_options
from swarmcensus.cli.output import speaking
from swarmcensus.results.presence import check_there


class Command(NamedTuple):
    """A command: its help text, the function that runs it, and the one that adds its options.

    `json` is whether it has --json, and `table` whether its answer is a table, which a pipe gets tab-separated.
    """

    text: str
    run: Callable[[argparse.Namespace], int]
    add_options: Callable[[argparse.ArgumentParser], None] | None = None
    json: bool = True
    table: bool = False


@escaping()
def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, or print the help if there is none; the exit code is 0, 2 for bad input, 130 after Ctrl-C."""
    try:
        return execute(arguments)
    except UsageError as error:
        print(f"{error.program}: {error}", file=sys.stderr)
        return 2
    except InputError as error:
        _complain(error)
        return 2
    except Interrupted as stopped:
        print(f"swarmcensus: {stopped}", file=sys.stderr)
        return STOPPED
    except KeyboardInterrupt:
        print("swarmcensus: stopped", file=sys.stderr)
        return STOPPED
    except BrokenPipeError:  # the reader of our output has gone, as after `| head`
        with contextlib.suppress(OSError, ValueError):  # so that no flush at exit fails, which would change the code
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.stderr.close()
        return 0
    except OSError as error:
        what = error.strerror or str(error)
        _complain(f"{error.filename}: {what}" if error.filename else what)
        return 2
    except UnicodeEncodeError as error:  # of bytes that are no text in the encoding of this system's file names
        said = ascii(error.object[max(0, error.start - 20) : error.end + 20])
        _complain(f"{said} is no text in this system's encoding: use other names, or set PYTHONUTF8=1")
        return 2
    except MemoryError:
        print("swarmcensus: not enough memory: try fewer robots, rounds, settings or trials", file=sys.stderr)
        return 2
    except Exception as error:
        if os.environ.get("SWARMCENSUS_DEBUG"):
            raise
        what = str(error).strip().splitlines()[0] if str(error).strip() else ""
        if any(frame.name == "_rc_params_in_file" for frame in traceback.extract_tb(error.__traceback__)):
            _complain(f"matplotlib cannot read its settings, matplotlibrc: {what}")
            return 2
        print(
            f"swarmcensus: {type(error).__name__}: {what} (internal error: SWARMCENSUS_DEBUG=1 shows where)",
            file=sys.stderr,
        )
        return 2


def execute(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code. Raises InputError, in the words of the command line."""
    options = _cached_parser().parse_args(arguments)
    if not hasattr(options, "run"):
        _cached_parser().print_help()
        return 0
    with shell_options(vars(options)), speaking(options):
        _look_for_results(options)
        code = int(options.run(options) or 0)
        sys.stdout.flush()  # a full disk is reported here
        return code


def parser() -> argparse.ArgumentParser:
    """All commands and their options."""
    top = Parser(
        prog="swarmcensus",
        description="Robot swarms with lying sensors agree on how much of a floor is black.",
        epilog="'swarmcensus COMMAND --help' shows the options of a command. To begin: swarmcensus reproduce",
    )
    top.add_argument("--version", action="version", version=f"swarmcensus {__version__}")
    commands = top.add_subparsers(title="commands", metavar="COMMAND", required=False)
    for name, command in COMMANDS.items():
        sub = commands.add_parser(name, help=command.text, description=command.text)
        sub.set_defaults(run=command.run)
        if command.add_options:
            command.add_options(sub)
        add_output_options(sub, command.json, command.table)
    return top


@functools.cache
def _cached_parser() -> argparse.ArgumentParser:
    return parser()


def _look_for_results(options: argparse.Namespace) -> None:
    """Raise InputError for results files that do not exist, before a command spends time on its imports."""
    results = getattr(options, "results", [])
    for path in [results] if isinstance(results, Path) else results:
        # a run may have written no results yet, and `export` reads folders too
        if options.run not in (run.status, export.export):
            check_there(path)


def _complain(what: object) -> None:
    """Print an error in one line, even if its message has several."""
    print("swarmcensus:", " ".join(str(what).split("\n")), file=sys.stderr)


def add_completion_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `completion`."""
    sub.add_argument(
        "shell",
        choices=("bash", "zsh", "tcsh"),
        metavar="bash|zsh|tcsh",
        help="for bash: swarmcensus completion bash > ~/.local/share/bash-completion/completions/swarmcensus",
    )


def completion(options: argparse.Namespace) -> int:
    """Print the script that makes a shell complete commands, options and files."""
    import shtab

    top = parser()
    [commands] = [action for action in top._actions if isinstance(action, argparse._SubParsersAction)]
    for sub in commands.choices.values():
        for action in sub._actions:
            if action.type is Path:
                action.complete = shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(top, options.shell))
    return 0


COMMANDS = {
    "reproduce": Command(
        "Run the paper's evaluation, draw its figures and check its claims.", run.reproduce, run.add_reproduce_options
    ),
    "run": Command("Run a study file and write its results as netCDF.", run.run, run.add_study_options, table=True),
    "show": Command(
        "Print a summary of a results file: medians and right decisions, one row per setting.",
        read_results.show, read_results.add_show_options, table=True,
    ),
    "compare": Command(
        "Rank brains within each world, paired trial by trial, and test their differences.",
        compare.compare, compare.add_compare_options, table=True,
    ),
    "explain": Command(
        "Compare all settings with theory, or show one in detail and what limits its error.",
        explain.explain, explain.add_explain_options, table=True,
    ),
    "leaderboard": Command(
        "Run the shipped brains, and your own beside them, in one fixed set of worlds.",
        leaderboard.leaderboard, leaderboard.add_leaderboard_options, table=True,
    ),
    "tune": Command(
        "Search for good values of a brain's parameters, or an adversary's worst, and evaluate them in new trials.",
        tune.tune, tune.add_tune_options,
    ),
    "plan": Command(
        "Find how many robots, or how many minutes, a mission needs.", plan.plan, plan.add_plan_options, table=True
    ),
    "status": Command(
        "Show how far a running or interrupted study is, and when it will end.", run.status, run.add_status_options
    ),
    "merge": Command(
        "Merge results files with different settings or trials into one.",
        read_results.merge, read_results.add_merge_options, json=False,
    ),
    "verify": Command(
        "Run trials of a results file again and compare them bit for bit.",
        read_results.verify, read_results.add_verify_options,
    ),
    "plot": Command("Draw a figure of a results file.", plot.plot, plot.add_plot_options, json=False),
    "export": Command(
        "Write results as a table with one row per robot and trial, or robots' logs as MCAP.",
        export.export, export.add_export_options, json=False,
    ),
    "replay": Command(
        "Run one trial of a results file again and show every round.",
        replay.replay, replay.add_replay_options, table=True,
    ),
    "infer": Command(
        "Run a brain on recorded observations and links instead of a simulated world.",
        replay.infer, replay.add_infer_options, table=True,
    ),
    "relive": Command(
        "Live robots' minds again from their logs, to the bit, or the same day under another brain.",
        relive.relive, relive.add_relive_options,
    ),
    "list": Command(
        "List what studies and figures can use by name, including plugins from other packages.",
        list_brains.choices, list_brains.add_list_options, table=True,
    ),
    "brains": Command(
        "List brains and adversaries, print the source of one, check a file, or measure what brains take of a chip.",
        list_brains.brains, list_brains.add_brains_options, table=True,
    ),
    "deploy": Command(
        "Write a brain's files for a robot, or check that a robot computes what it should.",
        deploy.deploy, deploy.add_deploy_options,
    ),
    "translate": Command(
        "Write a brain as C for a robot without Python, with a test that compares its bits with Python's.",
        translate.translate, translate.add_translate_options,
    ),
    "swarm": Command(
        "Run a swarm of processes on this machine that talk over sockets, as robots do.",
        swarm.swarm, swarm.add_swarm_options,
    ),
    "new": Command(
        "Write a study or a brain to start from, with every line explained.",
        start.new, start.add_new_options, json=False,
    ),
    "watch": Command(
        "Watch one trial live in a browser, or write it as an HTML page to share.",
        watch.watch, watch.add_watch_options, json=False,
    ),
    "studies": Command(
        "List the studies that come with swarmcensus, copy one, or print their schema.",
        start.studies, start.add_studies_options,
    ),
    "doctor": Command("Show which versions are installed, and what is missing.", start.doctor),
    "completion": Command(
        "Print the script that makes a shell complete commands, options and files.",
        completion, add_completion_options, json=False,
    ),
}  # fmt: skip
