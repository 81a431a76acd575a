"""Runs a brain file through all checks, in a process of its own, as a brain may hang or crash it."""

import ast
import contextlib
import faulthandler
import json
import os
import re
import signal
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from swarmcensus import brains
from swarmcensus.brains import adversary, robot_math
from swarmcensus.studies import taken_in_results
from swarmcensus.support.errors import BrainError, InputError
from swarmcensus.support.fork import bound_memory
from swarmcensus.support.hints import did_you_mean
from swarmcensus.support.options import wrong_option
from swarmcensus.support.plugins import read_source

PATIENCE = 30.0  # seconds of the processor for a check, about a hundred times what it takes; and for a call after that
LOOKS = 20  # into a call that lasts longer than that
LONGER = 10.0  # times as many seconds by the clock, after which a busy machine has left a check undecided
MANY_NUMBERS = 250  # numbers in a state from which on a check gets more time
COMPILE_PATIENCE = 300.0  # seconds; shipped brains take 8 s and 0.6 GiB, including Numba itself
MEMORY_BYTES = 2 << 30  # that a check may use, beyond what the process has
COMPILE_MEMORY_BYTES = 4 << 30
DEATHS = {"SIGKILL": ": out of memory", "SIGABRT": ": most likely out of memory"}
KEEPS, COMPILES, AGREES = "keeps the contract", "compiles", "CPython and machine code agree"
CHILD = (
    "import sys; from swarmcensus.support.fork import end_with; end_with(int(sys.argv[4])); "
    "from swarmcensus.checks import suite; suite.{}(sys.argv[1], float(sys.argv[2]), sys.argv[3])"
)
# Windows does not tell the time of the processor: there the clock alone counts
TELLS_CPU_TIME = hasattr(signal, "setitimer")
SLOW = "a call returned after the time was up"
DEFAULT_BRAIN = "minimalistic"  # the brain that an adversary wraps if none is named

OTHER_FILES = {  # what a file without `observe` is that has such a function, and what of a study takes it
    "watch": ("a metric", "metrics under [measure]"),
    "edges": ("a topology", "topology under [world]"),
    "score": ("a floor", "floor under [world]"),
    "quantile": ("a spread", "accuracy under [swarm]"),
}

Test = Callable[[brains.Brain], None]


@dataclass(frozen=True)
class Check:
    """One check: its name, what is wrong (None if nothing is), and whether the brain has the part it checks.

    A check that is not `decided` was given up: its `fault` says why, and the brain may have none.
    """

    name: str
    fault: str | None
    used: bool = True
    decided: bool = True

    @property
    def state(self) -> str:
        """How it ended, in a word or a mark."""
        return "-" if not self.used else "pass" if self.fault is None else "FAIL" if self.decided else "?"


def checks() -> dict[str, Test]:
    """All checks by name, in order; each raises Violation."""
    from swarmcensus.checks.contract_checks import PROMISES

    def compiles(brain: brains.Brain) -> None:  # imports Numba only when it is needed
        from swarmcensus.checks import machine_code
        from swarmcensus.checks.sample_states import Violation

        try:
            machine_code.compiles(brain)
        except MemoryError:
            raise Violation(f"Numba did not compile it within {COMPILE_MEMORY_BYTES >> 30} GiB of memory") from None

    def agrees(brain: brains.Brain) -> None:
        from swarmcensus.checks import machine_code

        machine_code.agrees(brain)

    return PROMISES | {COMPILES: compiles, AGREES: agrees}


class Mismatch(InputError):
    """No brain is there to check, though no file is at fault: an adversary does not fit, or a file is no brain."""


def brain_to_check(path: str | Path, wrapping: str = "") -> brains.Brain:
    """The brain with this name or file, or the adversary with this name or file, `wrapping` a brain.

    Raises InputError.
    """
    if not _is_adversary(path):
        hint = did_you_mean(str(path), [*brains.PLUGINS.names, *adversary.PLUGINS.names])
        if str(path) not in brains.PLUGINS and not Path(path).is_file() and (hint or wrapping):
            raise BrainError.named("brain", str(path), f"{hint}there is no brain, adversary or file of this name")
        if wrapping:
            raise wrong_option(
                "wrapping",
                wrapping,
                f"{path} has no lie(me, x), so it is no adversary, and only adversaries wrap a brain",
            )
        if Path(path).is_file():
            defined = re.findall(r"^def (\w+)", read_source("brain", Path(path)), re.MULTILINE)
            others = [OTHER_FILES[name] for name in defined if name in OTHER_FILES]
            if others and "observe" not in defined:
                what, key = others[0]
                raise Mismatch(f"{path} is {what}, no brain: name it in {key}, and swarmcensus run checks it")
        return brains.load(path)
    lies, brain = adversary.load(path), brains.load(wrapping or DEFAULT_BRAIN)
    try:
        return brains.lying_brain(lies, brain)
    except ValueError as error:
        raise Mismatch(f"{error}{': name another brain with --wrapping' * (not wrapping)}") from None


