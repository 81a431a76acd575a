"""A replica of a robot: the runtime of robots, fed with the readings, messages and random numbers of a log."""

import functools
from binascii import crc32
from collections.abc import Sequence
from typing import Any

from swarmcensus.brains import FORMATS, Brain, Format, Numbers, Precision, bytes_of, parts
from swarmcensus.robots.logs.logs import State, Tick
from swarmcensus.runtime.log import numbers_of
from swarmcensus.runtime.runtime import HEADER, Robot
from swarmcensus.translation import messages_of


class Unfit(Exception):
    """A brain cannot have written a log, and what is of another size: its memory, parameters or messages."""


class Replica(Robot):  # type: ignore[misc]
    """A robot's runtime without sensor, radio and clock."""

    def __init__(self, brain: Brain, b: float, w: float, number: int, parameters: dict[str, Any], period: int) -> None:
        """A blank state."""
        self.seen = 0.0, 0.0  # readings that say black, and all
        self.lots: list[float] = []  # random numbers for the next calls
        self.lacked = 0  # calls for which there was none
        self.said: bytes | None = None
        self.is_single = brain.numbers.precision == "single"
        draws = self.lot if brain.uses.luck else None
        super().__init__(
            brain.functions, messages_of(brain), None, self, lambda: 0, b, w, number, period, 1, parameters, draws
        )
        self.lacked = 0

    def _look(self) -> tuple[float, float]:
        return self.seen

    def send(self, datagram: bytes) -> None:
        """Keep what is said."""
        self.said = datagram[HEADER:]

    def lot(self) -> float:
        """The random number of the next call."""
        if self.lots:
            return self.lots.pop(0)
        self.lacked += 1
        return 0.5

    def first_half(self, tick: Tick) -> bytes | None:
        """Observe and broadcast; returns what is said."""
        self.seen = float(tick.blacks), float(tick.looks)
        self.said = None
        self.ticks = tick.tick - 1
        self.speak()
        return self.said

    def hear(self, code: bytes) -> None:
        """Receive a message, unless it holds a number that is not finite."""
        if len(code) == self.messages.body and (message := self.messages.read(code)) is not None:
            self._do(self.brain.receive, message)

    def remembered(self) -> list[float]:
        """The numbers of its memory, what it decides, whether it is done, and its interval, if its brain has these."""
        brain, more = self.brain, []
        more += [self.decision] * hasattr(brain, "decide") + [self.done] * hasattr(brain, "done")
        more += brain.interval(self.me) if hasattr(brain, "interval") else ()
        return [float(x) for x in (*self.numbers(), *more)]

    def become(self, numbers: Sequence[float], ticks: int) -> None:
        """Take over numbers as they are saved, after so many ticks."""
        self.restore(list(numbers))
        self.ticks = ticks
        self._ask()

    @property
    def checksum(self) -> int:
        """The checksum of the memory and of what is owed, as a log has it."""
        return crc32(numbers_of(self)) & 0xFFFFFFFF


def format_of(brain: Brain, state: State) -> Format:
    """The message format of a log; where it is not known, the first one in which messages have their size."""
    if 0 < state.form < len(FORMATS):
        return FORMATS[state.form]
    sizes = {one: bytes_of(parts(brain.message, brain.roles, one)) for one in FORMATS[1:]}
    return next((one for one, size in sizes.items() if size == state.code_bytes), "float32")


@functools.lru_cache(maxsize=256)
def in_numbers(brain: Brain, precision: Precision, format: Format, feedback: bool) -> Brain:
    """A brain in number formats; made once, because that takes milliseconds."""
    return brain.with_numbers(Numbers(precision, format, feedback))


def replica_of(brain: Brain, state: State) -> Replica:
    """The state of a robot as it is in a state of its log. Raises Unfit."""
    precision: Precision = "single" if state.single else "double"
    brain = in_numbers(brain.as_written, precision, format_of(brain, state), state.feedback)
    replica = Replica(brain, state.b, state.w, state.number, _parameters(brain, state), state.period)
    if replica.messages.body != state.code_bytes:
        raise Unfit("the size of its messages")
    if len(replica.numbers()) != len(state.numbers) or len(replica.messages.owed) != len(state.owed):
        raise Unfit("the size of its memory")
    replica.become((*state.numbers, *state.owed), state.tick)
    return replica


def _parameters(brain: Brain, state: State) -> dict[str, Any]:
    """The values of a brain's parameters in a log. Raises Unfit, unless the log has just as many."""
    values, rest = {}, state.parameters
    for name, default in sorted(brain.parameters.items()):
        size = len(default) if isinstance(default, tuple) else 1
        if len(rest) < size:
            raise Unfit("the number of its parameters")
        values[name] = rest[:size] if isinstance(default, tuple) else rest[0]
        rest = rest[size:]
    if rest:
        raise Unfit("the number of its parameters")
    return values
