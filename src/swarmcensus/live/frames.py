"""One trial as a page sees it: frames as bytes.

A message of frames is little-endian. It begins with eight 32-bit words: `KIND`, side, number of frames, of robots, of
columns, the layers present, number of links, 0. Then follow, for all frames, the numbers (f64, see COLUMNS), rounds
(u32), start of each frame's links and their end (u32), layers (u16, robot by robot), flags and headings (u8, robot by
robot), and links: pairs of robots (u16) if they move, else one number per edge (u8), 1 if it carried a message.
"""

from collections import OrderedDict

import numpy as np

from swarmcensus.engine.constants import SLACK
from swarmcensus.figures import edges_drawn
from swarmcensus.simulation import DECIDED, ENDS, IS_DONE, Stretch, Trace, free, right_option
from swarmcensus.studies import Measure
from swarmcensus.support.bins import on_edges, right_bins

KIND = 0x53574152
COLUMNS = (
    "truth", "mean", "deviation", "lowest", "low", "median", "high", "highest", "right", "sent", "heard", "bytes",
    "interval_low", "interval_high", "decided", "decided_right", "done", "black", "white",
)  # fmt: skip  # of the honest robots that have an estimate; only the numbers of messages are of all robots
QUARTERS = ("lowest", "low", "median", "high", "highest")
COUNTS = ("sent", "heard", "bytes")
HAS_INTERVALS, HAS_DECISIONS, MOVES = 1, 2, 4
LOOKED, READ_BLACK, ON_BLACK, DONE = 1, 2, 4, 8  # flags of a robot; the upper four bits are its option + 1
SCALE = 65_535
NO_ESTIMATE = 65_535  # in the layer of estimates, where 1 is stored as 65,534
MOST_PAIRS = 5_000  # of robots in range, in a frame
KEPT = 4  # stretches with kept frames
Encoded = tuple[np.ndarray, np.ndarray, np.ndarray]


