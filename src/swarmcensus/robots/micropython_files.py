"""The files of a robot that runs MicroPython: its brain, codec, runtime, settings, main program and self-test."""

import pprint
from functools import partial
from pathlib import Path

from swarmcensus.brains import FORMATS
from swarmcensus.robots.target import Order, Target
from swarmcensus.runtime import codec, history, lines, log, reports, runtime
from swarmcensus.runtime.reports import GATEWAY, USB
from swarmcensus.support.options import wrong_option
from swarmcensus.translation import filled, piece, quoted

NUMBERS = {"precision": "MicroPython's numbers are as long as its build has them"}  # an option that it refuses
SAVE_EVERY = 600  # ticks
HOLD = 2048  # bytes, so that a sector of flash is erased once in some forty ticks
LEAST = 10_000  # bytes of a log
HEAD = '''"""What this robot runs: {brain} over {radio}. Fill in the sensor, and what else is marked so."""

{imports}

import brain
import settings
from runtime import WRAP, Messages, Robot, since
'''


def micropython_files(order: Order) -> dict[str, str]:
    """The texts of all files by name. Raises InputError if a log is too short for its beginning."""
    brain = order.brain
    if order.log and order.log < LEAST:
        raise wrong_option("log", order.log, f"should be {LEAST:,} bytes at least: a beginning, and some ticks")
    radio = piece(f"radio_{order.name}.py")
    needed, _, rest = radio.partition("\n\n")
    every = ["from binascii import crc32", "import os", "import random", "import time"]
    imports = "\n".join(sorted({*needed.splitlines(), *every}))
    parts = [
        HEAD.format(brain=quoted(brain.label), radio=order.target.what, imports=imports),
        piece("sensor.py"),
        rest.strip("\n") + "\n\n",
        piece("loop.py"),
    ]
    checked = (
        f"{runtime.CHECKSUM} of them are a checksum" if order.target.checked else "the radio has a checksum of its own"
    )
    readme = filled(
        "micropython.md", brain=quoted(brain.label), radio=order.target.what, body=brain.message_bytes,
        size=order.datagram_bytes, checked=checked, save=SAVE_EVERY,
        counts=piece("counts.md").rstrip() if order.calibrate else "",
        logged="\n" + filled("logged.md", log=f"{order.log:,}", hold=f"{HOLD:,}").rstrip() if order.log else "",
        gateway="\nOne board more is the gateway: gateway.py says how." if order.report == GATEWAY else "",
    )  # fmt: skip
    used = [codec, runtime, history] + [log] * bool(order.log or order.report) + [reports] * bool(order.report)
    used += [lines] * (order.name == "serial" or order.report in (USB, GATEWAY))
    files = [Path(str(module.__file__)) for module in used]
    return {
        "brain.py": brain.source,
        **{file.name: file.read_text(encoding="utf-8") for file in files},
        "settings.py": settings_text(order),
        "main.py": "\n".join(parts),
        **order.counting,
        **({"gateway.py": piece("gateway.py")} if order.report == GATEWAY else {}),
        "selftest.py": piece("selftest.py"),
        "README.md": readme,
    }


def settings_text(order: Order) -> str:
    """The settings of a robot, as constants of Python."""
    brain = order.brain
    values: dict[str, tuple[object, str]] = {
        "BRAIN": (brain.name, ""),
        "NUMBER": (order.robot, "of this robot, 0 to 65535, another one for each"),
        "B": (order.b, "share of right readings on black" + "; calibrate.py helps to find it" * order.calibrate),
        "W": (order.w, "and on white"),
        "PERIOD": (order.period, "milliseconds a tick"),
        "READINGS": (1, "a tick"),
        "SAVE_EVERY": (SAVE_EVERY, "ticks: memory cells wear out"),
        "PARAMETERS": (dict(brain.overrides), "of the brain, that differ from its file"),
        "LUCK": (brain.uses.luck, "whether the brain uses luck"),
        "LENGTHS": (tuple(brain.message.values()), "of the message's fields, 0 for a number"),
        "PLAN": (tuple(tuple(part) for part in brain.parts), "coding, numbers of the message, owed"),
        "FIELDS": (tuple(brain.memory), "of its memory"),
        "MARK": (order.mark, "of brain and format"),
        "CHECKED": (order.target.checked, "whether a checksum is sent"),
    }
    if order.log or order.report:
        values |= {
            "REPORT": (order.report, "where those who watch are; the robot waits until they start it"),
            "LOG": (order.log, "bytes of robot.log at the most"),
            "HOLD": (HOLD, "of them that are written together: each time wears out flash memory"),
            "HASH": (bytes.fromhex(brain.sha256[:16]), "of the brain's file, how it begins"),
            "FORM": (FORMATS.index(brain.numbers.message), "of messages: 1 float32, 2 float16, 3 ratio16, 4 ratio8"),
        }
    lines = [
        f"{name} = {pprint.pformat(value, width=100)}{f'  # {what}' if what else ''}"
        for name, (value, what) in values.items()
    ]
    return "\n".join([f'"""The settings of a robot with the brain {quoted(brain.label)}."""', "", *lines, ""])


micropython_board = partial(
    Target,
    files=micropython_files,
    refuses=NUMBERS,
    flash=piece("flash_micropython.sh"),
    fetch=piece("fetch_micropython.sh"),
    moves=False,
    counts={"calibrate.py": "calibrate.py"},
)
