"""The command line: parses the options, calls a command, and says in one line what went wrong."""

import argparse
import functools
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from swarmcensus.basics.errors import STOPPED, InputError, Interrupted
from swarmcensus.basics.options import of_a_shell
from swarmcensus.cli.choices import choices
from swarmcensus.cli.compare import compare
from swarmcensus.cli.completion import completion
from swarmcensus.cli.explain import explain
from swarmcensus.cli.leaderboard import leaderboard
from swarmcensus.cli.options import parser
from swarmcensus.cli.output import speaking
from swarmcensus.cli.plan import plan
from swarmcensus.cli.plot import plot
from swarmcensus.cli.read_results import export, merge, show, verify
from swarmcensus.cli.replay import infer, replay
from swarmcensus.cli.run import brains, reproduce, run, status
from swarmcensus.cli.start import doctor, new, studies
from swarmcensus.cli.tune import tune
from swarmcensus.cli.watch import watch
from swarmcensus.results.presence import check_there


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the exit code is 0, 2 for bad input, 130 after Ctrl-C."""
    options = _all_commands().parse_args(arguments)
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


@functools.cache
def _all_commands() -> argparse.ArgumentParser:
    return parser(COMMANDS)


def _look_for_results(options: argparse.Namespace) -> None:
    """Raise InputError for results that are not there, before a command imports what it needs to open them."""
    given = getattr(options, "results", [])
    for path in [given] if isinstance(given, Path) else given:
        if options.run is not status:  # which has more to say
            check_there(path)


def _complain(what: object) -> None:
    """One line, whatever is in it."""
    print("swarmcensus:", " ".join(str(what).split("\n")), file=sys.stderr)


RUNS = (
    run, reproduce, show, explain, compare, leaderboard, tune, plan, merge, status, verify, plot, export, replay, infer,
    brains, new, studies, watch, doctor, completion,
)  # fmt: skip
COMMANDS = {one.__name__: one for one in RUNS} | {"list": choices}