class Show:
    """A trace that is watched."""

    def __init__(self, trace: Trace, measure: Measure) -> None:
        """Prepare the trial; `measure` gives the truth and the bins."""
        self.trace, self.bins, self.delta = trace, measure.bins, measure.delta
        self.setting = setting = trace.setting
        self.honest, self.moves = trace.honest, setting.body is not None
        self.opinions = setting.brain.is_opinion  # estimates are 0 or 1, and in no bin
        self.edges = edges_drawn(trace.given.links, 0 if self.moves else setting.robots)
        self._encoded: OrderedDict[int, tuple[Stretch, Encoded]] = OrderedDict()  # by their first rounds
        self._on_floor = measure.truth == "floor" and self.moves
        names = {name for brain in setting.brains for name in brain.memory}
        self._names = [free(name, names) for name in (DECIDED, IS_DONE, *ENDS)]

    @property
    def rounds(self) -> int:
        """How many rounds there are, for now if logs still grow."""
        return self.trace.rounds

    def frames(self, ticks: list[int], side: int = 0) -> bytes:
        """The frames of these rounds as bytes."""
        numbers, layers, flags, links, starts = [], [], [], [], [0]
        for tick in ticks:
            stretch, row = self.trace.find(tick)
            stretch_numbers, stretch_layers, stretch_flags = self._encode(stretch)
            numbers.append(stretch_numbers[row])
            layers.append(stretch_layers[:, row])
            flags.append(stretch_flags[:, row])
            links.append(self._links(stretch, row))
            starts.append(starts[-1] + len(links[-1]))
        kind = np.uint16 if self.moves else np.uint8
        words = [KIND, side, len(ticks), self.setting.robots, len(COLUMNS), self.layers, starts[-1], 0]
        return b"".join(
            part.tobytes()
            for part in (
                np.array(words, "<u4"), np.array(numbers, "<f8"), np.array(ticks, "<u4"), np.array(starts, "<u4"),
                np.array(layers, "<u2"), np.array(flags, np.uint8), *(np.asarray(pairs, kind) for pairs in links),
            )
        )  # fmt: skip

    @property
    def layers(self) -> int:
        """The layers of a frame besides estimates: positions if robots move, intervals, decisions."""
        brains = self.setting.brains
        intervals = HAS_INTERVALS * any(brain.has_interval for brain in brains)
        return intervals + HAS_DECISIONS * any(b.decides or b.ends for b in brains) + MOVES * self.moves

    def _encode(self, stretch: Stretch) -> Encoded:
        """Numbers (round, column), layers (layer, round, robot), flags and headings (2, round, robot) of a stretch."""
        if (known := self._encoded.get(stretch.first)) is not None and known[0] is stretch:
            return known[1]
        x = stretch.estimates
        x = np.where((x >= -SLACK) & (x <= 1.0 + SLACK), x, np.nan)  # where it is no fill ratio there is no estimate
        rounds = np.arange(len(stretch.estimates)) + stretch.first
        truths = self.truths(rounds)
        fields = {} if not self.layers & ~MOVES else stretch.decode(slice(None))
        decided, done, low, high = (fields.get(name, np.full(x.shape, np.nan)) for name in self._names)
        layers = [np.where(np.isnan(x), NO_ESTIMATE, np.clip(x, 0.0, 1.0) * (NO_ESTIMATE - 1))]
        if self.moves:
            half = self.setting.arena_side / 2.0
            layers += [np.clip((stretch.poses[..., axis] + half) / (2.0 * half), 0.0, 1.0) * SCALE for axis in (0, 1)]
        if self.layers & HAS_INTERVALS:
            layers += [np.clip(np.nan_to_num(end), 0.0, 1.0) * SCALE for end in (low, high)]
        flags = np.zeros((2, *x.shape), np.uint8)
        if self.moves:
            readings = np.where(self.trace.ended(stretch), np.nan, stretch.readings)
            flags[0] = LOOKED * ~np.isnan(readings) + READ_BLACK * (readings == 1.0)
            flags[0] += (ON_BLACK * (stretch.colours == 1.0)).astype(np.uint8)
            flags[1] = np.round(stretch.poses[..., 2] % (2 * np.pi) / (2 * np.pi) * 256).astype(np.int64) % 256
        flags[0] += (DONE * (done == 1.0)).astype(np.uint8)
        flags[0] += (np.clip(np.nan_to_num(decided, nan=-1.0), -1, 14).astype(np.int64) + 1 << 4).astype(np.uint8)
        honest = self.honest
        # before any reading no robot is right: its estimate is only the brain's first value; nor without a truth
        read = (rounds > 0) & ~np.isnan(truths)
        own, there = x[:, honest], ~np.isnan(x[:, honest])
        options = [brain.options for brain in self.setting.brains if brain.decides]
        option = np.array([right_option(float(f), options[0]) if options else np.nan for f in truths])[:, np.newaxis]
        ends = right_bins(truths, self.bins)
        is_right = (own >= ends[:, :1]) & (own < ends[:, 1:])
        nothing = np.full(truths.shape, np.nan)
        values = {
            "truth": truths,
            "mean": (mean := mean_of(own, there)),
            "deviation": np.sqrt(mean_of((own - mean[:, np.newaxis]) ** 2, there)),
            **dict(zip(QUARTERS, quarters_of(own, there), strict=True)),
            "right": nothing if self.opinions else np.where(read, mean_of(is_right, there), np.nan),
            "sent": stretch.messages[:, 0],
            "heard": stretch.messages[:, 1],
            "bytes": stretch.messages[:, 0] * self.setting.brain.message_bytes,
            "interval_low": mean_of(low[:, honest], there),
            "interval_high": mean_of(high[:, honest], there),
            "decided": share(decided[:, honest], there, decided[:, honest] >= 0.0),
            "decided_right": np.where(read, share(decided[:, honest], there, decided[:, honest] == option), np.nan),
            "done": share(done[:, honest], there, done[:, honest] == 1.0),
            "black": mean_of(own == 1.0, there) if self.opinions else nothing,
            "white": mean_of(own == 0.0, there) if self.opinions else nothing,
        }
        # single precision suffices for a picture, and compresses better; counts stay exact
        exact = {name: value if name in COUNTS else np.float32(value) for name, value in values.items()}
        numbers = np.stack([np.broadcast_to(exact[name], truths.shape) for name in COLUMNS], axis=1)
        encoded = numbers, np.round(np.stack(layers)).astype(np.uint16), flags
        self._encoded[stretch.first] = stretch, encoded
        if len(self._encoded) > KEPT:
            self._encoded.popitem(last=False)
        return encoded

    @property
    def on_edges(self) -> list[float]:
        """The fill ratios of this trial, at its start and as the setting has it, that are on the edge of two bins."""
        if self._on_floor:
            return []
        change = self.setting.change
        values = np.unique([self.setting.fill_ratio, *([change.first] if change else [])])
        return list(map(float, values[on_edges(values, self.bins)]))

    def truths(self, rounds: np.ndarray) -> np.ndarray:
        """The true fill ratio of these rounds, which robots are judged by."""
        return self.trace.truths(rounds, self._on_floor)

    def draws_links(self, stretch: Stretch, row: int) -> bool:
        """Whether the links of a round are in its frame; of more than MOST_PAIRS only those of a chosen robot are."""
        if not self.moves:
            return bool(self.edges.size)
        return len(pairs_in(stretch, stretch.first + row)) <= MOST_PAIRS

    def _links(self, stretch: Stretch, row: int) -> np.ndarray:
        """The links of a round: pairs of robots in range if they move, else one number per edge, 1 if it carried."""
        if self.moves:
            pairs = pairs_in(stretch, stretch.first + row)
            return pairs.ravel() if len(pairs) <= MOST_PAIRS else np.zeros(0)
        return self.trace.carried(stretch.first + row, self.edges[:, 0], self.edges[:, 1])


def pairs_in(stretch: Stretch, tick: int) -> np.ndarray:
    """The pairs of robots in range in a round (pair, 2)."""
    begin, end = np.searchsorted(stretch.links[:, 0], [tick, tick + 1])
    return stretch.links[begin:end, 1:]


def mean_of(values: np.ndarray, there: np.ndarray) -> np.ndarray:
    """The mean of each row over those that are there; NaN where nobody is."""
    count = there.sum(axis=1)
    total = np.where(there, values, 0.0).sum(axis=1)
    return np.asarray(np.divide(total, count, out=np.full(len(values), np.nan), where=count > 0))


def quarters_of(x: np.ndarray, there: np.ndarray) -> np.ndarray:
    """The least number, quartiles and greatest number of each row over those that are there (quarter, row)."""
    steps = np.linspace(0.0, 1.0, len(QUARTERS))
    if there.all():
        return np.asarray(np.quantile(x, steps, axis=1))
    rows = [np.quantile(row[some], steps) if some.any() else steps + np.nan for row, some in zip(x, there, strict=True)]
    return np.array(rows).T


def share(known: np.ndarray, there: np.ndarray, holds: np.ndarray) -> np.ndarray:
    """The share of each row in which `holds` is true, of those that are there; NaN where all of `known` is NaN."""
    return np.where(np.isnan(known).all(axis=1), np.nan, mean_of(holds, there))
