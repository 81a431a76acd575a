"""The command line: parses the options, calls a command, and says in one line what went wrong."""

import argparse
import functools
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from swarmcensus.basics.errors import STOPPED, InputError, Interrupted
from swarmcensus.basics.options import of_a_shell
from swarmcensus.basics.version import __version__
from swarmcensus.cli import (
    compare,
    explain,
    leaderboard,
    list_brains,
    plan,
    plot,
    read_results,
    replay,
    run,
    start,
    tune,
    watch,
)
from swarmcensus.cli.options import Parser, add_output_options
from swarmcensus.cli.output import speaking
from swarmcensus.results.presence import check_there


class Command(NamedTuple):
    """A command: what it does, the function that does it, the one that adds its options, and whether it has --json."""

    text: str
    run: Callable[[argparse.Namespace], int]
    add_options: Callable[[argparse.ArgumentParser], None] | None = None
    json: bool = True


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the exit code is 0, 2 for bad input, 130 after Ctrl-C."""
    options = _cached_parser().parse_args(arguments)
    try:
        with of_a_shell(vars(options)), speaking(options):
            _look_for_results(options)
            code = int(options.run(options) or 0)
            sys.stdout.flush()  # a full disk should be told of here
            return code
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
        sys.stderr.close()
        return 0
    except OSError as error:
        what = error.strerror or str(error)
        _complain(f"{error.filename}: {what}" if error.filename else what)
        return 2
    except MemoryError:
        print(
            "swarmcensus: not enough memory: fewer robots, rounds, settings or trials would need less", file=sys.stderr
        )
        return 2
    except Exception as error:
        if os.environ.get("SWARMCENSUS_DEBUG"):
            raise
        what = str(error).strip().splitlines()[0] if str(error).strip() else ""
        print(
            f"swarmcensus: {type(error).__name__}: {what} (unforeseen: with SWARMCENSUS_DEBUG=1 it says where)",
            file=sys.stderr,
        )
        return 2


def parser() -> argparse.ArgumentParser:
    """All commands and their options."""
    top = Parser(
        prog="swarmcensus",
        description="Robot swarms with lying sensors agree on how much of a floor is black.",
        epilog="'swarmcensus COMMAND --help' tells more. Begin with: swarmcensus reproduce",
    )
    top.add_argument("--version", action="version", version=f"swarmcensus {__version__}")
    every = top.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name, command in COMMANDS.items():
        sub = every.add_parser(name, help=command.text, description=command.text)
        sub.set_defaults(run=command.run)
        if command.add_options:
            command.add_options(sub)
        add_output_options(sub, command.json)
    return top


@functools.cache
def _cached_parser() -> argparse.ArgumentParser:
    return parser()


def _look_for_results(options: argparse.Namespace) -> None:
    """Raise InputError for results that are not there, before a command imports what it needs to open them."""
    given = getattr(options, "results", [])
    for path in [given] if isinstance(given, Path) else given:
        if options.run is not run.status:  # which has more to say
            check_there(path)


def _complain(what: object) -> None:
    """One line, whatever is in it."""
    print("swarmcensus:", " ".join(str(what).split("\n")), file=sys.stderr)


def add_completion_options(sub: argparse.ArgumentParser) -> None:
    """Of `completion`."""
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
    [commands] = [one for one in top._actions if isinstance(one, argparse._SubParsersAction)]
    for sub in commands.choices.values():
        for action in sub._actions:
            if action.type is Path:
                action.complete = shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(top, options.shell))
    return 0


COMMANDS = {
    "reproduce": Command(
        "Run the paper's evaluation; draw its figures; check its claims.", run.reproduce, run.add_reproduce_options
    ),
    "run": Command("Run a study file; write its results as netCDF.", run.run, run.add_study_options),
    "show": Command(
        "Print the summary of a results file: medians and right decisions, a row a setting.",
        read_results.show, read_results.add_show_options,
    ),
    "compare": Command(
        "Rank brains within each world, paired trial by trial, and say what trials tell.",
        compare.compare, compare.add_compare_options,
    ),
    "explain": Command(
        "Hold all settings against theory, or set what one measured beside it and say what limits it.",
        explain.explain, explain.add_explain_options,
    ),
    "leaderboard": Command(
        "Run the shipped brains, and your own beside them, in one fixed set of worlds.",
        leaderboard.leaderboard, leaderboard.add_leaderboard_options,
    ),
    "tune": Command(
        "Search for good values of a brain's parameters, and evaluate them where the search was not.",
        tune.tune, tune.add_tune_options,
    ),
    "plan": Command("Say how many robots, or how many minutes, a mission needs.", plan.plan, plan.add_plan_options),
    "status": Command(
        "Say how far a study is that runs, or was cut off, and when it ends.", run.status, run.add_status_options
    ),
    "merge": Command(
        "Put results together whose settings or trials differ.",
        read_results.merge, read_results.add_merge_options, json=False,
    ),
    "verify": Command(
        "Run trials of a results file again and compare them bit for bit.",
        read_results.verify, read_results.add_verify_options,
    ),
    "plot": Command("Draw a results file.", plot.plot, plot.add_plot_options, json=False),
    "export": Command(
        "Write results as a table: one row a robot and trial.",
        read_results.export, read_results.add_export_options, json=False,
    ),
    "replay": Command(
        "Run one trial of a results file again and show every round of it.", replay.replay, replay.add_replay_options
    ),
    "infer": Command(
        "Run a brain on recorded observations and links instead of a simulated world.",
        replay.infer, replay.add_infer_options,
    ),
    "list": Command(
        "List what there is to choose from, ours and what other installed packages add.",
        list_brains.choices, list_brains.add_list_options,
    ),
    "brains": Command(
        "List the shipped brains and adversaries, show one, or check a file.",
        list_brains.brains, list_brains.add_brains_options,
    ),
    "new": Command(
        "Write a study or a brain to begin with, every line explained.", start.new, start.add_new_options, json=False
    ),
    "watch": Command(
        "Watch one trial live in a browser, or write it as a page for others.",
        watch.watch, watch.add_watch_options, json=False,
    ),
    "studies": Command(
        "List the studies that come with swarmcensus, copy one, or print their schema.",
        start.studies, start.add_studies_options,
    ),
    "doctor": Command("Say what this installation is made of, and what is missing.", start.doctor),
    "completion": Command(
        "Print what makes a shell complete commands, options and files.", completion, add_completion_options, json=False
    ),
}  # fmt: skip
