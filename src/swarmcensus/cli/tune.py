"""The command `tune`: values of a brain's parameters, with their evidence. Imports wait until needed."""

import argparse
import time
from pathlib import Path

from swarmcensus.basics.formatting import counted
from swarmcensus.cli.options import from_zero, positive
from swarmcensus.cli.output import answer, reporting, say, wrote


def add_tune_options(sub: argparse.ArgumentParser) -> None:
    """Of `tune`."""
    sub.add_argument("study", type=Path, metavar="STUDY.toml")
    sub.add_argument("--brain", metavar="NAME", help="which of the study's brains, if several have parameters")
    sub.add_argument(
        "--parameters",
        nargs="+",
        required=True,
        metavar="NAME=LOW:HIGH",
        help="where to look, as prior=1:100, prior=1:100:log, k=1:9:whole, weights[0]=0:1",
    )
    sub.add_argument(
        "--metric",
        default="final_error",
        metavar="NAME",
        help="a measure as of compare, as correct, or my_metric:low (default: %(default)s)",
    )
    sub.add_argument(
        "--budget", default="200", metavar="N|TIME", help="evaluations, or a time as '10 min' (default: %(default)s)"
    )
    sub.add_argument(
        "--trials", type=positive, default=10, help="in each world of an evaluation (default: %(default)s)"
    )
    sub.add_argument("--seed", type=from_zero, help="instead of the study's own")
    sub.add_argument("--jobs", type=positive, help="threads (default: one a core); the values do not depend on it")
    sub.add_argument("--out", type=Path, metavar="FILE.toml", help="default: the brain's name with -tuned.toml, here")
    sub.add_argument("--fresh", action="store_true", help="begin anew instead of going on with the log")


def tune(options: argparse.Namespace) -> int:
    """Search for values of a brain's parameters."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.studies.study import Study
    from swarmcensus.tuning.plans import chosen
    from swarmcensus.tuning.tuning import files_of, tune

    study = Study.load(options.study).with_(seed=options.seed)
    brain = chosen(study, options.brain)
    out = options.out or Path(f"{Path(brain.name).stem}-tuned.toml")
    files = files_of(out)
    for path in files.values():
        check_writable(path, options.study)
    begun = time.monotonic()
    try:
        with reporting(f"tuning {brain.name}") as progress:
            found = tune(
                study,
                options.parameters,
                brain.name,
                options.metric,
                budget=options.budget,
                trials=options.trials,
                jobs=options.jobs,
                out=out,
                fresh=options.fresh,
                progress=progress,
                say=say,
            )
    except KeyboardInterrupt:
        if files[".csv"].exists():
            say(f"kept what is done in {files['.csv']}: tune again to go on")
        raise
    if options.json:
        answer("tuning", found.told)
    else:
        print(found)
    wrote(f"{out}: {counted(len(found.evaluations), 'evaluation')}, {time.monotonic() - begun:.1f} s")
    return 0
