"""The files of a Kilobot: its brain as C, a main program for Kilobot's own library, and a Makefile."""

import tempfile
from collections.abc import Mapping
from pathlib import Path

from swarmcensus.basics.errors import InputError
from swarmcensus.basics.options import wrong_option
from swarmcensus.brains.single import rounded_to_single
from swarmcensus.deployment.chips import KILOBOT, avr_size, for_avr, missing
from swarmcensus.deployment.comments import quoted
from swarmcensus.deployment.folders import write_texts
from swarmcensus.deployment.header import header
from swarmcensus.deployment.micropython_files import BOARDS
from swarmcensus.deployment.target import Order, Target

TICKS_A_SECOND = 32  # of a Kilobot's clock
FLASH, RAM = 20_000, 1_300  # bytes left beside Kilobot's own library, its boot loader and a stack
FLAGS = ("-funsigned-char", "-funsigned-bitfields", "-fpack-struct", "-fshort-enums")  # those of Kilobot's library
EMPTY = """
#include "kilolib.h"
volatile uint32_t kilo_ticks;
uint16_t kilo_uid;
void (*kilo_message_rx)(message_t *, distance_measurement_t *);
message_t *(*kilo_message_tx)(void);
void kilo_init(void) {}
void kilo_start(void (*setup)(void), void (*loop)(void)) { setup(); for (;;) loop(); }
int16_t get_ambientlight(void) { return 0; }
uint8_t rand_soft(void) { return 0; }
void set_color(uint8_t color) { (void)color; }
uint16_t message_crc(const message_t *message) { (void)message; return 0; }
"""
SETTINGS = """\
// The settings of a robot with the brain {brain}.

#define B {b}f  // share of right readings on black
#define W {w}f  // and on white
#define PERIOD {period}  // of a tick; a second has {second}
#define MARK 0x{mark:02x}  // of brain and format
#define LUCK {luck}  // whether the brain uses luck
#define NAMED {named}  // whether the brain uses the robot's name
#define IS_DONE {done}  // whether it makes no more readings
"""
README = """# {brain} on Kilobots

1. Measure your sensor: b and w are the shares of right readings on black and on white. They are in settings.h.
2. Fill in what is marked FILL IN in main.c.
3. Fetch and build Kilobot's own library, https://github.com/acornejo/kilolib, then `make KILOLIB=../kilolib` here.
4. Put robot.hex onto the robots. Red robots believe in mostly black, blue ones in mostly white.

A message has {body} bytes beside a header of 6; Kilobot's library adds a checksum. Memory starts blank after a power
cut, and the boot count, in the EEPROM, goes up. Nobody signs the messages: who knows the format can lie to the robots.

On an Arduino brain.h is the same: call brain_start once; in each tick observe, brain_send, brain_hear for each message
that has arrived, fuse, estimate.
"""


def kilobot_files(order: Order) -> dict[str, str]:
    """The texts of all files by name. Raises InputError if the brain has no translation to C."""
    brain = order.brain
    assert order.b is not None
    assert order.w is not None
    if order.hz > TICKS_A_SECOND:
        raise wrong_option("hz", order.hz, f"a Kilobot has at most {TICKS_A_SECOND} ticks a second")
    settings = SETTINGS.format(
        brain=quoted(brain.label), b=_literal(order.b), w=_literal(order.w),
        period=max(1, round(TICKS_A_SECOND / order.hz)), second=TICKS_A_SECOND, mark=order.mark & 0xFF,
        luck=int(brain.uses.luck), named=int(brain.uses.name),
        done="done(&me)" if brain.ends else "false",
    )  # fmt: skip
    return {
        "brain.h": header(brain),
        "settings.h": settings,
        "main.c": (BOARDS / "kilobot.c").read_text(encoding="utf-8"),
        "Makefile": (BOARDS / "kilobot.mk").read_text(encoding="utf-8"),
        "README.md": README.format(brain=quoted(brain.label), body=order.brain.message_bytes),
    }


def check_fits(order: Order, texts: Mapping[str, str]) -> tuple[int | None, int | None]:
    """The bytes of flash and of memory beside Kilobot's own library; None without avr-gcc. Raises InputError."""
    name = order.brain.name
    if order.brain.memory_bytes > RAM:
        raise InputError(
            f"the brain {name!r} remembers {order.brain.memory_bytes:,} bytes, and a Kilobot has {RAM:,} for it: it is "
            "too large"
        )
    if missing(("avr-gcc", "avr-size")):
        return None, None
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        write_texts(folder, texts)
        write_texts(folder, {"kilolib.c": EMPTY, "kilolib.h": (BOARDS / "kilolib.h").read_text(encoding="utf-8")})
        program = for_avr(folder / "main.c", KILOBOT, *FLAGS, f"-I{folder}", str(folder / "kilolib.c"))
        flash, ram = avr_size(program)
    if flash > FLASH or ram > RAM:
        raise InputError(
            f"the brain {name!r} needs {flash:,} bytes of flash and {ram:,} of memory, and a Kilobot has {FLASH:,} and "
            f"{RAM:,} beside its own library: it is too large"
        )
    return flash, ram


def _literal(value: float) -> str:
    """A number in C, with the digits that a float holds."""
    text = f"{rounded_to_single(value):.9g}"
    return text if "." in text or "e" in text else f"{text}.0"


TARGET = Target(
    "a Kilobot's infrared",
    kilobot_files,
    largest=9,
    checked=False,  # its own library adds a checksum
    message="ratio16",
    precisions=("single",),
    refuses={"robot": "a Kilobot has a number of its own", "log": "a Kilobot has no files"},
    measure=check_fits,
)
