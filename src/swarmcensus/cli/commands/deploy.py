"""The command `deploy`: a brain's files for a robot, and whether the robot computes what it should."""

from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from swarmcensus.cli.parameters import (  # fmt: skip
    BRAIN,
    COUNT,
    FILE,
    FOLDER,
    FORMATS,
    NUMBER,
    WHOLE,
    Parameters,
    Set,
    known,
    once,
    path,
    takes,
    toml_value,
    values_of,
)
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError, OptionError
from swarmcensus.support.options import option, option_conflict
from swarmcensus.support.texts import read_text


def deploy(
    brain: Annotated[str, BRAIN], folder: Annotated[Path | None, FOLDER] = None, /, *,
    target: Annotated[str | None, Parameter(metavar="NAME"), known("robots.targets")] = None,
    accuracy: Annotated[Any, takes(toml_value, "ACCURACY")] = None, parameter: Parameters = (),
    message: FORMATS | None = None, precision: Literal["double", "single"] | None = None,
    hz: Annotated[float | None, NUMBER] = None, robot: Annotated[int | None, WHOLE] = None,
    log: Annotated[int | None, COUNT] = None, study: Annotated[Path | None, FILE] = None, set: Set = (),
    robots: Annotated[Path | None, FILE] = None, calibrate: bool = False,
    report: Annotated[str | None, takes(str, "ADDRESS")] = None,
    selftest: Annotated[Path | None, takes(path, "OUTPUT")] = None,
) -> Answer:  # fmt: skip
    """Write a brain's files for a robot, or check a robot.

    Args:
        brain: a brain's name or file; with --selftest, the folder whose files are on the board
        folder: the folder to write: a new one, or empty; for ARGoS, other files and brains may be there
        target: what the files are for: udp, espnow, serial, kilobot, pogobot, argos or c; 'list targets' explains each
        accuracy: of the sensor: 0.9, or {black = 0.9, white = 0.85}
        message: format of messages (default: of those that fit, the one in which the brain errs least)
        precision: precision of numbers of C (default: single, in ARGoS double)
        hz: ticks a second (default: 10)
        robot: this robot's number (default: made of the chip's)
        log: let the robot keep a log in robot.log, up to so many bytes
        study: its first setting with BRAIN: arena, sensors and formats in ARGoS
        robots: a folder for each robot of a file such as robots.toml, and scripts that put them onto their boards and
            fetch their logs
        calibrate: add a program that counts readings on strips, for swarmcensus calibrate
        report: to a computer with 'swarm --on', which starts the robots and shows what they report: its address, usb
            for the robots' serial ports, or gateway, for ESP-NOW
        selftest: compare what a board's selftest.py printed
    """
    asked = {name: value for name, value in locals().items() if value is not False and value not in (None, ())}
    from swarmcensus.robots import compare, deploy as write

    if selftest:
        for name in (one for one in asked if one not in ("brain", "selftest")):
            given = str(folder) if name == "folder" else option(name)
            raise OptionError(f"{given} does not go with {option('selftest')}", key=name)
        output = read_text(selftest, option("selftest", selftest), most=None, errors="replace")
        try:
            return compare(output, Path(brain))
        except InputError as error:
            raise error if error.file else InputError.of(selftest, error) from None
    for name, given in (("folder", "FOLDER"), ("target", "--target")):
        if name not in asked:
            example = "swarmcensus deploy BRAIN FOLDER --target " + ("c" if target == "c" else "udp --accuracy 0.9")
            raise OptionError(f"{given} is missing: {example}", key=name)
    if set and study is None:
        raise option_conflict("set", None, "goes with --study")
    values = values_of(asked.pop("set", ()))
    return write(parameters=once("parameter", asked.pop("parameter", ())), set=values, **asked)
