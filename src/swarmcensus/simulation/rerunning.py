"""Finds the line at which a brain fails: machine code names none, so another process runs the trial in CPython."""

import contextlib
import dataclasses
import faulthandler
import io
import os
import pickle
import subprocess
import sys
import threading
import traceback
import types
from collections.abc import Sequence
from typing import Any

import numpy as np

from swarmcensus.brains import Brain
from swarmcensus.simulation.rides import run_ride
from swarmcensus.simulation.trials import Metrics, run_batch
from swarmcensus.studies import Setting
from swarmcensus.support.errors import InputError

COMMAND = "from swarmcensus.simulation.rerunning import main; main()"
SECONDS = 20.0  # of a trial; later failures keep their lines to themselves
LINES: dict[Any, str] = {}  # by brains and what they fail with: other trials of a study mostly fail at the same line
LOOKING = threading.Lock()


def line_of_failure(setting: Setting, seed: int, trial: int, metrics: Metrics, error: InputError) -> str:
    """The place where the brain fails, as ", at my_brain.py, line 12: x = 1 / me.n"; empty if it is not found."""
    cause = error.__cause__
    if cause is None:
        return ""
    key = setting.brains, repr(cause)
    with LOOKING:
        if key not in LINES:
            LINES[key] = _line(cause, setting.brains) or _found(setting, seed, trial, metrics)
        return LINES[key]


def _found(setting: Setting, seed: int, trial: int, metrics: Metrics) -> str:
    asked = packed((setting, seed, trial, dataclasses.replace(metrics, watched=())))
    try:
        found = subprocess.run(
            [sys.executable, "-P", "-W", "ignore", "-c", COMMAND], input=asked, capture_output=True, timeout=SECONDS,
            env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, start_new_session=True,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return found.stdout.decode(errors="replace")


def main() -> None:
    """Write the line of the trial that standard input has."""
    faulthandler.dump_traceback_later(SECONDS, exit=True)  # also if nobody waits for it any more
    setting, seed, trial, metrics = pickle.load(sys.stdin.buffer)
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what files of users print is no answer
    go_on = np.zeros(1, np.uint8)
    try:
        with np.errstate(divide="raise", invalid="raise"):  # which machine code raises, and NumPy's numbers do not
            if setting.body is None:
                run_batch(setting, seed, trial, 1, metrics, go_on)
            else:
                run_ride([setting], seed, trial, metrics, go_on)
    except InputError as error:
        if error.__cause__:
            answers.write(_line(error.__cause__, setting.brains))
    answers.flush()


def _line(error: BaseException, brains: Sequence[Brain]) -> str:
    """The line of an error in a brain, of which the engine runs a copy."""
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        for brain in brains:
            line = dict(enumerate(brain.source.splitlines(), start=1)).get(frame.lineno or 0, "").strip()
            if line and line == frame.line:
                return f", at {brain.path}, line {frame.lineno}: {line}"
    return ""


class _Packer(pickle.Pickler):
    def reducer_override(self, thing: Any) -> Any:
        """Brains without their modules, which are made of their source, and without what is computed once."""
        if isinstance(thing, types.ModuleType):
            return _no_module, ()
        if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
            return type(thing), tuple(getattr(thing, field.name) for field in dataclasses.fields(thing) if field.init)
        return NotImplemented


def _no_module() -> types.ModuleType:
    return types.ModuleType("unloaded")  # pickle finds no class of modules by its name


def packed(thing: Any) -> bytes:
    """Settings for another process; nothing if they hold what no other process can have."""
    into = io.BytesIO()
    with contextlib.suppress(pickle.PicklingError, TypeError, AttributeError):
        _Packer(into).dump(thing)
        return into.getvalue()
    return b""
