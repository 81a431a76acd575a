"""A quick check of brain files before they are run: some of the suite's checks, in CPython, under a second.

What it finds is kept in the cache of machine code, by the brain's source, so that each file is checked once.
"""

import contextlib
import functools
import hashlib
import warnings
from collections.abc import Iterable

from swarmcensus.brains import PLUGINS, Brain, Lines, TooManyLines
from swarmcensus.engine import cache_root
from swarmcensus.support.errors import BrainError, InputError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.fork import in_background
from swarmcensus.support.version import __version__

MOST_LINES = 1_000_000  # of a brain's file that are run in all: half a second
MOST_IN_A_CALL = 300_000  # lines of one call, after which it seems never to end
SLOW = "seems not to keep the contract"
MOST_BYTES = 2 << 30  # by which its process may grow
MOST_SECONDS = 10.0  # of the processor: a line may take for ever, too, and nothing in its process can end it


def caution(brains: Iterable[Brain]) -> None:
    """Warn, once each, of brain files that `swarmcensus brains --check` refuses, as far as a quick check shows.

    Raises BrainError for one with a function that does not return: a run of it would never end.
    """
    for brain in brains:
        if brain.name not in PLUGINS.shipped and brain.is_loaded and brain.path.is_file():
            _caution(brain.as_written)


@functools.lru_cache(maxsize=256)
def _caution(brain: Brain) -> None:
    digest = hashlib.sha256(f"{__version__}\0{brain.source}".encode()).hexdigest()[:24]
    fault = None
    with contextlib.suppress(OSError, UnicodeDecodeError):
        fault = (cache_root() / f"quick-{digest}.txt").read_text(encoding="utf-8")
    if fault is None:
        killed = f"{SLOW}: a call ended its process, or took {MOST_SECONDS:g} s of the processor"
        bounds = MOST_SECONDS, MOST_BYTES
        fault = in_background(lambda: quick_fault(brain), bounds=bounds, if_killed=lambda: killed)()
        with contextlib.suppress(OSError, InputError), atomic_write(cache_root() / f"quick-{digest}.txt") as file:
            file.write_text(fault, encoding="utf-8")
    more = f"{fault}: swarmcensus brains --check {brain.path} says more"
    if fault.startswith(SLOW):
        raise BrainError.named("brain", brain.name, more)
    if fault:
        warnings.warn(f"brain {brain.name!r} {more}", stacklevel=4)


def quick_fault(brain: Brain) -> str:
    """What the first fault in short histories says of the brain; empty if there is none."""
    import numpy as np

    from swarmcensus.checks.contract_checks import IN_EACH_STATE
    from swarmcensus.checks.sample_states import NotUsed, Violation, in_a_line, short_lives
    from swarmcensus.checks.suite import gist

    checks = {*IN_EACH_STATE.values()}
    try:
        with np.errstate(all="ignore"), Lines(brain, MOST_IN_A_CALL) as lines:
            for where, me in short_lives(brain):
                for check in tuple(checks):
                    try:
                        check(brain, where, me)
                    except NotUsed:
                        checks.remove(check)
                if lines.run > MOST_LINES:
                    break
    except Violation as fault:
        if isinstance(fault.__cause__, TooManyLines):
            return f"{SLOW}: {fault.__cause__}"
        if isinstance(fault.__cause__, MemoryError):
            return f"{SLOW}: {gist(str(fault))}"
        return f"breaks the contract: {gist(str(fault))}"
    except Exception as error:
        return f"breaks the contract: {in_a_line(error)}"
    return ""
