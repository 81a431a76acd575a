"""What is to be put onto a robot, checked: a brain, its sensor's accuracies, a radio and a message format."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from swarmcensus.basics.errors import InputError, OptionError
from swarmcensus.basics.hints import did_you_mean
from swarmcensus.basics.options import wrong_option
from swarmcensus.brains import Brain
from swarmcensus.brains.packing import FORMATS, Numbers
from swarmcensus.robot.runtime import CHECKSUM, HEADER

SENT = FORMATS[1:]  # all but "double", which is a simulation's
HIGHEST_HZ = 1000.0
LOWEST_HZ = 0.001


class Radio(NamedTuple):
    """A kind of radio."""

    what: str
    largest: int  # bytes of a datagram
    checked: bool  # whether a datagram carries our checksum


RADIOS = {
    "udp": Radio("UDP", 1400, True),
    "espnow": Radio("ESP-NOW", 250, True),
    "serial": Radio("a serial line", 250, True),
    "kilobot": Radio("a Kilobot's infrared", 9, False),  # its own library adds a checksum
}


@dataclass(frozen=True)
class Plan:
    """A robot to be made."""

    brain: Brain  # with a message format
    radio: str  # a key of RADIOS
    b: float
    w: float
    hz: float
    number: int | None  # of the robot; None takes the chip's
    log: int | None = None  # bytes of the robot's log at the most; None: it keeps none
    save_every: int = 600  # ticks

    @property
    def checked(self) -> bool:
        """Whether datagrams carry our checksum."""
        return RADIOS[self.radio].checked

    @property
    def period(self) -> int:
        """Milliseconds a tick."""
        return max(1, round(1000.0 / self.hz))

    @property
    def datagram_bytes(self) -> int:
        """The size of a datagram."""
        return datagram_bytes(self.brain, self.radio)

    @property
    def mark(self) -> int:
        """32 bits that another brain or format hardly has too."""
        text = f"{self.brain.sha256} {self.brain.numbers.message}"
        return int(hashlib.sha256(text.encode()).hexdigest()[:8], 16)


def plan_for(
    brain: Brain, radio: str, b: float, w: float, message: str | None = None, hz: float = 10.0,
    parameters: Mapping[str, object] | None = None, number: int | None = None, log: int | None = None,
) -> Plan:  # fmt: skip
    """The plan of a robot. `message` is a format, by default float32, or ratio16 for a Kilobot. Raises InputError."""
    if radio not in RADIOS:
        raise wrong_option("radio", radio, f"{did_you_mean(radio, RADIOS)}should be one of {', '.join(RADIOS)}")
    message = message or ("ratio16" if radio == "kilobot" else "float32")
    if message not in SENT:
        raise wrong_option("message", message, f"{did_you_mean(message, SENT)}should be one of {', '.join(SENT)}")
    for name, value in (("b", b), ("w", w)):
        if not 0.0 <= value <= 1.0:
            raise wrong_option(name, value, "should be a share of right readings, from 0 to 1")
    if abs(b + w - 1.0) < 1e-12:
        raise InputError(f"--b {b:g} --w {w:g}: b + w = 1: such a sensor says the same of black and white")
    if not LOWEST_HZ <= hz <= HIGHEST_HZ:
        raise wrong_option("hz", hz, f"should be ticks a second, from {LOWEST_HZ:g} to {HIGHEST_HZ:g}")
    if number is not None and not 0 <= number <= 0xFFFF:
        raise wrong_option("number", number, "should be from 0 to 65535")
    if number is not None and radio == "kilobot":
        raise InputError(f"--number {number} does not go with --radio kilobot: a Kilobot has a number of its own")
    if log is not None and radio == "kilobot":
        raise InputError(f"--log {log} does not go with --radio kilobot: a Kilobot has no files")
    if brain.is_oracle:
        raise InputError(f"the brain {brain.name!r} is a bound: no robot hears all others and knows every sensor")
    try:
        brain = brain.with_parameters(parameters or {}).with_numbers(Numbers(message=message))  # type: ignore[arg-type]
    except ValueError as error:
        raise OptionError(f"--parameter: {error}", key="parameter") from None
    size, largest = datagram_bytes(brain, radio), RADIOS[radio].largest
    if size > largest:
        sizes = [f"--message {format_} makes {bytes_}" for format_, bytes_ in fitting(brain, radio).items()]
        hint = " and ".join(sizes) or "no format makes it small enough"
        raise InputError(
            f"the brain {brain.name!r} sends datagrams of {size} bytes as {message}, a header of {HEADER} with them, "
            f"and {RADIOS[radio].what} holds {largest}: {hint}"
        )
    return Plan(brain, radio, float(b), float(w), float(hz), number, log)


def datagram_bytes(brain: Brain, radio: str) -> int:
    """The size of a brain's datagrams over a radio."""
    return HEADER + brain.message_bytes + (CHECKSUM if RADIOS[radio].checked else 0)


def fitting(brain: Brain, radio: str) -> dict[str, int]:
    """The message formats in which a brain's datagrams fit a radio, and their sizes."""
    numbered = {format_: brain.with_numbers(Numbers(message=format_)) for format_ in SENT}  # type: ignore[arg-type]
    sizes = {format_: datagram_bytes(one, radio) for format_, one in numbered.items()}
    return {format_: size for format_, size in sizes.items() if size <= RADIOS[radio].largest}
