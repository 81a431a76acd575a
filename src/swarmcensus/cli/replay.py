"""Commands that leave a trace: `replay` of a trial, `infer` from recorded data. Imports wait until needed."""

import argparse
from pathlib import Path

from swarmcensus.basics.errors import InputError
from swarmcensus.cli.output import wrote
from swarmcensus.cli.plot import brain_of, figure_files, save_figure


def replay(options: argparse.Namespace) -> int:
    """Run one trial again."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.cli.tables import rounds
    from swarmcensus.figures import plot
    from swarmcensus.results import recordings, replaying
    from swarmcensus.results.early import opened
    from swarmcensus.runs.progress import compiling

    if options.plot:
        figure_files(options.plot, ("png",), options.results)
    if options.out:
        _check_trace(options.out)
    recorded = options.recording / "observations.csv" if options.recording else None
    for path in filter(None, (options.out, recorded)):
        check_writable(path, options.results)
    data = opened(options.results)
    readings = edges = None
    with compiling(brain_of(data, options.setting)):
        trace = replaying.replay(data, options.setting, options.trial, options.brain)
        if options.recording:
            readings, edges = replaying.recording(data, options.setting, options.trial, options.brain)
    if options.out:
        recordings.write_trace(trace, options.out)
    if options.plot:
        save_figure(plot.curves(trace), options.plot, ("png",))
    if readings is not None and edges is not None:
        robots = [f"robot {i}" for i in range(readings.shape[1])]
        recordings.write_rows(options.recording / "observations.csv", robots, readings)
        header = ["i", "j"] if edges.shape[1] == 2 else ["step", "sender", "receiver"]
        recordings.write_rows(options.recording / "links.csv", header, edges)
        wrote(options.recording)
    rounds(trace, options.json)
    return 0


def infer(options: argparse.Namespace) -> int:
    """Run a brain on recorded data."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.cli.tables import rounds
    from swarmcensus.figures import plot
    from swarmcensus.results import recordings
    from swarmcensus.runs.progress import compiling
    from swarmcensus.simulation import inferring

    out = options.out or Path(f"{options.observations.stem}-trace.csv")
    _check_trace(out)
    check_writable(out, options.observations, Path(options.accuracy), *([options.links] if options.links else []))
    plotted = options.plot or out.with_suffix(".png")
    figure_files(plotted, ("png",))
    files = {"observations": options.observations, "links": options.links, "accuracy": f"--accuracy {options.accuracy}"}
    readings = recordings.read_observations(options.observations)
    links = recordings.read_links(options.links) if options.links else None
    try:
        accuracy = recordings.read_accuracy(options.accuracy)
        with compiling(Path(options.brain).name, "recorded data"):
            trace = inferring.infer(readings, links, accuracy, options.every, options.brain)
    except InputError as error:  # say which file it is in
        name = next((str(f) for key, f in files.items() if str(error).startswith(key)), None)
        raise InputError(f"{name}: {error}" if name else str(error)) from error
    recordings.write_trace(trace, out)
    rounds(trace, options.json)
    wrote(out)
    save_figure(plot.curves(trace), plotted, ("png",))
    return 0


def _check_trace(out: Path) -> None:
    if out.suffix not in (".csv", ".nc"):
        raise InputError(f"--out {out}: a trace is written as .csv or .nc")
