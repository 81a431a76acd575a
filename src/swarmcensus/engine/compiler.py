"""From sources to machine code: the engine's loops once a machine, few short functions for every brain."""

import functools
import types
from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np

from swarmcensus.brains import Brain, codec_source, is_shipped
from swarmcensus.brains.metrics import GIVEN, Metric
from swarmcensus.engine import codegen
from swarmcensus.engine.code_cache import LOCK, folder_name, is_kept, module, not_compiled, source
from swarmcensus.engine.constants import HELPERS, PHASES
from swarmcensus.engine.records import record_type
from swarmcensus.support.errors import InputError, without_colours

LOOPS = (
    "world", "scores", "failures", "states", "shared_trials", "agreement", "trial_arguments", "compiled_apart",
    "rounds", "kernel", "living", "motion", "neighbours", "walk", "riding", "steering",
)  # fmt: skip  # files of the engine that know of no brain: together, so that a process compiles once what they share
ALWAYS = ("begin", "sense", "believe")  # what of a brain is needed with whatever neighbours
ONE_BY_ONE, IN_SUMS, IN_SUMS_OF_ALL = "one by one", "in sums", "in sums of all"
HEARING = {  # and what by how a round's messages reach robots on fixed networks
    ONE_BY_ONE: {"hear", "end_round"},
    IN_SUMS: {"hear_sums"},
    IN_SUMS_OF_ALL: {"add_up", "pass_on", "hear_all"},
}


Piece = tuple[str, str]  # of machine code: its folder in the cache, and a pattern of its files (see `is_kept`)


class NotCompiled(Exception):
    """A brain of which Numba makes no machine code, in Numba's own words."""

    def __init__(self, brain: Brain, said: str) -> None:
        """Say which, and why."""
        super().__init__(said)
        self.brain = brain


class ArrayLayout(NamedTuple):
    """How a brain's states and messages lie in the engine's arrays."""

    record: np.dtype  # a state, with the brain's names
    blank: np.ndarray  # (byte): a state before its first observation: MEMORY, parameters, zeros for what is given
    number: np.dtype  # a number of a message
    message_bytes: int  # that are kept of a message
    is_signalled: bool  # whether a robot may be silent or jam
    clipped: int  # which byte of a state begins its count of messages that its format cannot hold; -1 without a format

    def records(self, states: np.ndarray) -> np.ndarray:
        """States (..., byte) as records (...)."""
        return states.view(self.record)[..., 0]


@functools.lru_cache(maxsize=256)
def array_layout(brain: Brain, mixed: bool = False) -> ArrayLayout:
    """The layout of a brain's states and messages; in a `mixed` swarm other brains hear the messages, too."""
    record = record_type(codegen.record_fields(brain))
    state = np.zeros(1, record)
    for name, value in (brain.memory | brain.parameters).items():
        state[name] = value
    blank = state.view(np.uint8)
    blank.flags.writeable = False
    number = np.dtype(np.float32 if brain.numbers.precision == "single" else np.float64)
    size = number.itemsize * len(codegen.message_numbers(brain, mixed))
    clipped = record.fields[codegen.CLIPPED][1] if brain.parts and record.fields else -1
    return ArrayLayout(record, blank, number, size, codegen.is_signalled(brain, mixed), clipped)


def blank_record(metric: Metric, **given: float) -> np.ndarray:
    """What a metric's record is before `begin`, shape (1,): what is GIVEN, and its fields."""
    record = np.zeros(1, record_type([(name, "f8") for name in (*GIVEN, *metric.fields)]))
    for name, value in given.items():
        record[name] = value
    return record


def compile_brain(brain: Brain, use: str = "network", exact: bool = False, mixed: bool = False) -> Any:
    """The addresses of a brain's functions, by their places in `constants.py`, as the engine's loops take them.

    Only what the use needs is there: one of HEARING on fixed networks where that is known, else "network", or
    "moving", "alone" (local estimates) or "recorded". Brains that differ in comments or parameters share machine code;
    `exact` is for messages that name a line of the very file; a `mixed` swarm has several brains. Raises NotCompiled.
    """
    return _compiled(brain.as_written, use, exact, mixed)


