"""One trial seen, whoever made it: the engine, step by step or in CPython, recorded readings, or robots' logs.

Who shows, draws, writes or compares a trial knows only a `Trace`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from swarmcensus.engine import Inputs
from swarmcensus.simulation.swarming import ended, free
from swarmcensus.studies import Setting

if TYPE_CHECKING:  # imported late: without it the page of a study appears half a second sooner
    import xarray as xr

ROUND = {"units": "rounds", "long_name": "communication round; 0 is before any observation"}
TICK = {"units": "ticks", "long_name": "tick; 0 is before any observation"}
SEEN = {
    "estimate": ((), {"units": "1", "long_name": "the fill ratio that the robot believes in"}),
    "position": (("axis",), {"units": "m", "long_name": "from the arena's centre"}),
    "heading": ((), {"units": "rad"}),
    "looked": ((), {"long_name": "1 where an observation was made"}),
    "tile": ((), {"long_name": "the true colour under the ground sensor, 1 black"}),
    "reading": ((), {"long_name": "what the ground sensor said, 1 black"}),
    "neighbours": ((), {"long_name": "robots in reach and sight"}),
}  # variables (round, robot, ...) of a dataset besides states: the other dimensions, and what they are
States = dict[str, np.ndarray]  # by field: (round, robot) or (round, robot, item)
nothing = partial(np.zeros, 0)


@dataclass(frozen=True)
class Stretch:
    """Some rounds, or ticks, of a trial: arrays (round, robot); the first row is that of round `first`.

    What is not known is NaN: a robot was away, or its log lacks the tick.
    """

    first: int
    estimates: np.ndarray
    decode: Callable[[slice], States]  # the states after some of these rounds
    messages: np.ndarray  # (round, what): how many all robots have sent and heard so far
    done: np.ndarray  # (robot): which robots were done before the first of these rounds
    history: np.ndarray = field(default_factory=nothing)  # (round, robot, byte): states as the engine has them
    said: np.ndarray = field(default_factory=nothing)  # (round, robot, byte): what was heard, as in an outbox
    signals: np.ndarray = field(default_factory=nothing)  # (round, robot): whether each was said, see `engine.States`
    poses: np.ndarray = field(default_factory=nothing)  # x, y, heading; from here on only if robots move
    colours: np.ndarray = field(default_factory=nothing)  # the true tile under the sensor, 1 black
    looked: np.ndarray = field(default_factory=nothing)  # whether it was on a tile that it looks at
    readings: np.ndarray = field(default_factory=nothing)  # NaN where none was made
    links: np.ndarray = field(default_factory=partial(np.zeros, (0, 3), np.int64))  # (link, 3): tick, robot, robot

    def __reduce__(self) -> Any:
        """Pickled with its states in place of what only the engine reads."""
        decoded = {"decode": partial(rows_of, self.decode(slice(None)))}
        return partial(Stretch, **vars(self) | decoded | dict.fromkeys(("history", "said"), nothing())), ()

    @property
    def bytes(self) -> int:
        """How much memory it takes."""
        return sum(value.nbytes for value in vars(self).values() if isinstance(value, np.ndarray))


class Trace:
    """One trial of robots: what is known of rounds a to b - 1 are arrays (round, robot); round 0 is before any reading.

    This one is known as a whole, from `start` on. Others compute their stretches, and know more of each.
    """

    setting: Setting
    seed: int
    trial: int
    rounds: int  # so far, where logs still grow
    length: int  # rounds of a stretch
    given: Inputs
    start: Stretch
    labels: Sequence[Any]  # the names of the robots
    adds = False  # whether messages are stored as what they add to the sums of their receivers
    is_compiled = True  # whether it is computed as fast as it ever will be

    def __init__(self, estimates: np.ndarray, states: States, labels: Sequence[Any]) -> None:
        """What robots believed and remembered, from round 0 on."""
        self.rounds = self.length = len(estimates) - 1
        self.labels, robots = labels, estimates.shape[1]
        decode = partial(rows_of, states)
        self.start = Stretch(0, estimates, decode, np.zeros((len(estimates), 2)), np.zeros(robots, np.bool_))

    def at(self, k: int) -> Stretch:
        """The k-th stretch, which begins with round k * length + 1; for k = -1 the start. Raises InputError."""
        return self.start

    def approach(self, k: int) -> bool:
        """Compute a piece of the way to the k-th stretch; returns whether that is reached."""
        return True

    def stretch(self, k: int) -> Stretch | None:
        """The k-th stretch if it is known without computation, else None."""
        return self.at(k)

    def read(self, tick: int, robot: int) -> tuple[float, int] | None:
        """How many black readings a robot of a fixed network made in a round, and how many in all; None if unknown."""
        return None

    def heard(self, tick: int, robot: int) -> list[dict[str, Any]]:
        """The messages that a robot heard in a round: the sender, and the contents or what they add to the sums."""
        return []

    def hears(self, tick: int, robot: int) -> tuple[np.ndarray, np.ndarray]:
        """The robots that a robot can hear in a round, and whether each link carried a message, 0 or 1."""
        return np.zeros(0, np.int64), np.zeros(0, np.uint8)

    def carried(self, tick: int, receivers: np.ndarray, senders: np.ndarray) -> np.ndarray:
        """Whether each link carried a message in a round (link), 0 or 1; all links of each receiver are needed."""
        return np.zeros(receivers.size, np.uint8)

    def floor(self) -> tuple[np.ndarray, np.ndarray]:
        """The tiles of the floor at tick 1, 1 for black, and the ticks at which they turn; see `Ground`."""
        return np.zeros((0, 0), np.uint8), np.zeros((0, 0), np.int64)

    def truths(self, rounds: np.ndarray, on_floor: bool = False) -> np.ndarray:
        """The fill ratio as the setting has it in these rounds; of robots that move, or that of their floor."""
        assert not on_floor
        return self.setting.fill_ratios(np.maximum(rounds, 1))

    def stretch_of(self, tick: int) -> int:
        """The stretch that contains a round; -1 for round 0."""
        return (tick - 1) // self.length

    def reach(self, tick: int) -> bool:
        """Compute a piece of the way to a round; returns whether it is reached."""
        return tick <= 0 or self.approach(self.stretch_of(tick))

    def find(self, tick: int) -> tuple[Stretch, int]:
        """The stretch that contains a round, and the row of the round in it."""
        stretch = self.at(self.stretch_of(tick))
        return stretch, tick - stretch.first

    def parts(self, a: int, b: int) -> Iterator[tuple[Stretch, slice]]:
        """The stretches of rounds a to b - 1, and the rows of these rounds in each."""
        while a < b:
            stretch, row = self.find(a)
            end = min(b - stretch.first, len(stretch.estimates))
            yield stretch, slice(row, end)
            a = stretch.first + end

    def estimates(self, a: int, b: int) -> np.ndarray:
        """What robots believe; NaN where that is not known."""
        return np.concatenate([stretch.estimates[rows] for stretch, rows in self.parts(a, b)])

    def states(self, a: int, b: int) -> States:
        """What robots remember, decide, and are sure of, as in `sc.replay`; NaN where it is not known."""
        return _joined([stretch.decode(rows) for stretch, rows in self.parts(a, b)])

    @property
    def moves(self) -> bool:
        """Whether it knows where robots are."""
        return self.start.poses.size > 0

    @property
    def honest(self) -> np.ndarray:
        """Whether metrics count each robot."""
        return self.given.honest[0] if self.given.honest.size else np.ones(len(self.labels), np.bool_)

    @property
    def group(self) -> np.ndarray:
        """Which of the setting's brains each robot has."""
        return self.given.group[0] if self.given.group.size else np.zeros(len(self.labels), np.int64)

    def ended(self, stretch: Stretch) -> np.ndarray:
        """Robots that were done before a round, and so make no reading in it (round, robot)."""
        before = np.zeros(stretch.estimates.shape, np.bool_)
        brains = self.setting.brains
        if any(brain.ends for brain in brains):
            before[0], before[1:] = stretch.done, ended(brains, stretch.decode(slice(None)))
        return before

    def dataset(self, links: bool = False) -> "xr.Dataset":
        """All rounds, as `sc.replay` says."""
        fields, seen, joined = [], [], []
        for stretch, rows in self.parts(0, self.rounds + 1):
            fields.append(stretch.decode(rows))
            seen.append({"estimate": stretch.estimates[rows]})
            if self.moves:
                seen[-1] |= self._moved(stretch)
                joined.append(stretch.links)
        made = dataset_of(_joined(fields), _joined(seen), self.labels)
        if links:
            made["link"] = (("link", "end"), np.concatenate(joined), {"long_name": "tick, robot, robot"})
        return made

    def _moved(self, stretch: Stretch) -> States:
        """What is known of robots that move."""
        ended, heard = self.ended(stretch), np.zeros(stretch.looked.shape, np.int32)
        for side in (1, 2):
            np.add.at(heard, (stretch.links[:, 0] - stretch.first, stretch.links[:, side]), 1)
        return {
            "position": stretch.poses[..., :2],
            "heading": stretch.poses[..., 2],
            "looked": (stretch.looked & ~ended).astype(np.int8),
            "tile": stretch.colours,
            "reading": np.where(ended, np.nan, stretch.readings),
            "neighbours": heard,
        }


