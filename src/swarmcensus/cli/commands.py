"""The command line: parses, calls, prints. Imports wait until a command needs them."""

import argparse
import os
import shlex
import sys
import time
import warnings
from collections.abc import Sequence
from pathlib import Path

from swarmcensus.basics.errors import InputError, Interrupted
from swarmcensus.cli.options import MOST_ROWS, parser
from swarmcensus.cli.plotting import brain_of, figure_files, plot, save_figure

DIFFER = 1  # results that do not come out again as stored
STOPPED = 130  # what a shell expects of a program that Ctrl-C ended


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the exit code is 0, 2 for bad input, 130 after Ctrl-C."""
    options = parser(COMMANDS).parse_args(arguments)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("default", UserWarning)
            warnings.showwarning = lambda message, *_, **__: print(f"warning: {message}", file=sys.stderr)
            code = int(options.run(options) or 0)
            sys.stdout.flush()  # a full disk should be told of here
            return code
    except InputError as error:
        _complain(error)
        return 2
    except Interrupted as stopped:
        print(f"swarmcensus: {stopped}", file=sys.stderr)
        return STOPPED
    except KeyboardInterrupt:
        print("swarmcensus: stopped", file=sys.stderr)
        return STOPPED
    except BrokenPipeError:  # the reader of our output has gone, as after `| head`
        sys.stderr.close()
        return 0
    except OSError as error:
        _complain(f"{error.filename}: {error.strerror}" if error.filename else error)
        return 2
    except MemoryError:
        print("swarmcensus: not enough memory: fewer robots, settings or trials would need less", file=sys.stderr)
        return 2
    except Exception as error:
        if os.environ.get("SWARMCENSUS_DEBUG"):
            raise
        what = str(error).strip().splitlines()[0] if str(error).strip() else ""
        print(
            f"swarmcensus: {type(error).__name__}: {what} (unforeseen: with SWARMCENSUS_DEBUG=1 it says where)",
            file=sys.stderr,
        )
        return 2


def _complain(what: object) -> None:
    """One line, whatever is in it."""
    print("swarmcensus:", " ".join(str(what).split("\n")), file=sys.stderr)


def reproduce(options: argparse.Namespace) -> int:
    """Run, draw and check the paper."""
    from swarmcensus.paper import report, reproducing
    from swarmcensus.runs.progress import reporting

    done = reproducing.reproduce(
        options.out,
        trials=options.trials,
        seed=options.seed,
        jobs=options.jobs,
        only=options.only,
        fresh=options.fresh,
        reporting=reporting,
    )
    if done.claims:
        report.show(done.claims)
    print(done.page)
    return 0


def run(options: argparse.Namespace) -> int:
    """Run a study file."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.cli.tables import failures, settings
    from swarmcensus.results.cautions import warn_of_edges, warn_of_start
    from swarmcensus.runs.progress import reporting
    from swarmcensus.runs.running import run as run_study
    from swarmcensus.studies.study import Study

    study = Study.load(options.study)
    out = options.out or Path(options.study.stem + ".nc")
    if out.suffix != ".nc":
        raise InputError(f"--out {out}: results are written as .nc")
    check_writable(out, options.study)
    study = study.with_(trials=options.trials, seed=options.seed)
    begun = time.monotonic()

    def say(line: str) -> None:
        print(line, file=sys.stderr)

    try:
        with reporting(study.name) as progress:
            data = run_study(
                study,
                options.jobs,
                progress,
                out=out,
                fresh=options.fresh,
                cluster=_cluster(options),
                share=options.share,
                say=say,
            )
    except Interrupted as stopped:
        print(f"kept {stopped.done:,} of {stopped.total:,} trials in {out}: run again to go on", file=sys.stderr)
        raise
    settings(data, out)
    warn_of_start(data)
    warn_of_edges(data)
    trials = f"up to {study.trials}" if study.until else str(study.trials)
    part = f"share {data.attrs['share']} of " if "share" in data.attrs else ""
    print(f"{out}: {part}{data.sizes['setting']:,} settings of {trials} trials, {time.monotonic() - begun:.1f} s")
    return failures(data)


def _cluster(options: argparse.Namespace) -> str | None:
    if options.scheduler and options.cluster:
        raise InputError("--scheduler and --cluster: a study runs on one of them")
    if options.jobs and (options.scheduler or options.cluster):
        raise InputError(f"--jobs {options.jobs} is of threads: a cluster has as many workers as it has")
    if options.scheduler and "://" not in options.scheduler:
        raise InputError(f"--scheduler {options.scheduler}: should be an address, as tcp://host:8786")
    return options.scheduler or options.cluster  # type: ignore[no-any-return]


def show(options: argparse.Namespace) -> int:
    """Print the summary of a results file."""
    from swarmcensus.cli import tables
    from swarmcensus.results import selecting, summaries
    from swarmcensus.results.cautions import warn_of_edges, warn_of_start
    from swarmcensus.results.early import opened
    from swarmcensus.results.origins import round_of
    from swarmcensus.results.remeasuring import remeasure

    stored = remeasure(opened(options.results), delta=options.delta, bins=options.bins)
    data = selecting.where(stored, options.where)
    checkpoint = round_of(data, options.checkpoint, "--checkpoint")
    if options.sort:
        data = summaries.ordered(data, options.sort, options.reverse, checkpoint)
    elif options.reverse:
        raise InputError("--reverse goes with --sort")
    if options.json:
        few = data.isel(setting=slice(options.limit or None))
        print(summaries.as_json(stored, few, checkpoint))
        return 0
    limit = MOST_ROWS if options.limit is None else options.limit
    title = tables.head(stored, options.results)
    tables.settings(data, options.results, limit, checkpoint, title, _again(options))
    tables.failures(data)
    warn_of_start(data)
    warn_of_edges(data)
    return 0


