"""The command `relive`: computes robots' states again from their logs, with their brain or others."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmcensus.cli.options import Command, Group, add_shared, once

from swarmcensus.cli.output import answer, say, wrote
from swarmcensus.support.errors import OptionError
from swarmcensus.support.options import misplaced, wrong_option

if TYPE_CHECKING:
    from swarmcensus.brains import Brain
    from swarmcensus.robots import Recording, Relived, RobotReplay, Stranger

DIFFER = 1  # exit code if a state differs in any bit, or there is none, or a log is of another recording
SHOWN = 8  # lines of a list


def add_relive_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `relive`."""
    sub.add_argument("folder", type=Path, metavar="FOLDER", help="robots' logs, as swarmcensus swarm or boards write")
    sub.add_argument(
        "--brain",
        action="append",
        default=[],
        metavar="BRAIN",
        help="replay under this brain too; repeatable",
    )
    add_shared(sub, parameter="of --brain", message="under --brain; default: that of the logs")
    sub.add_argument("--brain-file", type=Path, metavar="FILE", help="the robots' brain, if FOLDER lacks its file")
    add_shared(sub, fill_ratio="default: that of FOLDER")
    sub.add_argument("--out", type=Path, metavar="FILE.nc", help="results to write: one setting per brain")
    sub.add_argument(
        "--trace",
        type=Path,
        metavar="FILE.nc|csv",
        help="write every robot's estimate and memory after every tick, under --brain if there is one",
    )
    add_shared(sub, plot="the estimates of that trace")


def relive(options: argparse.Namespace) -> int:
    """Compute the states of a folder again."""
    from swarmcensus.robots import Clock, read_recording, relive_all, strangers_of, traces, under

    _check(options)
    recording = read_recording(options.folder, options.brain_file, options.fill_ratio)
    others = _brains(options, recording)
    for what in recording.absent:
        say(f"left out: {what}")
    clock = Clock(recording.members)
    lives = relive_all(recording, keep=bool(options.trace) and not others)
    strangers = strangers_of(recording)
    lived = [traces.as_logged(recording, lives)]
    lived += [under(recording, brain, options.message, clock, bool(options.trace)) for brain in others]
    if options.out:
        from swarmcensus.results import dataset_of, save

        save(dataset_of(recording, lived, clock, options.message), options.out)
    if options.trace or options.plot:
        _write_trace(options, traces.as_trace(recording, lived[-1], clock))
    if options.json:
        answer("relived", _as_dict(recording, lives, lived, strangers))
    else:
        _show(recording, lives, lived, strangers)
    if options.out:
        wrote(options.out)
    same = all(life.to_the_bit for life in lives) and any(life.ticks for life in lives)
    return 0 if same and not strangers else DIFFER


def _check(options: argparse.Namespace) -> None:
    """Raise InputError for options that do not go together, before anything is computed."""
    from swarmcensus.cli.commands.plot import figure_files

    from swarmcensus.support.files import check_output

    for name in ("parameter", "message"):
        if getattr(options, name) and not options.brain:
            raise misplaced(name, None, "goes with --brain")
    if options.parameter and len(options.brain) > 1:
        raise misplaced("parameter", None, "goes with one --brain")
    if (options.trace or options.plot) and len(options.brain) > 1:
        flag, other = ("trace", "") if options.trace else ("plot", ", or --out FILE.nc and swarmcensus plot FILE.nc")
        raise OptionError(f"--{flag} goes with one --brain at most: give each brain its own relive{other}", key=flag)
    check_output("out", options.out, (".nc",))
    check_output("trace", options.trace, (".csv", ".nc"))
    if options.out and options.trace and options.out.resolve() == options.trace.resolve():
        raise OptionError(f"--out and --trace both name {options.out}: they should name two files", key="out")
    if options.plot:
        figure_files(options.plot, ("png",))


