"""The files of a Pogobot: its brain as C, and a main program for the robot's own library and for pogosim."""

from swarmcensus.robots.target import FILL_IN, Order, Target
from swarmcensus.support.options import wrong_option
from swarmcensus.translation import filled, header, logged, piece, quoted, unit_of

LOOPS = 50  # of its library, a second, at most: small buffers hold messages for a loop of whole milliseconds
FASTEST = 255  # what a rate is, at most
TIME_STEP = 0.01  # seconds, of pogosim


def pogobot_files(order: Order) -> dict[str, str]:
    """The texts of all files by name. Raises InputError if the brain has no translation to C."""
    brain, name = order.brain, quoted(order.brain.label)
    if not (1 <= order.hz <= FASTEST and order.hz == int(order.hz)):
        raise wrong_option("hz", order.hz, f"a Pogobot has a whole number of ticks a second, from 1 to {FASTEST}")
    hz, real = int(order.hz), unit_of(brain).real
    loops = max(1, LOOPS // hz)
    b, w = (FILL_IN if one is None else real(one) for one in (order.b, order.w))
    settings = filled(
        "pogobot_settings.h", brain=name, b=b, w=w, hz=hz, loops=loops,
        mark=f"{order.mark & 0xFF:02x}", luck=int(brain.uses.luck), named=int(brain.uses.name), ends=int(brain.ends),
        steers=int(brain.steers),
    )  # fmt: skip
    return {
        "brain.py": brain.source,
        "brain.h": header(brain),
        "logged.h": logged(brain, order.mark),
        "settings.h": settings,
        "robot.h": piece("robot.h"),
        "sensor.h": piece("pogobot_sensor.h"),
        **order.counting,
        "robot_log.h": piece("robot_log.h"),
        "main.c": piece("pogobot.c"),
        "Makefile": piece("pogobot.mk"),
        "simulation.yaml": filled("pogobot.yaml", brain=name, step=min(TIME_STEP, 1.0 / (hz * loops))),
        "README.md": filled("pogobot.md", brain=name, body=brain.message_bytes),
    }


TARGET = Target(
    "a Pogobot's infrared",
    pogobot_files,
    largest=382,
    checked=False,  # its own library adds a checksum
    precisions=("single",),
    flash="""\
cp robot-"$1"/settings.h .
: "${SDK:?where is pogobot-sdk, from this folder}" "${SOURCES:?where is pogosim/src}"
make -B bin MAIN="${MAIN:-main}" SDK="$SDK" SOURCES="$SOURCES"
echo "put firmware.bin onto robot $1, then press Enter"; read -r _""",
    counts={"calibrate.c": "pogobot_calibrate.c", "counts.h": "counts.h"},
    refuses={"robot": "a Pogobot has a number of its own", "log": "a Pogobot has no files; in pogosim it always logs"},
)