@functools.lru_cache(maxsize=256)
def _compiled(brain: Brain, use: str, exact: bool, mixed: bool) -> Any:
    needed = needs(brain, use, mixed)
    try:
        return _addresses(phases_of(brain, exact, mixed), PHASES, needed)
    except (MemoryError, InputError):
        raise
    except Exception as error:
        raise NotCompiled(brain, without_colours(error)) from error


def compile_helpers(needed: Collection[str]) -> Any:
    """The addresses of functions that the engine calls, by their places in `constants.py`."""
    return _addresses(compile_world("compiled_apart"), HELPERS, needed)


def _addresses(module: types.ModuleType, names: Collection[str], needed: Collection[str]) -> Any:
    """The addresses of a module's functions that are needed, by their places among all names."""
    with LOCK:
        addresses = [getattr(module, name).address() if name in needed else None for name in names]
    if not_compiled():
        return np.array(addresses, object)
    return np.array([address or 0 for address in addresses], np.uint64)


def needs(brain: Brain, use: str, mixed: bool = False) -> set[str]:
    """Which of a brain's functions a use calls."""
    if use == "alone":
        return {"begin", "go_alone", "believe"}
    ways = {use} if use in HEARING else {ONE_BY_ONE}
    if use in ("network", "moving") and brain.sums and not mixed:
        ways |= {IN_SUMS} if use == "moving" and not brain.is_oracle else {IN_SUMS, IN_SUMS_OF_ALL}
    judged = {"judge"} if mixed or brain.decides or brain.ends else set()
    asked = {"ask"} if use == "moving" and brain.steers else set()
    bounded = {"bound"} if brain.has_interval else set()
    return {*ALWAYS, *judged, *asked, *bounded}.union(*(HEARING[way] for way in ways))


def phases_of(brain: Brain, exact: bool = False, mixed: bool = False) -> types.ModuleType:
    """The module `brain_calls.py` around a brain, none of it compiled yet."""
    return module(_brain_files(brain, exact or not_compiled(), mixed), "brain_calls")  # a debugger wants the very file


@functools.lru_cache(maxsize=64)
def compile_metric(metric: Metric) -> types.ModuleType:
    """The module `watching.py` around a metric."""
    files = {"__init__.py": "", "metric.py": metric.source, "gauge.py": codegen.of_metric(metric)}
    return module(files | {"watching.py": source("watching.py")}, "watching")


@functools.cache
def compile_world(name: str = "world") -> types.ModuleType:
    """The engine's entry points of one file, which know of no brain."""
    return module(_loop_files(), name)


def compile_loop(name: str) -> None:
    """Compile one of the engine's loops before there is anything to run: a file's name, a dot, and a function's."""
    file, _, function = name.partition(".")
    getattr(compile_world(file), function).address()


def is_known(world: str, entry: str) -> bool:
    """Whether machine code of one of the engine's entry points is on disk."""
    return is_kept(*loop_piece(world, entry))


def loop_piece(world: str, entry: str) -> Piece:
    """One of the engine's entry points."""
    return folder_name(_loop_files()), f"{world}.{entry}-*.nbc"


def is_compiled(brain: Brain, use: str = "network", mixed: bool = False) -> bool:
    """Whether all that a use needs of a brain is on disk as machine code."""
    return all(is_kept(*piece) for piece in pieces(brain, use, mixed))


def pieces(brain: Brain, use: str = "network", mixed: bool = False) -> set[Piece]:
    """All that a use needs of a brain."""
    folder = folder_name(_brain_files(brain, mixed=mixed))
    return {(folder, f"brain_calls.{name}-*.nbc") for name in needs(brain, use, mixed)}


@functools.cache
def _loop_files() -> dict[str, str]:
    return {"__init__.py": "", **{f"{name}.py": source(f"{name}.py") for name in LOOPS}}


@functools.lru_cache(maxsize=256)
def _brain_files(brain: Brain, exact: bool = False, mixed: bool = False) -> dict[str, str]:
    return {
        "__init__.py": "",
        "brain.py": brain.running_source if exact else codegen.essence(brain.running_source, not is_shipped(brain)),
        "robot.py": codegen.of_brain(brain, mixed),
        "brain_calls.py": source("brain_calls.py"),
    } | ({"codec.py": codec_source(brain.numbers.precision)} if brain.parts else {})
