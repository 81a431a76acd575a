"""The commands `replay` and `infer`, which write a trace. Imports wait until a command needs them."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from swarmcensus.cli.commands.plot import brain_of, figure_files, save_figure
from swarmcensus.cli.options import Command, Group, add_shared, positive

from swarmcensus.cli.output import say, wrote
from swarmcensus.cli.source import add_results
from swarmcensus.support.errors import InputError
from swarmcensus.support.options import misplaced

if TYPE_CHECKING:
    import numpy as np

    from swarmcensus.simulation import Readings

TRACES = (".csv", ".nc")
OF_BAGS = ("readings", "messages")  # options of `infer`
OF_TABLES = ("time", "robot", "reading", "decimal")


def add_replay_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `replay`."""
    add_results(sub)
    add_shared(sub, "setting", "trial", required=True)
    add_shared(sub, "brain_file")
    sub.add_argument("--out", type=Path, metavar="FILE.nc|csv", help="write every robot's memory after every round")
    add_shared(sub, plot="every robot's estimate against rounds")
    sub.add_argument(
        "--recording",
        type=Path,
        metavar="FOLDER",
        help="write the trial as observations.csv and links.csv, for 'infer'",
    )


def replay(options: argparse.Namespace) -> int:
    """Run one trial again and show every round."""
    from swarmcensus.cli.tables import rounds

    from swarmcensus.figures import plot
    from swarmcensus.results import opened, recordings, replaying
    from swarmcensus.runs import log_compilation
    from swarmcensus.support.files import check_output, check_writable

    if options.plot:
        figure_files(options.plot, ("png",), options.results)
    check_output("out", options.out, TRACES, options.results)
    if options.recording:
        check_writable(options.recording / "observations.csv", options.results)
    data = opened(options.results)
    readings = edges = None
    with log_compilation(brain_of(data, options.setting)):
        trace = replaying.replay(data, options.setting, options.trial, options.brain_file)
        if options.recording:
            readings, edges = replaying.recording(data, options.setting, options.trial, options.brain_file)
    if options.out:
        recordings.write_trace(trace, options.out)
        wrote(options.out)
    if options.plot:
        save_figure(plot.curves(trace), options.plot, ("png",))
    if readings is not None and edges is not None:
        robots = [f"robot {i}" for i in range(readings.shape[1])]
        recordings.write_rows(options.recording / "observations.csv", robots, readings)
        header = ["i", "j"] if edges.shape[1] == 2 else ["step", "sender", "receiver"]
        recordings.write_rows(options.recording / "links.csv", header, edges)
        wrote(options.recording)
    rounds(trace, options)
    return 0