def dataset_of(fields: States, seen: Mapping[str, np.ndarray], labels: Sequence[Any]) -> "xr.Dataset":
    """A trace as a dataset: fields of memories, and variables of SEEN."""
    import xarray as xr

    dims = "round", "robot"
    variables = {
        name: ((*dims, free(f"item_{name}", fields))[: values.ndim], np.ascontiguousarray(values))
        for name, values in fields.items()
    }
    made = xr.Dataset(variables, {"round": ("round", np.arange(len(seen["estimate"])), ROUND), "robot": list(labels)})
    for name, values in seen.items():
        more, says = SEEN[name]
        made[name] = ((*dims, *more), np.ascontiguousarray(values), says)
    return made if "position" not in seen else in_ticks(made.assign_coords(axis=["x", "y"]))


def in_ticks(made: "xr.Dataset") -> "xr.Dataset":
    """The same dataset, with ticks as its rounds."""
    made["round"].attrs = TICK
    return made


def rows_of(states: States, rows: slice) -> States:
    """Some rows of states."""
    return {name: values[rows] for name, values in states.items()}


def _joined(parts: Sequence[States]) -> States:
    """The same arrays of one part after the other; memory of parts is given back."""
    return {name: np.concatenate([part.pop(name) for part in parts]) for name in [*parts[0]]}
