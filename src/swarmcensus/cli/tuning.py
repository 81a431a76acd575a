"""The command `tune`: values of a brain's parameters, with their evidence. Imports wait until needed."""

import argparse
import sys
import time
from pathlib import Path


def tune(options: argparse.Namespace) -> int:
    """Search for values of a brain's parameters."""
    from swarmcensus.basics.files import check_writable
    from swarmcensus.runs.progress import reporting
    from swarmcensus.studies.study import Study
    from swarmcensus.tuning.plans import chosen
    from swarmcensus.tuning.tuning import files_of, tune

    study = Study.load(options.study).with_(seed=options.seed)
    brain = chosen(study, options.brain)
    out = options.out or Path(f"{Path(brain.name).stem}-tuned.toml")
    for path in files_of(out).values():
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
                say=lambda line: print(line, file=sys.stderr),
            )
    except KeyboardInterrupt:
        print(f"kept what is done in {files_of(out)['.csv']}: tune again to go on", file=sys.stderr)
        raise
    print(found)
    print(f"{out}: {len(found.evaluations):,} evaluations, {time.monotonic() - begun:.1f} s")
    return 0
