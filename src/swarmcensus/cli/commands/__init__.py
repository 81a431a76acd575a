"""The command line: finds the commands, parses their options, calls one, and reports an error in one line.

A module in this folder has one command or several in its `COMMANDS`. To add a command, add a file here, and nothing
elsewhere. All of them are imported for each help text, so that their own imports wait until a command runs.
"""

import argparse
import contextlib
import functools
import importlib
import os
import pkgutil
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

from swarmcensus.cli.options import Command, Group, Parser, UsageError, add_output_options
from swarmcensus.cli.output import complain, say, speaking
from swarmcensus.results import check_there
from swarmcensus.support.errors import STOPPED, STOPPING, InputError, Interrupted
from swarmcensus.support.options import shell_options
from swarmcensus.support.printable import escaping
from swarmcensus.support.version import __version__


@functools.cache
def commands() -> dict[str, Command]:
    """All commands by name, group by group."""
    modules = (importlib.import_module(f"{__name__}.{module.name}") for module in pkgutil.iter_modules(__path__))
    found = [command for module in modules for command in module.COMMANDS]
    found.sort(key=lambda command: ([*Group].index(command.group), command.place, command.name))
    return {command.name: command for command in found}


@escaping()
def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, or print the help if there is none; the exit code is 0, 2 for bad input, 130 after Ctrl-C."""
    try:
        return execute(arguments)
    except UsageError as error:
        complain(f"{error.program}: {error}")
        return 2
    except InputError as error:
        complain(f"swarmcensus: {error}")
        return 2
    except Interrupted as stopped:
        complain(f"swarmcensus: {stopped}")
        return STOPPED
    except KeyboardInterrupt:
        complain("swarmcensus: stopped")
        return STOPPED
    except BrokenPipeError:  # the reader of our output has gone, as after `| head`
        with contextlib.suppress(OSError, ValueError):  # so that no flush at exit fails, which would change the code
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.stderr.close()
        return 0
    except OSError as error:
        what = error.strerror or str(error)
        complain(f"swarmcensus: {error.filename}: {what}" if error.filename else f"swarmcensus: {what}")
        return 2
    except UnicodeEncodeError as error:  # of bytes that are not text in the encoding of this system's file names
        said = ascii(error.object[max(0, error.start - 20) : error.end + 20])
        complain(f"swarmcensus: {said} is no text in this system's encoding: use other names, or set PYTHONUTF8=1")
        return 2
    except MemoryError:
        complain("swarmcensus: not enough memory: try fewer robots, rounds, settings or trials")
        return 2
    except Exception as error:
        if STOPPING.is_set():
            complain("swarmcensus: stopped")
            return STOPPED
        if os.environ.get("SWARMCENSUS_DEBUG"):
            raise
        what = str(error).strip().splitlines()[0] if str(error).strip() else ""
        if any(frame.name == "_rc_params_in_file" for frame in traceback.extract_tb(error.__traceback__)):
            complain(f"swarmcensus: matplotlib cannot read its settings, matplotlibrc: {what}")
            return 2
        complain(f"swarmcensus: {type(error).__name__}: {what} (internal error: SWARMCENSUS_DEBUG=1 shows where)")
        return 2


def execute(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code. Raises InputError, in the words of the command line."""
    top = parser()
    words = sys.argv[1:] if arguments is None else arguments
    options = top.parse_args(words)
    if not hasattr(options, "run"):
        top.print_help()
        return 0
    with shell_options(vars(options), words), speaking(options):
        if getattr(options, "reads_results", False):  # before a command spends time on its imports
            for path in [options.results] if isinstance(options.results, Path) else options.results:
                check_there(path)
        given = [value for value in vars(options).values() if isinstance(value, Path)]
        missing = dict.fromkeys(path.parent for path in given if not path.parent.exists())
        code = int(options.run(options) or 0)
        for folder in missing:
            if folder.is_dir():  # a mistyped path should not make one silently
                say(f"made the folder {folder}")
        sys.stdout.flush()  # a full disk is reported here
        return code


def a_path(text: str) -> Path:
    """The path of a file or folder. Raises ArgumentTypeError for an empty text, which to Path is this folder."""
    if not text:
        raise argparse.ArgumentTypeError("should name a file or folder")
    return Path(text)


def parser() -> argparse.ArgumentParser:
    """All commands and their options."""
    top = Parser(
        prog="swarmcensus",
        description="Robot swarms with lying sensors agree on how much of a floor is black.",
        epilog="'swarmcensus COMMAND --help' shows the options of a command. To begin: swarmcensus reproduce",
    )
    top.add_argument("--version", action="version", version=f"swarmcensus {__version__}")
    listed = top.add_subparsers(metavar="COMMAND", required=False)
    for name, command in commands().items():
        sub = listed.add_parser(name, help=command.text, description=command.text)
        sub.set_defaults(run=command.run)
        sub.register("type", Path, a_path)
        command.add_options(sub)
        add_output_options(sub, command.json, command.table)
    top._positionals._group_actions.clear()
    for group in Group:  # in the help, commands are listed under the titles of their groups
        section = top.add_argument_group(group.value)
        shown = [action for action in listed._choices_actions if commands()[action.dest].group is group]
        section._group_actions.extend(shown)
    return top
