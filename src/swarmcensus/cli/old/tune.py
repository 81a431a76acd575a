"""The command `tune`. Imports wait until the command needs them."""

import argparse
import time
from pathlib import Path

from swarmcensus.cli.options import Command, Group, add_shared, positive

from swarmcensus.cli.output import answer, reporting, say, wrote
from swarmcensus.support.formatting import counted, elapsed


def add_tune_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `tune`."""
    sub.add_argument("study", type=Path, metavar="STUDY.toml", help="a study file with the brain and its worlds")
    sub.add_argument("--brain", metavar="BRAIN", help="the brain to tune, if several in the study have parameters")
    sub.add_argument(
        "--adversary",
        metavar="NAME",
        help="search this adversary of the study's members for the most harm; --brain is then the one that hears it",
    )
    sub.add_argument(
        "--parameter",
        action="append",
        required=True,
        metavar="NAME=LOW:HIGH",
        help="range in which a parameter is searched, such as prior=1:100, prior=1:100:log, k=1:9:whole or "
        "weights[0]=0:1; may be repeated",
    )
    sub.add_argument(
        "--metric",
        default="final_error",
        metavar="NAME",
        help="the measure to improve, or to worsen, as in 'compare': correct, or my_metric:low (default: %(default)s)",
    )
    sub.add_argument(
        "--budget",
        default="200",
        metavar="N|TIME",
        help="number of evaluations, or a time such as '10 min' (default: %(default)s)",
    )
    sub.add_argument(
        "--trials", type=positive, default=10, help="trials in each world of an evaluation (default: %(default)s)"
    )
    add_shared(sub, "seed", "jobs", "device", "fresh")
    sub.add_argument(
        "--out",
        type=Path,
        metavar="FILE.toml",
        help="what was found as a part of a study file (default: NAME-tuned.toml, or of an adversary NAME-worst.toml, "
        "in this folder)",
    )


def tune(options: argparse.Namespace) -> int:
    """Search for good values of a brain's parameters, or the worst of an adversary's, and evaluate them."""
    from swarmcensus.search import files_of, target_of, tune
    from swarmcensus.studies import Study
    from swarmcensus.support.files import check_writable

    study = Study.load(options.study).with_(seed=options.seed)
    target = target_of(study, options.brain, options.adversary)
    searched = target.program.name
    out = options.out or Path(f"{Path(searched).stem}-{'worst' if target.harms else 'tuned'}.toml")
    files = files_of(out)
    for path in files.values():
        check_writable(path, options.study)
    begun = time.monotonic()
    try:
        with reporting(f"{'searching' if target.harms else 'tuning'} {searched}") as progress:
            tuning = tune(
                study,
                options.parameter,
                target.brain.name,
                options.metric,
                budget=options.budget,
                trials=options.trials,
                jobs=options.jobs,
                device=options.device,
                out=out,
                fresh=options.fresh,
                progress=progress,
                say=say,
                adversary=options.adversary,
            )
    except KeyboardInterrupt:
        if files[".csv"].exists():
            say(f"kept finished evaluations in {files['.csv']}: the same command continues")
        raise
    if options.json:
        answer("tuning", tuning.as_dict)
    else:
        print(tuning)
    wrote(f"{out}: {counted(len(tuning.evaluations), 'evaluation')}, {elapsed(time.monotonic() - begun)}")
    return 0


COMMANDS = (
    Command(
        "tune", "Search for good values of a brain's parameters.",
        Group.BRAINS, 2, tune, add_tune_options,
    ),
)  # fmt: skip
