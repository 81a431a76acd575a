"""Whether a brain file keeps the contract: `sc.check`.

A brain may hang or crash the process that runs it. So all checks are made in one process of their own.
"""

import ast
import faulthandler
import json
import logging
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

from swarmcensus.brains import PLUGINS, Brain, adversary, exists, find, robot_math, slots
from swarmcensus.checks.suite import (
    AGREES,
    COMPILES,
    DEFAULT_BRAIN,
    KEEPS,
    Check,
    Mismatch,
    brain_to_check,
    checks,
    examine,
    is_adversary,
)
from swarmcensus.studies import taken_in_results
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.fork import bound_memory, end_with
from swarmcensus.support.printed_tables import Column, Table

LOG = logging.getLogger(__name__)
PATIENCE = 60.0  # seconds for a check; those of shipped brains take less than one, and compiling them eight
MANY_NUMBERS = 250  # numbers in a state from which on a check gets more time
MEMORY_BYTES = 4 << 30  # by which the process may grow; compiling takes 0.6 GiB
CHILD = "import sys; from swarmcensus.checks.checking import report; report(*sys.argv[1:])"
RUNNING = {  # what runs during a check while no function of the file does
    COMPILES: "Numba is compiling it",
    AGREES: "its machine code has not returned, and in CPython it does",
}


class Conformance(Answer):
    """The checks of a brain or adversary, in order, and `notes` on what breaks no promise but should be known."""

    checks: list[Check]
    notes: list[str]
    conforms: bool


def check(brain: str | Path, *, wrapping: str = "") -> Conformance:
    """Check a brain or an adversary, a name or a file, against the contract, as `swarmcensus brains --check` does.

    An adversary wraps the brain `wrapping`, by default the paper's. The file is compiled and run in a process of its
    own, which takes up to a minute. Its faults are returned, not raised; raises InputError if there is no such file,
    and if `wrapping` cannot be wrapped.
    """
    if wrapping:
        find(wrapping)  # so that a misspelt name is not reported as an error of the adversary
    if not (str(brain) in PLUGINS or exists(str(brain), None) or Path(brain).exists()):
        brain_to_check(brain, wrapping)  # raises the right error
    notes = list[str]()
    try:
        read = brain_to_check(brain, wrapping)
    except Mismatch:
        raise
    except InputError as error:
        made = [Check(KEEPS, str(error))]
    else:
        LOG.info("checking %s, which is compiled for it: some seconds", brain)
        notes = notes_on(brain, read, wrapping)
        made = run_checks(brain, read, wrapping)
    faults = [one for one in made if one.fault is not None]
    verdict = "does not keep the contract" if faults else "keeps the contract"
    said = [f"{one.state}  {one.name}: {one.fault}" for one in faults] + [f"note: {note}" for note in notes]
    names = [one.name + ": not used" * (not one.used) for one in made]
    states = Column("", [one.state for one in made], number=False, name="state")
    rows = [{"check": one.name, "state": one.state, "fault": one.fault} for one in made]
    found = {"conforms": not faults, "notes": notes}
    return Conformance(
        Table([states, Column("check", names, number=False, name="check")], folds=True), rows=rows, checks=made,
        sentences=[f"{brain} {verdict}", *said], fields={"file": brain, **found}, code=2 if faults else 0, **found,
    )  # fmt: skip


def notes_on(path: str | Path, brain: Brain, wrapping: str) -> list[str]:
    """What somebody who puts the brain on robots should know, though it breaks no promise."""
    missing = robot_math.missing_on_avr(ast.parse(brain.source))
    lacks = [f"AVR boards (Kilobot, Arduino) cannot run it, as avr-libc lacks {', '.join(missing)}"] if missing else []
    unsaid = adversary.load(path).unsaid(brain.message) if is_adversary(path) else []
    inner = wrapping or DEFAULT_BRAIN
    return lacks + [
        f"{name} says nothing: the MESSAGE of {inner} has no {name.removeprefix('say_')}" for name in unsaid
    ]


def run_checks(path: str | Path, brain: Brain, wrapping: str = "", patience: float = PATIENCE) -> list[Check]:
    """All checks of a brain. A check that does not end within `patience` seconds, or ends its process, is the last."""
    if name := taken_in_results(brain):
        return [Check(KEEPS, f"PARAMETERS key {name!r} is already a name in the results: choose another")]
    patience *= max(1.0, len(slots(brain.lengths)) / MANY_NUMBERS)
    folders = os.pathsep.join(folder or str(Path.cwd()) for folder in sys.path)
    given = [str(path), wrapping, str(patience), str(os.getpid())]
    done = subprocess.run(
        [sys.executable, "-P", "-c", CHILD, *given],
        env=os.environ | {"PYTHONPATH": folders, "PYTHONUTF8": "1"},
        capture_output=True, encoding="utf-8", errors="replace", check=False,
    )  # fmt: skip
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    results = [Check(KEEPS, None)] * bool(lines) + [Check(*line) for line in lines if len(line) == 3]
    if done.returncode:
        begun = lines[-1][0] if lines else KEEPS
        results.append(Check(begun, _why_it_ended(done, brain, begun, patience)))
    return results


def report(path: str, wrapping: str, patience: str, parent: str) -> None:
    """In the child process: print each check's name before it runs, and its `Check` afterwards, as lines of JSON."""
    end_with(int(parent))
    bound_memory(MEMORY_BYTES)

    def begin(name: str) -> None:
        print(json.dumps([name]), flush=True)
        faulthandler.dump_traceback_later(float(patience), exit=True)  # works while machine code runs, too

    for found in examine(brain_to_check(path, wrapping), checks(), begin):
        print(json.dumps([found.name, found.fault, found.used]), flush=True)
    faulthandler.cancel_dump_traceback_later()


def _why_it_ended(done: subprocess.CompletedProcess[str], brain: Brain, begun: str, patience: float) -> str:
    """Why the process of a check ended: the function of the file that has not returned, or what was said last."""
    if done.returncode < 0:
        return f"it ends its process by {signal.Signals(-done.returncode).name}: most likely it is out of memory"
    if "Timeout (" not in done.stderr:
        return f"it ends its process: {(done.stderr.strip().splitlines() or ['no more is said'])[-1]}"
    file = re.escape(str(brain.path).encode("ascii", "backslashreplace").decode())  # as faulthandler writes it
    calls = re.findall(rf'File "{file}", line (\d+) in (\w+)', done.stderr)  # the innermost comes first
    running = RUNNING.get(begun, "it is slow")
    if calls:
        (line, inner), (_, called) = calls[0], calls[-1]
        running = f"{called} has not returned, at line {line}{f' in {inner}' if inner != called else ''}"
    return f"it did not end within {patience:g} s: {running}"
