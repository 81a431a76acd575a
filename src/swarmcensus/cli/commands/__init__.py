"""The command line: one module for each command or several, and what reports an error in one line.

To add a command, add a function to a file here, and its name to `cli.help`.
"""

import contextlib
import os
import sys
import traceback
from collections.abc import Sequence

from swarmcensus.cli.help import COMMANDS, HELP, UsageError, overview
from swarmcensus.cli.messages import complain
from swarmcensus.support.control_characters import escaping
from swarmcensus.support.errors import STOPPED, STOPPING, InputError
from swarmcensus.support.version import __version__


@escaping()
def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, or print the help if there is none; the exit code is 0, 2 for bad input, 130 after Ctrl-C."""
    words = sys.argv[1:] if arguments is None else [*map(str, arguments)]
    try:
        if words == ["--version"] or not {*words} - {*HELP}:
            print(__version__ if words == ["--version"] else overview())
            return 0
        from swarmcensus.cli.app import execute  # imports the parser, which takes longer than to list commands

        return execute(words)
    except InputError as error:
        program = [name for name in words[:1] if isinstance(error, UsageError) and name in COMMANDS]
        return complain(" ".join(["swarmcensus", *program]) + f": {error}")
    except KeyboardInterrupt as stopped:
        return complain(f"swarmcensus: {str(stopped) or 'stopped'}", STOPPED)
    except BrokenPipeError:  # the reader of our output has gone, as after `| head`
        with contextlib.suppress(OSError, ValueError):  # so that no flush at exit fails, which would change the code
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.stderr.close()
        return 0
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return complain(f"swarmcensus: {where}{error.strerror or error}")
    except UnicodeEncodeError as error:  # of bytes that are not text in the encoding of this system's file names
        text = ascii(error.object[max(0, error.start - 20) : error.end + 20])
        return complain(
            f"swarmcensus: {text} is no text in this system's encoding: use other names, or set PYTHONUTF8=1"
        )
    except MemoryError:
        return complain("swarmcensus: not enough memory: try fewer robots, rounds, settings or trials")
    except Exception as error:
        if STOPPING.is_set():
            return complain("swarmcensus: stopped", STOPPED)
        if os.environ.get("SWARMCENSUS_DEBUG"):
            raise
        what = next(iter(str(error).strip().splitlines()), "")
        if any(frame.name == "_rc_params_in_file" for frame in traceback.extract_tb(error.__traceback__)):
            return complain(f"swarmcensus: matplotlib cannot read its settings, matplotlibrc: {what}")
        where = "(internal error: SWARMCENSUS_DEBUG=1 shows where)"
        return complain(f"swarmcensus: {type(error).__name__}: {what} {where}")