def _is_adversary(path: str | Path) -> bool:
    """Whether this is the name or file of an adversary, and of no brain."""
    return str(path) not in brains.PLUGINS and adversary.exists(str(path), None)


def check(path: str | Path, patience: float = PATIENCE, wrapping: str = "") -> list[Check]:
    """Run all checks on a brain file, or on an adversary `wrapping` one; the brain's faults are returned, not raised.

    A check that does not end within `patience` seconds of the processor, or ends its process, is the last. Raises
    Mismatch.
    """
    try:
        brain = brain_to_check(path, wrapping)
    except Mismatch:
        raise
    except InputError as error:
        return [Check(KEEPS, str(error))]
    if name := taken_in_results(brain):
        return [Check(KEEPS, f"PARAMETERS key {name!r} is already a name in the results: choose another")]
    patience *= max(1.0, len(brains.slots(brain.lengths)) / MANY_NUMBERS)
    done = _child("report", path, patience, wrapping)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    results = [Check(*line) for line in lines if len(line) > 1]
    if done.returncode or len(lines[-1]) == 1:
        begun = lines[-1][0] if lines else KEEPS
        fault, decided = _why_it_ended(done, brain, begun, (path, patience, wrapping))
        results.append(Check(begun, fault, decided=decided))
    return results


def notes(path: str | Path, wrapping: str = "") -> list[str]:
    """What somebody who puts the brain on robots should know, though it breaks no promise; empty if it is refused."""
    try:
        brain = brain_to_check(path, wrapping)
    except InputError:
        return []
    missing = robot_math.missing_on_avr(ast.parse(brain.source))
    lacks = [f"AVR boards (Kilobot, Arduino) cannot run it, as avr-libc lacks {', '.join(missing)}"] if missing else []
    unsaid = adversary.load(path).unsaid(brain.message) if _is_adversary(path) else []
    inner = wrapping or DEFAULT_BRAIN
    return lacks + [
        f"{name} says nothing: the MESSAGE of {inner} has no {name.removeprefix('say_')}" for name in unsaid
    ]


def gist(fault: str) -> str:
    """A fault without the history in which it was found."""
    return fault.rpartition(" (")[0] or fault


def examine(path: str | Path, tests: dict[str, Test], wrapping: str = "") -> Iterator[Check]:
    """Run checks in this process; a known fault is not repeated, and a brain that does not compile is not run."""
    import numpy as np

    try:
        brain = brain_to_check(path, wrapping)
    except InputError as error:
        yield Check(KEEPS, str(error))
        return
    yield Check(KEEPS, None)
    known: dict[str, str] = {}
    for name, test in tests.items():
        if name == AGREES and COMPILES in known:
            continue
        with np.errstate(all="ignore"):
            fault, used = _outcome(test, brain)
        yield Check(name, "the same as above" if fault and gist(fault) in known.values() else fault, used)
        if fault:
            known[name] = gist(fault)


def fault_of(test: Test, brain: brains.Brain) -> str | None:
    """What a check finds wrong, or None."""
    return _outcome(test, brain)[0]


def _outcome(test: Test, brain: brains.Brain) -> tuple[str | None, bool]:
    """What a check finds wrong, or None, and whether the brain has the part that it checks."""
    from swarmcensus.checks.sample_states import NotUsed, Violation, in_a_line

    try:
        test(brain)
    except NotUsed:
        return None, False
    except Violation as fault:
        return str(fault), True
    except Exception as error:
        return in_a_line(error), True
    return None, True


def report(path: str, patience: float, wrapping: str = "") -> None:
    """In the child process: print each check's name before it runs, and its `Check` afterwards, as lines of JSON."""

    def timed(name: str, test: Test) -> Test:
        def run(brain: brains.Brain) -> None:
            print(json.dumps([name]), flush=True)
            bound_memory(COMPILE_MEMORY_BYTES if name == COMPILES else MEMORY_BYTES)
            with _bounded_time(COMPILE_PATIENCE if name == COMPILES else patience, str(brain.path)):
                test(brain)

        return run

    for result in examine(path, {name: timed(name, test) for name, test in checks().items()}, wrapping):
        print(json.dumps([result.name, result.fault, result.used]), flush=True)


def single_life(path: str | Path, wrapping: str = "") -> str | dict[str, int | None]:
    """At which reading of a day single and double precision part, by the names of `Departure`; or why it ended."""
    brain = brain_to_check(path, wrapping)
    done = _child("live", path, COMPILE_PATIENCE, wrapping)
    if done.returncode:
        return _why_it_ended(done, brain, "", (path, COMPILE_PATIENCE, wrapping))[0]
    return json.loads(done.stdout)  # type: ignore[no-any-return]


