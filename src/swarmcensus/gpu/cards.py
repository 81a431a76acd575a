"""A card that runs batches of trials on fixed networks, to the bits of the CPU's engine."""

import hashlib
import math
import threading
from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from swarmcensus.brains import numbers as numbers_of, slots
from swarmcensus.engine import Inputs
from swarmcensus.engine.codegen import message_numbers
from swarmcensus.engine.constants import FULL, LISTED, PART
from swarmcensus.gpu.collecting import Arrays, are_wrong, batch_of, bounds_of, differences
from swarmcensus.gpu.driver import Buffer, CardError, CardFull, Cuda, keep, kept
from swarmcensus.gpu.kernel_arguments import ARRAYS, Given
from swarmcensus.gpu.source import MOST_STAGED, Features, measures, source
from swarmcensus.simulation import Batch, Metrics, bins_at, foreknowledge, inputs_of, run_batch, seconds
from swarmcensus.studies import Setting
from swarmcensus.support.errors import BrainError, InputError
from swarmcensus.translation import owed_numbers

MOST_IN_A_BLOCK = 1024  # threads, and so robots of a trial that one block can run
FEW_WORDS = 36  # of a state that threads keep in registers, if so many run in a block; larger ones are spilled
THREADS = 128  # of a block that runs several small trials, or robots or rows one by one
BLOCK_SIZE = 256  # robots of a block of a large swarm, whose messages are added up together (kernels/sums.h)
SHARED = 227 * 1024  # bytes of shared memory that a block may take, where the card has them (Hopper)
FOR_QUANTILES = 1120  # bytes of it
DIGITS, TALLIES = 8, 4096  # of a key, and bytes of the tallies of one digit, to find quantiles of wide rows
PIECE = 1 << 14  # robots of a row of which one block finds the extremes
ALIGNED = 256  # bytes
FAILED = "brain_failed"  # a variable of programs: whether Python would have raised an error
CHUNK = 64  # rounds that one block looks at for agreement
SPARE = 0.9  # the share of the free memory that a batch may take
MOST_WORK = 300.0  # seconds on one core that a batch would take: about one on a card
LONGEST = 3.0  # seconds on one core of a trial that is not cut into launches
MOST_BLOCKS = 1 << 30  # of a launch
MOST_COMPARED = 1000  # robots of a trial by which a program is compared with the CPU
LAUNCHES = 64  # rounds of a large swarm between two looks at whether to stop

# kernels that know of no brain
MEASURES = ("tables", "settle", "extremes", "tally", "choose", "agree", "check", "decide")


def why_not(setting: Setting, metrics: Metrics) -> str | None:
    """Why a card cannot run a setting; None if it can."""
    if setting.body is not None:
        return "robots move"
    if setting.spread is not None:
        return "each trial draws its fill ratio"
    return "metrics of files are measured" if metrics.watched else None


