"""The commands `replay` and `infer`, which write a trace. Imports wait until a command needs them."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from swarmcensus.cli.commands.plot import brain_of
from swarmcensus.cli.figures_out import figure_files
from swarmcensus.cli.messages import say
from swarmcensus.cli.parameters import (
    BRAIN,
    COUNT,
    FILE,
    FOLDER,
    NUMBER,
    WHOLE,
    BrainFiles,
    Results,
    Set,
    path,
    takes,
    values_of,
)
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import InputError, OptionError
from swarmcensus.support.options import option_conflict

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from swarmcensus.brains import Brain
    from swarmcensus.simulation import Readings

TRACES = (".csv", ".nc")
TOPIC, COLUMN = Parameter(metavar="TOPIC"), Parameter(metavar="COLUMN")


def replay(
    results: Results, /, *, setting: Annotated[int, WHOLE], trial: Annotated[int, WHOLE], brain_file: BrainFiles = (),
    out: Annotated[Path | None, takes(path, "FILE.nc|csv")] = None,
    recording: Annotated[Path | None, FOLDER] = None,
) -> Answer:  # fmt: skip
    """Run one trial again, and show some rounds; --out has all.

    Args:
        setting: number of the setting, as 'show' prints it
        trial: number of the trial, from 0
        out: write every robot's memory after every round
        recording: write the trial as observations.csv and links.csv, for 'infer'
    """
    from swarmcensus.results import open_partial
    from swarmcensus.runs import log_compilation
    from swarmcensus.summaries import recordings, replaying
    from swarmcensus.support.files import check_output, check_writable

    check_output("out", out, TRACES, results)
    if recording:
        check_writable(recording / "observations.csv", results)
    data = open_partial(results)
    with log_compilation(brain_of(data, setting)):
        trace = replaying.replay(data, setting, trial, brain_file)
        recorded = replaying.recording(data, setting, trial, brain_file) if recording else None
    files = []
    if out:
        recordings.write_trace(trace, out)
        files.append(out)
    if recording and recorded:
        readings, edges = recorded
        robots = [f"robot {i}" for i in range(readings.shape[1])]
        recordings.write_rows(recording / "observations.csv", robots, readings)
        header = ["i", "j"] if edges.shape[1] == 2 else ["step", "sender", "receiver"]
        recordings.write_rows(recording / "links.csv", header, edges)
        files.append(recording)
    return _rounds(trace, files)


def _rounds(trace: "xr.Dataset", files: list[Path]) -> Answer:
    """The swarm's estimates at a few rounds of a trace."""
    import numpy as np

    from swarmcensus.summaries import honest_in

    honest = honest_in(trace)
    estimates = trace["estimate"].values[:, honest]
    last = len(estimates) - 1
    at = sorted({0, last} | {m * 10**e for e in range(9) for m in (1, 2, 5) if m * 10**e < last})
    ends = {"lowest": estimates.min(axis=1), "median": np.median(estimates, axis=1), "highest": estimates.max(axis=1)}
    owners = "the robots'" if honest.all() else f"the {honest.sum():,} honest robots'"
    return Answer(
        title=f"{trace.attrs['title']}: {owners} estimates", files=dict.fromkeys(files, ""),
        rows=[{"round": k} | {name: values[k] for name, values in ends.items()} for k in at],
        fields={"robots": int(honest.sum())},
    )  # fmt: skip


