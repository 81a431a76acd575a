"""The robots of a swarm in one file, robots.toml: each with its number, its sensor's accuracies, and where it is."""

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError

from swarmcensus.support.errors import StudyError
from swarmcensus.support.files import atomic_write
from swarmcensus.support.texts import read_text
from swarmcensus.support.toml_text import read_toml, to_toml_value
from swarmcensus.support.toml_types import Number, Share, ValueTable, says, table_error

ENDING = ".toml"
ONE_EACH = ("number", "port", "address")  # of which no two robots have the same
ERROR = Annotated[Number, Field(ge=0.0, le=1.0), says("should be a standard error, from 0 to 1")]
PLACE = Annotated[str | None, Field(min_length=1), says("should be a text that is not empty, or left out")]


class KnownRobot(ValueTable):
    """A robot: its number, b and w with their standard errors, and its serial port or its address in a network.

    b and w are NaN before the calibration.
    """

    number: Annotated[int, Field(strict=True, ge=0, le=0xFFFF), says("should be a robot's number, from 0 to 65535")]
    b: Share = math.nan
    w: Share = math.nan
    b_error: ERROR = 0.0
    w_error: ERROR = 0.0
    port: PLACE = None
    address: PLACE = None

    @property
    def accuracy(self) -> dict[str, float] | None:
        """As in a study file; None before the calibration."""
        return None if math.isnan(self.b + self.w) else {"black": self.b, "white": self.w}


class _Robots(ValueTable):
    robots: Annotated[list[KnownRobot], Field(min_length=1)]


def read_robots(path: str | Path, *, calibrated: bool = True) -> list[KnownRobot]:
    """The robots of a file, in its order; `calibrated` ones need b and w.

    Raises InputError, also if two have one number, port or address.
    """
    content = read_toml(read_text(path, kind=StudyError), str(path))
    try:
        robots = _Robots.model_validate(content).robots
    except ValidationError as error:
        raise table_error(error, str(path), _Robots, content) from None
    lacking = [f"robots[{k}].{key}" for k, one in enumerate(robots) for key in "bw" if math.isnan(getattr(one, key))]
    if lacking and calibrated:
        more = f" (and {len(lacking) - 1} more)" * (len(lacking) > 1)
        raise StudyError.within(str(path), f"{lacking[0]} is missing{more}: calibrate finds b and w", lacking[0])
    for key in ONE_EACH:
        values = [getattr(robot, key) for robot in robots if getattr(robot, key) is not None]
        if twice := [value for value in values if values.count(value) > 1]:
            each = f"{key} = {twice[0]}: {values.count(twice[0])} robots have it, and each needs its own"
            raise StudyError.within(str(path), each, key, twice[0])
    return robots


def write_robots(path: str | Path, robots: Iterable[Mapping[str, Any]], about: str) -> None:
    """Write a file of robots, a line each below a comment, whole or not at all. Raises InputError."""
    lines = [f"  {to_toml_value(robot)}," for robot in robots]
    with atomic_write(path) as temporary:
        temporary.write_text("\n".join([f"# {about}", "robots = [", *lines, "]", ""]), encoding="utf-8")


def inlined(value: Any, base: Path, where: str, key: str = "") -> Any:
    """A study's tables with the accuracies of robots' files in place of their names, which are relative to `base`.

    An `accuracy` is spread by its standard error, an `assumed_accuracy` is what was measured. Raises InputError.
    """
    if isinstance(value, Mapping):
        return {name: inlined(one, base, where, f"{key}.{name}" if key else name) for name, one in value.items()}
    if isinstance(value, list):
        return [inlined(one, base, where, key) for one in value]
    is_file = isinstance(value, str) and value.lower().endswith(ENDING)
    name = key.rpartition(".")[2]
    if not is_file or name not in ("accuracy", "assumed_accuracy"):
        return value
    try:
        robots, scale = read_robots(base / value), 1.0 if name == "accuracy" else 0.0
    except StudyError as error:
        raise StudyError.within(where, f"{key} = {value!r}: {error}", key, value) from None
    sides = ([x for one in robots for x in (one.b, scale * one.b_error)],
             [x for one in robots for x in (one.w, scale * one.w_error)])  # fmt: skip
    return {colour: f"M({','.join(map(repr, side))})" for colour, side in zip(("black", "white"), sides, strict=True)}