def _brains(options: argparse.Namespace, recording: "Recording") -> list["Brain"]:
    from swarmcensus import brains

    found, values = [], once("parameter", options.parameter)
    for name in options.brain:
        brain = brains.load(name)
        try:
            brain = brain.with_parameters(values)
        except ValueError as error:
            raise OptionError(f"--parameter: {error}", key="parameter") from None
        if brain.name == recording.brain.name and brain.sha256 != recording.brain.sha256:
            brain = replace(brain, name=f"{brain.name} (--brain)")
        found.append(brain)
    labels = [recording.as_it_was.label, *(brain.label for brain in found)]
    if twice := next((label for label in labels if labels.count(label) > 1 and options.out), None):
        why = "the robots' own brain is always there" if twice == labels[0] else "give each --brain once"
        raise wrong_option("out", options.out, f"{twice} would be there twice: {why}")
    return found


def _write_trace(options: argparse.Namespace, trace: Any) -> None:
    from swarmcensus.cli.commands.plot import save_figure

    from swarmcensus.results import write_trace

    if options.trace:
        write_trace(trace, options.trace)
        wrote(options.trace)
    if options.plot:
        from swarmcensus.figures import plot

        save_figure(plot.curves(trace), options.plot, ("png",))


def _as_dict(
    recording: "Recording", lives: Sequence["RobotReplay"], lived: Sequence["Relived"], strangers: Sequence["Stranger"]
) -> dict[str, Any]:
    robots = [
        {
            "number": life.number, "ticks": life.ticks, "relived": life.relived, "unknown": life.unknown,
            "to_the_bit": life.to_the_bit,
            "starts": [
                {"boot": one.boot, "tick": one.tick, "kind": one.kind, "source_boot": one.source_boot}
                for one in life.starts
            ],
            "differences": [one._asdict() for one in life.breaks],
            "lost": [one._asdict() for one in life.lost],
        }
        for life in lives
    ]  # fmt: skip
    brains = [
        {"brain": label, **_ends(recording, one, robots), "unknown": one.unknown, "counts": dict(one.counts)}
        for label, one, robots in _rows(recording, lived)
    ]
    return {
        "title": recording.title, "fill_ratio": recording.fill_ratio, "robots": robots, "brains": brains,
        "strangers": [one._asdict() for one in strangers],
    }  # fmt: skip


def _rows(recording: "Recording", lived: Sequence["Relived"]) -> list[tuple[str, "Relived", Sequence[int]]]:
    """Each brain's label, what came of it, and its robots: those of one recording may have several brains."""
    everyone = [member.number for member in recording.members]
    kinds = recording.kinds if len(recording.kinds) > 1 else {lived[0].brain.label: everyone}
    others = [(one.brain.label, one, everyone) for one in lived[1:]]
    return [*((label, lived[0], robots) for label, robots in kinds.items()), *others]


def _ends(recording: "Recording", lived: "Relived", robots: Sequence[int]) -> dict[str, float | None]:
    """The mean error of honest robots at the end and the share in the right bin; None where f is not known."""
    import numpy as np

    from swarmcensus.robots import ends_of
    from swarmcensus.simulation import correct

    counted = np.array([member.honest and member.number in robots for member in recording.members])
    last = ends_of(recording, lived)[counted]
    last = last[np.isfinite(last)]
    if not last.size:
        return {"mean_estimate": None, "mean_error": None, "right": None}
    f = recording.fill_ratio
    return {
        "mean_estimate": float(last.mean()),
        "mean_error": None if f is None else float(np.abs(last - f).mean()),
        "right": None if f is None else float(correct(last, f, recording.bins)),
    }


