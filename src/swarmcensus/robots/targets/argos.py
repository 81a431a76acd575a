"""The files of a simulation in ARGoS 3: a controller around the brain as C, a floor, and an experiment."""

import json
import re
from pathlib import Path
from xml.sax.saxutils import quoteattr
from zlib import crc32

from swarmcensus.robots.target import Order, Target
from swarmcensus.studies import Setting, Study, set_apart
from swarmcensus.support.errors import StudyError
from swarmcensus.translation import filled, header, logged, piece, quoted
from swarmcensus.worlds import Accuracy, Body, Floor

OF_ALL = {  # files that are the same for all brains of a folder
    "swarmcensus_robot.h": "argos_robot.h",
    "swarmcensus_robot.cpp": "argos_robot.cpp",
    "swarmcensus_floor.cpp": "argos_floor.cpp",
    "robot.h": "robot.h",
    "robot_log.h": "robot_log.h",
    "CMakeLists.txt": "argos_cmake.txt",
    "README.md": "argos.md",
}
WALL = 0.1  # metres
RADIUS = 0.085036758  # of a foot-bot, in metres
FOOT_BOT = {"radius": 0.085, "wheel_distance": 0.14, "sensor": (0.063, 0.0116), "proximity_range": 0.083}


def argos_files(order: Order) -> dict[str, str]:
    """The texts of all files by name. Raises InputError if ARGoS has no such arena, or C no such brain."""
    setting = order.setting
    if setting is None:
        sensor = {"black": order.b, "white": order.w}
        study = Study(  # the paper's, Sec. IV-C
            trials=1,
            swarm={"robots": 25, "accuracy": sensor},
            world={"topology": "moving", "density": 1, "fill_ratio": 0.55},
            schedule={"ticks": 10_000},
        )
        setting = study.settings()[0]
    brain, name = order.brain, name_of(order.brain.path)
    values = {"brain": quoted(brain.name), "name": name, "datagram": order.datagram_bytes}
    own = f"{name}_{crc32(f'{order.mark} {brain.overrides} {brain.numbers}'.encode()):08x}"  # in no other library
    label = (brain.name, dict(brain.overrides), brain.numbers.message, brain.numbers.precision)
    return {
        f"{name}.cpp": filled(
            "argos_brain.cpp", **values, own=own,
            mark=f"{order.mark & 0xFF:02x}",
            whole_mark=", ".join(f"0x{byte:02x}" for byte in order.mark.to_bytes(4, "little")),
            luck=int(brain.uses.luck), named=int(brain.uses.name), ends=int(brain.ends), steers=int(brain.steers),
            label=", ".join(json.dumps(json.dumps(value)) for value in label),
        ),
        f"{name}_brain.h": header(brain),
        f"{name}_logged.h": logged(brain, order.mark),
        f"{name}.py": brain.source,
        f"{name}.argos": filled(
            "argos_experiment.argos", **values, **_arena(order, setting),
            library=quoteattr(str(order.folder / "build" / "libswarmcensus")),  # ARGoS looks where it is started
        ),
        **{file: piece(template) for file, template in OF_ALL.items()},
    }  # fmt: skip


def name_of(path: Path) -> str:
    """The name of a brain's controller, of its files, and of its robots: letters, digits and underscores."""
    name = re.sub(r"\W", "_", path.stem, flags=re.ASCII)
    return name if re.match("(?!swarmcensus)[a-zA-Z]", name) else f"brain_{name}"


