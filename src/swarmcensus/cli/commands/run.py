"""The commands `reproduce`, `run` and `status`. Imports wait until a command needs them."""

import argparse
import time
from pathlib import Path

from swarmcensus.cli.options import OF_RUNS, Command, Group, add_shared, part_of_trials
from swarmcensus.cli.output import answer, present, reporting, say, wrote
from swarmcensus.support.errors import Interrupted
from swarmcensus.support.formatting import counted, elapsed
from swarmcensus.support.options import command, misplaced, wrong_option


def add_reproduce_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `reproduce`."""
    sub.add_argument(
        "of",
        nargs="?",
        default="paper",
        metavar="WHAT",
        help="paper (default), or rivals: published results on other algorithms",
    )
    sub.add_argument("--out", type=Path, help="folder for the results (default: reproduction, or reproduction-rivals)")
    sub.add_argument(
        "--only", nargs="+", metavar="PART", help="only these parts, such as fig2, fig3, fig4, fig5 or claims"
    )
    sub.add_argument("--pdf", action="store_true", help="also write the figures as PDF")
    add_shared(sub, *OF_RUNS)


def reproduce(options: argparse.Namespace) -> int:
    """Run the studies of an evaluation, draw its figures and check its claims."""
    from swarmcensus.evaluation import report, reproducing
    from swarmcensus.support.intervals import FEWEST

    folder = "reproduction" if options.of == "paper" else f"reproduction-{options.of}"
    with reporting("reproduce") as progress:
        done = reproducing.reproduce(
            options.out or Path(folder), of=options.of, trials=options.trials, seed=options.seed, jobs=options.jobs,
            device=options.device, only=options.only, fresh=options.fresh, pdf=options.pdf, progress=progress,
            say=wrote,
        )  # fmt: skip
    if options.json:
        print(report.as_json(done.claims, done.datasets, done.of.source), end="")
    elif done.claims:
        report.show(done.claims)
        if options.trials is not None and options.trials < FEWEST:
            say(f"intervals need {FEWEST} trials or more: {counted(options.trials, 'trial')} cannot decide most claims")
    wrote(done.page)
    return 0


def add_study_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `run`."""
    sub.add_argument("study", type=Path, metavar="STUDY.toml", help="a study file ('new study' writes one)")
    sub.add_argument(
        "--out",
        type=Path,
        metavar="FILE.nc",
        help="results file (default: name of the study file with .nc, in this folder)",
    )
    add_shared(sub, *OF_RUNS)
    sub.add_argument(
        "--share",
        type=part_of_trials,
        metavar="K/N",
        help="run only the K-th of N parts of the trials; 'merge' joins the results",
    )
    sub.add_argument(
        "--scheduler", metavar="ADDRESS", help="address of a running Dask scheduler, such as tcp://host:8786"
    )
    sub.add_argument(
        "--cluster", metavar="WHERE", help="local:4 (4 processes of this machine) or a TOML file (docs/long-studies.md)"
    )


def run(options: argparse.Namespace) -> int:
    """Run a study file."""
    from swarmcensus.studies import Study
    from swarmcensus.support.files import check_output

    study = Study.load(options.study)
    out = options.out or Path(options.study.stem + ".nc")
    check_output("out", out, (".nc",), options.study)
    study = study.with_(trials=options.trials, seed=options.seed)
    # After the checks above, since these imports are slow:
    from swarmcensus.cli.tables import as_rows, failures, settings
    from swarmcensus.results import as_dict, packed
    from swarmcensus.runs import run as run_study

    begun = time.monotonic()
    try:
        with reporting(study.name) as progress:
            results = run_study(
                study,
                options.jobs,
                progress,
                out=out,
                fresh=options.fresh,
                cluster=_cluster(options),
                share=options.share,
                say=say,
                device=options.device,
            )
    except Interrupted as stopped:
        say(f"kept {stopped.done:,} of {counted(stopped.total, 'trial')} in {out}: the same command continues")
        raise
    data = packed(results)
    present(options, "summary", lambda: as_dict(data, data), lambda: as_rows(data), lambda: settings(data, out))
    trials = "up to " * bool(study.until) + counted(study.trials, "trial")
    part = f"share {data.attrs['share']} of " if "share" in data.attrs else ""
    wrote(f"{out}: {part}{counted(data.sizes['setting'], 'setting')} of {trials}, {elapsed(time.monotonic() - begun)}")
    if part:
        say(f"next, with the other shares: {command('swarmcensus', 'merge', out)} ... --out ALL.nc")
    elif data.attrs["trials_done"]:
        several = len({*data["brain"].values.tolist()}) > 1
        say(f"next: {command('swarmcensus', 'compare' if several else 'plot', out)}")
    return failures(data)


def _cluster(options: argparse.Namespace) -> str | None:
    if options.scheduler and options.cluster:
        raise misplaced("scheduler", None, "and --cluster exclude each other: give one of them")
    if options.jobs and (options.scheduler or options.cluster):
        raise misplaced(
            "jobs", options.jobs, "sets the threads of this machine: it does not go with --scheduler or --cluster"
        )
    if options.scheduler and "://" not in options.scheduler:
        raise wrong_option("scheduler", options.scheduler, "should be an address such as tcp://host:8786")
    return options.scheduler or options.cluster  # type: ignore[no-any-return]


def add_status_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `status`."""
    sub.add_argument("results", type=Path, metavar="RESULTS.nc", help="the file of --out, finished or not")


def status(options: argparse.Namespace) -> int:
    """Show how far a study is, and when it will end."""
    from swarmcensus.runs import status as status_of

    progress = status_of(options.results)
    if options.json:
        answer("status", progress.as_dict)
    else:
        print("\n".join(progress.lines))
        if progress.done == progress.total:
            say(f"next: {command('swarmcensus', 'show', options.results)}")
    return 0


COMMANDS = (
    Command(
        "reproduce", "Run the paper's evaluation: its figures and its claims.",
        Group.LOOK, 2, reproduce, add_reproduce_options,
    ),
    Command(
        "run", "Run a study and write its results.",
        Group.STUDIES, 2, run, add_study_options, table=True,
    ),
    Command(
        "status", "Show how far a study is, and when it will end.",
        Group.STUDIES, 3, status, add_status_options,
    ),
)  # fmt: skip
