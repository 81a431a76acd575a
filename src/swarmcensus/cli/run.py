"""Commands that run studies and brains: `run`, `reproduce`, `status`, `brains`. Imports wait until needed."""

import argparse
import sys
import time
from pathlib import Path

from swarmcensus.basics.counting import counted
from swarmcensus.basics.errors import InputError, Interrupted
from swarmcensus.cli.output import answer, reporting, say, wrote


def reproduce(options: argparse.Namespace) -> int:
    """Run, draw and check the paper."""
    from swarmcensus.paper import report, reproducing
    from swarmcensus.statistics.intervals import FEWEST

    done = reproducing.reproduce(
        options.out,
        of=options.of,
        trials=options.trials,
        seed=options.seed,
        jobs=options.jobs,
        only=options.only,
        fresh=options.fresh,
        reporting=reporting,
        say=wrote,
    )
    if options.json:
        print(report.as_json(done.claims, done.datasets, done.of.source), end="")
    elif done.claims:
        report.show(done.claims)
        if options.trials is not None and options.trials < FEWEST:
            few = f"{counted(options.trials, 'trial')} decide{'s' * (options.trials == 1)} next to nothing"
            say(f"{few}: with fewer than {FEWEST}, intervals do not hold")
    wrote(done.page)
    return 0


def run(options: argparse.Namespace) -> int:
    """Run a study file."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.studies.study import Study

    study = Study.load(options.study)
    out = options.out or Path(options.study.stem + ".nc")
    if out.suffix != ".nc":
        raise InputError(f"--out {out}: results are written as .nc")
    check_writable(out, options.study)
    study = study.with_(trials=options.trials, seed=options.seed)
    from swarmcensus.cli.tables import failures, settings  # once all is well: these take long
    from swarmcensus.results.cautions import warn_of_edges, warn_of_start
    from swarmcensus.results.summaries import told_of
    from swarmcensus.runs.running import run as run_study

    begun = time.monotonic()
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
        say(f"kept {stopped.done:,} of {counted(stopped.total, 'trial')} in {out}: run again to go on")
        raise
    if options.json:
        answer("summary", told_of(data, data))
    elif not options.quiet:  # what was asked for is the file
        settings(data, out)
    warn_of_start(data)
    warn_of_edges(data)
    trials = "up to " * bool(study.until) + counted(study.trials, "trial")
    part = f"share {data.attrs['share']} of " if "share" in data.attrs else ""
    wrote(f"{out}: {part}{counted(data.sizes['setting'], 'setting')} of {trials}, {time.monotonic() - begun:.1f} s")
    return failures(data)


def _cluster(options: argparse.Namespace) -> str | None:
    if options.scheduler and options.cluster:
        raise InputError("--scheduler and --cluster: a study runs on one of them")
    if options.jobs and (options.scheduler or options.cluster):
        raise InputError(f"--jobs {options.jobs} is of threads: a cluster has as many workers as it has")
    if options.scheduler and "://" not in options.scheduler:
        raise InputError(f"--scheduler {options.scheduler}: should be an address, as tcp://host:8786")
    return options.scheduler or options.cluster  # type: ignore[no-any-return]


def brains(options: argparse.Namespace) -> int:
    """List, show or check brains and adversaries."""
    from swarmcensus.cli import list_brains

    if options.check is None and options.show is None:
        if options.wearing:
            raise InputError(f"--wearing {options.wearing}: it goes with --check or --show, and an adversary")
        known, liars = list_brains.brains(), list_brains.adversaries()
        if options.json:
            answer("brains", {"brains": known, "adversaries": liars})
        else:
            list_brains.show_brains(known)
            list_brains.show_adversaries(liars)
        return 0
    from swarmcensus.brains import find
    from swarmcensus.conformance.suite import check, subject

    if options.wearing:
        find(options.wearing)  # what is misspelt there is no fault of the adversary's
    if options.show is not None:
        if options.json:
            raise InputError("--json is of the list and of --check: --show prints a program")
        sys.stdout.write(subject(options.show, options.wearing).source)
        return 0
    say(f"checking {options.check}: compiled too, which takes up to a minute")
    found = check(options.check, wearing=options.wearing)
    if not options.json:
        return 0 if list_brains.checks(options.check, found) else 2
    conforms = all(one.fault is None for one in found)
    answer("checks", {"file": options.check, "conforms": conforms, "checks": found})
    return 0 if conforms else 2


def status(options: argparse.Namespace) -> int:
    """Say how far a study is."""
    from swarmcensus.runs.status import status as status_of

    found = status_of(options.results)
    if options.json:
        answer("status", found.told)
    else:
        print("\n".join(found.lines))
    return 0