def infer(
    observations: Annotated[Path, takes(path, "OBSERVATIONS.csv|parquet|BAG")], /, *,
    readings: Annotated[str | None, TOPIC] = None, messages: Annotated[str | None, TOPIC] = None,
    period: Annotated[float | None, NUMBER] = None, time: Annotated[str | None, COLUMN] = None,
    robot: Annotated[str | None, COLUMN] = None, reading: Annotated[str | None, COLUMN] = None,
    decimal: Literal[".", ","] | None = None, links: Annotated[Path | None, takes(path, "LINKS.csv")] = None,
    accuracy: Annotated[str | None, Parameter(metavar="ACCURACY")] = None,
    observations_per_round: Annotated[int | None, COUNT] = None, brain: Annotated[str | None, BRAIN] = None,
    study: Annotated[Path | None, takes(path, "STUDY.toml")] = None, set: Set = (),
    out: Annotated[Path | None, takes(path, "FILE.csv|nc")] = None, plot: Annotated[Path | None, FILE] = None,
) -> Answer:  # fmt: skip
    """Run a brain on recorded readings and links.

    Args:
        observations: a table, with a row per step or per reading, or a bag of ROS 2: a folder, .mcap or .db3
        readings: topics of a bag with readings, such as '/robot_{robot}/floor', where {robot} is the robot's name
        messages: topics of a bag that tell whom a robot heard, such as '/robot_{robot}/heard'
        period: seconds of a step, of a bag or a table
        time: column of a table with steps, seconds or timestamps
        robot: column with the robots, of a table with a row per reading
        reading: column with the readings, of such a table
        decimal: mark of decimals in tables (default: what it must be)
        links: edges i, j, or messages step, sender, receiver
        accuracy: of the sensors: 0.8, {black = 0.9, white = 0.6}, or a CSV file with one row per robot
        observations_per_round: steps per round (default: 10; with messages 1)
        brain: a shipped brain or a brain file (default: minimalistic)
        study: a study, of which the first setting has the brain, the accuracy and the observations per round
        out: trace to write (default: OBSERVATIONS-trace.csv, next to the observations)
        plot: draw every robot's estimate against rounds: .png, .svg or .pdf (default: --out with .png)
    """
    from swarmcensus import brains
    from swarmcensus.checks import caution
    from swarmcensus.figures import plot as figures, save
    from swarmcensus.runs import log_compilation
    from swarmcensus.simulation import inferring, rows_of
    from swarmcensus.summaries import recordings
    from swarmcensus.support.files import check_output
    from swarmcensus.worlds import read_links

    of_study: Brain | None = None
    if set and study is None:
        raise option_conflict("set", None, "goes with --study")
    if study is not None:
        from swarmcensus.studies import Study

        setting = Study.load(study, values_of(set)).settings()[0]
        accuracy, of_study = accuracy or str(setting.accuracy), setting.brain
        observations_per_round = observations_per_round or (None if messages else setting.observations_per_round)
    if accuracy is None:
        raise OptionError("--accuracy or --study is missing: --accuracy 0.8", key="accuracy")
    known = brain or of_study or "minimalistic"
    seen = observations if observations.name not in ("", "..") else observations.resolve()
    out = out or seen.parent / f"{seen.stem}-trace.csv"  # each folder keeps its own
    check_output("out", out, TRACES, observations, Path(accuracy), *([links] if links else []))
    paths = figure_files(plot or out.with_suffix(".png"), ("png",))
    if links and messages:
        raise option_conflict("links", links, f"and --messages {messages}: one of them is right")
    of_table = {"time": time, "robot": robot, "reading": reading, "decimal": decimal}
    read, heard = _recorded(observations, {"readings": readings, "messages": messages}, of_table, period)
    edges = rows_of(read_links(links, decimal=decimal), read) if links else heard
    sources = {"observations": observations, "links": links or observations, "accuracy": f"--accuracy {accuracy}"}
    try:
        accuracies = recordings.read_accuracy(accuracy, read, decimal)
        loaded = known if isinstance(known, brains.Brain) else brains.load(known)
        with log_compilation(Path(loaded.name).name, "recorded data"):
            caution([loaded])
            trace = inferring.infer(read, edges, accuracies, observations_per_round, loaded)
    except InputError as error:  # the message should name the file or option
        source = next((str(source) for key, source in sources.items() if str(error).startswith(key)), None)
        if source is None:
            raise
        raise InputError.of(source, error) from error
    recordings.write_trace(trace, out)
    return _rounds(trace, [out, *save(figures.curves(trace), *paths)])


def _recorded(
    path: Path, of_bag: Mapping[str, Any], of_table: Mapping[str, Any], period: float | None
) -> "tuple[Readings, np.ndarray | None]":
    """Readings, and the messages of a bag."""
    from swarmcensus.robots import is_bag, read_bag
    from swarmcensus.summaries import recordings

    is_one = is_bag(path)
    for name, value in (of_table if is_one else of_bag).items():
        if value is not None:
            other = "is for a table" if is_one else "is for a bag: a folder, or a file that ends in .mcap or .db3"
            raise option_conflict(name, None, f"{other}, which {path} is not")
    needed = {"readings": of_bag["readings"], "period": period}
    if is_one and (missing := [f"--{name}" for name, value in needed.items() if value is None]):
        raise InputError.of(path, f"a bag needs {' and '.join(missing)}")
    if is_one:
        read, heard = read_bag(path, of_bag["readings"], of_bag["messages"], float(period or 0.0))
    else:
        read, heard = recordings.read_observations(path, period=period, **of_table), None
    for note in [f"robots {', '.join(read.labels)}"] * bool(read.labels) + [*read.notes]:
        say(f"{path}: {note}")
    return read, heard