def _show(
    recording: "Recording", lives: Sequence["RobotReplay"], lived: Sequence["Relived"], strangers: Sequence["Stranger"]
) -> None:
    from swarmcensus.robots import TOLD, UNKNOWN, summary_of
    from swarmcensus.support.formatting import counted
    from swarmcensus.support.printed_tables import Table
    from swarmcensus.support.terminal import show

    ticks, relived = sum(life.ticks for life in lives), sum(life.relived for life in lives)
    truth = "" if recording.fill_ratio is None else f", fill ratio {recording.fill_ratio:g}"
    logs = "its log" if len(lives) == 1 else "their logs"
    print(f"{recording.title}: {summary_of(recording)}, {counted(ticks, 'tick')} in {logs}{truth}")
    exact = f"{sum(life.to_the_bit for life in lives):,} of {counted(len(lives), 'robot')} lived again to the bit"
    if ticks:
        print(f"{exact}, {relived:,} of {counted(ticks, 'tick')}")
    else:
        print("the logs hold no ticks: nothing to compare")
    if unknown := sum(life.unknown for life in lives):
        print(f"{counted(unknown, 'tick')} not lived again: the memory before is not known")
    _list([f"  robot {one.robot} is not of this recording: {one.reason}" for one in strangers])
    _list(_break_lines(lives))
    _list([_lost_line(life.number, lost) for life in lives for lost in life.lost])
    _list(_start_lines(lives))
    names = ("mean estimate", "mean error", "right", "sent", "heard", "unknown")
    rows = []
    for label, one, robots in _rows(recording, lived):
        ends, was = _ends(recording, one, robots), one is lived[0]
        rows.append((
            label + ", as it was" * was, _number(ends["mean_estimate"]), _number(ends["mean_error"]),
            "-" if ends["right"] is None else f"{100 * ends['right']:.1f} %",
            f"{sum(one.sent[robot] for robot in robots):,}", f"{sum(one.heard[robot] for robot in robots):,}",
            "-" if was else f"{one.unknown:,}",
        ))  # fmt: skip
    print()
    show(Table.of_rows({"brain": False} | dict.fromkeys(names, True), rows))
    for one in lived[1:]:
        for kinds, title in ((UNKNOWN, "unknown under {}:"), (TOLD, "known under {}, and not as in the logs:")):
            lines = [f"  {one.counts[name]:,} {what}" for name, what in kinds.items() if one.counts[name]]
            if lines:
                print(title.format(one.brain.label), *lines, sep="\n")


def _break_lines(lives: Sequence["RobotReplay"]) -> list[str]:
    """A line for each difference, and one for all robots that ran another brain."""
    from swarmcensus.robots import ANOTHER

    together: dict[str, list[int]] = {}
    for life in lives:
        for one in life.breaks:
            if one.reason.startswith(ANOTHER):
                together.setdefault(one.reason.removeprefix(ANOTHER), []).append(life.number)
    several = {hashes: robots for hashes, robots in together.items() if len(robots) > 1}
    return [
        f"  {_those(robots, len(lives))} ran another brain: the hash of its file{hashes}"
        for hashes, robots in several.items()
    ] + [
        f"  robot {life.number}, boot {one.boot}, tick {one.tick}: {one.reason}"
        for life in lives for one in life.breaks if one.reason.removeprefix(ANOTHER) not in several
    ]  # fmt: skip


def _start_lines(lives: Sequence["RobotReplay"]) -> list[str]:
    """A line for each start that is worth one, and one for all robots if all started blank."""
    starts = [(life, s) for life in lives for s in life.starts if life.relived and (s.boot or s.kind != "blank")]
    blank = [life.number for life, s in starts if s.kind == "blank"]
    together = len(lives) > 1 and sorted(blank) == sorted(life.number for life in lives)
    lines = [f"  all {len(lives):,} robots started blank"] if together else []
    return lines + [
        f"  robot {life.number}, boot {s.boot}: " + (
            "started blank" if s.kind == "blank" else f"resumed the memory of boot {s.source_boot}, tick {s.tick}"
            if s.kind == "resumed" else f"started with a memory of tick {s.tick} that its log does not have"
        )
        for life, s in starts if not (together and s.kind == "blank")
    ]  # fmt: skip


def _those(robots: Sequence[int], count: int) -> str:
    if len(robots) == count:
        return f"all {count:,} robots"
    more = f" and {len(robots) - SHOWN:,} more" if len(robots) > SHOWN else ""
    return f"robots {', '.join(map(str, robots[:SHOWN]))}{more}"


def _lost_line(number: int, lost: Any) -> str:
    first = lost.after + 1
    ticks = f"ticks {first} on are" if lost.before is None else f"ticks {first} to {lost.before - 1} are"
    if lost.before == first + 1:
        ticks = f"tick {first} is"
    return f"  robot {number}, boot {lost.boot}: {ticks} not in the log: {lost.reason}"


def _list(lines: Sequence[str]) -> None:
    for line in lines[:SHOWN]:
        print(line)
    if len(lines) > SHOWN:
        print(f"  ... and {len(lines) - SHOWN:,} more")


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4f}"


COMMANDS = (
    Command(
        "relive", "Run robots' brains again from their logs, to the bit.",
        Group.ROBOTS, 3, relive, add_relive_options,
    ),
)  # fmt: skip
