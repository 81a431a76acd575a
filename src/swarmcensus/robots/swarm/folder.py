"""The folder of a swarm: the files that its robots run, and swarm.json, which tells what the swarm was."""

import json
import pprint
import py_compile
import shutil
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from swarmcensus.brains import FORMATS, MODULE, ROUND, codec_source
from swarmcensus.robots.folders import new_folder, write_texts
from swarmcensus.robots.logs.folders import HASH, hash_of
from swarmcensus.robots.swarm.plans import PlannedRobot, SwarmPlan
from swarmcensus.robots.target import in_single
from swarmcensus.runtime import log, runtime
from swarmcensus.support.documents import json_value
from swarmcensus.support.files import atomic_write
from swarmcensus.support.toml_text import to_toml_value

FORMAT = 1
ROUNDING = "rounding"
OURS = Path(__file__).parent
PROGRAMS = (OURS / "node.py", OURS / "air.py", OURS / f"{ROUNDING}.py", Path(log.__file__), Path(runtime.__file__))
RUN = "run"  # the folder in it with what robots run, their readings and memories
SAVED = 2.0  # seconds from one saving of a memory to the next, or FEWEST ticks if that is longer
FEWEST = 20


def write_folder(plan: SwarmPlan, folder: Path, command_port: int, token: str) -> None:
    """Write all that robots need, whole or not at all. Raises InputError if the folder exists and is not empty."""
    with new_folder(folder) as made:
        run = made / RUN
        run.mkdir()
        precision = plan.setting.precision
        texts = {path.name: path.read_text(encoding="utf-8") for path in PROGRAMS}
        texts["codec.py"] = _alone(codec_source(precision))
        for member in plan.members:
            texts[f"{_module(member.file)}.py"] = _alone(member.brain.running_source)
        write_texts(run, texts)
        for name in texts:  # so that not each robot compiles them
            py_compile.compile(str(run / name), doraise=True)
        write_texts(made, {member.file: member.brain.source for member in plan.members})
        looks = plan.readings.astype(np.uint8)
        for member in plan.members:
            (run / f"{member.number}.readings").write_bytes(np.ascontiguousarray(looks[:, member.number]).tobytes())
            settings = _settings(plan, member, Path(folder).resolve(), command_port, token)
            file = run / f"{module_of(member.number)}.py"
            file.touch(0o600)  # the token is for nobody else
            file.write_text(settings, encoding="utf-8", newline="\n")
        (made / "swarm.json").write_text(_summary(plan, None, {}), encoding="utf-8")


def complete(plan: SwarmPlan, folder: Path, ended: int | None, result: Mapping[str, Any]) -> None:
    """Write swarm.json again, with when the swarm started and ended, in milliseconds since 1970, and its result."""
    with atomic_write(folder / "swarm.json") as path:
        path.write_text(_summary(plan, ended, result), encoding="utf-8")


def module_of(number: int) -> str:
    """The module with a robot's settings."""
    return f"robot_{number}"


def forget(folder: Path, number: int) -> None:
    """Delete a robot's memory; its boot count stays, so that others know that its ticks begin again."""
    for name in ("memory", "memory.new"):
        (folder / RUN / f"{number}.{name}").unlink(missing_ok=True)


def clear(folder: Path) -> None:
    """Delete what Python has compiled."""
    shutil.rmtree(folder / RUN / "__pycache__", ignore_errors=True)


def _alone(source: str) -> str:
    """A source that imports nothing of swarmcensus."""
    return source.replace(f"from {MODULE} import {ROUND}", f"from {ROUNDING} import {ROUND}")


def _module(file: str) -> str:
    return file.removesuffix(".py").replace("-", "_")


def _settings(plan: SwarmPlan, member: PlannedRobot, folder: Path, command_port: int, token: str) -> str:
    brain, setting = member.brain, plan.setting
    is_single = setting.precision == "single"
    parameters = in_single(dict(brain.overrides)) if is_single else dict(brain.overrides)
    base = folder / RUN / f"{member.number}"
    values = {
        "NUMBER": member.number, "HOST": plan.air.host, "COMMAND": command_port, "TOKEN": token,
        "BRAIN": _module(member.file), "HASH": bytes.fromhex(brain.sha256)[:8],
        "FORM": FORMATS.index(brain.numbers.message), "SINGLE": is_single, "LENGTHS": tuple(brain.message.values()),
        "PLAN": tuple(tuple(part) for part in brain.parts), "MARK": plan.mark, "FEEDBACK": brain.numbers.feedback,
        "PARAMETERS": parameters, "B": member.b, "W": member.w, "PERIOD": plan.period,
        "LOOKS": setting.observations_per_round, "ROUNDS": setting.rounds, "READINGS": f"{base}.readings",
        "MEMORY": f"{base}.memory", "SAVE_EVERY": max(FEWEST, round(SAVED * 1000.0 / plan.period)),
        "LOG": str(folder / log_of(member.number)), "SEED": plan.chance,
        "LUCK": plan.draws if brain.uses.luck else None, "LOSS": plan.loss, "DUPLICATE": plan.air.duplicate,
        "DELAY": plan.delay, "JITTER": plan.air.jitter,
    }  # fmt: skip
    return "\n".join([f"{name} = {pprint.pformat(value, width=110)}" for name, value in values.items()]) + "\n"


def log_of(number: int) -> str:
    """The name of a robot's log."""
    return f"robot-{number}.log"


def _summary(plan: SwarmPlan, ended: int | None, result: Mapping[str, Any]) -> str:
    setting, brain, measure = plan.setting, plan.setting.brain, plan.study.measure
    started = result.get("started", round(time.time() * 1000))
    study = plan.study.text
    if brain.name.endswith(".py"):  # the swarm's own file, which has another name in the folder
        study = study.replace(to_toml_value(brain.name), to_toml_value("brain.py"))
    about = {
        "format": FORMAT, "title": plan.title,
        "brain": {"file": "brain.py", "name": brain.name, "parameters": dict(brain.overrides)},
        "message": brain.numbers.message, "precision": setting.precision, "feedback": brain.numbers.feedback,
        "fill_ratio": setting.fill_ratio, "seed": plan.seed, "trial": plan.trial, "setting": plan.number,
        "rounds": setting.rounds, "observations_per_round": setting.observations_per_round, "period": plan.period,
        "bins": measure.bins, "delta": measure.delta,
        "chance": {
            "seed": plan.chance, "loss": plan.loss, "duplicate": plan.air.duplicate, "delay": plan.delay,
            "jitter": plan.air.jitter,
        },
        "robots": [
            {
                "number": m.number, "log": log_of(m.number), "brain": m.file, "honest": m.honest, "b": m.b, "w": m.w,
                "adversary": m.adversary,
            }
            for m in plan.members
        ],
        "links": plan.links, "started": started, "ended": ended, "study": study,
        **{key: value for key, value in result.items() if key != "started"},
    }  # fmt: skip
    written = json_value(about)
    return json.dumps(written | {HASH: hash_of(written)}, indent=1) + "\n"
