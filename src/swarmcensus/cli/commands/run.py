"""The commands `reproduce`, `run` and `status`."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from swarmcensus.cli.messages import reporting, say
from swarmcensus.cli.parameters import (
    FILE,
    FOLDER,
    USUAL,
    Fresh,
    Hardware,
    Seed,
    Set,
    StudyFile,
    Trials,
    part_of_trials,
    path,
    takes,
    values_of,
)
from swarmcensus.support.answers import Answer
from swarmcensus.support.errors import Interrupted
from swarmcensus.support.formatting import counted, elapsed
from swarmcensus.support.options import command as shell_line, option_conflict

WHAT = Parameter(metavar="WHAT", completer=lambda _: ["paper", "rivals"])


def reproduce(
    of: Annotated[str, WHAT] = "paper", /, *, out: Annotated[Path | None, FOLDER] = None,
    only: Annotated[Sequence[str], Parameter(metavar="PART", consume_multiple=1, allow_repeating=True)] = (),
    pdf: bool = False, hardware: Hardware = USUAL, trials: Trials = None, seed: Seed = None,
    fresh: Fresh = False,
) -> Answer:  # fmt: skip
    """Run the paper's evaluation: its figures and its claims.

    Args:
        of: paper (default), or rivals: published results on other algorithms
        out: folder for the results (default: reproduction, or reproduction-rivals)
        only: only these parts, such as fig2, fig3, fig4, fig5 or claims
        pdf: also write the figures as PDF
    """
    from swarmcensus.evaluation import reproducing

    folder = "reproduction" if of == "paper" else f"reproduction-{of}"
    with reporting("reproduce") as progress:
        return reproducing.reproduce(
            out or Path(folder), of=of, trials=trials, seed=seed, only=only or None, fresh=fresh, pdf=pdf,
            progress=progress, say=say, **vars(hardware),
        )  # fmt: skip


def run(
    study: StudyFile, /, *, set: Set = (), out: Annotated[Path | None, FILE] = None,
    hardware: Hardware = USUAL, trials: Trials = None, seed: Seed = None, fresh: Fresh = False,
    share: Annotated[tuple[int, int] | None, takes(part_of_trials, "K/N")] = None,
    cluster: Annotated[str | None, Parameter(metavar="WHERE")] = None,
) -> Answer:  # fmt: skip
    """Run a study and write its results.

    Args:
        out: results file (default: name of the study file with .nc, in this folder)
        share: run only the K-th of N parts of the trials; 'merge' joins the results
        cluster: address of a running Dask scheduler, such as tcp://host:8786
    """
    from swarmcensus.studies import Study
    from swarmcensus.support.files import check_output

    read = Study.load(study, values_of(set, trials=trials, seed=seed))
    out = out or Path(study.stem + ".nc")
    check_output("out", out, (".nc",), study)
    read = read.with_(trials=trials, seed=seed)
    if hardware.jobs and cluster:
        raise option_conflict("jobs", hardware.jobs, "sets the threads of this machine: it does not go with --cluster")
    # After the checks above, since these imports are slow:
    from swarmcensus.results import packed
    from swarmcensus.runs import run as run_study
    from swarmcensus.summaries import Summary, failures

    begun = time.monotonic()
    try:
        with reporting(read.name) as progress:
            results = run_study(
                read, progress=progress, out=out, fresh=fresh, cluster=cluster, share=share, say=say, **vars(hardware)
            )
    except Interrupted as stopped:
        say(f"kept {stopped.done:,} of {counted(stopped.total, 'trial')} in {out}: the same command continues")
        raise
    data = packed(results)
    made = "up to " * bool(read.until) + counted(read.trials, "trial")
    part = f"share {data.attrs['share']} of " if "share" in data.attrs else ""
    written = f"{part}{counted(data.sizes['setting'], 'setting')} of {made}, {elapsed(time.monotonic() - begun)}"
    several = len({*data["brain"].values.tolist()}) > 1
    words = ["compare", out, "--metric", "final_error"] if several else ["plot", out]
    after = shell_line("swarmcensus", *words) if data.attrs["trials_done"] else ""
    if part:
        after = f"with the other shares, {shell_line('swarmcensus', 'merge', out)} ... --out ALL.nc"
    failed = failures(data)
    return Summary(data, data, None, out, failed, files={out: written}, next=after, code=2 if failed else 0)


def status(results: Annotated[Path, takes(path, "RESULTS.nc")], /) -> Answer:
    """Show how far a study is, and when it will end.

    Args:
        results: the file of --out, finished or not
    """
    from swarmcensus.runs import status as status_of

    found = status_of(results)
    if found.done == found.total:
        found.next = shell_line("swarmcensus", "show", results)
    return found