def _again(options: argparse.Namespace) -> str:
    """The command `show` with what it was given, but for --limit."""
    words = ["swarmcensus", "show", str(options.results)]
    for name in ("where", "bins", "delta", "checkpoint", "sort"):
        value = getattr(options, name)
        words += [f"--{name}", str(value)] if value is not None else []
    return shlex.join([*words, *(["--reverse"] if options.reverse else [])])


def status(options: argparse.Namespace) -> int:
    """Say how far a study is."""
    from swarmcensus.runs.status import status as status_of

    print("\n".join(status_of(options.results).lines))
    return 0


def merge(options: argparse.Namespace) -> int:
    """Put results together."""
    from swarmcensus.results import merging

    if options.out.suffix != ".nc":
        raise InputError(f"--out {options.out}: results are written as .nc")
    data = merging.write(options.out, options.results, fresh=options.fresh)
    done, total = data.attrs["trials_done"], data.attrs["trials_total"]
    print(f"{options.out}: {data.sizes['setting']:,} settings, {done:,} of {total:,} trials")
    return 0


def verify(options: argparse.Namespace) -> int:
    """Run trials again and compare; 1 where they differ."""
    import secrets

    from swarmcensus.runs import verifying
    from swarmcensus.runs.progress import reporting

    if options.all and options.seed is not None:
        raise InputError(f"--seed {options.seed} chooses a sample: it does not go with --all")
    seed = secrets.randbelow(2**31) if options.seed is None else options.seed
    sample = 1.0 if options.all else options.sample
    with reporting("verify") as progress:
        found = verifying.verify(
            options.results, sample, brain=options.brain, seed=seed, jobs=options.jobs, progress=progress
        )
    for difference in (*found.labels, *found.differences):
        print(difference)
    what = f"{found.checked:,} of {found.stored:,} trials run again" + ("" if options.all else f" (--seed {seed})")
    same = "the numbers are the same to the last bit" if found.labels or found.notes else "the same to the last bit"
    differ = f"{len(found.differences):,} differ" if found.differences else same
    labels = [f"{len(found.labels):,} of the file's labels are not its study's"] if found.labels else []
    print("; ".join([f"{options.results}: {what}: {differ}", *labels, *found.notes]))
    return DIFFER if found.differences or found.labels else 0


def export(options: argparse.Namespace) -> int:
    """Write results as a table."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.results import store
    from swarmcensus.results.early import opened, say_partial
    from swarmcensus.results.remeasuring import remeasure
    from swarmcensus.results.selecting import where

    kinds = {".csv": "csv", ".parquet": "parquet"}
    kind = options.to or (kinds.get(options.out.suffix.lower(), "csv") if options.out else "csv")
    out = options.out or Path(f"{options.results.stem}.{kind}")
    if kinds.get(out.suffix.lower(), kind) != kind:
        raise InputError(f"--out {out}: --to {kind} is written as .{kind}")
    check_writable(out, options.results)
    data = remeasure(opened(options.results), delta=options.delta)
    say_partial(data, options.results)
    rows = store.export(where(data, options.where), out, kind)
    print(f"{out}: {rows:,} rows")
    return 0


def replay(options: argparse.Namespace) -> int:
    """Run one trial again."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.cli.tables import rounds
    from swarmcensus.figures import kinds
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
        save_figure(kinds.curves(trace), options.plot, ("png",))
    if readings is not None and edges is not None:
        robots = [f"robot {i}" for i in range(readings.shape[1])]
        recordings.write_rows(options.recording / "observations.csv", robots, readings)
        header = ["i", "j"] if edges.shape[1] == 2 else ["step", "sender", "receiver"]
        recordings.write_rows(options.recording / "links.csv", header, edges)
        print(options.recording)
    rounds(trace)
    return 0


def infer(options: argparse.Namespace) -> int:
    """Run a brain on recorded data."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.cli.tables import rounds
    from swarmcensus.figures import kinds
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
    rounds(trace)
    print(out)
    save_figure(kinds.curves(trace), plotted, ("png",))
    return 0


def _check_trace(out: Path) -> None:
    if out.suffix not in (".csv", ".nc"):
        raise InputError(f"--out {out}: a trace is written as .csv or .nc")


def brains(options: argparse.Namespace) -> int:
    """List or check brains."""
    from swarmcensus.cli.tables import checks, shipped

    if options.check is None:
        shipped()
        return 0
    from swarmcensus.conformance.suite import check

    print(f"checking {options.check}: compiled too, which takes up to a minute", file=sys.stderr, flush=True)
    return 0 if checks(options.check, check(options.check)) else 2


COMMANDS = {
    run.__name__: run for run in (run, reproduce, show, merge, status, verify, plot, export, replay, infer, brains)
}
