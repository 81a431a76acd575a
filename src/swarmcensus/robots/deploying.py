"""Writes a brain's files for a robot, or as C."""

import math
import shlex
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from swarmcensus.brains import Brain, load
from swarmcensus.checks import caution as check_quickly
from swarmcensus.robots.folders import check_free, check_same, new_folder, write_texts
from swarmcensus.robots.format_errors import caution, measured, sentence
from swarmcensus.robots.target import Order, Target, fitting, order_of, report_bytes
from swarmcensus.robots.targets import find
from swarmcensus.runtime.reports import GATEWAY, USB
from swarmcensus.studies import Study
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError
from swarmcensus.support.formatting import counted
from swarmcensus.support.options import command, option, option_conflict
from swarmcensus.translation import filled, owed_numbers
from swarmcensus.worlds import KnownRobot, read_robots

LINE = 11_520  # bytes a second of a serial port with 115,200 bits
OWN = {"settings.py", "settings.h"}  # the files with a robot's number and sensor


def deploy(
    brain: Brain | str | Path, folder: str | Path, target: str, *, accuracy: Any = None,
    message: str | None = None, precision: str | None = None, hz: float | None = None,
    parameters: Mapping[str, Any] | None = None, robot: int | None = None, log: int | None = None,
    study: Study | str | Path | None = None, set: Mapping[str, Any] = {}, robots: str | Path | None = None,
    calibrate: bool = False, report: str | None = None,
) -> Answer:  # fmt: skip
    """Write a brain's files for a target into a new folder, whole or not at all.

    `target` is "udp", "espnow" or "serial" for boards with MicroPython, "kilobot", "pogobot", "argos", or "c".
    `accuracy` is that of the sensor, 0.9 or {"black": 0.9, "white": 0.85}; "c" needs none. `message` is the format of
    messages, "float32", "float16", "ratio16" or "ratio8", by default that in which the brain errs least of those that
    fit; `precision` that of numbers in C, "single" or "double"; `hz` the ticks a second, 10 by default; `robot` its
    number, by default made of the chip's; `log` the bytes of a log that it may keep; `study` one whose first setting
    with this brain ARGoS simulates, with its parameters and formats if no others are given, and `set` values in place
    of those of the file's keys. `robots` is a file of robots: each gets a folder with its number and accuracies,
    flash.sh puts them onto their boards, and fetch.sh gets their logs. With `calibrate` there is a program that counts
    readings, and b and w may be unknown, also in the file of robots; flash.sh then builds it for Kilobots and Pogobots.
    `report` is the address of those who watch, "gateway" or "usb": robots report each tick to it, and wait until they
    are started. A folder with C may be written again; one for ARGoS may hold other files, and none of them is replaced.
    Warns of a format that is wrong for the brain, and of a program that does not steer as the brain asks. The answer's
    `fields` have the names of the files, and sizes in bytes. Raises InputError.
    """
    folder, kind = Path(folder), find(target)
    may_hold = ("*",) if kind.adds else kind.may_replace
    check_free(folder, may_hold)
    brain = brain if isinstance(brain, Brain) else load(brain)
    known = _known(robots, target, kind, calibrate, accuracy=accuracy, robot=robot) if robots else []
    given = partial(
        order_of, brain, target, kind, message=message, precision=precision, hz=hz, parameters=parameters, log=log,
        study=study if study is None or isinstance(study, Study) else Study.load(study, set),
        where="study" if isinstance(study, Study) else f"study file {study}", calibrate=calibrate, report=report,
    )  # fmt: skip
    numbered = "robot" not in kind.refuses
    orders = [given(accuracy=one.accuracy, robot=one.number if numbered else None) for one in known] or [
        given(accuracy=accuracy, robot=robot)
    ]
    check_quickly([orders[0].brain])
    files = [kind.files(replace(order, folder=folder.resolve())) for order in orders]
    order, texts = orders[0], files[0]
    flash, ram = kind.measure(order, texts)
    if kind.adds:
        check_same(folder, texts)
    shared = {name: text for name, text in texts.items() if not (known and name in OWN)}
    if known:
        counts = "MAIN=calibrate\n" * ("MAIN" in kind.flash and any(one.b is None for one in orders))
        shared["flash.sh"] = _script("flash.sh", "puts each robot's files onto it", counts + kind.flash, known)
        gets = ("gets each robot's log into logs", kind.fetch)
        shared |= {"fetch.sh": _script("fetch.sh", *gets, known)} if log and kind.fetch else {}
    with new_folder(folder, may_hold) as made:
        write_texts(made, shared)
        for one, own in zip(known, files, strict=False):
            place = made / f"robot-{one.number}"
            place.mkdir()
            write_texts(place, {name: own[name] for name in own.keys() & OWN})
    if order.brain.steers and not kind.moves:
        warnings.warn(
            f"{order.brain.name} steers, and the program has nothing that moves the robot: fill that in, from the "
            "robot's course", stacklevel=2
        )  # fmt: skip
    if inverse := [one for one in orders if one.b is not None and one.w is not None and one.b + one.w < 1.0]:
        warnings.warn(f"b + w of {counted(len(inverse), 'robot')} is below 1: black taken for white?", stacklevel=2)
    if said := caution(order.brain, fitting(order.brain, kind)):
        warnings.warn(said, stacklevel=2)
    found = _answer(order, flash, ram)
    if message is None and kind.largest is not None:
        fits = ", ".join(fitting(order.brain, kind))
        found.sentences = [
            f"format    {order.brain.numbers.message}: of those that fit ({fits}), none is known to err less",
            *found.sentences,
        ]
    if order.report in (GATEWAY, USB):
        robots_a_port = max(1, len(known)) if order.report == GATEWAY else 1
        needed = round(robots_a_port * order.hz * report_bytes(order.brain, max(0, len(known) - 1)))
        many = f"reports of robots that all hear each other are {needed:,} bytes a second, and a serial port carries"
        found.cautions = [f"{many} {LINE:,}: lower --hz"] * (needed > LINE)
    found.fields = {**found.fields, "folder": folder, "names": tuple(shared), "robots": [one.number for one in known]}
    found.files = {folder: ", ".join([*shared, *[f"robot-* of {counted(len(known), 'robot')}"] * bool(known)])}
    if known:
        found.next = command("sh", folder / "flash.sh")
    elif {"Makefile", "selftest.c"} <= texts.keys():  # which compare the C with Python bit for bit
        found.next = command("make", "-C", folder, "calibrate" if calibrate else "check")
    elif "selftest.py" in texts:
        mine = "" if robot is None else f"-{robot}"
        counts = f"""exec "import calibrate; calibrate.run('black')" > robot{mine}-black.csv"""
        does = counts if calibrate else f"run {command(folder / 'selftest.py')} > board.txt"
        found.next = f"mpremote cp {command(folder)}/*.py : && mpremote {does}"
    return found