def live(path: str, patience: float, wrapping: str = "") -> None:
    """In a child process: print a brain's life in single precision, as JSON."""
    from swarmcensus.checks.single_life import life

    with _bounded_time(patience):
        print(json.dumps(life(brain_to_check(path, wrapping))._asdict()))


def call_by_call(path: str, patience: float, wrapping: str = "") -> None:
    """In a child process: find out which compiled function does not return."""
    from swarmcensus.checks.machine_code import step_by_step

    run = step_by_step(brain_to_check(path, wrapping))
    with _bounded_time(patience):
        run()


@contextlib.contextmanager
def _bounded_time(patience: float, file: str = "") -> Iterator[None]:
    """End this process, with a traceback, after so many seconds of the processor; much later by the clock.

    A call of a function in this file, the brain's, gets as many seconds more, and if it returns, the brain is slow.
    """
    first_call: FrameType | None = None

    def look(_: int, frame: FrameType | None) -> None:
        nonlocal first_call
        frames = [one for one, _ in traceback.walk_stack(frame)]
        first_call = first_call or next((one for one in frames[::-1] if one.f_code.co_filename == file), None)
        if first_call is None:
            signal.raise_signal(signal.SIGPROF)
        elif first_call not in frames:
            print(SLOW, file=sys.stderr, flush=True)
            os._exit(1)

    if TELLS_CPU_TIME:
        faulthandler.register(signal.SIGPROF, chain=True)  # works while machine code runs, too
        signal.setitimer(signal.ITIMER_PROF, patience * (2.0 if file else 1.0))
    if TELLS_CPU_TIME and file:
        signal.signal(signal.SIGVTALRM, look)
        signal.setitimer(signal.ITIMER_VIRTUAL, patience, patience / LOOKS)
    faulthandler.dump_traceback_later(patience * (LONGER if TELLS_CPU_TIME else 1.0), exit=True)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
        for timer in (signal.ITIMER_PROF, signal.ITIMER_VIRTUAL) if TELLS_CPU_TIME else ():
            signal.setitimer(timer, 0.0)


def _child(what: str, path: str | Path, patience: float, wrapping: str) -> subprocess.CompletedProcess[str]:
    folders = os.pathsep.join(folder or str(Path.cwd()) for folder in sys.path)
    return subprocess.run(
        [sys.executable, "-P", "-c", CHILD.format(what), str(path), str(patience), wrapping, str(os.getpid())],
        env=os.environ | {"PYTHONPATH": folders, "PYTHONUTF8": "1"},
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        check=False,
    )


def _why_it_ended(
    done: subprocess.CompletedProcess[str], brain: brains.Brain, name: str, arguments: tuple[str | Path, float, str]
) -> tuple[str, bool]:
    """What is wrong, and whether that is decided."""
    patience = COMPILE_PATIENCE if name == COMPILES else arguments[1]
    slow = f"the check itself took longer than {patience:g} s: the brain is slow"
    timed_out = "Timeout (" in done.stderr
    if timed_out and TELLS_CPU_TIME:
        waited = f"the machine gave it less than {patience:g} s of a processor in {patience * LONGER:g} s"
        return f"{waited}: try again when less runs", False
    if done.returncode < 0 and not (TELLS_CPU_TIME and done.returncode == -signal.SIGPROF):
        died = signal.Signals(-done.returncode).name
        return f"it ends its process by {died}{DEATHS.get(died, '')}", True
    if done.returncode > 0 and not timed_out:
        last = (done.stderr.strip().splitlines() or ["no more is said"])[-1]
        return (slow, False) if last.endswith(SLOW) else (f"it ends its process: {last}", True)
    frames = re.findall(r'File "(.*)", line (\d+) in (\w+)', done.stderr)
    file = str(brain.path).encode("ascii", "backslashreplace").decode()  # as faulthandler writes it
    own = [(line, function) for where, line, function in frames if where == file]
    if own:
        called = own[-1][1]
        helper = f" (in {own[0][1]})" if own[0][1] != called else ""
        return f"{called} did not return within {patience:g} s: it was at line {own[0][0]}{helper}", True
    if name == COMPILES:
        return f"Numba did not compile it within {patience:g} s", True
    if name != AGREES:
        return slow, False
    again = _child("call_by_call", *arguments)
    hangs = again.returncode and again.stdout
    if not hangs and not brain.steers:
        return slow, False
    last = again.stdout.splitlines()[-1] if hangs else "steer"
    return f"compiled, {last} did not return within {patience:g} s, though in CPython it does", True
