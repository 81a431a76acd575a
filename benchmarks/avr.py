"""What brains take of an ATmega328P: python benchmarks/avr.py [BRAIN ...].

Kilobots and many Arduinos have this chip. Each figure is that of a program that lives many ticks, less that of the same
program around an empty brain. A tick is a reading, `broadcast`, two messages received, `fuse` and `estimate`. The
messages are those of another robot, which sees the other colour, under one of many names. The chip's own timer counts
cycles.
"""

import contextlib
import sys
import tempfile
from pathlib import Path
from string import Template
from typing import NamedTuple

import harness

from swarmcensus.brains import Brain, Numbers, load
from swarmcensus.brains.brain import shipped
from swarmcensus.robots import chips
from swarmcensus.support.errors import BrainError
from swarmcensus.translation import header

sys.path.insert(0, str(harness.ROOT))
from tests.support.hosts import FLASH, LARGE, RAM, in_simavr

HERE = Path(__file__).parent

NUMBERS = Numbers(precision="single", message="ratio16")
TICKS = 2400  # that count: more than five phases of 45 s, in three of which some brains are silent
MORE_TICKS = 1000  # for the longest one: in every 50th of them, when most phases end, a crowd is heard
CROWD = 20
LEAST_STACK = 256  # bytes of RAM besides a program's memory; no shipped brain needs more
DRAWS = 16  # a random numbers of a tick, in sixteenths
KILOBOT_FLASH = 32768 - 4096 - 7168  # less its bootloader, and its library with rules for its radio
KILOBOT_RAM = 2048 - 256  # less the variables of the library, and what interrupts put on the stack
KILOBOT_MESSAGE = 9 - 6  # bytes of its messages, less a header which names the sender and shows losses


class Cost(NamedTuple):
    """What a brain takes of an ATmega328P: alone, and with its messages as bytes (ratio16)."""

    name: str
    flash: int  # bytes of program and tables
    cycles: int  # a tick, on average
    coded_flash: int  # with messages as bytes
    coded_cycles: int
    longest: int  # cycles of the longest tick, with messages as bytes, also of a crowd
    ram: int  # bytes of memory, and what the compiler adds
    stack: int  # bytes, at most
    message: int  # bytes
    chip: str  # on which cycles were counted: a larger one of the same core if its memory has no room here

    @property
    def milliseconds(self) -> float:
        """A tick with messages as bytes, at 8 MHz."""
        return 1000.0 * self.coded_cycles / chips.CLOCK

    @property
    def too_large(self) -> tuple[str, ...]:
        """What a Kilobot has no room for; empty if it has room."""
        needs = {
            "flash": self.coded_flash > KILOBOT_FLASH,
            "RAM": self.ram + self.stack > KILOBOT_RAM,
            "message": self.message > KILOBOT_MESSAGE,
        }
        return tuple(name for name, is_too_large in needs.items() if is_too_large)

    @property
    def kilobot(self) -> str:
        """Whether a Kilobot has room for it, and if not, what for."""
        return f"no: {', '.join(self.too_large)}" if self.too_large else "yes"


COLUMNS = {
    "brain": lambda one: one.name,
    "flash": lambda one: one.flash,
    "cycles": lambda one: one.cycles,
    "flash with bytes": lambda one: one.coded_flash,
    "cycles with bytes": lambda one: one.coded_cycles,
    "longest tick": lambda one: one.longest,
    "RAM": lambda one: one.ram,
    "stack": lambda one: one.stack,
    "message": lambda one: one.message,
    "ms a tick": lambda one: f"{one.milliseconds:.1f}",
    "Kilobot": lambda one: one.kilobot,
    "cycles of": lambda one: "ATmega328P" if one.chip == chips.KILOBOT else "ATmega1284P",
}


@harness.question
def costs(*brains, write=False, quick=False):
    """Flash, RAM, stack and cycles a tick, as C in single precision, and whether a Kilobot has room.

    It needs the packages of tools/install-chips.sh.
    """
    found = [cost(load(name)) for name in brains or (["commons"] if quick else shipped())]
    rows = [[str(text(one)) for text in COLUMNS.values()] for one in found]
    print(harness.markdown([*COLUMNS], rows))
    if write:
        harness.write_csv("atmega328p", [*COLUMNS], rows)


def cost(brain: Brain) -> Cost:
    """What a brain takes of an ATmega328P. Raises InputError if it has no translation, or a tool is missing."""
    for chip in (chips.KILOBOT, LARGE):
        with contextlib.suppress(chips.NoRoom), tempfile.TemporaryDirectory() as folder:
            return _cost_on(brain.with_numbers(NUMBERS), Path(folder), chip)
    flash, ram = FLASH[LARGE] // 1024, RAM[LARGE] // 1024
    small = f"an {LARGE}, with {flash} KB of flash and {ram} KB of RAM, is too small"
    raise BrainError(f"brain {brain.name}: {small}", key="brain", value=brain.name)


def _cost_on(brain: Brain, folder: Path, chip: str) -> Cost:
    costs = []
    for is_coded in (False, True):
        both = (_measure(brain, folder, chip, is_coded, is_empty) for is_empty in (False, True))
        costs.append([one - nothing for one, nothing in zip(*both, strict=True)])
    (flash, cycles, *_), (coded_flash, coded_cycles, longest, ram, stack) = costs
    own = brain.name, flash, cycles, coded_flash, coded_cycles
    return Cost(*own, longest, ram, stack, brain.message_bytes, chip)


def _measure(brain: Brain, folder: Path, chip: str, is_coded: bool, is_empty: bool) -> tuple[int, ...]:
    """Compile and run the program around a brain, or around an empty one: flash, cycles, longest, RAM and stack."""
    (folder / "brain.h").write_text((HERE / "avr_no_brain.h").read_text() if is_empty else header(brain))
    source = folder / "cost.c"
    has_luck, has_name = brain.uses.luck and not is_empty, brain.uses.name and not is_empty
    source.write_text(
        Template((HERE / "avr_cost.c").read_text()).substitute(
            ticks=TICKS,
            more=MORE_TICKS,
            crowd=CROWD,
            start=", 1" if has_name else "",
            draws=f"me->luck = ((number)(tick % {DRAWS}) + 0.5f) / {DRAWS}.0f;" if has_luck else "",
            name=f"cost_other.name = tick * 2 % {CROWD} + k + 2;" if has_name else "",
            **(CODED if is_coded else PLAIN),
        )
    )
    program = chips.for_avr(source, chip)
    size = chips.avr_size(program)
    if size.ram + LEAST_STACK > RAM[chip]:  # where the stack overwrites memory, a program may never end
        raise chips.NoRoom(f"brain {brain.name}: its memory has no room on an {chip}")
    printed = in_simavr(program, chip).split()
    if len(printed) != 4:  # the stack has overwritten the program's memory
        raise chips.NoRoom(f"brain {brain.name}: its stack has no room on an {chip}")
    total, stack, longest, of_others = map(int, printed)
    return size.flash, round(total * PRESCALER / TICKS), longest * PRESCALER, size.ram - of_others, stack


PRESCALER = 8  # the timer counts every so many cycles
PLAIN = {"message": "struct message", "send": "broadcast", "of_message": "message", "hear": "receive"}
CODED = {
    "message": "struct cost_message", "send": "brain_send", "of_message": "message->code", "hear": "brain_hear",
}  # fmt: skip


if __name__ == "__main__":
    harness.answer(globals())