class Sizes(NamedTuple):
    """What a trial of a setting takes."""

    trials: int
    robots: int
    rounds: int  # or observations, of local estimates
    slots: int  # of messages
    message: int  # bytes
    words: int  # of eight bytes that a robot's state may take
    features: Features
    seconds: float  # that a trial takes on one core
    most_shared: int  # bytes of shared memory that a block may have
    in_rounds: bool = False  # whether a trial is run round by round however small it is

    @property
    def shared(self) -> int:
        """Bytes of shared memory that one trial takes in a block."""
        full = self.features.mode == FULL
        blocks = -(-self.robots // BLOCK_SIZE)
        sums = (2 * self.robots + 3 * blocks) * self.message if full else 0
        return self.slots * self.robots * (self.message + 1) + sums + 8

    @property
    def is_small(self) -> bool:
        """Whether one block can run a trial, and not for long."""
        most = MOST_IN_A_BLOCK if self.words <= FEW_WORDS else MOST_IN_A_BLOCK // 2
        return not self.in_rounds and self.robots <= most and self.shared <= self.most_shared and self.seconds < LONGEST

    @property
    def bytes(self) -> int:
        """Bytes of memory that a trial takes, at most."""
        robots = self.robots
        large = 0 if self.is_small else robots * (8 * self.words + self.slots * (self.message + 1) + 2 * self.message)
        decisions = 2 * self.rounds * (robots + 1) if self.features.judged else 0
        each = 8 * robots + 20 + 2 * TALLIES * (robots > PIECE)
        return (self.rounds + 1) * each + large + decisions + robots * 512


class Card:
    """A graphics card, behind its driver."""

    def __init__(self, driver: Cuda) -> None:
        """Use a card."""
        self.driver = driver
        self.name = driver.name
        self._room: Buffer | None = None  # kept for the next batch: making room takes longer than a small batch
        self._held: _BatchOnCard | None = None  # the last batch: if it was stopped, its kernels may still run
        self._lock = threading.Lock()  # one batch at a time
        self._checked = set[str]()  # programs that were compared with the CPU

    def room(self, size: int) -> Buffer:
        """Memory for so many bytes or more. Raises CardFull."""
        if self._room is None or self._room.size < size:
            self._room = None  # is freed before there is more
            self._room = self.driver.empty(size)
        return self._room

    def most_trials(self, setting: Setting, metrics: Metrics, local: bool = False) -> int:
        """How many trials of a setting can be run at a time, but for their links.

        Raises CardFull where there is no memory for one.
        """
        features = Features(
            mode=FULL if setting.additive else LISTED,
            sound=True, jams=False, signalled=True, lucky=True, judged=_has_verdicts(setting, local),
            bounded=_has_intervals(setting, local), changes=True,
        )  # fmt: skip
        sizes = self._sizes(setting, 1, features, local)
        room = (self.driver.free() + (self._room.size if self._room else 0)) * SPARE
        kept = 8 * len(metrics.checkpoints) * setting.robots * (3 if features.bounded else 1)
        most = int(room // (sizes.bytes + kept))
        if most < 1:
            raise CardFull(
                f"the card {self.name} has {room / 1e6:,.0f} MB of free memory, and one trial of {setting} takes "
                f"{(sizes.bytes + kept) / 1e6:,.0f} MB: run it on the CPU, or with fewer rounds"
            )
        return max(1, min(most, int(MOST_WORK / sizes.seconds), MOST_BLOCKS // sizes.rounds))

    def _sizes(self, setting: Setting, trials: int, features: Features, local: bool) -> Sizes:
        brains = setting.brains
        number = 4 if setting.precision == "single" else 8
        fields = max(len(slots(brain.lengths)) + len(slots(brain.message)) + 4 for brain in brains)
        return Sizes(
            trials, setting.robots, rounds=setting.rounds * (setting.observations_per_round if local else 1),
            slots=(0 if local else setting.message_delay) + 2,
            message=number * len(message_numbers(brains[0], len(brains) > 1)), words=fields + 8, features=features,
            seconds=seconds(setting, local), most_shared=min(SHARED, self.driver.shared),
        )  # fmt: skip

    def compile_for(self, kinds: Iterable[tuple[Setting, bool]], seed: int) -> None:
        """Compile together what batches of some settings run, each local or not. Raises InputError."""
        # programs are for all parameters and fill ratios
        few = {(replace(one, brain=one.brain.as_written, fill_ratio=0.5), local) for one, local in kinds}
        of = ((one, local, features_of(*_smaller(one, seed, local), local)) for one, local in few)
        sources = (_source(one, self._sizes(one, 1, features, local), local) for one, local, features in of)
        self.driver.compile(chain([measures()], sources))

    def run_batch(
        self, setting: Setting, seed: int, first: int, trials: int, metrics: Metrics, stop: np.ndarray,
        local: bool = False,
    ) -> Batch | None:  # fmt: skip
        """Run trials as `simulation.run_batch` does; None if `stop` was set meanwhile.

        A trial in which a brain fails is run again by the CPU, which says why. Raises BrainError where that is one of
        several trials, and CardError for a program that is not `checked`.
        """
        given = inputs_of(setting, seed, first, trials, order=local)
        features = features_of(setting, given, local)
        sizes = self._sizes(setting, trials, features, local)
        self._check(setting, seed, sizes, metrics, stop, local)
        return self._run(setting, seed, given, sizes, metrics, stop, local)

    def _check(
        self, setting: Setting, seed: int, sizes: Sizes, metrics: Metrics, stop: np.ndarray, local: bool
    ) -> None:
        """Compare a trial of few robots with the CPU's, once for each program, card and driver. Raises CardError."""
        programs = "\0".join((self.driver.about, _source(setting, sizes, local), measures()))
        mark = hashlib.sha256(programs.encode()).hexdigest()
        if mark in self._checked or kept(mark):
            return
        few, given = _smaller(setting, seed, local)
        small = self._sizes(few, 1, sizes.features, local)._replace(in_rounds=not sizes.is_small)
        try:
            ours = run_batch(few, seed, 0, 1, metrics, stop, local)
            theirs = self._run(few, seed, given, small, metrics, stop, local) if ours else None
        except BrainError:  # is found again where it counts
            return
        if ours and theirs:
            if found := differences(few, ours, theirs, local):
                what = f"{', '.join(found)} of a trial of {few} are not those of the CPU"
                raise CardError(f"{self.name} computes wrongly: {what}: run it on the CPU (--device cpu)")
            self._checked.add(mark)
            keep(mark, b"checked")

    def _run(
        self, setting: Setting, seed: int, given: Inputs, sizes: Sizes, metrics: Metrics, stop: np.ndarray, local: bool
    ) -> Batch | None:
        """Run the trials of some inputs, as `run_batch` does."""
        with self._lock:
            try:
                held = self._held = _BatchOnCard(self, given, sizes, setting, metrics, local)
            except CardFull:  # what earlier batches left may be in the way
                if self._room is None:
                    raise
                self._held = self._room = None
                held = self._held = _BatchOnCard(self, given, sizes, setting, metrics, local)
            found = held.run(stop)
        if found is None:
            return None
        if held.failed or found["amiss"].any() or are_wrong(setting, given, found):
            first, last = given.first, given.first + sizes.trials - 1
            if last > first:
                raise BrainError(f"a brain fails in one of trials {first} to {last} of {setting}")
            return run_batch(setting, seed, first, 1, metrics, stop, local)
        return batch_of(setting, given, sizes.features, metrics, found, held.bounds, local)


def _smaller(setting: Setting, seed: int, local: bool) -> tuple[Setting, Inputs]:
    """A setting with fewer robots, if it can have them, and a trial of it. Raises InputError."""
    try:
        few = replace(setting, robots=min(setting.robots, MOST_COMPARED))
        return few, inputs_of(few, seed, 0, 1, order=local)
    except (InputError, ValueError):  # a network of a file, or groups of robots, that need their number
        return setting, inputs_of(setting, seed, 0, 1, order=local)


def features_of(setting: Setting, given: Inputs, local: bool = False) -> Features:
    """What the rounds of a setting have."""
    brains, sensors = setting.brains, given.sensors
    return Features(
        mode=LISTED if local else given.links.mode,
        sound=given.radio.threshold == 0 and given.stops.shape[2] == 0, jams=any(brain.jams for brain in brains),
        signalled=len(brains) > 1 or brains[0].uses.silence or brains[0].jams, lucky=given.draws.size > 0,
        judged=_has_verdicts(setting, local), bounded=_has_intervals(setting, local),
        changes=sensors.drift.shape[2] > 0 or sensors.course[3] > 1.0,
    )  # fmt: skip


def _has_verdicts(setting: Setting, local: bool) -> bool:
    """Whether it is noted what robots decide, and whether they are done."""
    return not local and any(brain.decides or brain.ends for brain in setting.brains)


def _has_intervals(setting: Setting, local: bool) -> bool:
    """Whether robots are asked for intervals."""
    return not local and any(brain.has_interval for brain in setting.brains)


def _source(setting: Setting, sizes: Sizes, local: bool) -> str:
    """The program that runs a setting."""
    kernels = "alone.cu" if local else "trials.cu" if sizes.is_small else "crowds.cu"
    threads = next(n for n in (128, 256, 512, 1024) if n >= (sizes.robots if sizes.is_small and not local else 1))
    return source(tuple(brain.as_written for brain in setting.brains), sizes.features, kernels, threads)


class _BatchOnCard:
    """The arrays of a batch on a card."""

    def __init__(
        self, card: Card, given: Inputs, sizes: Sizes, setting: Setting, metrics: Metrics, local: bool
    ) -> None:
        """Compile the program, upload what it is given, and make room for what it finds."""
        self.driver, self.sizes, self.local, self.metrics = card.driver, sizes, local, metrics
        driver = self.driver
        self.formats = not local and any(brain.parts for brain in setting.brains)
        self.program = driver.build(_source(setting, sizes, local))
        self.measures = driver.build(measures())
        for group, brain in enumerate(setting.brains):
            numbers = np.array(numbers_of(brain.parameters), _number(setting))
            if numbers.size:
                driver.set_global(self.program, f"parameters_{group}", numbers.tobytes())
        self.given = Given()
        self.bounds = bounds_of(given, sizes.robots) if sizes.features.mode == LISTED else np.zeros((1, 0), np.int64)
        self.uploaded = self._upload(given, setting)
        self._make_room(card)

    def _upload(self, given: Inputs, setting: Setting) -> Buffer:
        """Upload what kernels are given, in one piece."""
        sensors, links, one = given.sensors, given.links, self.given
        if self.local and self.sizes.features.changes and sensors.b.shape[1] == 1:  # nobody waits for who makes tables
            b, w = (np.repeat(side, self.sizes.robots, axis=1) for side in (sensors.b, sensors.w))
            sensors = sensors._replace(b=b, w=w)
        keys = {"readings_key": sensors.key, "losses_key": given.radio.key, "order_key": sensors.order}
        for name, key in (keys | {"luck_key": given.draws}).items():
            getattr(one, name)[: key.size] = key.tolist()
        one.course[:] = np.asarray(sensors.course, np.float64).tolist()
        one.threshold, one.delta = int(given.radio.threshold), self.metrics.delta
        checkpoints = np.array([] if self.local else self.metrics.checkpoints, np.int64)
        honest = given.honest
        robots, trials = self.sizes.robots, self.sizes.trials
        whole = {
            "first": given.first, "trials": trials, "robots": robots, "rounds": self.sizes.rounds,
            "looks": sensors.looks, "delay": self.sizes.slots - 2, "together": self.together,
            "sensors": sensors.b.shape[1], "kinds": (sensors.looks >= PART) + (sensors.looks % PART > 0),
            "beliefs": given.beliefs[0].shape[1], "drifts": sensors.drift.shape[2],
            "stop_rows": given.stops.shape[1] if given.stops.shape[2] else 0, "graphs": links.starts.size - 1,
            "liars": int(honest.size > 0), "checkpoints": checkpoints.size, "keeps": int(self.metrics.estimates),
            "chunk": CHUNK, "piece": PIECE if robots > PIECE else 0,
        }  # fmt: skip
        for name, value in whole.items():
            setattr(one, name, int(value))
        counted = honest.sum(axis=1) if honest.size else np.full(trials, robots)
        bins = bins_at(setting.fill_ratio, setting.change, tuple(checkpoints.tolist()), self.metrics.bins)
        arrays = {
            "b": sensors.b, "w": sensors.w, "drift": sensors.drift, "assumed_b": given.beliefs[0],
            "assumed_w": given.beliefs[1], "blanks": _blanks(setting, self.local), "stops": given.stops,
            "bounds": self.bounds,
            "senders": links.senders, "groups": given.group.astype(np.uint8), "honest": honest.astype(np.uint8),
            "counted": counted.astype(np.int64), "rounds_of": checkpoints, "bins": bins,
        }  # fmt: skip
        places, size = _places({name: array.nbytes for name, array in arrays.items()})
        piece = np.empty(size, np.uint8)
        for name, array in arrays.items():
            piece[places[name] : places[name] + array.nbytes] = np.ascontiguousarray(array).reshape(-1).view(np.uint8)
        buffer = self.driver.upload(piece)
        self._point(places, buffer)
        return buffer

    def _make_room(self, card: Card) -> None:
        """Make room for what kernels find, in one piece to download, and for what they work with."""
        sizes, checks = self.sizes, self.given.checkpoints
        trials, robots, rounds, features = sizes.trials, sizes.robots, sizes.rounds, sizes.features
        each = (trials, robots)
        shapes: dict[str, tuple[int, ...]] = {"amiss": (trials,), **dict.fromkeys(("where", "value", "final"), each)}
        if not self.local:
            shapes |= {"agreed": (trials, rounds // CHUNK + 1)}
            shapes |= dict.fromkeys(("correct", "disagreement"), (checks, trials))
            shapes |= {"kept": (checks, *each)} if self.metrics.estimates else {}
            shapes |= dict.fromkeys(("sent", "heard"), each) if features.counted else {}
            shapes |= {"verdicts": (*each, 6), "unanimous": (trials, rounds)} if features.judged else {}
            shapes |= {"bounds_of": (checks, trials, 2, robots)} if features.bounded else {}
        shapes |= {"clipped": each} if self.formats else {}
        sensors, kinds, wide = self.given.sensors, self.given.kinds, bool(self.given.piece) * trials * (rounds + 1)
        types = {name: np.dtype(ARRAYS[name].removesuffix("_t")) for name in shapes}
        kept = {name: types[name].itemsize * math.prod(shape) for name, shape in shapes.items()}
        work = {
            "said": 4 * trials * (rounds + 1) if features.counted and features.mode == FULL else 0,
            "extremes": 16 * wide, "tallies": TALLIES * wide,
            "rows": 8 * trials * (rounds + 1) * robots, "tables": 8 * 16 * trials * kinds * sensors,
            "stand": 8 * 3 * trials * sensors, "sought": 64 * wide, "widths": 8 * wide,
            "decisions": 2 * trials * rounds * robots if features.judged else 0,
        }  # fmt: skip
        if not self.local and not sizes.is_small:
            blocks = -(-robots // BLOCK_SIZE)
            work |= {
                "memory": 8 * trials * robots * sizes.words, "outbox": trials * sizes.slots * robots * sizes.message,
                "signals": trials * sizes.slots * robots if features.signalled else 0,
                "parts": 3 * trials * blocks * sizes.message if features.mode == FULL else 0,
                "around": 2 * trials * robots * sizes.message if features.mode == FULL else 0,
            }  # fmt: skip
        places, size = _places(kept | work)
        self.room = card.room(size)
        self.driver.clear(self.room, places["rows"])  # what is found, and what is counted from 0
        self._point(places, self.room)
        self.piece = np.empty(places["said"], np.uint8)
        self.found: Arrays = {
            name: self.piece[places[name] : places[name] + kept[name]].view(types[name]).reshape(shape)
            for name, shape in shapes.items()
        }

    def _point(self, places: Mapping[str, int], buffer: Buffer) -> None:
        """Give the kernels the addresses of arrays in a buffer."""
        for name, place in places.items():
            assert name in ARRAYS
            setattr(self.given, name, buffer.address + place)

    @property
    def together(self) -> int:
        """How many trials a block runs."""
        if not self.sizes.is_small:
            return 1
        return max(1, min(THREADS // self.sizes.robots, self.sizes.most_shared // self.sizes.shared))

    def run(self, stop: np.ndarray) -> Arrays | None:
        """Run the trials and measure them; None if `stop` was set meanwhile."""
        sizes = self.sizes
        self.driver.set_global(self.program, FAILED, bytes(4))
        trials, robots, rounds = sizes.trials, sizes.robots, sizes.rounds
        if self.local:
            self._launch("tables", trials * self.given.sensors, tables_made=trials, k=1)
            self._launch("alone", trials * robots)
        elif sizes.is_small:
            together = self.together
            self._launch_blocks("trials", -(-trials // together), together * robots, together * sizes.shared)
        elif not self._run_crowd(stop):
            return None
        self._launch("settle", trials * robots)
        if not self.local:
            threads = min(-(-robots // 32) * 32, MOST_IN_A_BLOCK)
            if piece := self.given.piece:
                pieces = -(-robots // piece)
                self._launch_blocks("extremes", trials * (rounds + 1) * pieces, threads, FOR_QUANTILES)
                for n in reversed(range((rounds // CHUNK + 1) * DIGITS)):
                    digit = {"chunk_at": n // DIGITS, "k": DIGITS - 1 - n % DIGITS}
                    self._launch_blocks("tally", trials * CHUNK * pieces, threads, TALLIES, **digit)
                    self._launch_blocks("choose", trials * CHUNK, 2 * THREADS, TALLIES)
            else:
                self._launch_blocks("agree", trials * (rounds // CHUNK + 1), threads, FOR_QUANTILES)
            if self.given.checkpoints:
                self._launch_blocks("check", trials * self.given.checkpoints, threads, FOR_QUANTILES)
            if sizes.features.judged:
                self._launch_blocks("decide", trials * rounds, threads, FOR_QUANTILES)
        if not self.driver.wait(stop):
            return None
        self.failed = any(self.driver.get_global(self.program, FAILED, 4))
        self.driver.download(self.room, self.piece)
        return self.found

    def _run_crowd(self, stop: np.ndarray) -> bool:
        """Run a large swarm, round by round; False if `stop` was set meanwhile."""
        sizes, sensors = self.sizes, self.given.sensors
        trials, blocks, full = sizes.trials, -(-sizes.robots // BLOCK_SIZE), sizes.features.mode == FULL
        for k in range(sizes.rounds + 1):
            if k % LAUNCHES == LAUNCHES - 1 and not self.driver.wait(stop):
                return False
            if k < sizes.rounds and (k == 0 or sizes.features.changes):
                self._launch("tables", trials * sensors, tables_made=trials, k=k + 1)
            if full and k > self.given.delay:
                self._launch_blocks("sums", trials * blocks, 32, 0, k=k)
                staged = sizes.message + MOST_STAGED * 8
                self._launch_blocks("chains", trials, THREADS, staged, k=k)
                self._launch_blocks("around", trials * blocks, 64, 0, k=k)
            self._launch("rounds", trials * sizes.robots, k=k)
        return True

    def _launch(self, kernel: str, items: int, **numbers: int) -> None:
        self._launch_blocks(kernel, -(-items // THREADS), THREADS, 0, **numbers)

    def _launch_blocks(self, kernel: str, blocks: int, threads: int, shared: int, **numbers: int) -> None:
        for name, value in numbers.items():
            setattr(self.given, name, value)
        program = self.measures if kernel in MEASURES else self.program
        self.driver.launch(program, kernel, blocks, -(-threads // 32) * 32, shared, bytes(self.given))


def _places(sizes: Mapping[str, int]) -> tuple[dict[str, int], int]:
    """Where arrays of so many bytes begin in one piece of memory, and how long that is."""
    places, at = {}, 0
    for name, size in sizes.items():
        places[name] = at
        at += -(-size // ALIGNED) * ALIGNED
    return places, at


def _number(setting: Setting) -> np.dtype[Any]:
    return np.dtype(np.float32 if setting.precision == "single" else np.float64)


def _blanks(setting: Setting, local: bool) -> np.ndarray:
    """The states of all brains before their first observation, as they lie in C."""
    schedule = foreknowledge(setting, alone=local)
    flat: list[float] = []
    for brain in setting.brains:
        flat += numbers_of(brain.memory | (schedule if brain is setting.brain else {}))
        flat += [0.0] * (2 + brain.uses.luck + brain.uses.name + owed_numbers(brain))
    return np.array(flat, _number(setting))
