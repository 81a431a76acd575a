"""The files of a Kilobot: its brain as C, a main program for Kilobot's own library, and a Makefile."""

import tempfile
from collections.abc import Mapping
from pathlib import Path

from swarmcensus.robots.chips import CLOCK, KILOBOT, avr_size, for_avr, missing
from swarmcensus.robots.folders import write_texts
from swarmcensus.robots.target import FILL_IN, Order, Target
from swarmcensus.support.errors import BrainError
from swarmcensus.support.options import wrong_option
from swarmcensus.translation import filled, header, owed_numbers, piece, quoted, unit_of

TICKS_A_SECOND = CLOCK / 1024 / 256  # as Kilobot's own library counts: a timer of 8 bits, every 1024 cycles
HIGHEST_HZ = 10.0  # a message takes 4.2 ms of the infrared, which neighbours share
FLASH, RAM = 20_000, 1_300  # bytes left by Kilobot's own library, its boot loader and a stack
FLAGS = ("-funsigned-char", "-funsigned-bitfields", "-fpack-struct", "-fshort-enums")  # those of Kilobot's library


def kilobot_files(order: Order) -> dict[str, str]:
    """The texts of all files by name. Raises InputError if the brain has no translation to C."""
    brain, real = order.brain, unit_of(order.brain).real
    b, w = (FILL_IN if one is None else real(one) for one in (order.b, order.w))
    if order.hz > HIGHEST_HZ:
        raise wrong_option("hz", order.hz, f"a Kilobot has at most {HIGHEST_HZ:g} ticks a second, each with a message")
    settings = filled(
        "kilobot_settings.h", brain=quoted(brain.label), b=b, w=w,
        robot="kilo_uid" if order.robot is None else order.robot, second=f"{TICKS_A_SECOND:.1f}",
        period=max(1, round(TICKS_A_SECOND / order.hz)), mark=f"{order.mark & 0xFF:02x}", ends=int(brain.ends),
        luck=int(brain.uses.luck), named=int(brain.uses.name), steers=int(brain.steers), owed=owed_numbers(brain),
    )  # fmt: skip
    return {
        "brain.h": header(brain),
        "settings.h": settings,
        "robot.h": piece("robot.h"),
        "sensor.h": piece("kilobot_sensor.h"),
        **order.counting,
        "main.c": piece("kilobot.c"),
        "Makefile": piece("kilobot.mk"),
        "README.md": filled("kilobot.md", brain=quoted(brain.label), body=order.brain.message_bytes),
    }


def check_fits(order: Order, texts: Mapping[str, str]) -> tuple[int | None, int | None]:
    """The bytes of flash and of memory besides Kilobot's own library; None without avr-gcc. Raises InputError."""
    name = order.brain.name
    if order.brain.memory_bytes > RAM:
        raise _too_large(name, f"remembers {order.brain.memory_bytes:,} bytes, and a Kilobot has {RAM:,} for it")
    if missing(("avr-gcc", "avr-size")):
        return None, None
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        write_texts(folder, texts)
        write_texts(folder, {"kilolib.c": piece("no_kilolib.c"), "kilolib.h": piece("kilolib.h")})
        program = for_avr(
            folder / "main.c", KILOBOT, *FLAGS, f"-D{FILL_IN}=1", f"-I{folder}", str(folder / "kilolib.c")
        )
        flash, ram = avr_size(program)
    if flash > FLASH or ram > RAM:
        needs = f"needs {flash:,} bytes of flash and {ram:,} of memory"
        raise _too_large(name, f"{needs}, and a Kilobot has {FLASH:,} and {RAM:,} besides its own library")
    return flash, ram


def _too_large(name: str, needs: str) -> BrainError:
    return BrainError(f"the brain {name!r} {needs}: it is too large", key="brain", value=name)


TARGET = Target(
    "a Kilobot's infrared",
    kilobot_files,
    largest=9,
    numbers=range(1, 0xFFFF),
    checked=False,  # its own library adds a checksum
    precisions=("single",),
    refuses={"log": "a Kilobot has no files"},
    flash="""\
cp robot-"$1"/settings.h .
make -B "${MAIN:-robot}.hex" KILOLIB="${KILOLIB:?where is kilolib, from this folder}"
echo "upload ${MAIN:-robot}.hex to robot $1 with kilogui, then press Enter"; read -r _""",
    measure=check_fits,
    moves=False,
    counts={"calibrate.c": "kilobot_calibrate.c", "counts.h": "counts.h"},
)