def _known(path: str | Path, name: str, kind: Target, calibrate: bool, **asked: Any) -> list[KnownRobot]:
    """The robots of a file, for a target with a program for each. Raises InputError, also if more is `asked`."""
    for key, value in asked.items():
        if value is not None:
            raise option_conflict(key, value, f"does not go with {option('robots', path)}, which has it for each robot")
    if not kind.flash:
        raise option_conflict("robots", path, f"does not go with {option('target', name)}: it has no robots' programs")
    robots = read_robots(path, calibrated=not calibrate)
    for one in robots:
        if one.number not in kind.numbers:
            raise InputError.of(path, f"number = {one.number}: should be from {kind.numbers[0]} to {kind.numbers[-1]}")
        if math.isclose(one.b + one.w, 1.0):
            raise InputError.of(path, f"robot {one.number}, b = {one.b} and w = {one.w}: black and white read the same")
    return robots


def _script(name: str, what: str, does: str, robots: Sequence[KnownRobot]) -> str:
    """A script that does something with one robot after another."""
    lines = [shlex.join(["one", str(one.number), one.port or "", one.address or ""]) for one in robots]
    known = " ".join(str(one.number) for one in robots)
    does = does.strip().replace("\n", "\n    ")
    return filled("each.sh", name=name, what=what, does=does, known=known, robots="\n".join(lines))


def _answer(order: Order, flash: int | None, ram: int | None) -> Answer:
    """What a brain needs of its robot, in bytes, and how wrong the robot will be; None where that is not known."""
    brain = order.brain
    # 4 bytes a number, with those that the program keeps of rounded messages
    memory = brain.memory_bytes + 4 * (owed_numbers(brain) - len(brain.owed))
    within = "" if order.datagram_bytes is None else f", in a datagram of {order.datagram_bytes:,}"
    size = 8 if order.target.precisions and brain.numbers.precision == "double" else 4
    lines = [
        f"message   {counted(brain.message_bytes, 'byte')}{within}",
        f"memory    {memory * size // 4:,} bytes of numbers, {size} a number",
        f"error     {sentence(brain)}",
    ]
    if order.report:
        one, more = report_bytes(brain), report_bytes(brain, 1) - report_bytes(brain)
        size = order.datagram_bytes or 1
        lines.append(
            f"report    {one} bytes a tick and {more} for each message heard: {one / size:.1f} datagrams and more"
        )
    if flash is not None:
        lines.insert(2, f"flash     {flash:,} bytes, besides Kilobot's own library")
        lines.insert(3, f"RAM       {ram:,} bytes, with messages that wait")
    fields = {
        "brain": brain.label, "target": order.name, "message": brain.numbers.message,
        "precision": brain.numbers.precision if order.target.precisions else None,
        "message_bytes": brain.message_bytes, "datagram_bytes": order.datagram_bytes, "memory_bytes": memory,
        "flash_bytes": flash, "ram_bytes": ram, "mark": order.mark, "measured": measured(brain, brain.numbers.message),
    }  # fmt: skip
    return Answer(sentences=lines, fields=fields)
