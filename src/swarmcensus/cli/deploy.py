"""The command `deploy`: a brain's files for a robot, and whether the robot computes what it should."""

import argparse
import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.basics.errors import InputError, OptionError
from swarmcensus.basics.formatting import counted
from swarmcensus.basics.options import wrong_option
from swarmcensus.cli.options import from_zero, positive
from swarmcensus.cli.output import answer, wrote

if TYPE_CHECKING:
    from swarmcensus.deployment.board_tests import Comparison
    from swarmcensus.deployment.deploying import Deployed

SHOWN = 8  # differences that are listed


def add_deploy_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `deploy`."""
    sub.add_argument(
        "what", metavar="BRAIN", help="a brain's name or file; with --check, the folder whose files are on the board"
    )
    sub.add_argument("--to", type=Path, metavar="FOLDER", help="the folder to write; it should be new, or empty")
    sub.add_argument("--radio", metavar="udp|espnow|serial|kilobot", help="what robots talk by")
    sub.add_argument("--b", type=number, metavar="SHARE", help="how often the sensor reads black right")
    sub.add_argument("--w", type=number, metavar="SHARE", help="how often the sensor reads white right")
    sub.add_argument(
        "--message",
        metavar="FORMAT",
        help="float32, float16, ratio16 or ratio8 (default: float32, on a Kilobot ratio16)",
    )
    sub.add_argument("--hz", type=number, help="ticks a second (default: 10)")
    sub.add_argument("--parameter", action="append", metavar="NAME=VALUE", help="a parameter of the brain; repeatable")
    sub.add_argument("--number", type=from_zero, help="of this robot, another one for each (default: from the chip)")
    sub.add_argument(
        "--log", type=positive, metavar="BYTES", help="let the robot log its life in robot.log, up to so many bytes"
    )
    sub.add_argument("--check", type=Path, metavar="OUTPUT", help="compare what a board's self-test printed")


def deploy(options: argparse.Namespace) -> int:
    """Write a robot's files, or compare a board's self-test."""
    return _check(options) if options.check else _deploy(options)


def _deploy(options: argparse.Namespace) -> int:
    from swarmcensus import brains
    from swarmcensus.conformance.quick import caution as check_quickly
    from swarmcensus.deployment.deploying import deploy as write
    from swarmcensus.deployment.folders import check_free
    from swarmcensus.deployment.format_errors import caution, measured, sentence
    from swarmcensus.deployment.plans import plan_for

    for name in ("to", "radio", "b", "w"):
        if getattr(options, name) is None:
            raise InputError(f"--{name} is missing: swarmcensus deploy BRAIN --to FOLDER --radio udp --b 0.9 --w 0.85")
    check_free(options.to)
    plan = plan_for(
        brains.load(options.what), options.radio, options.b, options.w, options.message,
        10.0 if options.hz is None else options.hz, parameters_of(options.parameter or []), options.number, options.log,
    )  # fmt: skip
    check_quickly([plan.brain])
    made = write(plan, options.to)
    if options.json:
        about = {"brain": plan.brain.label, "radio": plan.radio, "mark": plan.mark}
        found = measured(plan.brain, plan.brain.numbers.message)
        answer("deployment", vars(made) | about | {"measured": found})
    else:
        for line in _sizes(made):
            print(line)
        print(f"error     {sentence(plan)}")
    if said := caution(plan):
        warnings.warn(said, stacklevel=1)
    wrote(f"{made.folder}: {', '.join(made.files)}")
    return 0


def _sizes(made: "Deployed") -> list[str]:
    lines = [
        f"message   {counted(made.message_bytes, 'byte')}, in a datagram of {made.datagram_bytes:,}",
        f"memory    {made.memory_bytes:,} bytes of numbers, 4 a number",
    ]
    if made.flash_bytes is not None:
        lines.append(f"flash     {made.flash_bytes:,} bytes, beside Kilobot's own library")
        lines.append(f"RAM       {made.ram_bytes:,} bytes, with messages that wait")
    return lines


def parameters_of(given: list[str]) -> dict[str, Any]:
    """The values of --parameter. Raises InputError."""
    values: dict[str, Any] = {}
    for text in given:
        name, equals, value = text.partition("=")
        try:
            numbers = tuple(float(part) for part in value.split(","))
        except ValueError:
            numbers = ()
        if not (name and equals and numbers):
            raise wrong_option("parameter", text, "should be NAME=VALUE, with commas between the numbers of a vector")
        values[name] = numbers if len(numbers) > 1 else numbers[0]
    return values


def _check(options: argparse.Namespace) -> int:
    from swarmcensus.deployment.board_tests import compare

    making = ("to", "radio", "b", "w", "message", "hz", "parameter", "number", "log")
    given = [name for name in making if _is_given(options, name)]
    if given:
        raise OptionError(f"--{given[0]} does not go with --check", key=given[0])
    try:
        output = options.check.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise wrong_option("check", options.check, f"{error.strerror}") from None
    result = compare(output, Path(options.what))
    if options.json:
        answer("selftest", vars(result) | {"passes": result.passes, "wrong": [vars(d) for d in result.wrong]})
    else:
        _show(result)
    return 0 if result.passes else 2


def _is_given(options: argparse.Namespace, name: str) -> bool:
    return getattr(options, name) is not None


def _show(result: "Comparison") -> None:
    print(f"{result.brain}: {result.bits} binary digits on the board, and in the reference")
    print(f"{counted(result.numbers, 'number')} compared, {result.equal:,} equal to the bit")
    print(f"largest difference {result.largest:.1e}, relative above 1")
    print(f"{result.datagrams:,} datagrams compared, {result.datagrams_equal:,} equal")
    for wrong in result.wrong[:SHOWN]:
        where = f"tick {wrong.tick}, robot {wrong.robot}, {wrong.field}"
        print(f"  {where}: {wrong.board:.9g} on the board, {wrong.reference:.9g} in the reference")
    if len(result.wrong) > SHOWN:
        print(f"  ... and {len(result.wrong) - SHOWN:,} more")
    if result.wrong:
        print(f"FAIL: more than {result.allowed:g} apart")
    elif result.miscoded:
        print(f"FAIL: {result.miscoded:,} datagrams differ, although all numbers are equal")
    else:
        print("the board computes what it should")


def number(text: str) -> float:
    """A finite number. Raises ArgumentTypeError."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError("should be a number")
    return value