def _arena(order: Order, setting: Setting) -> dict[str, object]:
    """What the experiment has of a setting. Raises InputError if ARGoS has no such thing."""
    _check(setting, order.where)
    body, half = setting.body, setting.arena_side / 2.0
    assert body is not None
    sensor = _sides(setting.accuracy)
    believed = _sides(setting.assumed_accuracy) if isinstance(setting.assumed_accuracy, Accuracy) else sensor
    b, w = (given if given is not None else its for given, its in zip((order.b, order.w), believed, strict=True))
    numbers = {
        "b": b, "w": w, "true_b": sensor[0], "true_w": sensor[1],
        "side": 2.0 * half, "inside": half - RADIUS, "beyond": half + WALL / 2.0, "wall": 2.0 * (half + WALL),
        "outer": 2.0 * (half + WALL) + 1.0, "tile": body.tile, "pixels": round(1.0 / body.tile),
        "fill_ratio": setting.fill_ratio,
        "robots": setting.robots, "seconds": setting.rounds * body.tick, "ticks_per_second": round(1.0 / body.tick),
        "seed": max(1, order.seed % 2**32), "radio_range": body.radio_range, "loss": 1.0 - setting.link_success,
        "speed": 100.0 * body.speed, "turn_speed": 100.0 * body.turn_speed, "straight_mean": body.straight_mean,
        "turn_most": body.turn_most, "avoid_above": body.avoid_above, "avoid_within": body.avoid_within,
    }  # fmt: skip
    texts = {key: f"{value:.12g}" for key, value in numbers.items()}
    return {**texts, "line_of_sight": str(body.line_of_sight).lower()}


def _sides(accuracy: Accuracy) -> tuple[float, float]:
    """b and w that are the same for all robots."""
    return accuracy.black.numbers[0], (accuracy.white or accuracy.black).numbers[0]


def _check(setting: Setting, where: str) -> None:
    """Raise InputError for what this experiment lacks."""
    body, assumed, varies = setting.body, setting.assumed_accuracy, setting.change or setting.spread
    if body is None:
        what = f"world.topology = {setting.topology.name!r}: for ARGoS it should be 'moving'"
        raise StudyError.within(where, what, "world.topology", setting.topology.name)
    lacks: dict[str, tuple[bool, object, str]] = {
        "swarm.accuracy": (not _is_plain(setting.accuracy), setting.accuracy, "a number, the same for all robots"),
        "swarm.assumed_accuracy": (
            assumed is not None and not _is_plain(assumed), assumed, "a number, the same for all robots"
        ),
        "world.fill_ratio": (bool(varies), varies, "a number, because floors do not change"),
        "world.floor": (setting.floor not in (None, Floor()), setting.floor, "'tiles'"),
        "faults": (bool(setting.faults), "[...]", "left out, because no robot fails"),
        "members": (bool(setting.members), "[...]", "left out, because a swarm has one brain"),
        "world.body.message_delay": (body.message_delay != 1, body.message_delay, "1"),
        "world.body.tick": (
            abs(round(1.0 / body.tick) * body.tick - 1.0) > 1e-9, body.tick, "a whole part of a second, such as 0.1"
        ),
    }  # fmt: skip
    for key in ("radius", "wheel_distance", "sensor", "wheel_lag", "proximity_range", "proximity_near"):
        value, usual = getattr(body, key), getattr(Body(), key)
        right = f"{FOOT_BOT[key]}, that of a foot-bot, or left out" if key in FOOT_BOT else "left out"
        lacks[f"world.body.{key}"] = (value not in (usual, FOOT_BOT.get(key)), value, right)
    for new in set_apart(setting):  # of keys that this experiment does not have
        if new.name not in ("precision", "message", "feedback"):
            lacks[f"{new.table}.{new.name}"] = (True, getattr(setting, new.field), "left out")
    for key, (is_lacking, value, right) in lacks.items():
        if is_lacking:
            raise StudyError.within(where, f"{key} = {value}: for ARGoS it should be {right}", key, value)


def _is_plain(accuracy: object) -> bool:
    """Whether all robots have the same accuracies, all the time."""
    return (
        isinstance(accuracy, Accuracy)
        and accuracy.drift is None
        and all(one.is_number for one in accuracy.distributions)
    )


TARGET = Target(
    "ARGoS's range and bearing",
    argos_files,
    largest=1000,
    # in place of a checksum is the whole mark: nothing damages messages there, but other brains talk too
    precisions=("double", "single"),
    refuses={
        "hz": "the tick of the study decides that, 0.1 s by default",
        "robot": "each robot gets a number of its own",
        "log": 'logs="FOLDER" in the experiment writes them',
    },
    adds=True,
    takes_study=True,
)
