"""The command `tune`. Imports wait until the command needs them."""

import argparse
import time
from pathlib import Path

from swarmcensus.basics.formatting import counted, elapsed
from swarmcensus.cli.options import from_zero, positive
from swarmcensus.cli.output import answer, reporting, say, wrote


def add_tune_options(sub: argparse.ArgumentParser) -> None:
    """Add the options of `tune`."""
    sub.add_argument("study", type=Path, metavar="STUDY.toml", help="a study file with the brain and its worlds")
    sub.add_argument("--brain", metavar="NAME", help="the brain to tune, if several in the study have parameters")
    sub.add_argument(
        "--adversary",
        metavar="NAME",
        help="search this adversary of the study's members for the most harm; --brain is then the one that hears it",
    )
    sub.add_argument(
        "--parameters",
        nargs="+",
        required=True,
        metavar="NAME=LOW:HIGH",
        help="ranges to search, such as prior=1:100, prior=1:100:log, k=1:9:whole, weights[0]=0:1",
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
    sub.add_argument("--seed", type=from_zero, help="seed of all random numbers, instead of the study's own")
    sub.add_argument(
        "--jobs", type=positive, help="number of threads (default: one per core); results do not depend on it"
    )
    sub.add_argument(
        "--out",
        type=Path,
        metavar="FILE.toml",
        help="what was found as a part of a study file (default: NAME-tuned.toml, or of an adversary NAME-worst.toml, "
        "in this folder)",
    )
    sub.add_argument("--fresh", action="store_true", help="start over instead of continuing the log of --out")


def tune(options: argparse.Namespace) -> int:
    """Search for good values of a brain's parameters, or the worst of an adversary's, and evaluate them."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.studies.study import Study
    from swarmcensus.tuning.targets import target_of
    from swarmcensus.tuning.tuning import files_of, tune

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
                options.parameters,
                target.brain.name,
                options.metric,
                budget=options.budget,
                trials=options.trials,
                jobs=options.jobs,
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
