"""The command line: one module for each command or several, and what reports an error in one line.

To add a command, add a function with the mark of `command` to a file here, and nothing elsewhere.
"""

import contextlib
import os
import sys
import traceback
from collections.abc import Sequence

from swarmcensus.cli import app
from swarmcensus.cli.app import UsageError, commands as commands
from swarmcensus.cli.output import complain
from swarmcensus.support.control_characters import escaping
from swarmcensus.support.errors import STOPPED, STOPPING, InputError, Interrupted


@escaping()
def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, or print the help if there is none; the exit code is 0, 2 for bad input, 130 after Ctrl-C."""
    try:
        return app.execute(sys.argv[1:] if arguments is None else [*map(str, arguments)])
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
