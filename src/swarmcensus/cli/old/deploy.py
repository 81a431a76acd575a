"""The command `deploy`: a brain's files for a robot, and whether the robot computes what it should."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from swarmcensus.cli.options import Command, Group, add_shared, from_zero, once, positive, share

from swarmcensus.cli.output import answer, say, wrote
from swarmcensus.support.errors import InputError, OptionError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command, option
from swarmcensus.support.texts import read_text

if TYPE_CHECKING:
    from swarmcensus.robots import Comparison, Deployed

SHOWN = 8  # differences that are listed
MAKING = ("target", "b", "w", "message", "precision", "hz", "parameter", "robot", "log", "study")


def add_deploy_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `deploy`."""
    sub.add_argument(
        "what", metavar="BRAIN", help="a brain's name or file; with --selftest, the folder whose files are on the board"
    )
    free = "the folder to write: a new one, or empty; for ARGoS, other files and brains may be there"
    sub.add_argument("folder", nargs="?", type=Path, metavar="FOLDER", help=free)
    targets = "udp, espnow, serial, kilobot, pogobot, argos or c; 'list targets' explains each"
    sub.add_argument("--target", metavar="NAME", help=f"what the files are for: {targets}")
    sub.add_argument("--b", type=share, metavar="SHARE", help="how often the sensor reads black right")
    sub.add_argument("--w", type=share, metavar="SHARE", help="how often the sensor reads white right")
    add_shared(
        sub,
        "parameter",
        message="default: float32, on a Kilobot ratio16",
        precision="of C; default: single, in ARGoS double",
    )
    add_shared(sub, hz="default: 10")
    sub.add_argument("--robot", type=from_zero, metavar="N", help="this robot's number (default: made of the chip's)")
    sub.add_argument(
        "--log", type=positive, metavar="BYTES", help="let the robot keep a log in robot.log, up to so many bytes"
    )
    sub.add_argument(
        "--study", type=Path, metavar="FILE", help="its first setting with BRAIN: arena, sensors and formats in ARGoS"
    )
    sub.add_argument("--selftest", type=Path, metavar="OUTPUT", help="compare what a board's selftest.py printed")


def deploy(options: argparse.Namespace) -> int:
    """Write a robot's files, or compare a board's self-test."""
    return _compare(options) if options.selftest else _deploy(options)


def _deploy(options: argparse.Namespace) -> int:
    from swarmcensus.robots import deploy as write, measured, sentence

    for name, value in (("FOLDER", options.folder), ("--target", options.target)):
        if value is None:
            example = "swarmcensus deploy BRAIN FOLDER --target " + (
                "c" if options.target == "c" else "udp --b 0.9 --w 0.85"
            )
            raise OptionError(f"{name} is missing: {example}", key=name.strip("-").lower())
    made = write(
        options.what, options.folder, options.target, b=options.b, w=options.w, message=options.message,
        precision=options.precision, hz=options.hz, parameters=once("parameter", options.parameter),
        robot=options.robot, log=options.log, study=options.study,
    )  # fmt: skip
    brain = made.order.brain
    if options.json:
        answer("deployment", made.as_dict | {"measured": measured(brain, brain.numbers.message)})
    else:
        print("\n".join(_sizes(made)))
        print(f"error     {sentence(made.order)}")
    wrote(f"{made.folder}: {', '.join(made.files)}")
    for name in made.kept:
        say(f"{made.folder / name}: yours is kept: delete it to have the one of this deploy")
    if "Makefile" in made.files and "selftest.c" in made.files:
        say(f"next: {command('make', '-C', made.folder, 'check')}, which compares the C with Python bit for bit")
    return 0


def _sizes(made: "Deployed") -> list[str]:
    brain, datagram = made.order.brain, made.order.datagram_bytes
    within = "" if datagram is None else f", in a datagram of {datagram:,}"
    size = 8 if made.order.target.precisions and brain.numbers.precision == "double" else 4
    lines = [
        f"message   {counted(brain.message_bytes, 'byte')}{within}",
        f"memory    {made.memory_bytes * size // 4:,} bytes of numbers, {size} a number",
    ]
    if made.flash_bytes is not None:
        lines.append(f"flash     {made.flash_bytes:,} bytes, besides Kilobot's own library")
        lines.append(f"RAM       {made.ram_bytes:,} bytes, with messages that wait")
    return lines


def _compare(options: argparse.Namespace) -> int:
    from swarmcensus.robots import compare

    given = [name for name in MAKING if getattr(options, name) not in (None, [])]
    if options.folder or given:
        what = option(given[0]) if given else str(options.folder)
        raise OptionError(f"{what} does not go with {option('selftest')}", key=given[0] if given else "folder")
    output = read_text(options.selftest, option("selftest", options.selftest), most=None, errors="replace")
    try:
        result = compare(output, Path(options.what))
    except InputError as error:
        raise error if error.file else InputError.of(options.selftest, error) from None
    if options.json:
        answer("selftest", vars(result) | {"passes": result.passes, "wrong": [vars(d) for d in result.wrong]})
    else:
        _show(result)
    return 0 if result.passes else 2


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


COMMANDS = (
    Command(
        "deploy", "Write a brain's files for a robot, or check a robot.",
        Group.ROBOTS, 1, deploy, add_deploy_options,
    ),
)  # fmt: skip
