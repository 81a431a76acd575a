"""The command `tune`."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from swarmcensus.cli.messages import reporting, say
from swarmcensus.cli.parameters import (
    BRAIN,
    COUNT,
    FILE,
    NAME,
    USUAL,
    Fresh,
    Hardware,
    Seed,
    Set,
    StudyFile,
    known,
    takes,
    values_of,
)
from swarmcensus.support.answers import Answer
from swarmcensus.support.formatting import counted, elapsed
from swarmcensus.support.options import command as shell_line


def tune(
    study: StudyFile, /, *, set: Set = (), brain: Annotated[str | None, BRAIN] = None,
    adversary: Annotated[str | None, NAME, known("brains.adversary")] = None,
    parameter: Annotated[Sequence[str], takes(str, "NAME=LOW:HIGH", several=True)],
    metric: Annotated[str, NAME] = "final_error", budget: Annotated[int, COUNT] = 200,
    trials: Annotated[int, COUNT] = 10, seed: Seed = None, hardware: Hardware = USUAL,
    fresh: Fresh = False, out: Annotated[Path | None, FILE] = None,
) -> Answer:  # fmt: skip
    """Search for good values of a brain's parameters.

    Args:
        parameter: range to search: prior=1:100, prior=1:100:log, k=1:9:whole or weights[0]=0:1; may be repeated
        brain: the brain to tune, if several in the study have parameters
        adversary: search this adversary of the study for the most harm; --brain is then the one that hears it
        metric: measure to improve, or to worsen, as in 'compare': correct, or my_metric:low (default: final_error)
        budget: number of evaluations (default: 200)
        trials: trials in each world of an evaluation (default: 10)
        out: what was found as a part of a study file (default: NAME-tuned.toml, or of an adversary NAME-worst.toml)
    """
    from swarmcensus.search import files_of, target_of, tune as tune_of
    from swarmcensus.studies import Study

    read = Study.load(study, values_of(set, seed=seed)).with_(seed=seed)
    target = target_of(read, brain, adversary)
    searched = target.program.name
    out = out or Path(f"{Path(searched).stem}-{'worst' if target.harms else 'tuned'}.toml")
    files = files_of(out, study)
    begun = time.monotonic()
    try:
        with reporting(f"{'searching' if target.harms else 'tuning'} {searched}") as progress:
            found = tune_of(
                read, parameter, target.brain.name, metric, budget=budget, trials=trials, out=out, fresh=fresh,
                progress=progress, say=say, adversary=adversary, **vars(hardware),
            )  # fmt: skip
    except KeyboardInterrupt:
        if files[".csv"].exists():
            say(f"kept finished evaluations in {files['.csv']}: the same command continues")
        raise
    if files[".nc"].exists():
        found.next = shell_line("swarmcensus", "show" if target.harms else "compare", files[".nc"])
    found.files = {out: f"{counted(len(found.evaluations), 'evaluation')}, {elapsed(time.monotonic() - begun)}"}
    return found