def add_infer_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `infer`."""
    sub.add_argument(
        "observations",
        type=Path,
        metavar="OBSERVATIONS.csv|parquet|BAG",
        help="readings: one row per step, one column per robot, or columns such as step, robot, observation; or a bag "
        "of ROS 2, a folder or its .mcap or .db3",
    )
    sub.add_argument(
        "--readings",
        metavar="TOPIC",
        help="topics of a bag with readings, such as '/robot_{robot}/floor', where {robot} is the robot's name",
    )
    sub.add_argument(
        "--messages",
        metavar="TOPIC",
        help="topics of a bag that tell whom a robot heard, such as '/robot_{robot}/heard'",
    )
    sub.add_argument("--period", type=float, metavar="SECONDS", help="time of a step, of a bag or a table")
    sub.add_argument("--time", metavar="COLUMN", help="column of a table with steps, seconds or timestamps")
    sub.add_argument("--robot", metavar="COLUMN", help="column with the robots, of a table with a row per reading")
    sub.add_argument("--reading", metavar="COLUMN", help="column with the readings, of such a table")
    sub.add_argument("--decimal", choices=(".", ","), help="mark of decimals in tables (default: what it must be)")
    sub.add_argument("--links", type=Path, metavar="LINKS.csv", help="edges i, j, or messages step, sender, receiver")
    sub.add_argument(
        "--accuracy",
        required=True,
        help="of the sensors: 0.8 (b = w), 0.9,0.6 (b, w), or a CSV file with one row per robot",
    )
    sub.add_argument(
        "--observations-per-round", type=positive, metavar="R", help="steps per round (default: 10; with messages 1)"
    )
    sub.add_argument(
        "--brain",
        default="minimalistic",
        metavar="BRAIN",
        help="a shipped brain or a brain file (default: %(default)s)",
    )
    sub.add_argument(
        "--out",
        type=Path,
        metavar="FILE.csv|nc",
        help="trace to write (default: OBSERVATIONS-trace.csv, next to the observations)",
    )
    add_shared(sub, plot="default: --out with .png")


def infer(options: argparse.Namespace) -> int:
    """Run a brain on recorded observations."""
    from swarmcensus.cli.tables import rounds

    from swarmcensus import brains
    from swarmcensus.checks import caution
    from swarmcensus.figures import plot
    from swarmcensus.results import recordings
    from swarmcensus.runs import log_compilation
    from swarmcensus.simulation import inferring, rows_of
    from swarmcensus.support.files import check_output
    from swarmcensus.worlds import read_links

    seen = options.observations if options.observations.name not in ("", "..") else options.observations.resolve()
    out = options.out or seen.parent / f"{seen.stem}-trace.csv"  # each folder keeps its own
    inputs = options.observations, Path(options.accuracy), *([options.links] if options.links else [])
    check_output("out", out, TRACES, *inputs)
    plotted = options.plot or out.with_suffix(".png")
    figure_files(plotted, ("png",))
    sources = {
        "observations": options.observations,
        "links": options.links or options.observations,
        "accuracy": f"--accuracy {options.accuracy}",
    }
    readings, heard = _recorded(options)
    links = rows_of(read_links(options.links, decimal=options.decimal), readings) if options.links else heard
    try:
        accuracy = recordings.read_accuracy(options.accuracy, readings, options.decimal)
        with log_compilation(Path(options.brain).name, "recorded data"):
            caution([brains.load(options.brain)], endless=False)
            trace = inferring.infer(readings, links, accuracy, options.observations_per_round, options.brain)
    except InputError as error:  # the message should name the file or option
        source = next((str(source) for key, source in sources.items() if str(error).startswith(key)), None)
        if source is None:
            raise
        raise InputError.of(source, error) from error
    recordings.write_trace(trace, out)
    rounds(trace, options)
    wrote(out)
    save_figure(plot.curves(trace), plotted, ("png",))
    return 0


def _recorded(options: argparse.Namespace) -> "tuple[Readings, np.ndarray | None]":
    """Readings, and the messages of a bag."""
    from swarmcensus.results import recordings
    from swarmcensus.robots import is_bag, read_bag
    from swarmcensus.simulation import Readings

    path = options.observations
    of_bag = is_bag(path)
    for name in OF_TABLES if of_bag else OF_BAGS:
        if getattr(options, name) is not None:
            other = "is for a table" if of_bag else "is for a bag: a folder, or a file that ends in .mcap or .db3"
            raise misplaced(name, None, f"{other}, which {path} is not")
    if not of_bag:
        columns = {name: getattr(options, name) for name in ("time", "robot", "reading", "period")}
        read = recordings.read_observations(path, options.decimal, **columns)
        if read.labels:
            say(f"{path}: robots {', '.join(read.labels)}")
        for note in read.notes:
            say(f"{path}: {note}")
        return read, None
    if missing := [f"--{name}" for name in ("readings", "period") if getattr(options, name) is None]:
        raise InputError.of(path, f"a bag needs {' and '.join(missing)}")
    if options.links and options.messages:
        raise misplaced("links", options.links, f"and --messages {options.messages}: one of them is right")
    recorded = read_bag(path, options.readings, options.messages, options.period)
    for note in recorded.notes:
        say(note)
    return Readings(recorded.readings), recorded.messages


COMMANDS = (
    Command(
        "replay", "Run one trial again, and show every round.",
        Group.STUDIES, 11, replay, add_replay_options, table=True,
    ),
    Command(
        "infer", "Run a brain on recorded readings and links.",
        Group.ROBOTS, 4, infer, add_infer_options, table=True,
    ),
)  # fmt: skip
