"""The files of a robot that runs MicroPython: its brain, codec, runtime, settings, main program and self-test."""

import pprint
from pathlib import Path

from swarmcensus.brains.packing import FORMATS
from swarmcensus.deployment.comments import quoted
from swarmcensus.deployment.target import Order
from swarmcensus.robot import codec, log, runtime

NUMBERS = {"precision": "MicroPython's numbers are as long as its build has them"}  # an option that it refuses
BOARDS = Path(__file__).parent / "boards"
HEAD = '''"""What this robot runs: {brain} over {radio}. Fill in the sensor, and what else is marked so."""

{imports}

import brain
import settings
from runtime import WRAP, Messages, Robot
'''
README = """# {brain} on MicroPython, over {radio}

1. Measure your sensor: b and w are the shares of right readings on black and on white. They are in settings.py.
2. Fill in what is marked FILL IN in main.py. NUMBER in settings.py is another one for each robot; None takes one from
   the chip.
3. Copy the files, and let the board prove that it computes what the simulator does:

       mpremote cp *.py :
       mpremote run selftest.py > board.txt
       swarmcensus deploy . --selftest board.txt

4. Restart the board. Every hundred ticks it prints a line: its estimate, and what went wrong so far.

A message has {body} bytes, a datagram {size}; {checked}.
Memory is saved every {save} ticks. It outlives a power cut; delete the files memory* for a fresh start.{logged}
Nobody signs the messages: who knows the format can lie to the robots.
"""
LOGGED = """
The robot logs what it reads, says and hears in robot.log, up to {log:,} bytes in all; then it goes on without. The line
tells as log_faults what the log lacks. Every board's log has this name: copy each into one folder under another one,

       mpremote cp :robot.log day/robot-1.log

and swarmcensus relive day lives the robots' minds again. Delete robot.log for a new day."""


def micropython_files(order: Order) -> dict[str, str]:
    """The texts of all files by name."""
    radio = (BOARDS / f"radio_{order.name}.py").read_text(encoding="utf-8")
    needed, _, rest = radio.partition("\n\n")
    imports = "\n".join(sorted([*needed.splitlines(), "from binascii import crc32", "import random", "import time"]))
    parts = [
        HEAD.format(brain=quoted(order.brain.label), radio=order.target.what, imports=imports),
        (BOARDS / "sensor.py").read_text(encoding="utf-8"),
        rest.strip("\n") + "\n\n",
        (BOARDS / "loop.py").read_text(encoding="utf-8"),
    ]
    checked = (
        f"{runtime.CHECKSUM} of them are a checksum" if order.target.checked else "the radio has a checksum of its own"
    )
    readme = README.format(
        brain=quoted(order.brain.label), radio=order.target.what, body=order.brain.message_bytes,
        size=order.datagram_bytes, checked=checked, save=order.save_every,
        logged=LOGGED.format(log=order.log) if order.log else "",
    )  # fmt: skip
    logged = {"log.py": Path(log.__file__).read_text(encoding="utf-8")} if order.log else {}
    return {
        "brain.py": order.brain.source,
        "codec.py": Path(codec.__file__).read_text(encoding="utf-8"),
        "runtime.py": Path(runtime.__file__).read_text(encoding="utf-8"),
        **logged,
        "settings.py": settings_text(order),
        "main.py": "\n".join(parts),
        "selftest.py": (BOARDS / "selftest.py").read_text(encoding="utf-8"),
        "README.md": readme,
    }


def settings_text(order: Order) -> str:
    """The settings of a robot, as constants of Python."""
    brain = order.brain
    values: dict[str, tuple[object, str]] = {
        "BRAIN": (brain.name, ""),
        "NUMBER": (order.robot, "of this robot, 0 to 65535, another one for each"),
        "B": (order.b, "share of right readings on black"),
        "W": (order.w, "and on white"),
        "PERIOD": (order.period, "milliseconds a tick"),
        "READINGS": (1, "a tick"),
        "SAVE_EVERY": (order.save_every, "ticks: memory cells wear out"),
        "PARAMETERS": (dict(brain.overrides), "of the brain, that differ from its file"),
        "LUCK": (brain.uses.luck, "whether the brain uses luck"),
        "LENGTHS": (tuple(brain.message.values()), "of the message's fields, 0 for a number"),
        "PLAN": (tuple(tuple(part) for part in brain.parts), "coding, numbers of the message, owed"),
        "MARK": (order.mark, "of brain and format"),
        "CHECKED": (order.target.checked, "whether a checksum is sent"),
    }
    if order.log:
        values |= {
            "LOG": (order.log, "bytes of robot.log at the most"),
            "HASH": (bytes.fromhex(brain.sha256[:16]), "of the brain's file, how it begins"),
            "FORM": (FORMATS.index(brain.numbers.message), "of messages: 1 float32, 2 float16, 3 ratio16, 4 ratio8"),
        }
    lines = [
        f"{name} = {pprint.pformat(value, width=100)}{f'  # {what}' if what else ''}"
        for name, (value, what) in values.items()
    ]
    return "\n".join([f'"""The settings of a robot with the brain {quoted(brain.label)}."""', "", *lines, ""])
