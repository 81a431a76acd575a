"""The command `tune`: values of a brain's parameters, with their evidence. Imports wait until needed."""

import argparse
import time
from pathlib import Path

from swarmcensus.basics.counting import counted
from swarmcensus.cli.output import answer, reporting, say, wrote


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
